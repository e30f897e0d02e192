"""An overhead crane whose cable is one straight line: a single link, or a light taut cable below a heavy payload.

For one link the equations are exact; for a chain they leave out that the links can bend, an error of the order of the
square of (mass of the nodes above / mass of the payload). With M = Σ m_i, S = Σ m_i r_i, I = Σ m_i r_i² over the nodes
at distances r_i below the trolley:

    T = M g cos α + S α'² - M (x'' sin α + l''),   V = -(M - S²/I)(x'' cos α + g sin α + 2 l' α'),
    I α'' = -S (x'' cos α + g sin α + 2 l' α'),

where T pulls the trolley along the line and V across it. State: a flat tuple of floats
(x, (l1), α, x', (l1'), α', (energy supplied), (modes)).
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.energy_meter import Meter, meter_entry, meter_size
from crane_sim.models.guards import Guard, decode, encode, friction_event, smaller_guard
from crane_sim.models.overhead import layout_of, switch
from crane_sim.models.overhead.modes import (
    EventLimits,
    count_payload_changes,
    get_mode,
    get_payload_mass,
    hoist_guard,
    limits_guard,
    payload_guard,
)
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import (
    HOIST,
    ForceHoist,
    Hoist,
    MasslessHoist,
    hoist_coordinates,
    hoist_friction_guard,
    hoist_power,
    hoist_reflected_mass,
    hoist_response,
    hoist_sticks,
    mode_of_stopped_hoist,
)
from crane_sim.models.supports.rails import (
    Axis,
    add_bristle_power,
    axis_guard,
    axis_mass,
    axis_power,
    axis_response,
    has_friction,
    initial_mode,
    mode_after_stop,
    mode_rate,
)
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_entry

MASS, DISTANCE = 0, 1
"""Rows of a line's nodes: m_i [kg], the payload's as the scene has it at first, and b_i [m]."""


class Line(NamedTuple):
    """Nodes on a straight line. Distances are from the first link's lower end; sums leave out the payload."""

    length: float  # m, of the first link where there is no hoist
    mass: float  # kg, Σ m_i of the nodes above the payload
    first: float  # kg m, Σ m_i b_i
    second: float  # kg m², Σ m_i b_i²
    payload: float  # kg
    reach: float  # m, b_N of the payload
    nodes: Any  # (2, N), MASS and DISTANCE of all nodes from the top


class RodCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    cable: Line
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None


class Swing(NamedTuple):
    """Accelerations and forces at one instant."""

    s: float  # sin α
    c: float  # cos α
    trolley: float  # m/s²
    paid: float  # m/s²
    turning: float  # rad/s²
    tension: float  # N, at the top
    pull: float  # N, of the cable on the trolley along x


@layout_of.register(RodCrane)
def _(p):
    nq = 2 + hoist_coordinates(p.hoist)
    return nq, nq - 1, 2 * nq + meter_size(p.energy_meter)


@generic
def hoisted_rod(hoist, cable, x):
    """Return (length, rate) of the first link."""
    return x[1], x[4]


@hoisted_rod.register(type(None))
def _(hoist, cable, x):
    return cable.length, 0.0


def mass_moments(p, x, length):
    """Return (M [kg], S [kg m], I [kg m²], M I - S²) of the nodes, about the trolley."""
    cable = p.cable
    payload = get_payload_mass(p.event_limits, x, len(x) - 1, cable.payload)
    total = cable.mass + payload
    s0 = cable.first + payload * cable.reach
    i0 = cable.second + payload * cable.reach * cable.reach
    return total, s0 + total * length, i0 + length * (2.0 * s0 + total * length), total * i0 - s0 * s0


@generic
def solve_pull(hoist, total, rest, bias_acc, inv_mass, s, c, side, of_hoist):
    """Return (trolley's acceleration, tension, acceleration of the length).

    Args:
        hoist: its type decides which of tension and length is unknown.
        total: mass [kg] below the trolley.
        rest: M g cos α + S α'² [N], the tension of a trolley at rest and a length that does not change.
        bias_acc, inv_mass: acceleration [m/s²] without the cable and inverse mass [1/kg] of the trolley.
        s, c: sine and cosine of the angle.
        side: (M - S²/I [kg], g sin α + 2 l' α' [m/s²]), what the line carries across.
        of_hoist: (inverse mass, bias acceleration) of the length, see `hoist_response`.
    """
    across_mass, across_acc = side
    hoist_inv_mass, hoist_bias_acc = of_hoist
    attenuation = 1.0 / (1.0 + total * hoist_inv_mass)
    rest_tension = (rest - total * hoist_bias_acc) * attenuation
    a = (bias_acc + inv_mass * (s * rest_tension - across_mass * c * across_acc)) / (
        1.0 + inv_mass * (total * s * s * attenuation + across_mass * c * c)
    )
    tension = rest_tension - total * s * a * attenuation
    return a, tension, hoist_bias_acc + hoist_inv_mass * tension


@solve_pull.register(MasslessHoist)
def _(hoist, total, rest, bias_acc, inv_mass, s, c, side, of_hoist):
    across_mass, across_acc = side
    _, tension = of_hoist
    a = (bias_acc + inv_mass * (s * tension - across_mass * c * across_acc)) / (1.0 + inv_mass * across_mass * c * c)
    return a, tension, (rest - tension) / total - s * a


def solve_swing(p, t, x, tau):
    """Return accelerations and forces at time t in state x under joint efforts tau."""
    nq, _, modes = layout_of(p)
    (s, c), v, w = sincos(x[nq - 1]), x[nq], x[2 * nq - 1]
    length, rate = hoisted_rod(p.hoist, p.cable, x)
    total, first, second, gram = mass_moments(p, x, length)
    inv_mass, bias_acc = axis_response(p.trolley, t, tau, 0, v, get_mode(p.event_limits, x, modes, 0))
    across_mass, across_acc = gram / second, p.gravity * s + 2.0 * rate * w
    rest = total * p.gravity * c + first * w * w
    of_hoist = hoist_response(p.hoist, t, tau, x, nq + 1)
    a, tension, paid = solve_pull(p.hoist, total, rest, bias_acc, inv_mass, s, c, (across_mass, across_acc), of_hoist)
    turning = -(first / second) * (c * a + across_acc)
    return Swing(s, c, a, paid, turning, tension, tension * s - across_mass * (c * a + across_acc) * c)


@generic
def length_rates(hoist, x, paid):
    """Return (rate, acceleration) of the first link's length, each a tuple, empty without a hoist."""
    return (x[4],), (paid,)


@length_rates.register(type(None))
def _(hoist, x, paid):
    return (), ()


@generic
def mode_rates(limits, p, x):
    """Return the derivatives of the modes, zeros but those of bristles."""
    return ()


@mode_rates.register(EventLimits)
def _(limits, p, x):
    nq, _, modes = layout_of(p)
    return (mode_rate(p.trolley, x[nq], x[modes]), *drum_modes(p.hoist, 0.0), 0.0)


@generic
def drum_modes(hoist, rate):
    """Return the mode of the hoist at this rate as a tuple, empty for one without friction."""
    return ()


@drum_modes.register(ForceHoist)
def _(hoist, rate):
    return drum_modes(hoist.friction, rate)


@drum_modes.register(Friction)
def _(hoist, rate):
    return (np.sign(rate),)


@system.rhs.register(RodCrane)
def _(p, t, x, u):
    nq, _, _ = layout_of(p)
    tau = system.effort(u, p, t, x)
    swing = solve_swing(p, t, x, tau)
    rate, paid = length_rates(p.hoist, x, swing.paid)
    power = meter_entry(p.energy_meter, supplied_power(p, x, tau, swing))
    return (x[nq], *rate, x[2 * nq - 1], swing.trolley, *paid, swing.turning, *power, *mode_rates(p.event_limits, p, x))


def supplied_power(p, x, tau, swing):
    """Return the power [W] that drives, imposed motions and losses supply."""
    nq, _, modes = layout_of(p)
    _, rate = hoisted_rod(p.hoist, p.cable, x)
    power = axis_power(p.trolley, tau, 0, x[nq], swing.pull) + hoist_power(p.hoist, tau, rate, swing.tension)
    return add_bristle_power(p.trolley, power, x[nq], get_mode(p.event_limits, x, modes, 0))


@generic
def joint_entries(hoist, x, i):
    """Return the joint coordinates (nq,) that stand from x[i] on, as a tuple."""
    return x[i], x[i + 1], x[i + 2]


@joint_entries.register(type(None))
def _(hoist, x, i):
    return x[i], x[i + 1]


@generic
def initial_modes(limits, p, t, v):
    """Return the modes that a crane with joint velocities v starts in at time t."""
    return ()


@initial_modes.register(EventLimits)
def _(limits, p, t, v):
    return (initial_mode(p.trolley, v[0]), *drum_modes(p.hoist, v[1]), count_payload_changes(limits, t))


@system.state.register(RodCrane)
def _(p, t, q, v):
    known = initial_modes(p.event_limits, p, t, v)
    return (*joint_entries(p.hoist, q, 0), *joint_entries(p.hoist, v, 0), *meter_entry(p.energy_meter, 0.0), *known)


@system.joints.register(RodCrane)
def _(p, x):
    nq, _, _ = layout_of(p)
    return joint_entries(p.hoist, x, 0), joint_entries(p.hoist, x, nq)


@system.acceleration.register(RodCrane)
def _(p, t, x, u):
    nq, _, _ = layout_of(p)
    return joint_entries(p.hoist, system.rhs(p, t, x, u), nq)


@system.kinetic.register(RodCrane)
def _(p, x):
    nq, _, _ = layout_of(p)
    length, rate = hoisted_rod(p.hoist, p.cable, x)
    total, first, second, _ = mass_moments(p, x, length)
    (s, c), v, w = sincos(x[nq - 1]), x[nq], x[2 * nq - 1]
    carried = total * (0.5 * (v * v + rate * rate) + v * rate * s) + first * v * w * c + 0.5 * second * w * w
    return carried + 0.5 * axis_mass(p.trolley) * v * v + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate


@system.potential.register(RodCrane)
def _(p, x):
    nq, _, _ = layout_of(p)
    length, _ = hoisted_rod(p.hoist, p.cable, x)
    return -p.gravity * mass_moments(p, x, length)[1] * sincos(x[nq - 1])[1]


@system.link_count.register(RodCrane)
def _(p):
    return p.cable.nodes.shape[1]


@system.tensions.register(RodCrane)
def _(p, t, x, u, rows, i, first):
    nq, _, _ = layout_of(p)
    swing, (length, _) = solve_swing(p, t, x, system.effort(u, p, t, x)), hoisted_rod(p.hoist, p.cable, x)
    acceleration, rate_sq = p.gravity * swing.c - swing.trolley * swing.s - swing.paid, x[2 * nq - 1] * x[2 * nq - 1]
    rows[i, first] = swing.tension
    for k in range(1, rows.shape[1] - first):  # each link carries what the one above does, less the node between them
        distance = length + p.cable.nodes[DISTANCE, k - 1]
        rows[i, first + k] = rows[i, first + k - 1] - p.cable.nodes[MASS, k - 1] * (acceleration + distance * rate_sq)


@system.power.register(RodCrane)
def _(p, t, x, u):
    tau = system.effort(u, p, t, x)
    return supplied_power(p, x, tau, solve_swing(p, t, x, tau))


@system.points.register(RodCrane)
def _(p, t, x, out):
    nq, _, _ = layout_of(p)
    length, _ = hoisted_rod(p.hoist, p.cable, x)
    s, c = sincos(x[nq - 1])
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for i in range(p.cable.nodes.shape[1]):
        r = length + p.cable.nodes[DISTANCE, i]
        out[i + 1, 0], out[i + 1, 1], out[i + 1, 2] = x[0] + r * s, 0.0, -r * c


@system.observe.register(RodCrane)
def _(p, t, q, v, u):
    nq, _, _ = layout_of(p)
    x = system.state(p, t, q, v)
    swing, (length, _) = solve_swing(p, t, x, u), hoisted_rod(p.hoist, p.cable, x)
    reach = length + p.cable.reach
    payload = x[0] + reach * swing.s, 0.0, -reach * swing.c
    return (system.kinetic(p, x), system.potential(p, x)), swing.tension, (x[0], 0.0, 0.0), payload


@system.guard.register(RodCrane)
def _(p, t, x, u, work):
    nq, _, modes = layout_of(p)
    tau = system.effort(u, p, t, x)
    taut = p.event_limits.taut > 0.0
    forces = taut or (has_friction(p.trolley) and x[modes] == 0.0) or hoist_sticks(p.hoist, x)
    tension, pull = forces_of(p, t, x, tau) if forces else (0.0, 0.0)
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, pull), encode(Guard.FRICTION, 0))
    best = limits_guard(p.event_limits, best, 0, x[0])
    best = hoist_guard(p.event_limits, best, hoisted_rod(p.hoist, p.cable, x)[0])
    best = hoist_friction_guard(p.hoist, best, x, nq + 1, tau, tension)
    best = payload_guard(p.event_limits, best, t, x[len(x) - 1])
    value, number = smaller_guard(best, tension, encode(Guard.LINK, 0)) if taut else best
    return value, number, int(forces)


def forces_of(p, t, x, tau):
    """Return (tension, pull on the trolley) [N]."""
    swing = solve_swing(p, t, x, tau)
    return swing.tension, swing.pull


def total_energy(p, x):
    """Return the total energy [J]."""
    return system.kinetic(p, x) + system.potential(p, x)


def mode_of_stopped_joint(p, joint, mode, tau, swing):
    """Return the new mode of trolley or hoist, at rest at this Swing, after its guard has failed in `mode`."""
    if joint == HOIST:
        return mode_of_stopped_hoist(p.hoist, mode, tau, swing.tension)
    return mode_after_stop(p.trolley, mode, tau, 0, swing.pull)


@switch.register(RodCrane)
def _(p, t, x, tau, number):
    nq, _, modes = layout_of(p)
    kind, joint, _ = decode(number)
    if kind == Guard.PAYLOAD:
        after = replace_entry(x, len(x) - 1, x[len(x) - 1] + 1.0)
        gained = total_energy(p, after) - total_energy(p, x)  # the payload takes its energy along
        return replace_entry(after, modes - 1, x[modes - 1] + gained), number, True
    if kind == Guard.FRICTION:
        rate, at = (nq + 1, len(x) - 2) if joint == HOIST else (nq, modes)
        still = replace_entry(replace_entry(x, rate, 0.0 if x[at] != 0.0 else x[rate]), at, 0.0)
        mode = mode_of_stopped_joint(p, joint, x[at], tau, solve_swing(p, t, still, tau))
        return replace_entry(still, at, mode), friction_event(joint, mode), True
    return x, number, False
