"""Instruments that measure more than joints: when they take samples, and their errors.

A sample is a function of the seed and of the number of the control period in which it is taken
(`random`), so it does not depend on subscribers.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crane_sim.hardware.random import normal, seed_to_uint64
from crane_sim.numerics.jit import entry_point

Vector = tuple[float, float, float]
IMU_STREAM, CAMERA_STREAM = 1_000_000, 2_000_000
"""First streams of random numbers, two for each signal; those of joint sensors are below."""


class Sampling(NamedTuple):
    """When samples are taken, and when they are read."""

    every: int = 1  # periods from one sample to the next
    delay: int = 0  # periods from a sample to its reading


class Imu(NamedTuple):
    """An inertial measurement unit; see `scenes.schema.instruments.ImuGroup`."""

    sampling: Sampling
    position: Vector  # m
    acceleration: tuple[float, Vector]  # m/s², (standard deviation, bias)
    angular_velocity: tuple[float, Vector]  # rad/s, likewise
    orientation: float | None  # rad, standard deviation; None where none is measured


class Camera(NamedTuple):
    """A camera that measures the payload."""

    sampling: Sampling
    noise: float  # m, standard deviation
    bias: Vector  # m


class Instruments(NamedTuple):
    """The instruments of a scene; None for one that it has not."""

    imu: Imu | None = None
    camera: Camera | None = None


@entry_point
def fill_standard_normals(seed, stream, k, out):
    """Fill out (n,) with normal numbers of period k, mean 0, deviation 1, from 2 n streams.

    The `seed` is a word.
    """
    for i in range(len(out)):
        out[i] = normal(seed, stream + 2 * i, k)


def standard_normals(seed: int, stream: int, k: int, count: int) -> NDArray[np.float64]:
    """Return normal numbers (count,) of the period k, mean 0 and deviation 1."""
    out = np.empty(count)
    fill_standard_normals(seed_to_uint64(seed), stream, k, out)
    return out
