"""Camera measurement of the payload: sampled, noisy, delayed, filtered.

The velocity is by backward difference.

Between frames the measurement is held. The noise is drawn before the run, which keeps runs
repeatable and the compiled law free of a random generator.
"""

from math import exp, inf, pi
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Seed
from crane_sim.numerics.jit import routine
from crane_sim.scenes.scene import Scene

MAX_FRAMES = 10_000_000


class CameraSettings(NamedTuple):
    """A camera that measures the payload: late, noisy, filtered frames.

    Velocities are by backward difference.
    """

    rate: Annotated[Positive, Field(le=1e4)] = 30.0  # Hz, of frames, between which the measurement
    # is held
    noise: NonNegative = 0.002  # m, standard deviation of each coordinate
    latency: Annotated[NonNegative, Field(le=60.0)] = 0.0  # s, from a frame to its use
    low_pass: Positive | None = 5.0  # Hz, corner of the first-order filter; `null`: no filter
    seed: Seed = 0  # -, of the noise


class CameraState(NamedTuple):
    """State of the camera; times in s, from the start of the run."""

    counts: Any  # (3,) int64: frames taken, frames used, index of the interval in which the next
    # frame is due
    queue: Any  # (n, 3): time taken [s], x, y [m] of frames that are delayed by the latency; a ring
    # buffer
    last_used_frame: Any  # (3,) time taken [s], x, y [m]
    filtered: Any  # (4,) x, y [m], their rates [m/s]


class Camera(NamedTuple):
    """A camera: its parameters, the noise drawn for the run, and its state."""

    interval: float  # s, between frames
    latency: float  # s
    corner_rad_s: float  # rad/s, corner frequency of the low-pass filter; infinite where there is
    # none
    noise_std: float  # m, standard deviation of the noise of each coordinate
    noise_samples: Any  # (frames, 2) m, noise of each frame
    state: CameraState

    def with_initial_state(self) -> "Camera":
        """Return the camera before its first frame."""
        return self._replace(state=_empty(len(self.state.queue)))


class Measurement(NamedTuple):
    """The payload's measured state relative to the base, horizontal coordinates."""

    position: tuple[float, float]  # m, filtered
    velocity: tuple[float, float]  # m/s
    raw: tuple[float, float]  # m, position in the last frame used, unfiltered
    age: float  # s, since that frame was taken
    new: bool  # whether that frame was not used before this call


def make_camera(settings: CameraSettings | None, nominal: Scene) -> Camera | None:
    """Return the camera for a run of the nominal scene; None if the measurement is exact.

    Raises:
        SceneError: the run would take too many frames.
    """
    if settings is None:
        return None
    frames = int(np.ceil(nominal.duration * settings.rate)) + 2
    if frames > MAX_FRAMES:
        raise SceneError(
            f"control.vision.rate = {settings.rate:g}: makes {frames:.0f} frames, at most "
            f"{MAX_FRAMES:.0e}"
        )
    noise = np.random.default_rng(settings.seed).normal(0.0, settings.noise, (frames, 2))
    corner_rad_s = inf if settings.low_pass is None else 2.0 * pi * settings.low_pass
    # frames within the latency at one time, at most
    size = int(np.ceil(settings.latency * settings.rate)) + 2
    return Camera(
        1.0 / settings.rate, settings.latency, corner_rad_s, settings.noise, noise, _empty(size)
    )


def _empty(size: int) -> CameraState:
    return CameraState(np.zeros(3, np.int64), np.zeros((size, 3)), np.zeros(3), np.zeros(4))


def measure(camera, t, position, velocity):
    """Return the Measurement at t [s] of a payload at a position (2,) [m], velocity (2,) [m/s]."""
    if camera is None:
        return Measurement(position, velocity, position, 0.0, True)
    return take_frame(camera, t, position)


@routine
def take_frame(camera, t, position):
    """Return a camera's Measurement; take a frame if due, and filter those that have arrived."""
    counts, queue, last_used_frame, filtered = camera.state
    tolerance = 1e-9 * camera.interval  # rounding of the times
    if t >= counts[2] * camera.interval - tolerance:
        row, noise = (
            counts[0] % len(queue),
            camera.noise_samples[counts[0] % len(camera.noise_samples)],
        )
        queue[row, 0], queue[row, 1], queue[row, 2] = (
            t,
            position[0] + noise[0],
            position[1] + noise[1],
        )
        if counts[0] == 0:
            # a first frame without latency: the payload's position before the run is known
            filter_frame(camera, queue[row])
        counts[0] += 1
        counts[2] = int(t / camera.interval + 1e-9) + 1
    new = False
    while (
        counts[1] < counts[0] and t >= queue[counts[1] % len(queue), 0] + camera.latency - tolerance
    ):
        filter_frame(camera, queue[counts[1] % len(queue)])
        counts[1] += 1
        new = True
    return Measurement(
        (filtered[0], filtered[1]),
        (filtered[2], filtered[3]),
        (last_used_frame[1], last_used_frame[2]),
        t - last_used_frame[0],
        new,
    )


@routine
def filter_frame(camera, frame):
    """Update the filter with a frame (time, x, y)."""
    last_used_frame, filtered = camera.state.last_used_frame, camera.state.filtered
    first = camera.state.counts[1] == 0
    elapsed = camera.interval if first else frame[0] - last_used_frame[0]
    gain = 1.0 - exp(-camera.corner_rad_s * elapsed)
    for i in range(2):
        previous = frame[1 + i] if first else filtered[i]
        filtered[i] = previous + gain * (frame[1 + i] - previous)
        filtered[2 + i] = (filtered[i] - previous) / elapsed
    last_used_frame[:] = frame
