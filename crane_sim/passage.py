"""Whole runs as arrays: a scene under its law, from its initial state to its end or to where it fails."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.hardware.passing import hardware_rollout
from crane_sim.hardware.rig import Rig
from crane_sim.laws import asked
from crane_sim.plant import Plant
from crane_sim.rows import row_width, split
from crane_sim.scene import Scene
from crane_sim.stepping import Replay, begin, free_rollout, held_rollout

Array = npt.NDArray[np.float64]


class Passage(NamedTuple):
    """A run, up to where it ended."""

    rows: Array  # (periods + 1, width), as of `crane_sim.rows`
    samples: Array  # (m, width)
    flow: Any  # the integration as it ended
    saturated: int  # periods in which a demand was limited
    rig: Rig | None = None  # the hardware, of a scene with some
    loads: Array = np.empty((0, 2))  # (periods, 2) of the payload: kg, and J that its changes brought up to there

    def stretches(self, scene: Scene) -> list[tuple[int, int, Any]]:
        """Return (first period, the one after the last, model) of the stretches in which the payload keeps its mass."""
        periods = len(self.rows) - 1
        if self.rig is None or scene.hardware.reload is None:
            return [(0, periods, scene.model)]
        first = [0, *(np.flatnonzero(np.diff(self.loads[:periods, 0])) + 1).tolist()]
        rig, after = self.rig, [*first[1:], periods]
        laden = [rig.crane(scene.model, float(self.loads[k, 0])) for k in first]
        return list(zip(first, after, laden, strict=True))

    def given(self, k: int) -> float:
        """Return the energy [J] that a change of the payload brought at the begin of period k."""
        if not len(self.loads):
            return 0.0
        return float(self.loads[k, 1] - (self.loads[k - 1, 1] if k else 0.0))


def passage(scene: Scene, law: Any, times: Array) -> Passage:
    """Run a scene.

    Args:
        scene: what to run.
        law: of a sampled scene, as of `laws.Law`.
        times: where samples are wanted (m,), increasing, within the run.

    Raises:
        SimulationError: the integration failed in a run whose law is Python.
        LawError: the law failed.
    """
    model = scene.model
    flow, q, _ = begin(model, np.array(scene.initial_q), np.array(scene.initial_v))
    nq, nu = len(q), len(scene.actuated)
    rows, samples = (np.empty((n, row_width(model, nq, nu))) for n in (scene.steps + 1, len(times)))
    if scene.hardware is not None and not scene.hardware.ideal:
        return _with_hardware(scene, law, flow, times, rows, samples)
    if not scene.sampled:
        flow, passed = free_rollout(scene.method, model, scene.source, flow, scene.period, rows, times, samples)
        return Passage(*_whole(scene, rows, times, samples, passed), flow, 0)
    demands, law = np.empty((scene.steps, nu)), _compiled(scene, law)
    flow, passed = held_rollout(scene.method, model, law, flow, scene.period, rows, demands, times, samples)
    limited = np.any(demands[:passed] != split(rows[:passed], nq, nu).u, axis=1)
    return Passage(*_whole(scene, rows, times, samples, passed), flow, int(limited.sum()))


def _with_hardware(scene: Scene, law: Any, flow: Any, times: Array, rows: Array, samples: Array) -> Passage:
    """Return the run of a scene with hardware, whose open-loop inputs are taken once a period as demands are."""
    rig, nu = Rig(scene), len(scene.actuated)
    demands, loads = np.empty((scene.steps, nu)), np.empty((scene.steps, 2))
    asked_for = _compiled(scene, law) if scene.sampled else scene.source
    if type(asked_for) is tuple:
        asked_for = Replay(scene.model, scene.period, np.tile(asked_for, (scene.steps, 1)))
    here = (flow, scene.period, rows, demands, times, samples, loads)
    flow, passed = hardware_rollout(scene.method, scene.model, asked_for, rig.hardware, rig.memory, *here)
    return Passage(*_whole(scene, rows, times, samples, passed), flow, rig.saturated, rig, loads[: passed + 1])


def _whole(scene: Scene, rows: Array, times: Array, samples: Array, passed: int) -> tuple[Array, Array]:
    """Return rows and samples up to the end of the last whole period."""
    return rows[: passed + 1], samples[times <= passed * scene.period] if passed < scene.steps else samples


def _compiled(scene: Scene, law: Any) -> Any:
    """Return the law, as a replay of what it demands where it is Python."""
    return law if system.command.knows(type(law)) else Replay(scene.model, scene.period, _demanded(scene, law))


def _demanded(scene: Scene, law: Any) -> Array:
    """Return the demands (steps, nu) of a law that is Python, asked every period."""
    plant = Plant(scene)
    demands = np.empty((scene.steps, len(scene.actuated)))
    for k in range(scene.steps):
        demand = asked(law, plant.t, *plant.seen, demands.shape[1])
        demands[k] = demand
        plant.advance(demand)
    return demands
