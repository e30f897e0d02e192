"""Integration of traced equations: a step is one traced function, the loops around it know only arrays and addresses.

A state is an array of n reals. The equations are a traced function derivative(p, t, x, u, out) of the arrays of
parameters p, state x and inputs u, which writes the state's rate into `out`.
"""
