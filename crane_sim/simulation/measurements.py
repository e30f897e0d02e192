"""Measurements of a scene's instruments (IMU, camera), as functions of the control period."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.hardware.instruments import CAMERA_STREAM, IMU_STREAM, Camera, Imu, standard_normals
from crane_sim.simulation.base_state import base_state

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from crane_sim.scenes.scene import Scene

    Array = NDArray[np.float64]


class ImuSample(NamedTuple):
    """A sample of an inertial measurement unit, in its axes, which are those of the base."""

    specific_force: Array  # (3,) m/s², acceleration less gravity
    angular_velocity: Array  # (3,) rad/s
    rotation: Array | None  # (3, 3), takes vectors of the base to the world; None where it is not
    # measured


def measure_imu(scene: Scene, imu: Imu, k: int) -> ImuSample:
    """Return the sample of an inertial measurement unit at the beginning of period k.

    At its position r the specific force is f + α × r + ω × (ω × r), f the one at the origin of the
    base, ω and α the base's angular velocity and acceleration.
    """
    base, r = base_state(scene, k * scene.period), np.array(imu.position)
    omega = base.angular_velocity
    force = (
        base.specific_force
        + np.cross(base.angular_acceleration, r)
        + np.cross(omega, np.cross(omega, r))
    )
    noise = standard_normals(scene.seed, IMU_STREAM, k, 9).reshape(3, 3)
    measured = [
        true + bias + deviation * normals
        for true, (deviation, bias), normals in zip(
            (force, omega), (imu.acceleration, imu.angular_velocity), noise[:2], strict=True
        )
    ]
    rotation = (
        None
        if imu.orientation is None
        else base.rotation @ rotation_matrix(imu.orientation * noise[2])
    )
    return ImuSample(measured[0], measured[1], rotation)


def measure_payload(scene: Scene, camera: Camera, k: int, payload: Sequence[float]) -> Array:
    """Return the payload's position (3,) [m] in the base frame as a camera sees it.

    It is that at the beginning of period k.

    Args:
        scene, camera, k: the scene, its camera, the period.
        payload: its true position in the world (3,) [m].
    """
    base = base_state(scene, k * scene.period)
    true = base.rotation.T @ (np.array(payload) - base.position)
    return true + camera.bias + camera.noise * standard_normals(scene.seed, CAMERA_STREAM, k, 3)


def rotation_matrix(vector: Array) -> Array:
    """Return the rotation matrix (3, 3) of a rotation vector (3,) [rad] (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    half_sinc = np.sinc(0.5 * angle / np.pi)  # sin(angle / 2) / (angle / 2), 1 for a zero vector
    return np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * half_sinc * half_sinc * cross @ cross
