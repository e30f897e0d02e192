"""Lagrange dynamics of overhead cranes in the coordinates of Brogliato's report.

They are for analysis, not for simulation.

B. Brogliato, Lagrange dynamics of lumped-mass multibody models of overhead cranes, hal-03674652 v1,
2022. Equation numbers in this package are the report's. Coordinates are q = (x, θ_1 .. θ_N, l_1 ..
l_N): the trolley's position, the angle of each link from the one above it, the links' lengths; x to
the right, z upwards, angles positive towards +x from the downward vertical. Simulations use
absolute angles and tensions, which stay accurate below heavy payloads.
"""
