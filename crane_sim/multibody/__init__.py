"""Trees of joints and bodies: kinematics, mass matrix, accelerations, reaction on their base.

Plain Python on numbers, which `tracing` turns into code: what is the literal 0 in a declaration
costs nothing.
"""
