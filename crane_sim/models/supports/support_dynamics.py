"""Forces, accelerations, power and energies of a support in a posture, from joints and bodies.

Vectors are in the tree's axes (`multibody.tree`): the base's, turned by the slew.
"""

from typing import Any, NamedTuple

from crane_sim.models.moving_base import (
    BaseKinematics,
    BaseState,
    added_energy,
    airspeed,
    imposed_acceleration,
    turned_by,
)
from crane_sim.models.supports.backlash import replace_by_pushes
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.support import (
    Mechanism,
    Posture,
    Pressed,
    Spring,
    Support,
    SupportState,
    frictions_of,
)
from crane_sim.models.wind_load import BoomWindage, RodWindage, rod_drag
from crane_sim.multibody import linear
from crane_sim.multibody.tree import (
    Inertia,
    Point,
    Wrench,
    body_motions,
    compute_inertia,
    efforts_of,
    point_position,
    point_velocity,
    to_base_axes,
    to_tree_axes,
    tree_reaction,
    wrench_at,
)
from crane_sim.multibody.vectors import Vector, add, cross, dot, multiply, scale, subtract
from crane_sim.numerics.states import replace_entry


class Dynamics(NamedTuple):
    """The inertia of a support in a posture."""

    inertia: Inertia
    matrix: linear.Matrix  # (n, n), with the motors
    free: tuple[Any, ...]  # (n,) which coordinates move: neither held by friction nor prescribed
    factors: linear.Factors  # of the matrix of the free ones


def compute_dynamics(support: Support, posture: Posture) -> Dynamics:
    """Return a support's inertia in a posture, with motors, without what friction holds."""
    mechanism = posture.mechanism
    inertia = compute_inertia(mechanism.tree, posture.kinematics, len(posture.state.q))
    matrix = _add_to_diagonal(inertia.matrix, support.motors)
    free = _free_coordinates(support, mechanism, posture.state)
    return Dynamics(inertia, matrix, free, linear.factor(_of_free(matrix, free)))


def _add_to_diagonal(matrix: linear.Matrix, motors: tuple[float, ...] | None) -> linear.Matrix:
    if motors is None:
        return matrix
    return tuple((*row[:-1], row[-1] + motor) for row, motor in zip(matrix, motors, strict=True))


def _free_coordinates(
    support: Support, mechanism: Mechanism, state: SupportState
) -> tuple[Any, ...]:
    free = tuple(not each for each in mechanism.prescribed) or (True,) * len(state.q)
    for (i, friction), friction_state in zip(frictions_of(support), state.friction, strict=True):
        if isinstance(friction, Friction):
            free = replace_entry(free, i, free[i] and not friction.sticks(friction_state))
    return free


def _of_free(matrix: linear.Matrix, free: tuple[Any, ...]) -> linear.Matrix:
    """Return the matrix with the identity's rows and columns for coordinates that are not free."""
    rows = ()
    for i, row in enumerate(matrix):
        others = tuple(_entry_if(free[i], _entry_if(free[k], row[k])) for k in range(i))
        rows = (*rows, (*others, row[i] if free[i] else 1.0))
    return rows


def _entry_if(condition: Any, entry: Any) -> Any:
    """Return an entry where a condition holds, else 0; a structural 0 stays one."""
    if isinstance(entry, int):
        return entry
    return entry if condition else 0.0


def joint_efforts(support: Support, posture: Posture, command: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the efforts (n,) of drives, springs and friction at commands.

    Drives that prescribe motions have none.
    """
    state, mechanism = posture.state, posture.mechanism
    efforts = mechanism.by_coordinate(command)
    if mechanism.prescribed:
        efforts = tuple(
            0 if p else effort for p, effort in zip(mechanism.prescribed, efforts, strict=True)
        )
    efforts = replace_by_pushes(support.drives, efforts, state)
    for spring in mechanism.springs:
        efforts = linear.add(efforts, _spring_efforts(spring, state.q, state.v))
    for (i, friction), friction_state in zip(frictions_of(support), state.friction, strict=True):
        efforts = replace_entry(
            efforts, i, efforts[i] + friction.effort(state.v[i], friction_state)
        )
    return efforts


def prescribed_accelerations(
    support: Support, posture: Posture, t: Any, command: tuple[Any, ...]
) -> tuple[Any, ...]:
    """Return the accelerations (n,) that drives prescribe at t [s] and commands, 0 of others.

    The result is () where none do.
    """
    state, mechanism = posture.state, posture.mechanism
    if not mechanism.prescribed:
        return ()
    return support.structure.prescribe(t, mechanism.by_coordinate(command), state.q, state.v)


def _deflection(spring: Spring, q: tuple[Any, ...]) -> Any:
    return linear.inner(spring.lever, q) - spring.rest


def _spring_efforts(spring: Spring, q: tuple[Any, ...], v: tuple[Any, ...]) -> tuple[Any, ...]:
    pull = spring.stiffness * _deflection(spring, q) + spring.damping * linear.inner(
        spring.lever, v
    )
    return linear.scale(-pull, spring.lever)


def base_efforts(posture: Posture, base: Any) -> tuple[Any, ...]:
    """Return the efforts (n,) of a moving base's inertial forces on the support's bodies.

    `base` is that of `moving_base.base_kinematics_at`, None at rest.
    """
    tree, kinematics = posture.mechanism.tree, posture.kinematics
    total: tuple[Any, ...] = (0,) * len(posture.state.q)
    for joint, wrench in _imposed_wrenches(posture, base):
        total = linear.add(total, efforts_of(tree, kinematics, len(total), joint, wrench))
    return total


def _imposed_wrenches(posture: Posture, base: Any) -> tuple[tuple[int, Wrench], ...]:
    """Return (joint, wrench) of what a moving base imposes on each body; none of a base at rest."""
    if base is None:
        return ()
    turned, wrenches = turned_by(base, *posture.kinematics.turn), ()
    for joint, body, place, velocity, inertia, omega in body_motions(
        posture.mechanism.tree, posture.kinematics
    ):
        force = scale(body.mass, imposed_acceleration(turned, place, velocity))
        moment = scale(-1.0, _imposed_spin(turned, inertia, omega))
        wrenches = (*wrenches, (joint, Wrench(force, add(moment, cross(place, force)))))
    return wrenches


def base_reaction(
    posture: Posture, dynamics: Dynamics, gravity: Any, base: Any, qdd: tuple[Any, ...]
) -> Wrench:
    """Return force [N] and moment [N m] of the base on the structure, in the tree's axes.

    What hangs at the tip is left out.

    It balances what moves the bodies at accelerations qdd (n,) of the coordinates (d'Alembert);
    motors have no part.
    """
    total = tree_reaction(posture.mechanism.tree, dynamics.inertia, qdd, gravity)
    for _, wrench in _imposed_wrenches(posture, base):
        total = Wrench(subtract(total.force, wrench.force), subtract(total.moment, wrench.moment))
    return total


def _imposed_spin(base: BaseKinematics, inertia: Any, omega: Vector) -> Vector:
    """Return the moment [N m] that a turning base adds to what turns a body.

    It is I (w' + w × ω) + Ω × I Ω - ω × I ω.
    """
    w = base.angular_velocity
    whole = add(w, omega)
    accelerated = multiply(inertia, add(base.angular_acceleration, cross(w, omega)))
    gyroscopic = subtract(
        cross(whole, multiply(inertia, whole)), cross(omega, multiply(inertia, omega))
    )
    return add(accelerated, gyroscopic)


def wind_efforts(posture: Posture, flow: Any, base: Any) -> tuple[Any, ...]:
    """Return the efforts (n,) of the wind on the structure.

    `flow` is of `airflow_at`, `base` as of `base_efforts`.
    """
    tree, kinematics, state = posture.mechanism.tree, posture.kinematics, posture.state
    total: tuple[Any, ...] = (0,) * len(state.q)
    if flow is None:
        return total
    for part in posture.mechanism.pressed:
        point, windage = _pressure_point(part, state.q)
        place, velocity = point_position(kinematics, point), point_velocity(kinematics, point)
        turn, along = kinematics.turn, kinematics.links[part.joint].axes[0]
        at, moves = to_base_axes(turn, place), to_base_axes(turn, velocity)
        force = rod_drag(windage, flow, to_base_axes(turn, along), at, airspeed(base, at, moves))
        wrench = wrench_at(place, to_tree_axes(turn, force))
        total = linear.add(total, efforts_of(tree, kinematics, len(total), part.joint, wrench))
    return total


def _pressure_point(part: Pressed, q: tuple[Any, ...]) -> tuple[Point, Any]:
    if not isinstance(part.windage, BoomWindage):
        return Point(part.joint, (part.reach, 0, 0)), part.windage
    length = q[part.length]
    whole = RodWindage(part.windage.width * length, part.windage.drag_coefficient, 0.5)
    return Point(part.joint, (0.5 * length, 0, 0)), whole


def yaw_efforts(posture: Posture, couple: Any) -> tuple[Any, ...]:
    """Return the efforts (n,) of a couple [N m] about the vertical on what carries the tip."""
    return tuple(couple if i in posture.mechanism.yaw else 0 for i in range(len(posture.state.q)))


def tip_efforts(posture: Posture, force: Vector) -> tuple[Any, ...]:
    """Return the efforts Jᵀ f (n,) of a force [N] on the tip."""
    tree, n = posture.mechanism.tree, len(posture.state.q)
    return efforts_of(tree, posture.kinematics, n, tree.tip.joint, wrench_at(posture.tip, force))


def net_efforts(dynamics: Dynamics, gravity: Any, efforts: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return what accelerates the coordinates (n,): efforts less bias and weight."""
    inertia = dynamics.inertia
    return linear.subtract(
        linear.subtract(efforts, inertia.bias_efforts), linear.scale(gravity, inertia.weights)
    )


def accelerations(
    dynamics: Dynamics, net: tuple[Any, ...], given: tuple[Any, ...]
) -> tuple[Any, ...]:
    """Return the accelerations (n,) of the coordinates under `net_efforts`, 0 if friction holds.

    `given` is of `prescribed_accelerations`.
    """
    if not given:
        return responses(dynamics, net)
    rest = linear.subtract(net, linear.product(dynamics.matrix, given))
    return linear.add(given, responses(dynamics, rest))


def responses(dynamics: Dynamics, levers: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the accelerations (n,) of the coordinates by efforts (n,), 0 of those not free."""
    return linear.solve(
        dynamics.factors, tuple(_entry_if(f, b) for f, b in zip(dynamics.free, levers, strict=True))
    )


def constraint_effort(
    dynamics: Dynamics, net: tuple[Any, ...], qdd: tuple[Any, ...], i: int
) -> Any:
    """Return what holds coordinate i bears [N or N m]: what would accelerate it."""
    others = tuple(0 if k == i else qdd[k] for k in range(len(qdd)))
    return net[i] - linear.product(dynamics.matrix, others)[i]


def drive_power(
    posture: Posture,
    dynamics: Dynamics,
    efforts: tuple[Any, ...],
    net: tuple[Any, ...],
    qdd: tuple[Any, ...],
) -> Any:
    """Return the power [W] of efforts (n,) and prescribed motions, less that which springs store.

    `net` (n,) is all that accelerates the coordinates, by qdd (n,).
    """
    state, mechanism = posture.state, posture.mechanism
    for spring in mechanism.springs:
        efforts = linear.add(
            efforts, linear.scale(spring.stiffness * _deflection(spring, state.q), spring.lever)
        )
    return linear.inner(efforts, state.v) - prescribed_power(posture, dynamics, net, qdd)


def prescribed_power(
    posture: Posture, dynamics: Dynamics, net: tuple[Any, ...], qdd: tuple[Any, ...]
) -> Any:
    """Return the power [W] that drives of prescribed motions take, from what `drive_power` does.

    Of impulses and the jumps of velocities that they cause it is the energy [J].
    """
    power: Any = 0
    for i, prescribed in enumerate(posture.mechanism.prescribed):
        if prescribed:
            effort = constraint_effort(dynamics, net, qdd, i) - dynamics.matrix[i][i] * qdd[i]
            power = power + effort * posture.state.v[i]
    return power


def kinetic_energy(posture: Posture, dynamics: Dynamics) -> Any:
    """Return the kinetic energy [J] of structure and motors relative to the base."""
    return 0.5 * linear.inner(posture.state.v, linear.product(dynamics.matrix, posture.state.v))


def potential_energy(posture: Posture, dynamics: Dynamics, gravity: Any) -> Any:
    """Return the potential energy [J] of gravity and springs."""
    total = gravity * dynamics.inertia.first_moment[2]
    for spring in posture.mechanism.springs:
        total = total + 0.5 * spring.stiffness * _deflection(spring, posture.state.q) ** 2
    return total


def energy_by_base(posture: Posture, base: BaseState, gravity: Any) -> tuple[Any, Any]:
    """Return (kinetic, potential) energy [J] of the bodies in the world less those in the base."""
    turned, kinetic, potential = turned_by(base, *posture.kinematics.turn), 0.0, 0.0
    w = turned.angular_velocity
    for _, body, place, velocity, inertia, omega in body_motions(
        posture.mechanism.tree, posture.kinematics
    ):
        more = added_energy(turned, gravity, body.mass, place, velocity)
        spin = multiply(inertia, w)
        kinetic, potential = (
            kinetic + more[0] + dot(omega, spin) + 0.5 * dot(w, spin),
            potential + more[1],
        )
    return kinetic, potential
