"""Supports, which carry the upper end of the rope, one file each; here the functions of the closed forms.

Below knuckle boom and driven point a single rope has closed forms (`single_rope`), which are faster than those of the
tree in `support`, and equal. They work in a frame of their own: origin at the base, z up, turned about z by the yaw
angle. The state is a tuple (positions..., velocities...). All vectors below are in that frame; `tip_velocity` is the
rate of change of the tip's coordinates in it.
"""

from crane_sim.models.moving_base import BaseKinematics
from crane_sim.numerics.jit import generic


@generic
def forward_kinematics(support, xs):
    """Return a NamedTuple of what state xs fixes: at least tip (3,), tip_velocity (3,), yaw_rate."""
    raise NotImplementedError


@generic
def support_acceleration(support, pose, gravity, tau, force):
    """Return the joint accelerations under joint efforts tau and a force (3,) [N] on the tip."""
    raise NotImplementedError


@generic
def joint_constraint_efforts(support, pose, gravity, tau, force, qdd):
    """Return the constraint efforts of joints that stick: what friction bears; arguments of `support_acceleration`.

    qdd are its accelerations; the numbers of joints that move mean nothing.
    """
    raise NotImplementedError


@generic
def tip_acceleration(support, pose, qdd):
    """Return (second rate of change of the tip's coordinates (3,), yaw acceleration) at joint accelerations qdd."""
    raise NotImplementedError


@generic
def tip_mobility(support, pose, n):
    """Return nᵀ J Mc⁻¹ Jᵀ n [1/kg]: the tip's acceleration along the unit vector n for a unit force along n."""
    raise NotImplementedError


def with_base(support, tau, base, pose):
    """Return the joint efforts tau plus those that a moving base imposes on the support's own masses.

    `base` is that of `crane_sim.models.moving_base.base_kinematics_at`, in the axes of the support's frame. A support
    without masses, and a base that rests, leave tau as it is.
    """
    return add_base_efforts(base, support, tau, pose)


@generic
def add_base_efforts(base, support, tau, pose):
    """Return the result of `with_base`: tau itself for a base at rest."""
    return tau


@add_base_efforts.register(BaseKinematics)
def _(base, support, tau, pose):
    return add_imposed_efforts(support, base, tau, pose)


@generic
def add_imposed_efforts(support, base, tau, pose):
    """Return the joint efforts tau plus those of the inertial forces of a moving base on the support's masses."""
    return tau


@generic
def with_wind(support, tau, flow, base, pose):
    """Return the joint efforts tau plus those of the wind on the support's own bodies.

    `flow` is that of `crane_sim.models.wind_load.airflow_at`, None without wind, and `base` as in `with_base`, both in
    the axes of the support's frame. A support without windage leaves tau as it is.
    """
    return tau


@generic
def add_yaw_moment(support, tau, couple):
    """Return the joint efforts tau plus those of a couple [N m] about the vertical, applied to the support."""
    return tau


@generic
def drive_power(support, tau, pose, force):
    """Return the power [W] of joint efforts tau with a force (3,) [N] on the tip."""
    raise NotImplementedError


@generic
def yaw(support, xs):
    """Return the angle [rad] of the support's frame about z."""
    raise NotImplementedError


@generic
def support_polyline(support, xs):
    """Return the support's polyline, base to tip, in its own frame: a tuple of (x, y, z)."""
    raise NotImplementedError


@generic
def support_kinetic(support, pose):
    """Return the support's kinetic energy [J], without rope and payload."""
    raise NotImplementedError


@generic
def support_potential(support, pose, gravity):
    """Return the support's potential energy [J] of gravity and joint springs, without rope and payload."""
    raise NotImplementedError


@generic
def support_base_energy(support, base, pose, gravity):
    """Return (kinetic, potential) energy [J] of the support's masses in the world less those relative to the base.

    `base` is that of `crane_sim.models.moving_base.base_state`, in the axes of the support's frame. A support without
    masses has none.
    """
    return 0.0, 0.0


@generic
def support_guard(support, best, xs):
    """Return the smallest one of `best`, see `crane_sim.models.guards`, and of the support's travel limits."""
    return best


@generic
def support_polyline_size(support):
    """Return the number of points of the support's polyline."""
    raise NotImplementedError


@generic
def joint_coordinates(support, p, x):
    """Return (q, v), the joint coordinates of the crane p on this support in state x."""
    raise NotImplementedError


@generic
def state_from_joints(support, p, q, v):
    """Return (support state, payload state) of the crane p on this support at joint coordinates q, v."""
    raise NotImplementedError


@generic
def joint_accelerations(support, p, motion):
    """Return the joint accelerations of the crane p on this support, at this Motion."""
    raise NotImplementedError


@generic
def actuated_joints(support, p, x):
    """Return (q, v) of the actuated joints only."""
    raise NotImplementedError


@generic
def efforts_from_row(support, p, row):
    """Return the efforts in the array `row` as a tuple."""
    raise NotImplementedError
