"""The benchmark's cranes as one row of joints, as multibody engines want them, and the steps worth trying.

Every joint slides along or turns about an axis of the frame before it; every linear spring becomes the spring of one
joint. So the payload of the knuckle crane hangs on two swing angles and a sliding joint below the jib's end, and no
engine needs a force between two bodies. The two angles are singular for a rope square to the plane of boom and jib.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.evaluation.bench.engine import sweep_values
from crane_sim.evaluation.bench.problem import Boom, Chain, KnuckleCrane, Problem, Spring

Array = npt.NDArray[np.float64]
Vector = tuple[float, float, float]
_NONE = (0.0, 0.0, 0.0)


class Rest(NamedTuple):
    """A linear spring on a joint's coordinate, and where it rests."""

    stiffness: float  # N/m or N m/rad
    rest: float  # m or rad


class Joint(NamedTuple):
    """A joint and the body behind it, whose frame is the joint's; z is up in all frames while the angles are zero."""

    slides: bool  # else it turns
    axis: int  # 0, 1, 2: x, y, z of its own frame
    start: float  # m or rad, of its coordinate
    offset: Vector = _NONE  # m, from the frame before
    mass: float = 0.0  # kg; the next joint moves a body without any on from the same point
    centre: Vector = _NONE  # m, of mass
    inertia: Vector = _NONE  # kg m², about the axes at the centre of mass
    spring: Rest | None = None


def model_joints(problem: Problem) -> list[Joint]:
    """Return the joints from the ground on; the payload is the last one's centre of mass."""
    if isinstance(problem, Chain):
        return _chain_joints(problem)
    return _spring_joints(problem) if isinstance(problem, Spring) else _knuckle_joints(problem)


def centre(row: list[Joint], q: Array) -> Array:
    """Return where the last body's centre of mass is (3,) [m], world, at joint coordinates q (n,)."""
    at = np.array(row[-1].centre)
    for joint, value in zip(reversed(row), q[::-1], strict=True):
        if joint.slides:
            at[joint.axis] += value
        else:
            i, j = (joint.axis + 1) % 3, (joint.axis + 2) % 3
            c, s = np.cos(value), np.sin(value)
            at[i], at[j] = c * at[i] - s * at[j], s * at[i] + c * at[j]
        at += joint.offset
    return at


def tension(row: list[Joint], q: Array) -> float | None:
    """Return the tension [N] of the spring that the payload hangs on, None without one; q (n,)."""
    spring = row[-1].spring
    return spring.stiffness * (spring.rest - float(q[-1])) if spring else None


def steps(problem: Problem, first: float, last: float, per_decade: int = 6) -> list[float]:
    """Return steps [s] that fill the duration, from `first` down to `last`, both relative to the fastest motion."""
    frequency = fastest(problem)
    counts = np.ceil(problem.duration / np.array(sweep_values(first / frequency, last / frequency, per_decade)))
    return [problem.duration / count for count in counts]


def fastest(problem: Problem) -> float:
    """Return the highest frequency [rad/s] of small motions, roughly."""
    if isinstance(problem, Chain):
        return _chain_frequency(problem)
    if isinstance(problem, Spring):
        return float(np.sqrt(problem.stiffness * (1.0 / problem.trolley + 1.0 / problem.payload)))
    inertias = problem.boom.inertia, problem.jib.inertia, problem.payload
    return float(max(np.sqrt(k / i) for k, i in zip(problem.stiffness, inertias, strict=True)))


def _chain_frequency(chain: Chain) -> float:
    """Return the highest frequency of the hanging chain, its tensions those at rest."""
    masses = np.array([chain.trolley, *chain.masses])
    tensions = chain.gravity * np.cumsum(chain.masses[::-1])[::-1]
    difference = np.diff(np.eye(len(masses)), axis=0) / np.sqrt(masses)
    return float(np.linalg.norm(difference * np.sqrt(tensions / chain.lengths)[:, None], 2))


def _trolley(mass: float) -> Joint:
    return Joint(True, 0, 0.0, mass=mass)


def _chain_joints(chain: Chain) -> list[Joint]:
    row, length, before = [_trolley(chain.trolley)], 0.0, 0.0
    for mass, below, angle in zip(chain.masses.tolist(), chain.lengths.tolist(), chain.angles.tolist(), strict=True):
        row.append(Joint(False, 1, before - angle, (0.0, 0.0, -length), mass, (0.0, 0.0, -below)))
        length, before = below, angle
    return row


def _spring_joints(crane: Spring) -> list[Joint]:
    x, z = crane.start
    swing = Joint(False, 1, float(np.arctan2(-x, -z)))
    spring = Rest(crane.stiffness, -crane.length)
    return [_trolley(crane.trolley), swing, Joint(True, 2, -float(np.hypot(x, z)), mass=crane.payload, spring=spring)]


def _rod_joint(rod: Boom, foot: float, start: float, spring: Rest) -> Joint:
    inertia = rod.axial, rod.inertia, rod.inertia
    return Joint(False, 1, start, (foot, 0.0, 0.0), rod.mass, (0.5 * rod.length, 0.0, 0.0), inertia, spring)


def _knuckle_joints(crane: KnuckleCrane) -> list[Joint]:
    (kb, kj, kr), (beta0, gamma0, length) = crane.stiffness, crane.rest
    (alpha, beta, gamma), turning = crane.q.tolist(), (crane.tower, crane.tower, crane.tower)
    row = [
        Joint(False, 2, alpha, mass=1.0, inertia=turning),  # on its axis any mass will do
        _rod_joint(crane.boom, 0.0, -beta, Rest(kb, -beta0)),
        _rod_joint(crane.jib, crane.boom.length, beta - gamma, Rest(kj, -gamma0)),
    ]
    hook = Joint(False, 1, 0.0, (crane.jib.length, 0.0, 0.0))
    rope = crane.start - centre([*row, hook], np.array([alpha, -beta, beta - gamma, 0.0]))
    c, s = np.cos(alpha), np.sin(alpha)
    radial, across, up = c * rope[0] + s * rope[1], c * rope[1] - s * rope[0], rope[2]
    tilt = float(np.arctan2(-radial, -up)) + gamma
    swing = Joint(False, 0, float(np.arctan2(across, np.hypot(radial, up))))
    slide = Joint(True, 2, -float(np.linalg.norm(rope)), mass=crane.payload, spring=Rest(kr, -length))
    return [*row, hook._replace(start=tilt), swing, slide]
