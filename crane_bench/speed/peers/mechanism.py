"""The benchmark's cranes with a rigid load as a mechanism for general multibody engines.

Bodies form a tree of prismatic and revolute joints; between bodies there are springs that pull, the
falls. A rope whose length a winch imposes is a prismatic joint with an inertia of `HEAVY` times
what hangs on it: the winch's own motion l'' = (u - l') / T then needs no constraint, and the load
changes it by g / HEAVY.

Inputs are tables of straight lines. Between two of their times every input rises at a constant
rate, so that an engine which integrates the input's value beside the crane's state has the exact
input in every stage of its method.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from crane_bench.speed.peers.joints import Joint, Vector, model_joints
from crane_bench.speed.problem import Problem
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.supports.bridge import Bridge
from crane_sim.models.supports.hoist import MotionHoist
from crane_sim.models.supports.support import Support
from crane_sim.models.supports.tower_crane import Slew, TowerCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.breakpoints import unwrap
from crane_sim.trajectories.inputs import Constant, Inputs, Table

Array = npt.NDArray[np.float64]
HEAVY = 1e12
"""Inertia of a winch that imposes motion, in units of the suspended mass."""
_ROTOR = 1e-3  # kg, of a slewing part whose centre is on its axis: any mass


class Body(NamedTuple):
    """A joint and its child body in a tree."""

    joint: Joint
    parent: int  # number of its parent, -1: the ground
    rate: float = 0.0  # m/s or rad/s, initial
    armature: float = 0.0  # kg or kg m², inertia on the joint's coordinate
    damping: float = 0.0  # N s/m or N m s/rad


class Fall(NamedTuple):
    """A spring and a damper between points of two bodies."""

    upper: tuple[int, Vector]  # number of the body, point in its frame [m]
    lower: tuple[int, Vector]
    length: float  # m, unstretched
    stiffness: float  # N/m
    damping: float  # N s/m


class Drive(NamedTuple):
    """An input of one joint: its effort is gain × the table's value."""

    body: int
    gain: float
    table: Table


class Mechanism(NamedTuple):
    """A crane with a rigid load, the last body."""

    bodies: list[Body]
    point: Vector  # m, what is compared, in the last body's frame
    falls: list[Fall]
    drives: list[Drive]
    gravity: float  # m/s²
    duration: float  # s


def mechanism_of_problem(problem: Problem) -> Mechanism:
    """Return a crane of the benchmark, a chain of joints whose last body is the payload."""
    joints = model_joints(problem)
    bodies = [Body(joint, i - 1) for i, joint in enumerate(joints)]
    return Mechanism(bodies, joints[-1].com, [], [], problem.gravity, problem.duration)


class Segment(NamedTuple):
    """A time between two kinks of the inputs."""

    duration: float  # s
    rates: Array  # 1/s, of the inputs' values


def mechanism_of(scene: Scene) -> Mechanism | None:
    """Return the scene's crane, None for one of another kind."""
    model, load = scene.model, getattr(scene.model, "load", None)
    added = (getattr(model, name, None) for name in ("base", "wind", "drag", "force"))
    hoist = getattr(model, "hoist", None)
    if (
        scene.sampled
        or not isinstance(load, RigidLoad)
        or not isinstance(hoist, MotionHoist)
        or any(added)
    ):
        return None
    if (inputs := input_tables(scene)) is None:
        return None
    if np.count_nonzero(load.inertia - np.diag(np.diag(load.inertia))):
        return None  # not written for other than principal axes
    support = getattr(model, "support", None)
    if isinstance(support, Support) and support != Support(support.structure):
        return None  # friction, motors and play are not written there
    if support is not None and support.structure.mechanism().prescribed:
        return None  # nor are motions
    if isinstance(model, FallsCrane) and isinstance(model.support.structure, Bridge):
        return _on_falls(scene, model, inputs)
    return _on_cable(scene, model, load, inputs) if isinstance(model, SuspendedCrane) else None


def input_tables(scene: Scene) -> list[Table] | None:
    """Return a table for each actuated joint, None where an input is no table and not constant."""
    source = unwrap(scene.source)
    channels: Any = (
        source.channels if isinstance(source, Inputs) else [Constant(value) for value in source]
    )
    tables = [
        Table((0.0,), (channel.value,)) if isinstance(channel, Constant) else channel
        for channel in channels
    ]
    return tables if all(isinstance(table, Table) for table in tables) else None


def segments(mechanism: Mechanism) -> tuple[Array, list[Segment]]:
    """Return (inputs at t = 0, the times between kinks of the inputs up to the end)."""
    tables, end = [drive.table for drive in mechanism.drives], mechanism.duration
    kinks = sorted({0.0, end, *(t for table in tables for t in table.times if 0.0 < t < end)})
    values = np.array(
        [[np.interp(t, table.times, table.values) for table in tables] for t in kinks]
    )
    times = np.diff(kinks)
    rates = np.diff(values, axis=0) / times[:, None]
    return values[0], [Segment(float(t), row) for t, row in zip(times, rates, strict=True)]


def initial_state(mechanism: Mechanism) -> tuple[Array, Array]:
    """Return coordinates and rates (n,) of the joints at t = 0."""
    rows = [(body.joint.initial, body.rate) for body in mechanism.bodies]
    q, v = np.array(rows).T
    return q, v


def load_pose(mechanism: Mechanism, q: Array) -> tuple[Array, Array]:
    """Return the compared point (3,) [m] and the load's rotation (3, 3) at joints q (n,)."""
    poses = [(np.zeros(3), np.eye(3))]  # of the ground, at index -1 of the others
    for body, value in zip(mechanism.bodies, q, strict=True):
        at, turn = poses[body.parent + 1]
        at, axis = at + turn @ body.joint.offset, body.joint.axis
        poses.append(
            (at + value * turn[:, axis], turn)
            if body.joint.prismatic
            else (at, turn @ rotation(axis, value))
        )
    at, turn = poses[-1]
    return at + turn @ mechanism.point, turn


def rotation(axis: int, angle: float) -> Array:
    """Return the rotation matrix (3, 3) about an axis (0, 1, 2: x, y, z)."""
    i, j, (c, s) = (axis + 1) % 3, (axis + 2) % 3, (np.cos(angle), np.sin(angle))
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def attitude_of(q: Any) -> Array:
    """Return the rotation matrix (3, 3) of a unit quaternion (w, x, y, z), the last four of q."""
    w, (x, y, z) = q[-4], q[-3:]  # of a run that failed, they may be anything
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross


def _support(scene: Scene, support: Any) -> list[Body]:
    """Return the bodies of a bridge crane or a tower crane, the last one the trolley."""
    q, v = scene.initial_q, scene.initial_v
    if isinstance(support, Bridge):
        bridge = Joint(True, 1, q[1], mass=support.axes[1].mass)
        return [
            Body(bridge, -1, v[1]),
            Body(Joint(True, 0, q[0], mass=support.trolley.mass), 0, v[0]),
        ]
    assert isinstance(support, TowerCrane) and isinstance(support.slew, Slew)
    inertia = support.slew.inertia
    slew = Joint(False, 2, q[0], mass=_ROTOR, inertia=(inertia, inertia, inertia))
    return [Body(slew, -1, v[0]), Body(Joint(True, 0, q[1], mass=support.trolley.mass), 0, v[1])]


def _drives(support: Any, tables: list[Table]) -> list[Drive]:
    # the bridge carries the trolley, which comes first
    order = (1, 0) if isinstance(support, Bridge) else (0, 1)
    drives = [Drive(body, 1.0, table) for body, table in zip(order, tables[:2], strict=True)]
    return [drive for drive in drives if any(drive.table.values)]


def _turns(matrix: Array) -> Array:
    """Return the angles (a, b, c) of Rx(a) Ry(b) Rz(c)."""
    return Rotation.from_matrix(matrix).as_euler("XYZ")


def _spin(angles: Array, omega: Array) -> Array:
    """Return those angles' rates at an angular velocity (3,) [rad/s], in body axes.

    The velocity is relative to the parent.
    """
    _, b, c = angles
    own = rotation(2, -c)
    axes = np.column_stack([own @ rotation(1, -b)[:, 0], own[:, 1], (0.0, 0.0, 1.0)])
    return np.asarray(np.linalg.solve(axes, omega), dtype=np.float64)


def _angular_velocity(q: Any, v: Any) -> Array:
    """Return ω = 2 q* ⊗ q' (3,) [rad/s], in body axes, of the last four of q and v."""
    w, vector, rate = q[-4], np.array(q[-3:]), np.array(v[-3:])
    return 2.0 * (w * rate - v[-4] * vector - np.cross(vector, rate))


def _load_bodies(
    load: RigidLoad, com: Any, offset: Vector, motion: tuple[Array, Array], parent: int
) -> list[Body]:
    """Return the load's three revolute joints.

    Args:
        load: a body whose principal axes are its own.
        com: its centre of mass from the joints (3,) [m].
        offset: of the joints from the parent's.
        motion: (rotation (3, 3), angular velocity (3,) [rad/s], in its axes) relative to the
            parent.
        parent: number of the parent.
    """
    inertia: Any = tuple(load.inertia[i][i] for i in range(3))
    angles = _turns(motion[0])
    rates = _spin(angles, motion[1])
    first = Body(Joint(False, 0, angles[0], offset), parent, rates[0])
    second = Body(Joint(False, 1, angles[1]), parent + 1, rates[1])
    last = Joint(False, 2, angles[2], mass=load.mass, com=tuple(com), inertia=inertia)
    return [first, second, Body(last, parent + 2, rates[2])]


def _on_falls(scene: Scene, crane: FallsCrane, inputs: list[Table]) -> Mechanism | None:
    q, v = scene.initial_q, scene.initial_v
    if any(inputs[2].values) or v[2] != 0.0:
        return None  # the falls' length would change
    bodies = _support(scene, crane.support.structure)
    for axis in (0, 1, 2):
        bodies.append(
            Body(Joint(True, axis, q[3 + axis]), len(bodies) - 1 if axis else -1, v[3 + axis])
        )
    turn, omega, origin = attitude_of(q), _angular_velocity(q, v), (0.0, 0.0, 0.0)
    bodies += _load_bodies(crane.load, origin, origin, (turn, omega), len(bodies) - 1)
    ropes = _ropes(crane, q[2], len(bodies) - 1)
    drives = _drives(crane.support.structure, inputs)
    return Mechanism(bodies, (0.0, 0.0, 0.0), ropes, drives, crane.gravity, scene.duration)


def _ropes(crane: FallsCrane, hoisted: float, load: int) -> list[Fall]:
    """Return the falls at a length of the hoist [m], on the body of number `load`."""
    falls, ropes = crane.falls, list[Fall]()
    ends = zip(falls.top.tolist(), falls.bottom.tolist(), strict=True)
    materials = zip(falls.offset, falls.axial_stiffness, falls.relaxation, strict=True)
    for (top, bottom), (offset, axial, relaxation) in zip(ends, materials, strict=True):
        length = hoisted + float(offset)
        stiffness, damping = float(axial / length), float(relaxation * axial / length)
        ropes.append(Fall((1, tuple(top)), (load, tuple(bottom)), length, stiffness, damping))
    return ropes


def _on_cable(
    scene: Scene, crane: SuspendedCrane, load: RigidLoad, inputs: list[Table]
) -> Mechanism | None:
    q, v, chain = scene.initial_q, scene.initial_v, crane.cable
    n, lag = len(chain.masses), getattr(crane.hoist, "time_constant", None)
    structure = crane.support.structure
    if lag is None or any(v[2 : 5 + 3 * (n - 1)]) or not isinstance(structure, Bridge | TowerCrane):
        return None  # beside the support only the load's attitude may have rates
    bodies = _support(scene, structure)
    turn = rotation(2, q[0]) if isinstance(structure, TowerCrane) else np.eye(3)
    heavy, masses = HEAVY * float(chain.masses.sum()), [*chain.masses[:-1].tolist(), 0.0]
    rope = rotation(0, q[3]) @ rotation(1, -q[4])
    bodies += _turned_line(rope, len(bodies), (0.0, 0.0, 0.0))
    hoist = Joint(True, 2, -q[2], mass=masses[0])
    bodies.append(Body(hoist, len(bodies) - 1, 0.0, heavy, heavy / lag))
    drives = [*_drives(structure, inputs), Drive(len(bodies) - 1, -heavy / lag, inputs[2])]
    turn, offset = turn @ rope, (0.0, 0.0, 0.0)
    for k in range(1, n):
        link = _rotation_to(turn.T @ np.array(q[2 + 3 * k : 5 + 3 * k]))
        bodies += _turned_line(link, len(bodies), offset, masses[k], float(chain.lengths[k]))
        turn, offset = turn @ link, (0.0, 0.0, -float(chain.lengths[k]))
    motion = turn.T @ attitude_of(q), _angular_velocity(q, v)
    bodies += _load_bodies(load, -np.array(load.attachment), offset, motion, len(bodies) - 1)
    return Mechanism(bodies, (0.0, 0.0, 0.0), [], drives, crane.gravity, scene.duration)


def _rotation_to(direction: Array) -> Array:
    """Return the rotation Rx(a) Ry(b) that turns (0, 0, -1) to a unit vector (3,)."""
    x, y, z = direction
    return rotation(0, float(np.arctan2(y, -z))) @ rotation(
        1, float(-np.arctan2(x, np.hypot(y, z)))
    )


def _turned_line(
    turn: Array, first: int, offset: Vector, mass: float = 0.0, length: float = 0.0
) -> list[Body]:
    """Return the two revolute joints of a line, with a mass at its lower end."""
    a, b, _ = _turns(turn)
    lower = Joint(False, 1, b, mass=mass, com=(0.0, 0.0, -length))
    return [Body(Joint(False, 0, a, offset), first - 1), Body(lower, first)]
