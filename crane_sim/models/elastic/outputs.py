"""Outputs of a crane with an elastic cable: energies, tensions and points; modes of links that only pull."""

from crane_sim import system
from crane_sim.models.elastic.crane import (
    ElasticCrane,
    node_at,
    payload_state,
    pull_of,
    stretch_at,
    tautness,
)
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.hanging.carrier import carrier_energies, node_energies, posture_of, write_polyline
from crane_sim.models.hanging.exchange import load_of
from crane_sim.models.hanging.layout import layout_of
from crane_sim.models.loads import load_energies
from crane_sim.models.moving_base import pose_at, to_world
from crane_sim.models.supports.support import bare_tip
from crane_sim.models.wind_kink import pressed_point
from crane_sim.multibody import linear
from crane_sim.numerics.jit import routine


@routine
def initialize_link_modes(p, x):
    """Set the modes of links that go slack to those of their elongations."""
    if p.cable.slack is None:
        return
    (_, _, modes), tip = layout_of(p), bare_tip(posture_of(p, x))
    for k in range(len(p.cable.masses)):
        x[modes + k] = 1.0 if min(*link_forces(p, x, k, tip)) >= 0.0 else 0.0


def link_forces(p, x, k, tip):
    """Return (k e, k e + c e') [N] of link k: where it is taut it pulls by the second one."""
    _, stretch, rate = stretch_at(p, x, k, tip)
    spring = p.cable.stiffness[k] * stretch
    return spring, spring + p.cable.damping[k] * rate


@routine
def elastic_energies(p, base, x):
    """Return the energies [J] of the crane, see `carrier_energies`."""
    pose, n = posture_of(p, x), len(p.cable.masses)
    total, tip = carrier_energies(p, base, x, pose), bare_tip(pose)
    for k in range(n):
        _, stretch, _ = stretch_at(p, x, k, tip)
        stored = 0.5 * tautness(p, x, k) * p.cable.stiffness[k] * stretch * stretch
        total = linear.add(total, (0.0, stored, 0.0, 0.0))
    for k in range(1, n):
        total = linear.add(total, node_energies(base, p.cable.masses[k - 1], node_at(p, x, k), p.gravity))
    return linear.add(total, load_energies(base, load_of(p, x), payload_state(p, x), p.gravity))


@system.tensions.register(ElasticCrane)
@routine
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    tip = bare_tip(posture_of(p, x))
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = pull_of(p, x, k, stretch_at(p, x, k, tip)).tension


@system.points.register(ElasticCrane)
@routine
def write_points(p, t, x, out):
    """Write support and nodes in the world into out (N, 3)."""
    base = pose_at(p.base, t)
    i = write_polyline(posture_of(p, x), base, out)
    for k in range(len(p.cable.masses)):
        out[i + k, 0], out[i + k, 1], out[i + k, 2] = to_world(base, node_at(p, x, k + 1)[0])


@pressed_point.register(ElasticCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    return payload_state(p, x).position


def links_guard(p, best, x):
    """Return the smaller one of `best` and the guards [N] of links that only pull.

    A slack one pulls where both its e and its k e + c e' are > 0.
    """
    if p.cable.slack is None:
        return best
    tip = bare_tip(posture_of(p, x))
    for k in range(len(p.cable.masses)):
        spring, total = link_forces(p, x, k, tip)
        value = total if tautness(p, x, k) > 0.0 else -min(spring, total)
        best = smaller_guard(best, value, encode(Guard.LINK, k))
    return best
