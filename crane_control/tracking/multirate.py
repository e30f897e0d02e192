"""A tracker that works slower than the servo below it: it is asked at a rate of its own, and its demand holds between.

The two need not be one process: the servo's half is the same law with its tracker left out, which takes the demands
that another process has found.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_control.tracking.tracker import Demand, Pendulum, Tracker, demanded_tip
from crane_sim.files.errors import SceneError
from crane_sim.laws import fresh
from crane_sim.numerics.jit import generic, kernel

EARLY = 1e-9  # of an interval: rounding of the times


class Memory(NamedTuple):
    """What holds until the tracker is asked again."""

    due: Any  # (1,) s, when that is
    demand: Any  # (6,) x, y of the position [m], the velocity [m/s] and the acceleration [m/s²]


class MultirateTracker(NamedTuple):
    """A tracker with a rate of its own: it is asked at the first control step of every interval."""

    tracker: Tracker | None  # None: in another process
    pendulum: Pendulum
    interval: float  # s
    memory: Memory

    def fresh(self) -> "MultirateTracker":
        """Return it before the first state."""
        return self._replace(tracker=fresh(self.tracker), memory=_nothing())

    def due(self, t: float) -> bool:
        """Return whether the state at t [s] asks for a new demand."""
        return bool(t >= self.memory.due[0])

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates of the suspension point, as messages name them."""
        return "tip_x", "tip_y"

    @property
    def demand(self) -> tuple[float, ...]:
        """The demand (6,) that holds."""
        return tuple(self.memory.demand.tolist())

    def take(self, demand: tuple[float, ...]) -> None:
        """Let a demand (6,) hold."""
        self.memory.demand[:] = demand


def make_multirate(tracker: Tracker, rate: float | None, period: float) -> Tracker | MultirateTracker:
    """Return the tracker, asked `rate` times a second, or in every control period [s] where `rate` is None.

    Raises:
        SceneError: states do not come that often.
    """
    if rate is None:
        return tracker
    if rate * period > 1.0 + EARLY:
        raise SceneError(f"control.tracker_rate = {rate:g}: must be at most 1 / period = {1.0 / period:g} Hz")
    return MultirateTracker(tracker, tracker.pendulum, 1.0 / rate, _nothing())


def _nothing() -> Memory:
    return Memory(np.zeros(1), np.zeros(6))


@generic
def tip_demand(tracker, t, tip, y, dy):
    """Return the Demand on the suspension point at `tip` (2,) for the payload at y, dy (2,), now or from before."""
    return demanded_tip(tracker, t, tip, y, dy)


@tip_demand.register(MultirateTracker)
def _(tracker, t, tip, y, dy):
    demand = read_memory(tracker.memory.demand)
    if t >= tracker.memory.due[0]:
        demand = renew_demand(tracker.tracker, demand, t, tip, y, dy)
        remember(tracker.memory.demand, demand)
        tracker.memory.due[0] = (int(t / tracker.interval + EARLY) + 1 - EARLY) * tracker.interval
    return demand


@generic
def renew_demand(tracker, demand, t, tip, y, dy):
    """Return the Demand that holds from t [s] on: the one that is there, where the tracker is in another process."""
    return demand


@renew_demand.register(Tracker)
def _(tracker, demand, t, tip, y, dy):
    return demanded_tip(tracker, t, tip, y, dy)


@kernel
def read_memory(memory):
    """Return the numbers (6,) as a Demand."""
    return Demand((memory[0], memory[1]), (memory[2], memory[3]), (memory[4], memory[5]))


@kernel
def remember(memory, demand):
    """Write a Demand into the numbers (6,)."""
    for i in range(2):
        memory[i], memory[2 + i], memory[4 + i] = demand.x[i], demand.v[i], demand.a[i]
