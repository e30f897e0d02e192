"""Supports carry the upper end of the rope. One file each; the protocol every support answers is here.

A support works in a frame of its own: origin at its base, z up, turned about z by its yaw angle (a trolley's is 0).
Its state is a tuple (positions..., velocities...). All vectors below are in that frame; `tip_velocity` is the rate of
change of the tip's coordinates in it.
"""

from crane_sim.jit import generic


@generic
def posture(support, xs):
    """Return a NamedTuple of what state xs fixes: at least tip (3,), tip_velocity (3,), yaw_rate."""
    raise NotImplementedError


@generic
def support_acceleration(support, pose, gravity, tau, force):
    """Return the joint accelerations under joint efforts tau and a force (3,) [N] on the tip."""
    raise NotImplementedError


@generic
def tip_acceleration(support, pose, qdd):
    """Return (second rate of change of the tip's coordinates (3,), yaw acceleration) at joint accelerations qdd."""
    raise NotImplementedError


@generic
def tip_mobility(support, pose, n):
    """Return nᵀ J Mc⁻¹ Jᵀ n [1/kg]: the tip's acceleration along the unit vector n for a unit force along n."""
    raise NotImplementedError


@generic
def with_couple(support, tau, couple):
    """Return the joint efforts tau plus those of a couple [N m] about the vertical, applied to the support."""
    raise NotImplementedError


@generic
def yaw(support, xs):
    """Return the angle [rad] of the support's frame about z."""
    raise NotImplementedError


@generic
def skeleton(support, xs):
    """Return the support's polyline, base to tip, in its own frame: a tuple of (x, y, z)."""
    raise NotImplementedError


@generic
def support_kinetic(support, pose):
    """Return the support's kinetic energy [J], without rope and load."""
    raise NotImplementedError


@generic
def support_potential(support, pose, gravity):
    """Return the support's potential energy [J] of gravity and joint springs, without rope and load."""
    raise NotImplementedError
