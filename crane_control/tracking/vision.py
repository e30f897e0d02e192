"""Camera measurement of the payload: sampled, noisy, delayed, filtered; its velocity by backward difference.

Between frames everything is held. A noise that is drawn beforehand keeps runs repeatable and the compiled law simple.
"""

from math import exp, inf, pi
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Seed
from crane_sim.numerics.jit import generic, routine
from crane_sim.scenes.scene import Scene

MAX_FRAMES = 10_000_000


class Vision(NamedTuple):
    """A camera that looks at the payload: late, noisy, filtered frames; velocities by backward difference."""

    rate: Annotated[Positive, Field(le=1e4)] = 30.0  # Hz, of frames, between which everything is held
    noise: NonNegative = 0.002  # m, standard deviation of each coordinate
    latency: Annotated[NonNegative, Field(le=60.0)] = 0.0  # s, from a frame to its use
    low_pass: Positive | None = 5.0  # Hz, corner of the first-order filter; `null`: no filter
    seed: Seed = 0  # -, of the noise


class Memory(NamedTuple):
    """State of the camera; times in s, from the start of the run."""

    counts: Any  # (3,) int64: frames taken, frames used, the instant of the next one in intervals
    queue: Any  # (n, 3): time taken, x, y of frames on their way, a ring
    newest: Any  # (3,) of the last frame used
    filtered: Any  # (4,) x, y [m], their rates [m/s]


class Camera(NamedTuple):
    """A camera with its drawn noise and its state."""

    interval: float  # s, between frames
    latency: float  # s
    corner: float  # 1/s, of the filter; infinite where there is none
    deviation: float  # m, of the noise
    noise: Any  # (frames, 2) m, drawn
    memory: Memory

    def fresh(self) -> "Camera":
        """Return the camera before its first frame."""
        return self._replace(memory=_empty(len(self.memory.queue)))


class Measurement(NamedTuple):
    """The payload's measured state relative to the base, horizontal coordinates."""

    y: tuple[float, float]  # m
    dy: tuple[float, float]  # m/s
    raw: tuple[float, float]  # m, as measured, unfiltered
    age: float  # s, of `raw`
    new: bool  # whether `raw` is new since the last call


def camera(settings: Vision | None, nominal: Scene) -> Camera | None:
    """Return the camera for a run of the nominal scene, None where the law sees everything as it is.

    Raises:
        SceneError: the run would take too many frames.
    """
    if settings is None:
        return None
    frames = int(np.ceil(nominal.duration * settings.rate)) + 2
    if frames > MAX_FRAMES:
        raise SceneError(
            f"control.vision.rate = {settings.rate:g}: makes {frames:.0f} frames, at most {MAX_FRAMES:.0e}"
        )
    noise = np.random.default_rng(settings.seed).normal(0.0, settings.noise, (frames, 2))
    corner = inf if settings.low_pass is None else 2.0 * pi * settings.low_pass
    size = int(np.ceil(settings.latency * settings.rate)) + 2  # frames on their way at one time, at most
    return Camera(1.0 / settings.rate, settings.latency, corner, settings.noise, noise, _empty(size))


def _empty(size: int) -> Memory:
    return Memory(np.zeros(3, np.int64), np.zeros((size, 3)), np.zeros(3), np.zeros(4))


@generic
def measure(eye, t, y, dy):
    """Return the Measurement at time t [s] of a payload at y (2,) [m] with velocity dy (2,) [m/s]."""
    return Measurement(y, dy, y, 0.0 * t, True)


@measure.register(Camera)
def _(eye, t, y, dy):
    return take_frame(eye, t, y)


@routine
def take_frame(eye, t, y):
    """Return the Measurement of a camera, which takes a frame when it is time and uses the frames that have arrived."""
    counts, queue, newest, kept = eye.memory
    late = 1e-9 * eye.interval  # rounding of the times
    if t >= counts[2] * eye.interval - late:
        row, noise = counts[0] % len(queue), eye.noise[counts[0] % len(eye.noise)]
        queue[row, 0], queue[row, 1], queue[row, 2] = t, y[0] + noise[0], y[1] + noise[1]
        if counts[0] == 0:  # the camera has looked at the load before the run: the law knows where it was
            use(eye, queue[row])
        counts[0] += 1
        counts[2] = int(t / eye.interval + 1e-9) + 1
    new = False
    while counts[1] < counts[0] and t >= queue[counts[1] % len(queue), 0] + eye.latency - late:
        use(eye, queue[counts[1] % len(queue)])
        counts[1] += 1
        new = True
    return Measurement((kept[0], kept[1]), (kept[2], kept[3]), (newest[1], newest[2]), t - newest[0], new)


@routine
def use(eye, frame):
    """Take a frame (time, x, y) into the filter."""
    newest, kept = eye.memory.newest, eye.memory.filtered
    first = eye.memory.counts[1] == 0
    elapsed = eye.interval if first else frame[0] - newest[0]
    share = 1.0 - exp(-eye.corner * elapsed)
    for i in range(2):
        before = frame[1 + i] if first else kept[i]
        kept[i] = before + share * (frame[1 + i] - before)
        kept[2 + i] = (kept[i] - before) / elapsed
    for i in range(3):
        newest[i] = frame[i]
