"""An overhead crane whose cable is one straight line: one link, or a light cable under a load.

The light cable is taut below a heavy payload.

For one link the equations are exact; for a chain they leave out that the links can bend, an error
of the order of the square of (mass of the nodes above / mass of the payload). With M = Σ m_i, S = Σ
m_i r_i, I = Σ m_i r_i² over the nodes at distances r_i below the trolley:

    T = M g cos α + S α'² - M (x'' sin α + l''),   V = -(M - S²/I)(x'' cos α + g sin α + 2 l' α'),
    I α'' = -S (x'' cos α + g sin α + 2 l' α'),

where T pulls the trolley along the line and V across it. State: a flat tuple of floats
(x, (l1), α, x', (l1'), α', (energy supplied), (modes)).
"""

from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.models.energy_meter import Meter, meter_entry
from crane_sim.models.guards import Guard, decode, encode, friction_event, smaller_guard
from crane_sim.models.overhead import hoist_mode, layout_of
from crane_sim.models.overhead.events import (
    EventLimits,
    drives_power,
    drum_modes,
    get_payload_mass,
    mode_of_stopped_drive,
    mode_rate,
    needs_forces,
    smallest_drive_guard,
    trolley_mode,
)
from crane_sim.models.supports.hoist import (
    HOIST,
    Hoist,
    MasslessHoist,
    hoist_reflected_mass,
    hoist_response,
)
from crane_sim.models.supports.rails import Axis, axis_mass
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.states import replace_entry

MASS, DISTANCE = 0, 1
"""Rows of a line's nodes: m_i [kg], the payload's as the scene has it at first, and b_i [m]."""


class Line(NamedTuple):
    """Nodes on a line, by distances from the first link's lower end; sums omit the payload."""

    length: float  # m, of the first link where there is no hoist
    mass: float  # kg, Σ m_i of the nodes above the payload
    first: float  # kg m, Σ m_i b_i
    second: float  # kg m², Σ m_i b_i²
    payload: float  # kg
    reach: float  # m, b_N of the payload
    nodes: Any  # (2, N), MASS and DISTANCE of all nodes from the top

    def with_payload(self, mass):
        """Return the cable with another payload [kg]."""
        return self._replace(payload=mass)


class RodCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    cable: Line
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None

    wind = None

    def cable_coordinates(self):
        """Return the number of angles."""
        return 1


class Swing(NamedTuple):
    """Accelerations and forces at one instant."""

    s: float  # sin α
    c: float  # cos α
    trolley: float  # m/s²
    paid: float  # m/s²
    turning: float  # rad/s²
    tension: float  # N, at the top
    pull: float  # N, of the cable on the trolley along x


def hoisted_rod(p, x):
    """Return (length, rate) of the first link."""
    return (p.cable.length, 0) if p.hoist is None else (x[1], x[4])


def mass_moments(p, x, length):
    """Return (M [kg], S [kg m], I [kg m²], M I - S²) of the nodes, about the trolley."""
    cable = p.cable
    payload = get_payload_mass(p.event_limits, x, len(x) - 1, cable.payload)
    total = cable.mass + payload
    s0 = cable.first + payload * cable.reach
    i0 = cable.second + payload * cable.reach * cable.reach
    return (
        total,
        s0 + total * length,
        i0 + length * (2.0 * s0 + total * length),
        total * i0 - s0 * s0,
    )


def solve_pull(hoist, total, rest, bias_acc, inv_mass, s, c, side, of_hoist):
    """Return (trolley's acceleration, tension, acceleration of the length).

    Args:
        hoist: its type decides which of tension and length is unknown.
        total: mass [kg] below the trolley.
        rest: M g cos α + S α'² [N], the tension of a trolley at rest and a length that does not
            change.
        bias_acc, inv_mass: acceleration [m/s²] without the cable and inverse mass [1/kg] of the
            trolley.
        s, c: sine and cosine of the angle.
        side: (M - S²/I [kg], g sin α + 2 l' α' [m/s²]), what the line carries across.
        of_hoist: (inverse mass, bias acceleration) of the length, see `hoist_response`.
    """
    across_mass, across_acc = side
    hoist_inv_mass, hoist_bias_acc = of_hoist
    if isinstance(hoist, MasslessHoist):
        tension = hoist_bias_acc
        pull = s * tension - across_mass * c * across_acc
        a = (bias_acc + inv_mass * pull) / (1.0 + inv_mass * across_mass * c * c)
        return a, tension, (rest - tension) / total - s * a
    attenuation = 1.0 / (1.0 + total * hoist_inv_mass)
    rest_tension = (rest - total * hoist_bias_acc) * attenuation
    a = (bias_acc + inv_mass * (s * rest_tension - across_mass * c * across_acc)) / (
        1.0 + inv_mass * (total * s * s * attenuation + across_mass * c * c)
    )
    tension = rest_tension - total * s * a * attenuation
    return a, tension, hoist_bias_acc + hoist_inv_mass * tension


def solve_swing(p, t, x, tau):
    """Return accelerations and forces at time t in state x under joint efforts tau."""
    nq, _, modes = layout_of(p)
    (s, c), v, w = sincos(x[nq - 1]), x[nq], x[2 * nq - 1]
    length, rate = hoisted_rod(p, x)
    total, first, second, gram = mass_moments(p, x, length)
    inv_mass, bias_acc = p.trolley.response(t, tau, 0, v, trolley_mode(p.event_limits, x, modes))
    across_mass, across_acc = gram / second, p.gravity * s + 2.0 * rate * w
    rest = total * p.gravity * c + first * w * w
    of_hoist = hoist_response(p.hoist, t, tau, hoist_mode(x), (length, rate), p.gravity)
    a, tension, paid = solve_pull(
        p.hoist, total, rest, bias_acc, inv_mass, s, c, (across_mass, across_acc), of_hoist
    )
    turning = -(first / second) * (c * a + across_acc)
    return Swing(
        s, c, a, paid, turning, tension, tension * s - across_mass * (c * a + across_acc) * c
    )


def mode_rates(p, x):
    """Return the derivatives of the modes, zeros but those of bristles, as a tuple."""
    if p.event_limits is None:
        return ()
    nq, _, modes = layout_of(p)
    return (mode_rate(p.trolley, x[nq], x[modes]), *drum_modes(p.hoist, 0.0), 0.0)


@system.rhs.register(RodCrane)
def state_derivative(p, t, x, u):
    """Return the derivative of the state."""
    nq, _, _ = layout_of(p)
    tau = system.effort(u, p, t, x)
    swing = solve_swing(p, t, x, tau)
    paid = () if p.hoist is None else (swing.paid,)
    power = meter_entry(p.energy_meter, supplied_power(p, x, tau, swing))
    return (*x[nq : 2 * nq], swing.trolley, *paid, swing.turning, *power, *mode_rates(p, x))


def supplied_power(p, x, tau, swing):
    """Return the power [W] that drives, imposed motions and losses supply."""
    return drives_power(p, x, tau, swing.tension, swing.pull, hoisted_rod(p, x)[1])


@system.kinetic.register(RodCrane)
def kinetic_energy(p, x):
    """Return the kinetic energy [J]."""
    nq, _, _ = layout_of(p)
    length, rate = hoisted_rod(p, x)
    total, first, second, _ = mass_moments(p, x, length)
    (s, c), v, w = sincos(x[nq - 1]), x[nq], x[2 * nq - 1]
    carried = (
        total * (0.5 * (v * v + rate * rate) + v * rate * s)
        + first * v * w * c
        + 0.5 * second * w * w
    )
    return (
        carried
        + 0.5 * axis_mass(p.trolley) * v * v
        + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate
    )


@system.potential.register(RodCrane)
def potential_energy(p, x):
    """Return the potential energy [J]."""
    nq, _, _ = layout_of(p)
    return -p.gravity * mass_moments(p, x, hoisted_rod(p, x)[0])[1] * sincos(x[nq - 1])[1]


@system.link_count.register(RodCrane)
def count_links(p):
    """Return the number of links that form the line."""
    return p.cable.nodes.shape[1]


@system.tensions.register(RodCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions [N] along the line, from node to node."""
    nq, _, _ = layout_of(p)
    swing, (length, _) = solve_swing(p, t, x, system.effort(u, p, t, x)), hoisted_rod(p, x)
    acceleration, rate_sq = (
        p.gravity * swing.c - swing.trolley * swing.s - swing.paid,
        x[2 * nq - 1] * x[2 * nq - 1],
    )
    rows[i, first] = swing.tension
    for k in range(1, rows.shape[1] - first):
        distance = length + p.cable.nodes[DISTANCE, k - 1]
        rows[i, first + k] = rows[i, first + k - 1] - p.cable.nodes[MASS, k - 1] * (
            acceleration + distance * rate_sq
        )


@system.power.register(RodCrane)
def external_power(p, t, x, u):
    """Return the power [W] under a source of efforts."""
    tau = system.effort(u, p, t, x)
    return supplied_power(p, x, tau, solve_swing(p, t, x, tau))


@system.points.register(RodCrane)
def write_points(p, t, x, out):
    """Write trolley and nodes."""
    nq, _, _ = layout_of(p)
    length, _ = hoisted_rod(p, x)
    s, c = sincos(x[nq - 1])
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for i in range(p.cable.nodes.shape[1]):
        r = length + p.cable.nodes[DISTANCE, i]
        out[i + 1, 0], out[i + 1, 1], out[i + 1, 2] = x[0] + r * s, 0.0, -r * c


@system.guard.register(RodCrane)
def smallest_guard(p, t, x, u, work):
    """Return the smallest guard, of drives, payload and a line that must stay taut."""
    tau, forces = system.effort(u, p, t, x), needs_forces(p, x)
    tension, pull = top_forces(p, t, x, tau) if forces else (0.0, 0.0)
    best = smallest_drive_guard(p, t, x, tau, tension, pull, hoisted_rod(p, x)[0])
    value, number = (
        smaller_guard(best, tension, encode(Guard.LINK, 0))
        if p.event_limits.stops.taut > 0.0
        else best
    )
    return value, number, int(forces)


def top_forces(p, t, x, tau):
    """Return (tension at the top, pull on the trolley) [N]."""
    swing = solve_swing(p, t, x, tau)
    return swing.tension, swing.pull


@system.apply_reset_map.register(RodCrane)
def switch(p, t, x, u, number):
    """Return the state after a change of payload or of a drive's friction; others end a run."""
    tau, (nq, _, modes), (kind, joint, _) = system.effort(u, p, t, x), layout_of(p), decode(number)
    if kind == Guard.PAYLOAD:
        after = replace_entry(x, len(x) - 1, x[len(x) - 1] + 1.0)
        gained = total_energy(p, after) - total_energy(p, x)  # the payload takes its energy along
        return replace_entry(after, modes - 1, x[modes - 1] + gained), number, True
    if kind == Guard.FRICTION:
        rate, at = (nq + 1, len(x) - 2) if joint == HOIST else (nq, modes)
        still = replace_entry(replace_entry(x, rate, 0.0 if x[at] != 0.0 else x[rate]), at, 0.0)
        mode = mode_of_stopped_drive(p, joint, x[at], tau, *top_forces(p, t, still, tau))
        return replace_entry(still, at, mode), friction_event(joint, mode), True
    return x, number, False


def total_energy(p, x):
    """Return the total energy [J]."""
    return system.kinetic(p, x) + system.potential(p, x)
