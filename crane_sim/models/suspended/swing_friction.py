"""Friction of the swing joints at the support's tip, against the first link's swing in its frame.

It is internal: what it pulls on the link's lower end it pushes on the tip, and the couple between
the two turns the support about the vertical.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_sim.models.cables.chain_3d import row_of
from crane_sim.models.moving_base import rotate_to_base
from crane_sim.multibody.vectors import Vector, add, cross, scale, subtract, to_turned_axes


class SwingPull(NamedTuple):
    """Friction of the swing at one instant."""

    force: Vector  # N, on the lower end of the first link, in the axes of the base
    couple: Any  # N m, on the support about the vertical
    loss: Any  # W, that it takes


def swing_pull(friction, pose, links):
    """Return the SwingPull in a posture of the support, None without friction."""
    if friction is None:
        return None
    (s, c), length = pose.heading, links.lengths[0]
    n, (rx, ry, rz) = (
        to_turned_axes(row_of(links.units, 0), s, c),
        to_turned_axes(row_of(links.rates, 0), s, c),
    )
    rx, ry = rx + pose.yaw_rate * n[1], ry - pose.yaw_rate * n[0]
    c2 = sqrt(n[1] * n[1] + n[2] * n[2])
    s1, c1 = (n[1] / c2, -n[2] / c2) if c2 > 0.0 else (0.0, 1.0)
    w1, w2 = c1 * ry + s1 * rz, c2 * rx + n[0] * (c1 * rz - s1 * ry)
    a1, a2 = friction.moments(n, w1, w2)
    pull = scale(-1.0 / length, (a2 * c2, a1 * c1 - a2 * s1 * n[0], a1 * s1 + a2 * c1 * n[0]))
    couple = length * (n[1] * pull[0] - n[0] * pull[1])
    return SwingPull(to_turned_axes(pull, -s, c), couple, a1 * w1 + a2 * w2)


def pull_first_node(swing, links, acc):
    """Add friction to the acceleration (N + 1, 3) of the node between first link and load."""
    if swing is not None and len(links.squared_rates) > 1:
        acc[1, 0], acc[1, 1], acc[1, 2] = add(
            row_of(acc, 1), scale(links.inv_masses[0], swing.force)
        )


def pull_load(swing, links, body, load, force, moment):
    """Return (force (3,) [N], moment (3,) [N m]) on a load below the first link, with friction.

    The moment is in the load's axes.
    """
    if swing is None or len(links.squared_rates) > 1:
        return force, moment
    if not hasattr(load, "rows"):
        return add(force, swing.force), moment
    lever = cross(body.attachment, rotate_to_base(load.rows, swing.force))
    return add(force, swing.force), add(moment, lever)


def pull_tip(swing, couple, force):
    """Return (couple [N m] about the vertical, force (3,) [N]) on the tip, with friction."""
    return (
        (couple, force) if swing is None else (couple + swing.couple, subtract(force, swing.force))
    )
