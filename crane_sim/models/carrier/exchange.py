"""Pick-up and release of loads: the loads of a run's schedule, and the passage to the next one.

What is let go leaves with the motion that it has and takes its momentum along, so nothing jumps.
What is taken up joins the load by a perfectly inelastic impact: the two have their momentum and
their angular momentum about the attachment P together, as if the cable were not there,

    m v_C = m₀ v_C₀ + m₁ V,    I ω + d × m v_C = I₀ ω₀ + d₀ × m₀ v_C₀ + s₁ × V,

where d leads from P to the centre of mass C, and m₁ = m - m₀, s₁ = m d - m₀ d₀ are what is taken up
at the velocity V. Then the cable's impulses hold P (`impulses`).
"""

from typing import Any, NamedTuple

from crane_sim.models.carrier.layout import exchange_index
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.loads import PointLoad, RigidLoad
from crane_sim.models.moving_base import rotate_to_base
from crane_sim.models.wind_load import Windage
from crane_sim.multibody.vectors import ZERO, Vector, add, cross, dot, multiply, scale, subtract
from crane_sim.system import EVENT_LOG_CAPACITY, Switching

INERTIA, INVERSE, ATTACHMENT, CENTRE = 0, 9, 18, 21
"""Columns of `Exchange.bodies`."""
COLUMNS = 24
DONE = 1
"""Outcome of an exchange after which the run goes on."""


class Exchange(NamedTuple):
    """Schedule of a crane's loads, all point masses or all rigid bodies."""

    times: Any  # (n,) s, of the exchanges, in order
    velocities: Any  # (n, 3) m/s, of what is taken up, relative to the base and in its axes
    carried: Any  # (n,) 1: what is taken up moves with the load, or something is let go: no
    # velocity jumps
    masses: Any  # (n + 1,) kg, of the loads
    bodies: Any  # (n + 1, COLUMNS) inertia, its inverse, attachment and centre of pressure of rigid
    # ones
    windages: Any  # (n + 1, 2) area and drag coefficient


class Joined(NamedTuple):
    """The load and what it takes up, as one body that no cable holds yet."""

    jump: Vector  # m/s, of the attachment's velocity, in the axes of the base
    omega: Vector  # rad/s, in the body's axes
    energy: float  # J, kinetic, less that of the load before


def count_exchanges(p, t, x):
    """Write the number of exchanges before time t [s] into state x."""
    if p.exchange is None:
        return
    mode = exchange_index(p)
    x[mode] = 0.0
    for time in p.exchange.times:
        if time < t:
            x[mode] += 1.0


def vector_at(rows, k, i):
    """Return entries i to i + 2 of row k as a vector."""
    return rows[k, i], rows[k, i + 1], rows[k, i + 2]


def matrix_at(rows, k, i):
    """Return entries i to i + 8 of row k as the rows of a matrix."""
    return vector_at(rows, k, i), vector_at(rows, k, i + 3), vector_at(rows, k, i + 6)


def load_of(p, x) -> Any:
    """Return the parameters of the load in state x."""
    if p.exchange is None:
        return p.load
    k, rows = int(x[exchange_index(p)]), p.exchange.bodies
    mass, windage = p.exchange.masses[k], p.load.windage
    if windage is not None:
        windage = Windage(p.exchange.windages[k, 0], p.exchange.windages[k, 1])
    if isinstance(p.load, PointLoad):
        return PointLoad(mass, windage)
    tensor, inverse = matrix_at(rows, k, INERTIA), matrix_at(rows, k, INVERSE)
    return RigidLoad(
        mass, tensor, inverse, vector_at(rows, k, ATTACHMENT), windage, vector_at(rows, k, CENTRE)
    )


def body_of_coordinates(p, x, state):
    """Return the BodyState of the load in state x, from that of its coordinates.

    The coordinates are those of the first load's centre of mass.
    """
    if p.exchange is None:
        return state
    k = int(x[exchange_index(p)])
    c = subtract(p.load.attachment, vector_at(p.exchange.bodies, k, ATTACHMENT))
    position = add(state.position, multiply(state.rows, c))
    velocity = add(state.velocity, multiply(state.rows, cross(state.omega, c)))
    return state._replace(position=position, velocity=velocity, centre=c, number=k)


def exchange_guard(p, best, t, x):
    """Return the smaller one of `best` and the guard of the next exchange of the load."""
    if p.exchange is None:
        return best
    times, k = p.exchange.times, int(x[exchange_index(p)])
    return smaller_guard(best, times[k] - t, encode(Guard.PAYLOAD, k)) if k < len(times) else best


def with_exchange_switching(exchange, switching):
    """Return the result of `system.switching`: `switching` without exchanges."""
    # no `step_control`: a step to an exchange at the start of a period would have no size
    return switching if exchange is None else Switching(EVENT_LOG_CAPACITY, 0, None)


def join(load, after, state, velocity):
    """Return what the load and what it takes up become, `Joined`.

    Args:
        load: parameters before.
        after: parameters of both together.
        state: kinematics of the load.
        velocity: of what is taken up (3,) [m/s], relative to the base and in its axes.
    """
    if isinstance(load, RigidLoad):
        return join_bodies(load, after, state, velocity)
    v = state.velocity
    jump = scale((after.mass - load.mass) / after.mass, subtract(velocity, v))
    new = add(v, jump)
    return Joined(jump, ZERO, 0.5 * (after.mass * dot(new, new) - load.mass * dot(v, v)))


def join_bodies(load, after, state, velocity):
    """Return the result of `join` for rigid bodies."""
    m0, m, d0, d = (
        load.mass,
        after.mass,
        scale(-1.0, load.attachment),
        scale(-1.0, after.attachment),
    )
    w, v, given = (
        state.omega,
        rotate_to_base(state.rows, state.velocity),
        rotate_to_base(state.rows, velocity),
    )
    momentum, moment = add(scale(m0, v), scale(m - m0, given)), subtract(scale(m, d), scale(m0, d0))
    spin = add(add(multiply(load.inertia, w), scale(m0, cross(d0, v))), cross(moment, given))
    omega = multiply(after.inverse_inertia, subtract(spin, cross(d, momentum)))
    centre = momentum[0] / m, momentum[1] / m, momentum[2] / m
    jump = subtract(subtract(centre, cross(omega, d)), subtract(v, cross(w, d0)))
    energy = 0.5 * (m * dot(centre, centre) + dot(omega, multiply(after.inertia, omega)))
    energy -= 0.5 * (m0 * dot(v, v) + dot(w, multiply(load.inertia, w)))
    return Joined(multiply(state.rows, jump), omega, energy)


def carried_energy(load, after, state):
    """Return the energy [J] of a part that moves with the load, or is let go.

    No velocity of what stays jumps.

    It is kinetic, less that of the load before.
    """
    if isinstance(load, PointLoad):
        return 0.5 * (after.mass - load.mass) * dot(state.velocity, state.velocity)
    w, v0 = state.omega, rotate_to_base(state.rows, state.velocity)
    v = add(v0, cross(w, subtract(load.attachment, after.attachment)))
    energy = 0.5 * (after.mass * dot(v, v) + dot(w, multiply(after.inertia, w)))
    return energy - 0.5 * (load.mass * dot(v0, v0) + dot(w, multiply(load.inertia, w)))


def describe_exchange(
    exchange: Exchange, k: int, outcome: int, forbidden: tuple[str, str]
) -> tuple[str, str]:
    """Return texts (meaning of exchange k, what a user can change).

    The outcome is DONE, or it ended the run.

    Args:
        exchange, k, outcome: of the payload, number and outcome of the event.
        forbidden: why it would end a run, what a user can change.
    """
    before, after = float(exchange.masses[k]), float(exchange.masses[k + 1])
    word, change = ("taken up", after - before) if after > before else ("let go", before - after)
    text = f"payload of {change:g} kg {word}, {after:g} kg hang now"
    return (text, "") if outcome == DONE else (f"{text}: {forbidden[0]}", forbidden[1])
