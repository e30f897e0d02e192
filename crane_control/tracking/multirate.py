"""A tracker that is sampled more slowly than its servo; its setpoint is held (zero-order hold).

The two need not be one process: the inner loop is the same law without its tracker, which receives
the setpoints that another process computes.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_control.tracking.tracker import Pendulum, TipSetpoint, Tracker, compute_tip_setpoint
from crane_sim.files.errors import SceneError
from crane_sim.laws import with_initial_state

TIME_TOLERANCE = 1e-9  # of an interval: rounding of the times


class HeldSetpoint(NamedTuple):
    """State of the hold: the setpoint until the tracker is sampled again."""

    due: Any  # (1,) s, when the tracker is sampled next
    setpoint: Any  # (6,) x, y of the position [m], the velocity [m/s] and the acceleration [m/s²]


class MultirateTracker(NamedTuple):
    """A tracker with a rate of its own, sampled at the first control step of every interval."""

    tracker: Tracker | None  # None: in another process
    pendulum: Pendulum
    interval: float  # s
    held: HeldSetpoint

    def with_initial_state(self) -> "MultirateTracker":
        """Return the tracker with its initial state."""
        return self._replace(tracker=with_initial_state(self.tracker), held=_initial_setpoint())

    def due(self, t: float) -> bool:
        """Return whether the tracker is sampled at t [s]."""
        return bool(t >= self.held.due[0])

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates of the suspension point, as messages name them."""
        return "tip_x", "tip_y"

    @property
    def demand(self) -> tuple[float, ...]:
        """The setpoint (6,) that is held."""
        return tuple(self.held.setpoint.tolist())

    def take(self, demand: tuple[float, ...]) -> None:
        """Hold a setpoint (6,)."""
        self.held.setpoint[:] = demand


def make_multirate(
    tracker: Tracker, rate: float | None, period: float
) -> Tracker | MultirateTracker:
    """Return the tracker, sampled `rate` times a second.

    It is sampled in every control period [s] where `rate` is None.

    Raises:
        SceneError: the rate is above that of the control periods.
    """
    if rate is None:
        return tracker
    if rate * period > 1.0 + TIME_TOLERANCE:
        raise SceneError(
            f"control.tracker_rate = {rate:g}: must be at most 1 / period = {1.0 / period:g} Hz"
        )
    return MultirateTracker(tracker, tracker.pendulum, 1.0 / rate, _initial_setpoint())


def _initial_setpoint() -> HeldSetpoint:
    return HeldSetpoint(np.zeros(1), np.zeros(6))


def tip_setpoint(tracker, t, tip, y, dy):
    """Return the TipSetpoint at `tip` (2,) and payload y, dy (2,): a new or the held one.

    It is held on where the tracker is in another process.
    """
    if isinstance(tracker, Tracker):
        return compute_tip_setpoint(tracker, t, tip, y, dy)
    setpoint = read_setpoint(tracker.held.setpoint)
    if t >= tracker.held.due[0]:
        if tracker.tracker is not None:
            setpoint = compute_tip_setpoint(tracker.tracker, t, tip, y, dy)
        tracker.held.setpoint[:] = (*setpoint.x, *setpoint.v, *setpoint.a)
        tracker.held.due[0] = (
            int(t / tracker.interval + TIME_TOLERANCE) + 1 - TIME_TOLERANCE
        ) * tracker.interval
    return setpoint


def read_setpoint(values):
    """Return the numbers (6,) as a TipSetpoint."""
    return TipSetpoint((values[0], values[1]), (values[2], values[3]), (values[4], values[5]))
