"""Trees of joints and rigid bodies: their kinematics, mass matrix, accelerations and the reaction on their base.

Plain Python on numbers, which `tracing` turns into code: what is the literal 0 in a declaration costs nothing.
"""
