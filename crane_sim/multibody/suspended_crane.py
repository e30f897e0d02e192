"""A crane: a support, a chain of rigid links below its tip, and a load at the end, on a base that may move.

State: positions [support (ns), (first length), directions n_1 .. n_N (3 each), (attitude of a body, 4)], all relative
to the base, then their rates. Equations see directions and attitude put back on what they hold, |n| = 1 and n · n' = 0.
"""

from typing import Any, NamedTuple

from crane_sim.multibody import linear
from crane_sim.multibody.attitude import align
from crane_sim.multibody.chain import Link, Winch, direction_accelerations, solve_tensions
from crane_sim.multibody.load import (
    Load,
    LoadForce,
    LoadMotion,
    RigidLoad,
    attitude_acceleration,
    end_acceleration,
    end_acceleration_across,
    end_mobility,
    move_load,
    pull_moment,
)
from crane_sim.multibody.tree import (
    BaseMotion,
    Dynamics,
    Tree,
    Wrench,
    accelerations,
    base_reaction,
    compute_dynamics,
    efforts_of,
    point_acceleration,
    point_mobility,
    point_position,
    to_base_axes,
    to_tree_axes,
)
from crane_sim.multibody.vectors import ZERO, Vector, add, cross, scale, subtract


class Crane(NamedTuple):
    """Parameters of a crane."""

    support: Tree
    masses: tuple[Any, ...]  # kg, of the nodes above the load, from the top
    lengths: tuple[Any, ...]  # m, of the links; the first is a coordinate where there is a hoist
    load: Load
    hoisted: bool = False  # the first length is a coordinate


class Inputs(NamedTuple):
    """What acts on a crane at one instant."""

    base: BaseMotion
    efforts: tuple[Any, ...]  # (ns,) on the support's joints
    winch: Winch = Winch()  # its `rate` is the state's, where the length is a coordinate
    on_load: LoadForce = LoadForce()
    free: tuple[Any, ...] | None = None  # (ns,) conditions: joints that do not stick; None: none does


class State(NamedTuple):
    """Positions or velocities, accelerations of a crane."""

    support: tuple[Any, ...]
    length: Any  # None without a hoist
    directions: tuple[Vector, ...]
    attitude: Any  # (4,), None of a point mass


class Solution(NamedTuple):
    """Accelerations and forces at one instant."""

    accelerations: State
    tensions: tuple[Any, ...]  # N, from the top
    reaction: Wrench  # of the base on the support, about the base's origin, in the tree's axes
    dynamics: Dynamics


def crane_accelerations(crane: Crane, q: State, v: State, inputs: Inputs) -> Solution:
    """Return what moves, and what holds, a crane in a state of positions q and velocities v."""
    dynamics = compute_dynamics(crane.support, q.support, v.support, inputs.base, inputs.free)
    motion = _load_motion(crane.load, q, v, inputs.base)
    links = _links(crane, q, v, motion, inputs.base)
    winch = inputs.winch._replace(rate=v.length) if crane.hoisted else inputs.winch
    free = _free_accelerations(crane, dynamics, inputs, motion)
    first, last = to_tree_axes(dynamics, links[0].unit), links[-1].unit
    mobility = point_mobility(crane.support, dynamics, crane.support.tip, first, inputs.free)
    tensions, length_acceleration = solve_tensions(links, winch, mobility, free)
    pull = scale(tensions[0], first)
    efforts = linear.add(inputs.efforts, efforts_of(crane.support, dynamics, crane.support.tip, pull))
    qdd = accelerations(dynamics, efforts, inputs.free)
    tip = point_acceleration(crane.support, dynamics, crane.support.tip, qdd)
    end = add(free[-1], end_acceleration_across(crane.load, motion, last, tensions[-1]))
    ends = (to_base_axes(dynamics, tip), *free[1:-1], end)
    directions = direction_accelerations(links, winch, tensions, ends)
    moved = State(
        qdd,
        length_acceleration if crane.hoisted else None,
        tuple(_relative(a, n, d, inputs.base) for a, n, d in zip(directions, q.directions, v.directions, strict=True)),
        _attitude_acceleration(crane.load, motion, inputs, last, tensions[-1]),
    )
    return Solution(moved, tensions, _reaction(crane, dynamics, qdd, pull), dynamics)


def aligned(q: State, v: State) -> tuple[State, State]:
    """Return positions and velocities whose directions and attitude are put back on what they hold."""
    pairs = [align(n, rate) for n, rate in zip(q.directions, v.directions, strict=True)]
    units: Any = tuple(unit for unit, _ in pairs)
    rates: Any = tuple(rate for _, rate in pairs)
    attitude, spin = align(q.attitude, v.attitude) if q.attitude is not None else (None, None)
    return q._replace(directions=units, attitude=attitude), v._replace(directions=rates, attitude=spin)


def _links(crane: Crane, q: State, v: State, motion: LoadMotion | None, base: BaseMotion) -> tuple[Link, ...]:
    lengths = (q.length, *crane.lengths[1:]) if crane.hoisted else crane.lengths
    mobilities = [*(1.0 / mass for mass in crane.masses), end_mobility(crane.load, motion, q.directions[-1])]
    links = []
    for n, rate, length, mobility in zip(q.directions, v.directions, lengths, mobilities, strict=True):
        links.append(Link(n, add(rate, cross(base.angular_velocity, n)), length, mobility))
    return tuple(links)


def _load_motion(load: Load, q: State, v: State, base: BaseMotion) -> LoadMotion | None:
    return move_load(q.attitude, v.attitude, base) if isinstance(load, RigidLoad) else None


def _free_accelerations(
    crane: Crane, dynamics: Dynamics, inputs: Inputs, motion: LoadMotion | None
) -> tuple[Vector, ...]:
    """Return the absolute accelerations (N + 1) of tip, nodes and load without tensions, in the base's axes."""
    qdd = accelerations(dynamics, inputs.efforts, inputs.free)
    tip = point_acceleration(crane.support, dynamics, crane.support.tip, qdd)
    nodes = (ZERO,) * len(crane.masses)  # they fall: gravity is in the accelerations
    return (to_base_axes(dynamics, tip), *nodes, end_acceleration(crane.load, motion, inputs.on_load))


def _relative(acceleration: Vector, n: Vector, rate: Vector, base: BaseMotion) -> Vector:
    """Return the second derivative of a direction in the base's axes, from the absolute one."""
    w, alpha = base.angular_velocity, base.angular_acceleration
    carried = add(cross(alpha, n), cross(w, add(cross(w, n), scale(2.0, rate))))
    return subtract(acceleration, carried)


def _attitude_acceleration(load: Load, motion: LoadMotion | None, inputs: Inputs, last: Vector, tension: Any) -> Any:
    if not isinstance(load, RigidLoad) or motion is None:
        return None
    moment = add(inputs.on_load.moment, pull_moment(load, motion, last, tension))
    return attitude_acceleration(load, motion, inputs.base, moment)


def _reaction(crane: Crane, dynamics: Dynamics, qdd: tuple[Any, ...], pull: Vector) -> Wrench:
    """Return what the base does: what moves the support less the rope's pull on its tip."""
    total = base_reaction(dynamics, qdd)
    place = point_position(dynamics, crane.support.tip)
    return Wrench(subtract(total.force, pull), subtract(total.moment, cross(place, pull)))
