"""Transforms between a crane's frames, from its URDF and joint positions, as a tree holds them.

Those of fixed joints never change. The others are one for each joint that moves, `world` to
`base_link` where the base moves, and the payload's turn where its attitude is part of the state: no
joint of a URDF can be a quaternion.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin, sqrt
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from crane_sim.description.rotations import NO_TURN, Quaternion, product, quaternion_of
from crane_sim.description.suspended import ATTITUDE_JOINT
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.simulation.base_state import BaseState, base_state

WORLD, BASE, PAYLOAD = "world", "base_link", "payload_link"
Vector = tuple[float, float, float]


class Transform(NamedTuple):
    """A child frame in the axes of its parent."""

    parent: str
    child: str
    translation: Vector  # m
    rotation: Quaternion = NO_TURN  # x, y, z, w: takes vectors of the child to the parent


class RelativeMotion(NamedTuple):
    """A child frame and its velocities in the axes of its parent."""

    transform: Transform
    velocity: NDArray[np.float64]  # (3,) m/s
    angular_velocity: NDArray[np.float64]  # (3,) rad/s


class MovingJoint(NamedTuple):
    """A joint of a URDF that moves."""

    parent: str
    child: str
    origin: Vector  # m
    axis: Vector
    slides: bool  # along the axis; else it turns about it
    source: int  # index of the scene's joint that moves it
    multiplier: float  # of that joint's position

    def transform(self, q: Sequence[float]) -> Transform:
        """Return the child's frame at the scene's joint positions q (nq,) [m or rad]."""
        position, (x, y, z), (a, b, c) = self.multiplier * q[self.source], self.origin, self.axis
        if self.slides:
            return Transform(
                self.parent, self.child, (x + position * a, y + position * b, z + position * c)
            )
        s = sin(0.5 * position)
        return Transform(
            self.parent, self.child, self.origin, (s * a, s * b, s * c, cos(0.5 * position))
        )

    def motion(self, q: Sequence[float], v: Sequence[float]) -> RelativeMotion:
        """Return the child's frame and its velocities at the scene's positions and rates (nq,)."""
        rate, rest = self.multiplier * v[self.source] * np.array(self.axis), np.zeros(3)
        return RelativeMotion(self.transform(q), *((rate, rest) if self.slides else (rest, rate)))


class TransformTree:
    """All transforms of a crane.

    Attributes:
        fixed: those that never change.
    """

    def __init__(self, document: str, joints: Sequence[str]) -> None:
        """Read a URDF whose free joints are those of the scene, `joints` (nq,)."""
        self._attitude = [joints.index(name) for name in ATTITUDE if name in joints]
        self._turned: Transform | None = None  # the payload's frame without its turn
        self.fixed: list[Transform] = []
        self._moving: list[MovingJoint] = []
        for joint in ElementTree.fromstring(document).findall("joint"):
            parent, child, origin = (
                _link(joint, "parent"),
                _link(joint, "child"),
                _vector(joint, "origin"),
            )
            if joint.attrib["type"] != "fixed":
                self._moving.append(_moving_joint(joint, joints))
            elif joint.attrib["name"] == ATTITUDE_JOINT and self._attitude:
                self._turned = Transform(parent, child, origin)
            else:
                self.fixed.append(Transform(parent, child, origin))

    def moving(self, q: Sequence[float]) -> list[Transform]:
        """Return the transforms of all that moves in the base, at positions q (nq,) [m or rad]."""
        transforms = [joint.transform(q) for joint in self._moving]
        if self._turned is not None:
            w, x, y, z = (q[i] for i in self._attitude)
            size = sqrt(w * w + x * x + y * y + z * z)
            transforms.append(
                self._turned._replace(rotation=(x / size, y / size, z / size, w / size))
            )
        return transforms

    def motions(self, q: Sequence[float], v: Sequence[float]) -> list[RelativeMotion]:
        """Return all frames in the base and their velocities, at positions q, rates v (nq,)."""
        rest = np.zeros(3)
        motions = [RelativeMotion(transform, rest, rest) for transform in self.fixed]
        motions += [joint.motion(q, v) for joint in self._moving]
        if self._turned is not None:
            (w, *axis), (w_rate, *rates) = ([x[i] for i in self._attitude] for x in (q, v))
            # twice the vector part of q' q*, of a quaternion of any size
            n, n_rate = np.array(axis), np.array(rates)
            turning = 2.0 * (w * n_rate - w_rate * n + np.cross(n, n_rate)) / (w * w + n @ n)
            motions.append(RelativeMotion(self.moving(q)[-1], rest, turning))
        return motions


def payload_orientation(scene: Scene, t: float, q: Sequence[float]) -> Quaternion:
    """Return the payload's quaternion in the world at time t [s] and positions q (nq,).

    A point has no turn.
    """
    indices = [scene.joint_names.index(name) for name in ATTITUDE if name in scene.joint_names]
    if not indices:
        return NO_TURN
    size = sqrt(sum(q[i] * q[i] for i in indices))
    w, x, y, z = (q[i] / size for i in indices)
    return product(base_transform(base_state(scene, t)).rotation, (x, y, z, w))


def base_transform(state: BaseState) -> Transform:
    """Return the frame of the base in the world."""
    x, y, z = state.position.tolist()
    return Transform(WORLD, BASE, (x, y, z), quaternion_of(state.rotation))


def _moving_joint(joint: ElementTree.Element, joints: Sequence[str]) -> MovingJoint:
    mimic = joint.find("mimic")
    name = joint.attrib["name"] if mimic is None else mimic.attrib["joint"]
    return MovingJoint(
        _link(joint, "parent"),
        _link(joint, "child"),
        _vector(joint, "origin"),
        _vector(joint, "axis"),
        joint.attrib["type"] == "prismatic",
        list(joints).index(name),
        1.0 if mimic is None else float(mimic.attrib["multiplier"]),
    )


def _link(joint: ElementTree.Element, end: str) -> str:
    element = joint.find(end)
    assert element is not None
    return element.attrib["link"]


def _vector(joint: ElementTree.Element, name: str) -> Vector:
    element = joint.find(name)
    assert element is not None
    x, y, z = map(float, element.attrib["xyz"].split())
    return x, y, z
