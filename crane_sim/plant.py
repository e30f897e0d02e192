"""A scene in motion, one control period at a time: what `simulate` and the plant node both step."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crane_sim import outputs as _outputs  # noqa: F401  registers what a crane shows
from crane_sim.integrators import CHATTER, ENDLESS, NOT_FINITE, OK, STALLED, STOPPED
from crane_sim.metrics import Metrics, polyline
from crane_sim.scene import Scene
from crane_sim.stepping import begin, free_step, held_step

BLOCK = 512
SHOWN = 20
"""Events in the summary."""


class SimulationError(RuntimeError):
    """The simulation cannot go on; the message is one line with the time and the cause.

    Attributes:
        run: the Rollout up to there, where `simulate` raised it.
    """

    run: Any = None


def as_tuple(vector: Any) -> tuple[float, ...]:
    """Return a vector of compiled code, a tuple or an array, as a tuple of floats."""
    return vector if isinstance(vector, tuple) else tuple(vector.tolist())


_CAUSES = {
    NOT_FINITE: "the state is not finite",
    STALLED: "the step size shrank to nothing",
    ENDLESS: "the motion has become too fast to follow",
    CHATTER: "the equations switch back and forth without end",
}


def check_status(flow: Any, model: Any) -> None:
    """Raise SimulationError when the integration under way has failed, or the model is no longer valid."""
    if flow.status == OK:
        return
    cause, remedy = _CAUSES.get(flow.status, ""), "check the scene's parameters and steps"
    if flow.status >= STOPPED:
        cause, remedy = model.story(flow.status - STOPPED)
    raise SimulationError(f"stopped at t = {flow.t:.6g} s: {cause}; {remedy}")


def events_of(flow: Any, model: Any, end: float) -> list[tuple[float, str]]:
    """Return (time [s], what happened) of every event that was kept, in the order of time.

    Steps that follow the solution may reach beyond `end` [s]: what happens there is not part of the run, unless it is
    what ended it.
    """
    if flow.seen is None:
        return []
    rows = flow.seen.rows[: min(flow.seen.total, len(flow.seen.rows))]
    last = end if flow.status == OK else flow.t
    return [(float(t), model.story(int(which))[0]) for t, which in rows if t <= last]


def noted_events(flow: Any, model: Any, end: float) -> dict[str, Any]:
    """Return the first events and their number for the summary; nothing for a model that does not switch."""
    if flow.seen is None:
        return {}
    events = events_of(flow, model, end)
    unkept = max(0, flow.seen.total - len(flow.seen.rows))
    return {"events": [{"t": t, "what": what} for t, what in events[:SHOWN]], "event_count": len(events) + unkept}


class Plant:
    """The plant of a scene, from its initial state onwards.

    Attributes:
        k: control periods passed.
        q, v: joint positions and velocities (nq,), in the order of scene.joint_names.
        applied: efforts applied in the last period (nu,), after limits.
        saturated: periods in which a demand was limited.
    """

    def __init__(self, scene: Scene) -> None:
        """Put the crane in its initial state."""
        self.scene = scene
        self.model = scene.model
        self.reset()

    def reset(self) -> None:
        """Return to the scene's initial state and forget the run."""
        initial = (np.array(self.scene.initial_q), np.array(self.scene.initial_v))
        self._flow, q, v = begin(self.model, *initial)
        self.q, self.v = as_tuple(q), as_tuple(v)
        self.k, self.saturated, self._filled = 0, 0, 0
        self.applied: tuple[float, ...] = (0.0,) * len(self.scene.actuated)
        nq = len(self.q)
        self._rows = np.empty((BLOCK, 2 * nq + len(self.applied) + 1))
        self._metrics = Metrics(self.scene, self.model, self._flow.x)

    @property
    def t(self) -> float:
        """Time [s] since the scene's start."""
        return self.k * self.scene.period

    @property
    def payload(self) -> tuple[float, float, float]:
        """Position of the payload in the world [m]."""
        nodes, _ = polyline(self.scene.model, self.t, np.array(self.q), np.array(self.v))
        return tuple(nodes[-1].tolist())

    @property
    def flow(self) -> Any:
        """The integration under way, with its counters of evaluations and steps."""
        return self._flow

    def advance(self, u: Sequence[float] | None = None) -> None:
        """Pass one control period.

        Args:
            u: efforts (nu,) held over the period; None when the equations evaluate the scene's own source.

        Raises:
            SimulationError: the integration failed; the plant stays at the start of the period.
        """
        scene, end = self.scene, (self.k + 1) * self.scene.period
        if u is None:
            here = (self._flow, self.t, end, self._rows, self._filled)
            flow, q, v, applied = free_step(scene.method, self.model, scene.source, *here)
        else:
            u = tuple(u)
            flow, q, v, applied = held_step(scene.method, self.model, u, self._flow, end, self._rows, self._filled)
            self.saturated += applied != u
        if flow.status != OK and flow.t < end:
            check_status(flow, self.model)
        self._flow, self.q, self.v, self.applied = flow, as_tuple(q), as_tuple(v), applied
        self.k += 1
        self._filled += 1
        if self._filled == BLOCK:
            self._flush()

    def _flush(self) -> None:
        start = self.k - self._filled
        t = np.arange(start, self.k, dtype=np.float64) * self.scene.period
        self._metrics.extend(t, self._rows[: self._filled])
        self._filled = 0

    def summary(self) -> dict[str, Any]:
        """Return the run's figures up to now: keys and meanings as of `crane_sim.metrics.Metrics.summary`."""
        self._flush()
        figures = self._metrics.summary(self.t, self.q, self.v, self._flow, self.saturated)
        return figures | noted_events(self._flow, self.model, self.t)
