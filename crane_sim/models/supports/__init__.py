"""Supports, which carry the upper end of the rope, one file each.

Below knuckle boom and driven point a single rope has closed forms (`single_rope`), which are faster
than those of the tree in `support`, and equal: the methods of `Knuckle` and `DrivenPoint`. They
work in a frame of their own: origin at the base, z up, turned about z by the yaw angle. The state
xs is a tuple (positions..., velocities...). All vectors are in that frame; `tip_velocity` is the
rate of change of the tip's coordinates in it.
"""
