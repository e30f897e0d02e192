"""A crane whose load, a rigid body, hangs on n elastic falls below the support's tip.

Fall i leads from the point a_i, given from the tip in axes of the link that the slew turns (of the base where none
does), to b_i of the load, given from its centre of mass in its own axes. Of its unstretched length L_i = l + δ_i the
winch drives l, common to all. With the distance d_i of the two points and the elongation e_i = d_i - L_i a taut fall
pulls with

    T_i = (EA_i / L_i) (e_i + τ_i e_i'),

and a slack one with nothing. The rope on the drum is unstretched: a winch that pays out loses T + T_s²/(2 EA) for each
metre, the pull and the energy of the strain that goes with it, T_s without the damping.

State: positions [support (ns), (length), centre of mass (3), attitude (4)] relative to the base, then their rates.
"""

from typing import Any, NamedTuple

from crane_sim.multibody import linear
from crane_sim.multibody.attitude import align, angular_velocity
from crane_sim.multibody.chain import Winch
from crane_sim.multibody.load import LoadForce, RigidLoad, attitude_acceleration, move_load, to_body
from crane_sim.multibody.tree import (
    BaseMotion,
    Dynamics,
    Point,
    Tree,
    Wrench,
    accelerations,
    base_reaction,
    compute_dynamics,
    efforts_of,
    point_position,
    point_velocity,
    slew,
    to_base_axes,
    to_tree_axes,
)
from crane_sim.multibody.vectors import (
    ZERO,
    Vector,
    acceleration_gradient,
    add,
    combine,
    cross,
    dot,
    multiply,
    scale,
    subtract,
)
from crane_sim.tracing.operations import sqrt


class Fall(NamedTuple):
    """One elastic rope."""

    top: Vector  # m, from the tip, in axes of the link that the slew turns
    bottom: Vector  # m, from the load's centre of mass, in its axes
    axial_stiffness: Any  # N, EA of all parts of the fall together
    relaxation: Any = 0.0  # s, τ of the damping
    offset: Any = 0.0  # m, added to the common length


class FallsCrane(NamedTuple):
    """Parameters of a crane."""

    support: Tree
    falls: tuple[Fall, ...]
    load: RigidLoad  # its attachment is not used
    length: Any = None  # m, unstretched; None: a winch drives it, it is a coordinate


class FallsState(NamedTuple):
    """Positions or velocities, accelerations of a crane, relative to the base."""

    support: tuple[Any, ...]
    length: Any  # None without a winch
    centre: Vector
    attitude: Any  # (4,)


class FallsInputs(NamedTuple):
    """What acts on a crane at one instant."""

    base: BaseMotion
    efforts: tuple[Any, ...]  # (ns,) on the support's joints
    taut: tuple[Any, ...]  # (n,) 1 for a taut fall, 0 for a slack one
    winch: Winch = Winch()
    on_load: LoadForce = LoadForce()
    free: tuple[Any, ...] | None = None  # (ns,) conditions: joints that do not stick; None: none does


class Pull(NamedTuple):
    """What a fall does, in the base's axes."""

    force: Vector  # N, on the load
    moment: Vector  # N m, on the load about its centre of mass
    couple: Vector  # N m, on the support about the tip
    on_winch: Any  # N, T + T_s² / (2 EA)
    tension: Any  # N, of the taut fall


class FallsSolution(NamedTuple):
    """Accelerations and forces at one instant."""

    accelerations: FallsState
    tensions: tuple[Any, ...]  # N
    reaction: Wrench  # of the base on the support, about the base's origin, in the tree's axes


def falls_accelerations(crane: FallsCrane, q: FallsState, v: FallsState, inputs: FallsInputs) -> FallsSolution:
    """Return what moves, and what holds, a crane in a state of positions q and velocities v, aligned."""
    dynamics = compute_dynamics(crane.support, q.support, v.support, inputs.base, inputs.free)
    motion = move_load(q.attitude, v.attitude, inputs.base)
    omega = angular_velocity(q.attitude, v.attitude)
    pulls = [_pull(crane, i, dynamics, (q, v), motion.rows, omega, inputs) for i in range(len(crane.falls))]
    force, moment, couple = (_total(vectors) for vectors in zip(*(pull[:3] for pull in pulls), strict=True))
    qdd = _support_accelerations(crane, dynamics, inputs, force, couple)
    turning = add(inputs.on_load.moment, to_body(motion.rows, moment))
    on_winch = sum((pull.on_winch for pull in pulls), 0.0)
    moved = FallsState(
        qdd,
        inputs.winch.acceleration + inputs.winch.inverse_mass * on_winch if crane.length is None else None,
        _centre_acceleration(crane.load, q, v, inputs, force),
        attitude_acceleration(crane.load, motion, inputs.base, turning),
    )
    reaction = _reaction(crane, dynamics, qdd, to_tree_axes(dynamics, force), to_tree_axes(dynamics, couple))
    return FallsSolution(moved, tuple(pull.tension for pull in pulls), reaction)


def aligned_attitude(q: FallsState, v: FallsState) -> tuple[FallsState, FallsState]:
    """Return positions and velocities whose attitude is put back on what it holds."""
    attitude, rate = align(q.attitude, v.attitude)
    return q._replace(attitude=attitude), v._replace(attitude=rate)


def _pull(
    crane: FallsCrane, i: int, dynamics: Dynamics, state: tuple[FallsState, FallsState], rows: Any, omega: Vector,
    inputs: FallsInputs,
) -> Pull:  # fmt: skip
    (q, v), fall = state, crane.falls[i]
    length, rate = (q.length, v.length) if crane.length is None else (crane.length, 0.0)
    arm = to_base_axes(dynamics, _arm(crane, dynamics, fall))
    lever, moves = multiply(rows, fall.bottom), multiply(rows, cross(omega, fall.bottom))
    top, velocity = _top_motion(crane, dynamics, fall, inputs.base)
    along = subtract(top, add(q.centre, lever))
    distance = sqrt(dot(along, along))
    n = scale(1.0 / distance, along)
    rest = length + fall.offset
    elongation_rate = dot(n, subtract(velocity, add(v.centre, moves))) - rate
    stiffness = fall.axial_stiffness / rest
    spring = stiffness * (distance - rest)
    tension = inputs.taut[i] * (spring + stiffness * fall.relaxation * elongation_rate)
    strain = inputs.taut[i] * spring * spring / (2.0 * fall.axial_stiffness)
    force = scale(tension, n)
    return Pull(force, cross(lever, force), scale(-1.0, cross(arm, force)), tension + strain, tension)


def _top_motion(crane: FallsCrane, dynamics: Dynamics, fall: Fall, base: BaseMotion) -> tuple[Vector, Vector]:
    """Return place and velocity of a fall's upper end relative to the base, in its axes."""
    place, arm, slewed = point_position(dynamics, crane.support.tip), _arm(crane, dynamics, fall), slew(crane.support)
    velocity = subtract(point_velocity(dynamics, crane.support.tip), _carried_velocity(dynamics, base, place))
    if slewed is not None:
        base_rate = to_tree_axes(dynamics, base.angular_velocity)
        velocity = add(velocity, cross(subtract(dynamics.links[slewed].angular_velocity, base_rate), arm))
    return to_base_axes(dynamics, add(place, arm)), to_base_axes(dynamics, velocity)


def _arm(crane: FallsCrane, dynamics: Dynamics, fall: Fall) -> Vector:
    """Return the way from the tip to a fall's upper end, in the tree's axes."""
    slewed = slew(crane.support)
    return fall.top if slewed is None else combine(dynamics.links[slewed].axes, fall.top)


def _carried_velocity(dynamics: Dynamics, base: BaseMotion, place: Vector) -> Vector:
    return add(to_tree_axes(dynamics, base.velocity), cross(to_tree_axes(dynamics, base.angular_velocity), place))


def _support_accelerations(
    crane: FallsCrane, dynamics: Dynamics, inputs: FallsInputs, force: Vector, couple: Vector
) -> tuple[Any, ...]:
    pulled = efforts_of(crane.support, dynamics, crane.support.tip, scale(-1.0, to_tree_axes(dynamics, force)))
    efforts, slewed = linear.add(inputs.efforts, pulled), slew(crane.support)
    if slewed is not None:
        turned = efforts_of(crane.support, dynamics, Point(slewed), ZERO, to_tree_axes(dynamics, couple))
        efforts = linear.add(efforts, turned)
    return accelerations(dynamics, efforts, inputs.free)


def _centre_acceleration(load: RigidLoad, q: FallsState, v: FallsState, inputs: FallsInputs, pull: Vector) -> Vector:
    """Return the acceleration of the centre of mass relative to the base."""
    base = inputs.base
    gradient = acceleration_gradient(base.angular_velocity, base.angular_acceleration)
    carried = add(
        add(base.acceleration, multiply(gradient, q.centre)), cross(base.angular_velocity, scale(2.0, v.centre))
    )
    return subtract(scale(1.0 / load.mass, add(pull, inputs.on_load.force)), carried)


def _reaction(crane: FallsCrane, dynamics: Dynamics, qdd: tuple[Any, ...], force: Vector, couple: Vector) -> Wrench:
    """Return what the base does: what moves the support, and what its falls pull it down with."""
    total, place = base_reaction(dynamics, qdd), point_position(dynamics, crane.support.tip)
    moment = subtract(add(total.moment, cross(place, force)), couple)
    return Wrench(add(total.force, force), moment)


def _total(vectors: Any) -> Vector:
    total = ZERO
    for vector in vectors:
        total = add(total, vector)
    return total
