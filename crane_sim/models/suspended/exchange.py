"""Pick-up and release of loads in a run: the loads of its schedule, and how one of them passes into the next.

What is let go leaves with the motion that it has and takes its momentum along, so nothing jumps. What is taken up
joins the load by a perfectly inelastic impact: the two have their momentum and their angular momentum about the
attachment P together, as if the cable were not there,

    m v_C = m₀ v_C₀ + m₁ V,    I ω + d × m v_C = I₀ ω₀ + d₀ × m₀ v_C₀ + s₁ × V,

where d leads from P to the centre of mass C, and m₁ = m - m₀, s₁ = m d - m₀ d₀ are what is taken up at the velocity V.
Then the cable's impulses hold P (`impulses`).
"""

from typing import Any, NamedTuple

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import cross, dot, rotate_to_base
from crane_sim.models.suspended.load_dynamics import ChangedBody, add, multiply, subtract
from crane_sim.models.wind_load import Windage
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_field
from crane_sim.system import EVENT_LOG_CAPACITY, Switching

Vector = tuple[float, float, float]
INERTIA, INVERSE, ATTACHMENT, CENTRE = 0, 9, 18, 21
"""Columns of `Exchange.bodies`."""
COLUMNS = 24
DONE = 1
"""Outcome of an exchange after which the run goes on."""


class Exchange(NamedTuple):
    """Schedule of a crane's loads, all point masses or all rigid bodies."""

    times: Any  # (n,) s, of the exchanges, in order
    velocities: Any  # (n, 3) m/s, of what is taken up, relative to the base and in its axes
    carried: Any  # (n,) 1: what is taken up moves with the load, or something is let go: no velocity jumps
    masses: Any  # (n + 1,) kg, of the loads
    bodies: Any  # (n + 1, COLUMNS) inertia, its inverse, attachment and centre of pressure of rigid ones
    windages: Any  # (n + 1, 2) area and drag coefficient


class Joined(NamedTuple):
    """The load and what it takes up, as one body that no cable holds yet."""

    jump: Vector  # m/s, of the attachment's velocity, in the axes of the base
    omega: Vector  # rad/s, in the body's axes
    energy: float  # J, kinetic, less that of the load before


@generic
def exchange_modes(exchange):
    """Return the number of floats that the exchange adds to the state: how many exchanges there were."""
    return 1


@exchange_modes.register(type(None))
def _(exchange):
    return 0


@generic
def count_exchanges(exchange, t, x, mode):
    """Write the number of exchanges before time t [s] into state x at index `mode`."""


@count_exchanges.register(Exchange)
def _(exchange, t, x, mode):
    x[mode] = 0.0
    for time in exchange.times:
        if time < t:
            x[mode] += 1.0


@generic
def windage_of_row(windage, exchange, k):
    """Return the windage of load k: None where no load has any."""
    return windage


@windage_of_row.register(Windage)
def _(windage, exchange, k):
    return Windage(exchange.windages[k, 0], exchange.windages[k, 1])


def vector_at(rows, k, i):
    """Return entries i to i + 2 of row k as a vector."""
    return rows[k, i], rows[k, i + 1], rows[k, i + 2]


def matrix_at(rows, k, i):
    """Return entries i to i + 8 of row k as the rows of a matrix."""
    return vector_at(rows, k, i), vector_at(rows, k, i + 3), vector_at(rows, k, i + 6)


@generic
def scheduled_load(load, exchange, k):
    """Return load k of the schedule; `load` is the first one."""
    load = replace_field(load, "mass", exchange.masses[k])
    return replace_field(load, "windage", windage_of_row(load.windage, exchange, k))


@scheduled_load.register(RigidLoad)
def _(load, exchange, k):
    rows, windage = exchange.bodies, windage_of_row(load.windage, exchange, k)
    tensor, inverse = matrix_at(rows, k, INERTIA), matrix_at(rows, k, INVERSE)
    attachment, centre = vector_at(rows, k, ATTACHMENT), vector_at(rows, k, CENTRE)
    return RigidLoad(exchange.masses[k], tensor, inverse, attachment, windage, centre)


@generic
def current_load(exchange, load, x, mode):
    """Return the load in state x, whose exchanges are counted at index `mode`; `load` is the first one."""
    return load


@current_load.register(Exchange)
def _(exchange, load, x, mode):
    return scheduled_load(load, exchange, int(x[mode]))


@generic
def body_of_coordinates(exchange, load, x, mode, state):
    """Return the kinematics of the load in state x, its coordinates being those of the first load's centre of mass.

    Args:
        exchange, load, x, mode: as of `current_load`.
        state: BodyState of the coordinates.
    """
    return state


@body_of_coordinates.register(Exchange)
def _(exchange, load, x, mode, state):
    position, velocity, rows, omega, quaternion = state
    k = int(x[mode])
    c = subtract(load.attachment, vector_at(exchange.bodies, k, ATTACHMENT))
    position, velocity = add(position, multiply(rows, c)), add(velocity, multiply(rows, cross(omega, c)))
    return ChangedBody(position, velocity, rows, omega, quaternion, c, k)


@generic
def exchange_guard(exchange, best, t, x, mode):
    """Return the smaller one of `best` and the guard of the next exchange of the load."""
    return best


@exchange_guard.register(Exchange)
def _(exchange, best, t, x, mode):
    k = int(x[mode])
    return smaller_guard(best, exchange.times[k] - t, encode(Guard.PAYLOAD, k)) if k < len(exchange.times) else best


@generic
def with_exchange_switching(exchange, switching):
    """Return the result of `system.switching`: `switching` without exchanges."""
    return switching


@with_exchange_switching.register(Exchange)
def _(exchange, switching):
    # no `step_control`: a step to an exchange at the start of a period would have no size
    return Switching(EVENT_LOG_CAPACITY, 0, None)


@generic
def join(load, after, state, velocity):
    """Return what the load and what it takes up become, `Joined`.

    Args:
        load: parameters before.
        after: parameters of both together.
        state: kinematics of the load.
        velocity: of what is taken up (3,) [m/s], relative to the base and in its axes.
    """
    share, v = (after.mass - load.mass) / after.mass, state.velocity
    dx, dy, dz = subtract(velocity, v)
    jump = share * dx, share * dy, share * dz
    new = add(v, jump)
    return Joined(jump, (0.0, 0.0, 0.0), 0.5 * (after.mass * dot(new, new) - load.mass * dot(v, v)))


@join.register(RigidLoad)
def _(load, after, state, velocity):
    m0, m = load.mass, after.mass
    (x0, y0, z0), (x, y, z) = load.attachment, after.attachment
    d0, d, w = (-x0, -y0, -z0), (-x, -y, -z), state.omega
    v, given = rotate_to_base(state.rows, state.velocity), rotate_to_base(state.rows, velocity)
    more, moment = m - m0, (m * d[0] - m0 * d0[0], m * d[1] - m0 * d0[1], m * d[2] - m0 * d0[2])
    momentum = m0 * v[0] + more * given[0], m0 * v[1] + more * given[1], m0 * v[2] + more * given[2]
    cx, cy, cz = cross(d0, v)
    spin = add(add(multiply(load.inertia, w), (m0 * cx, m0 * cy, m0 * cz)), cross(moment, given))
    omega = multiply(after.inverse_inertia, subtract(spin, cross(d, momentum)))
    centre = momentum[0] / m, momentum[1] / m, momentum[2] / m
    jump = subtract(subtract(centre, cross(omega, d)), subtract(v, cross(w, d0)))
    energy = 0.5 * (m * dot(centre, centre) + dot(omega, multiply(after.inertia, omega)))
    energy -= 0.5 * (m0 * dot(v, v) + dot(w, multiply(load.inertia, w)))
    return Joined(multiply(state.rows, jump), omega, energy)


@generic
def carry(load, after, state):
    """Return `Joined` of a part that moves with the load, or is let go: no velocity of what stays jumps."""
    v = state.velocity
    return Joined((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.5 * (after.mass - load.mass) * dot(v, v))


@carry.register(RigidLoad)
def _(load, after, state):
    w, v0 = state.omega, rotate_to_base(state.rows, state.velocity)
    v = add(v0, cross(w, subtract(load.attachment, after.attachment)))
    energy = 0.5 * (after.mass * dot(v, v) + dot(w, multiply(after.inertia, w)))
    return Joined((0.0, 0.0, 0.0), w, energy - 0.5 * (load.mass * dot(v0, v0) + dot(w, multiply(load.inertia, w))))


def describe_exchange(exchange: Exchange, k: int, outcome: int, rods: bool) -> tuple[str, str]:
    """Return texts (meaning of exchange k, what a user can change); the outcome is DONE, or it ended the run.

    Args:
        exchange, k, outcome: of the payload, number and outcome of the event.
        rods: whether the links may be rods, which push: falls of a reeving may not.
    """
    before, after = float(exchange.masses[k]), float(exchange.masses[k + 1])
    word, change = ("taken up", after - before) if after > before else ("let go", before - after)
    text = f"payload of {change:g} kg {word}, {after:g} kg hang now"
    if outcome == DONE:
        return text, ""
    return (
        f"{text}: a link would push at that",
        f"change events[{k}].velocity" + (", or take rope.slack: allow if links are rods" if rods else ""),
    )
