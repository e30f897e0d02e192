"""Cranes with rigid links below any support, and a load that is a point mass or a rigid body.

The support gives the motion and the mobility of its tip, the cable its tensions, the load its
inertia. A crane with one rigid rope and a point mass is faster in the payload's coordinates:
`single_rope`.
"""
