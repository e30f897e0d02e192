"""Torsion of a rope between the support's tip and a rigid load: its twist, and the forces of it.

The tip's frame goes down the links by parallel transport, which turns it at each bend from the
direction a to the next one b about a × b and nowhere else (R. L. Bishop, Amer. Math. Monthly 82,
1975, 246-251). The first a is the vertical of the tip, the last b the load's own one, both
downwards. The twist φ is the load's angle about its vertical from the frame that arrives there, in
the product of unit quaternions

    q = q_swing (cos φ/2, 0, 0, sin φ/2),    φ' = -(ψ' + Σ t · (a' + b') + ω · b_load),    t = a × b / (1 + a · b)

with the tip's yaw ψ and the load's angular velocity ω. The moment M = -(k φ + c φ') does the work M
φ', so virtual work gives all forces: the couple -M on the support about the vertical, -M (n + b) /
(1 + n · b) on the load below the last link n, and on each link a pair of forces across it, for
which it has to be bent.

Quaternions cover the rotations twice, so φ follows from the positions alone within a whole turn to
either side, and a run ends shortly before it: the load's quaternion and its opposite are the same
attitude, a turn of the rope apart.
"""  # noqa: E501

from math import atan2
from typing import NamedTuple

from crane_sim.files.types import NonNegative, Positive
from crane_sim.models.cables.chain_3d import row_of
from crane_sim.models.moving_base import rotate_to_base
from crane_sim.multibody.vectors import add, cross, dot, multiply, scale, subtract
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine

DOWN, STILL = (0.0, 0.0, -1.0), (0.0, 0.0, 0.0)
MAX_TWIST = 6.0  # rad, where a run ends: beyond 2π the twist is not known


class Torsion(NamedTuple):
    """The rope's resistance to twist, all of its falls together."""

    stiffness: Positive  # N m/rad, moment on the load by the angle between tip and load
    damping: NonNegative = 0.0  # N m s/rad, moment on the load by the rate of that angle


class Twist(NamedTuple):
    """The twisted rope at one instant."""

    angle: float  # rad, φ
    rate: float  # rad/s, of the angle
    moment: float  # N m, M
    loss: float  # W, that damping takes
    vertical: tuple[float, float, float]  # b of the load, in the axes of the base


def bend(a, b):
    """Return t (3,) of the bend from a direction to another one."""
    return scale(1.0 / (1.0 + dot(a, b)), cross(a, b))


def turn_by_bend(q, a, b):
    """Return the quaternion of a frame after the bend from direction a to b, of any length."""
    (x, y, z), s = cross(a, b), 1.0 + dot(a, b)
    w, i, j, k = q
    return (
        s * w - x * i - y * j - z * k,
        s * i + x * w + y * k - z * j,
        s * j - x * k + y * w + z * i,
        s * k + x * j - y * i + z * w,
    )


def direction_of(links, k):
    """Return the unit vector (3,) of link k, the tip's downward vertical above the first."""
    return DOWN if k < 0 else row_of(links.units, k)


def rate_of(links, k):
    """Return the rate (3,) [1/s] of `direction_of`."""
    return STILL if k < 0 else row_of(links.rates, k)


def load_vertical(load):
    """Return the load's own vertical b (3,), downwards, in the axes of the base."""
    return -load.rows[0][2], -load.rows[1][2], -load.rows[2][2]


@routine
def twist_motion(links, load, angle, rate):
    """Return (twist [rad] between -2π and 2π, its rate [rad/s]) below a tip.

    The tip has a yaw angle [rad] and its rate.
    """
    (s, c), n = sincos(0.5 * angle), len(links.squared_rates)
    frame, turning = (c, 0.0, 0.0, s), rate
    for k in range(n):
        a, b = direction_of(links, k - 1), direction_of(links, k)
        frame = turn_by_bend(frame, a, b)
        turning += dot(bend(a, b), add(rate_of(links, k - 1), rate_of(links, k)))
    last, vertical, omega = (
        direction_of(links, n - 1),
        load_vertical(load),
        multiply(load.rows, load.omega),
    )
    w, i, j, k = turn_by_bend(frame, last, vertical)
    turning += dot(omega, vertical) + dot(
        bend(last, vertical), add(rate_of(links, n - 1), cross(omega, vertical))
    )
    e, x, y, z = load.quaternion
    across, along = w * z - i * y + j * x - k * e, w * e + i * x + j * y + k * z
    return 2.0 * atan2(across, along), -turning


def twist_of(torsion, links, load, angle, rate):
    """Return the Twist, None without torsion.

    `links` are Directions, `load` is a BodyState; other arguments as in `twist_motion`.
    """
    if torsion is None:
        return None
    angle, rate = twist_motion(links, load, angle, rate)
    moment = -(torsion.stiffness * angle + torsion.damping * rate)
    return Twist(angle, rate, moment, torsion.damping * rate * rate, load_vertical(load))


def link_force(twist, links, k):
    """Return the force (3,) [N] on the lower end of link k; its opposite is on the upper one."""
    n, own = len(links.squared_rates), direction_of(links, k)
    lower = direction_of(links, k + 1) if k + 1 < n else twist.vertical
    return scale(
        -twist.moment / links.lengths[k],
        add(bend(direction_of(links, k - 1), own), bend(own, lower)),
    )


def push_nodes(twist, links, acc):
    """Add what torsion does to the nodes' accelerations (N + 1, 3) above the load."""
    if twist is None:
        return
    for k in range(len(links.squared_rates) - 1):
        force = subtract(link_force(twist, links, k), link_force(twist, links, k + 1))
        x, y, z = add(row_of(acc, k + 1), scale(links.inv_masses[k], force))
        acc[k + 1, 0], acc[k + 1, 1], acc[k + 1, 2] = x, y, z


def twist_load(twist, links, body, load, force, moment):
    """Return (force (3,) [N], moment (3,) [N m] in its axes) on the load with those of torsion."""
    if twist is None:
        return force, moment
    n = len(links.squared_rates)
    last, push = direction_of(links, n - 1), link_force(twist, links, n - 1)
    couple = scale(-twist.moment / (1.0 + dot(last, twist.vertical)), add(last, twist.vertical))
    pushed = cross(body.attachment, rotate_to_base(load.rows, push))
    return add(force, push), add(moment, add(rotate_to_base(load.rows, couple), pushed))


def twist_couple(twist):
    """Return the couple [N m] of torsion on the support about the vertical."""
    return 0 if twist is None else -twist.moment


def twist_tip(twist, links, pull):
    """Return the pull (3,) [N] on the tip with that of torsion, in the axes of the base."""
    return pull if twist is None else subtract(pull, link_force(twist, links, 0))


def add_twist_power(twist, power, yaw_rate):
    """Return the power [W] less that of the couple on the support and that of damping."""
    return power if twist is None else power + twist.moment * yaw_rate - twist.loss


def twist_energy(twist, torsion):
    """Return the potential energy [J] of torsion."""
    return 0.0 if twist is None else 0.5 * torsion.stiffness * twist.angle * twist.angle
