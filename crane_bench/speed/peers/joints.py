"""The benchmark's cranes as serial chains of joints for multibody engines, and their step sizes.

Every joint is prismatic along or revolute about an axis of its parent frame; every linear spring
becomes the spring of one joint. So the payload of the knuckle crane is the child of two swing
angles and a prismatic joint below the jib's end, and no engine needs a force between two bodies.
The two angles are singular for a rope perpendicular to the plane of boom and jib.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.speed.engine import sweep_values
from crane_bench.speed.problem import Chain, KnuckleCrane, Problem, RodParameters, Spring

Array = npt.NDArray[np.float64]
Vector = tuple[float, float, float]
_ZERO = (0.0, 0.0, 0.0)


class JointSpring(NamedTuple):
    """A linear spring on a joint's coordinate, and its neutral position."""

    stiffness: float  # N/m or N m/rad
    neutral: float  # m or rad


class Joint(NamedTuple):
    """A joint and its child body in its frame; z is up in all frames at zero angles."""

    prismatic: bool  # else revolute
    axis: int  # 0, 1, 2: x, y, z of its own frame
    initial: float  # m or rad, of its coordinate
    offset: Vector = _ZERO  # m, from the parent frame
    mass: float = 0.0  # kg; a massless body has zero length: the next joint is at the same point
    com: Vector = _ZERO  # m, centre of mass
    inertia: Vector = _ZERO  # kg m², about the axes at the centre of mass
    spring: JointSpring | None = None


def model_joints(problem: Problem) -> list[Joint]:
    """Return the joints from the ground on; the payload is the last one's centre of mass."""
    if isinstance(problem, Chain):
        return _chain_joints(problem)
    return _spring_joints(problem) if isinstance(problem, Spring) else _knuckle_joints(problem)


def payload_position(joints: list[Joint], q: Array) -> Array:
    """Return the last body's centre of mass (3,) [m], world, at joint coordinates q (n,)."""
    position = np.array(joints[-1].com)
    for joint, value in zip(reversed(joints), q[::-1], strict=True):
        if joint.prismatic:
            position[joint.axis] += value
        else:
            i, j = (joint.axis + 1) % 3, (joint.axis + 2) % 3
            c, s = np.cos(value), np.sin(value)
            position[i], position[j] = (
                c * position[i] - s * position[j],
                s * position[i] + c * position[j],
            )
        position += joint.offset
    return position


def tension(joints: list[Joint], q: Array) -> float | None:
    """Return the tension [N] of the payload's spring, None without one; q (n,)."""
    spring = joints[-1].spring
    return spring.stiffness * (spring.neutral - float(q[-1])) if spring else None


def step_sizes(problem: Problem, first: float, last: float, per_decade: int = 6) -> list[float]:
    """Return step sizes [s] that divide the duration, `first` to `last`.

    These are relative to 1 / highest frequency.
    """
    frequency = highest_frequency(problem)
    counts = np.ceil(
        problem.duration / np.array(sweep_values(first / frequency, last / frequency, per_decade))
    )
    return [problem.duration / count for count in counts]


def highest_frequency(problem: Problem) -> float:
    """Return an estimate of the highest frequency [rad/s] of small motions."""
    if isinstance(problem, Chain):
        return _chain_frequency(problem)
    if isinstance(problem, Spring):
        return float(np.sqrt(problem.stiffness * (1.0 / problem.trolley + 1.0 / problem.payload)))
    inertias = problem.boom.inertia, problem.jib.inertia, problem.payload
    return float(max(np.sqrt(k / i) for k, i in zip(problem.stiffness, inertias, strict=True)))


def _chain_frequency(chain: Chain) -> float:
    """Return the highest frequency of the chain about its equilibrium, by its static tensions."""
    masses = np.array([chain.trolley, *chain.masses])
    tensions = chain.gravity * np.cumsum(chain.masses[::-1])[::-1]
    difference = np.diff(np.eye(len(masses)), axis=0) / np.sqrt(masses)
    return float(np.linalg.norm(difference * np.sqrt(tensions / chain.lengths)[:, None], 2))


def _trolley(mass: float) -> Joint:
    return Joint(True, 0, 0.0, mass=mass)


def _chain_joints(chain: Chain) -> list[Joint]:
    joints, previous_length, previous_angle = [_trolley(chain.trolley)], 0.0, 0.0
    for mass, length, angle in zip(
        chain.masses.tolist(), chain.lengths.tolist(), chain.angles.tolist(), strict=True
    ):
        joints.append(
            Joint(
                False,
                1,
                previous_angle - angle,
                (0.0, 0.0, -previous_length),
                mass,
                (0.0, 0.0, -length),
            )
        )
        previous_length, previous_angle = length, angle
    return joints


def _spring_joints(crane: Spring) -> list[Joint]:
    x, z = crane.start
    swing = Joint(False, 1, float(np.arctan2(-x, -z)))
    spring = JointSpring(crane.stiffness, -crane.length)
    return [
        _trolley(crane.trolley),
        swing,
        Joint(True, 2, -float(np.hypot(x, z)), mass=crane.payload, spring=spring),
    ]


def _rod_joint(rod: RodParameters, offset: float, initial: float, spring: JointSpring) -> Joint:
    inertia = rod.axial, rod.inertia, rod.inertia
    return Joint(
        False,
        1,
        initial,
        (offset, 0.0, 0.0),
        rod.mass,
        (0.5 * rod.length, 0.0, 0.0),
        inertia,
        spring,
    )


def _knuckle_joints(crane: KnuckleCrane) -> list[Joint]:
    (kb, kj, kr), (beta0, gamma0, length) = crane.stiffness, crane.neutral
    (alpha, beta, gamma), inertia = crane.q.tolist(), (crane.tower, crane.tower, crane.tower)
    joints = [
        Joint(False, 2, alpha, mass=1.0, inertia=inertia),  # any mass, its centre is on the axis
        _rod_joint(crane.boom, 0.0, -beta, JointSpring(kb, -beta0)),
        _rod_joint(crane.jib, crane.boom.length, beta - gamma, JointSpring(kj, -gamma0)),
    ]
    hook = Joint(False, 1, 0.0, (crane.jib.length, 0.0, 0.0))
    rope = crane.start - payload_position(
        [*joints, hook], np.array([alpha, -beta, beta - gamma, 0.0])
    )
    c, s = np.cos(alpha), np.sin(alpha)
    radial, across, up = c * rope[0] + s * rope[1], c * rope[1] - s * rope[0], rope[2]
    tilt = float(np.arctan2(-radial, -up)) + gamma
    swing = Joint(False, 0, float(np.arctan2(across, np.hypot(radial, up))))
    slide = Joint(
        True, 2, -float(np.linalg.norm(rope)), mass=crane.payload, spring=JointSpring(kr, -length)
    )
    return [*joints, hook._replace(initial=tilt), swing, slide]
