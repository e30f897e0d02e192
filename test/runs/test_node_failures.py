"""Nodes killed during a run: fail-over, braking, recovery of files, and the reported error."""

import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap_samples import read, stamp_of

from crane_bench.soak.kill import Kill, back_after, soak_kills
from crane_bench.soak.monitor import Received
from crane_bench.soak.realtime import completion_delays
from crane_sim import Scene, load_scene, orchestration, read_recording
from crane_sim.recording.completeness import CUT, Completeness
from crane_sim.recording.rerun.reader import read_curves, read_summary
from crane_sim.recording.rerun.recorder import BLOCK_STEPS
from crane_sim.simulation.plant import SLOW
from crane_sim.simulation.rollout import simulate

SCENE = load_scene("knuckle_setpoint", {"duration": 60.0})
# a killer that is held up comes before its end, too
ENDLESS = load_scene("knuckle_setpoint", {"duration": 1e5})


class NodeKiller:
    """Kills the active nodes of given roles, each once, at given steps of a run.

    Attributes:
        news: of the run.
    """

    def __init__(self, steps: dict[str, int]) -> None:
        """Kill by role, at these steps."""
        self._steps, self._pids = dict(steps), dict[str, int]()
        self.news: list[str] = []

    def record_active(self, name: str, pid: int) -> None:
        """Record the process id of the active node of a role."""
        self._pids[name] = pid

    def kill_due(self, step: int, _: int) -> None:
        """Kill the nodes whose step has come."""
        for name in [name for name, due in self._steps.items() if step >= due]:
            del self._steps[name]
            os.kill(self._pids[name], signal.SIGKILL)

    def run(self, path: Path | None, scene: Scene = SCENE, **options: Any) -> dict[str, Any]:
        """Return the summary of a run with these kills."""
        callbacks: dict[str, Callable[..., object]] = {
            "on_activated": self.record_active,
            "on_progress": self.kill_due,
            "on_news": self.news.append,
        }
        return orchestration.run(scene, record=path, **callbacks, **options)


@pytest.mark.long
def test_killed_nodes_are_replaced_and_no_bit_changes(tmp_path: Path) -> None:
    """With restarts a run has the same states; the recording has them all, as have the bags."""
    path = tmp_path / "run.rrd"
    summary = NodeKiller({"controller": 500, "recorder": 2000}).run(
        path, restart=True, mcap=tmp_path / "run.mcap"
    )
    assert "error" not in summary and summary["restarts"] == {"controller": 1, "recorder": 1}
    assert summary["state_sha256"] == simulate(SCENE).summary["state_sha256"]
    assert summary["recorded_steps"] == read_summary(path)["recorded_steps"] == SCENE.steps
    assert summary["lost_steps"] == 0
    assert np.array_equal(
        np.unique(read_curves(path, "plots/q").step), np.arange(1, SCENE.steps + 1)
    )
    recorded = read_recording(path)
    assert recorded.finished and recorded.completeness == Completeness()
    bags = [tmp_path / name for name in ("run.recovered.mcap", "run.part2.mcap")]
    assert summary["bag_parts"] == [*map(str, bags)]
    for topic, count in (
        ("/knuckle/joint_states", SCENE.steps + 1),
        ("/knuckle/applied_effort", SCENE.steps),
    ):
        stamps = {stamp_of(message) for bag in bags for _, message in read(bag)[topic]}
        assert stamps == set(range(SCENE.period_ns, (count + 1) * SCENE.period_ns, SCENE.period_ns))
    assert summary["mcap"] == str(bags[-1])
    assert set(tmp_path.iterdir()) == {path, *bags}  # the parts of the recording have become one


def test_a_killed_controller_has_the_crane_braked_to_rest(tmp_path: Path) -> None:
    """Without restarts drives come to rest; the run ends with the fault, recorded whole."""
    path = tmp_path / "run.rrd"
    killer = NodeKiller({"controller": 100})
    summary = killer.run(path, ENDLESS)
    assert summary["error"] == "controller: it was killed by SIGKILL"
    assert killer.news == ["controller: it was killed by SIGKILL; the crane is braked to rest"]
    assert summary["recorded_steps"] == summary["steps"] < ENDLESS.steps
    rates = read_curves(path, "plots/v").values
    driven = [SCENE.joint_names.index(name) for name in SCENE.actuated]
    assert np.abs(rates[:100, driven]).max() > 10 * SLOW  # it did move
    assert np.abs(rates[-1, driven]).max() < SLOW  # what the plant itself calls rest
    assert [state for _, state in read_recording(path).states["brakes"]] == ["released", "acting"]


@pytest.mark.long
def test_a_killed_recorder_costs_no_step(tmp_path: Path) -> None:
    """A killed recorder costs no step; its file is recovered; the error names the missing steps."""
    killer = NodeKiller({"recorder": 2 * BLOCK_STEPS})  # it may be behind by a block
    summary = killer.run(tmp_path / "run.rrd")
    assert summary["steps"] == SCENE.steps
    assert summary["lost_steps"] == SCENE.steps - summary["recorded_steps"] > 0
    recovered = tmp_path / "run.recovered.rrd"
    assert summary["recording"] == str(recovered)
    counted = f"it has {summary['recorded_steps']} of {SCENE.steps} steps"
    assert (
        summary["error"]
        == f"recorder: it was killed by SIGKILL; {recovered} is incomplete, {counted}"
    )
    # steps that were being written when the process was killed may be there, too
    assert len(read_curves(recovered, "plots/q").step) >= summary["recorded_steps"] > 0
    run = read_recording(recovered)
    assert (
        run.completeness.state == CUT
        and len(run.t) >= summary["recorded_steps"]
        and not run.finished
    )


def test_control_is_back_with_the_next_controller_s_command() -> None:
    """A dead controller's command that is still held does not count, nor one not applied."""
    old, new = ("1.0",), ("2.0",)
    heard = {
        "c": [Received(100, 1, old), Received(900, 2, new)],
        "e": [Received(950, 1, old), Received(1200, 2, new), Received(1300, 3, new)],
        "s": [],
    }
    assert back_after(Kill("controller", 200, 800), heard) == pytest.approx(1000e-9)
    assert back_after(Kill("controller", 200, 0), heard) == float("inf")


def test_overruns_are_counted_from_outside() -> None:
    """A step's lateness is that of its last message, by the schedule of the most punctual state."""
    late = np.array([0, 400, 1100, 0, 2500, 900])  # ns, of periods of 1000 ns
    first = Received(-5000, 1000, ())  # from before the schedule
    states = [
        first,
        *(Received(k * 1000 + by, (k + 2) * 1000, ()) for k, by in enumerate(late.tolist())),
    ]
    efforts = [Received(state.sent + 30, state.stamp - 1000, ()) for state in states[1:]]
    assert completion_delays(states, efforts, 1000).tolist() == (late + 30).tolist()


@pytest.mark.slow
@pytest.mark.parametrize("count", [20, 200])
def test_kills_in_real_time(count: int) -> None:
    """The soak passes: steps of plant, subscriber and recording, control in time, and no leak."""
    metrics, data = soak_kills(count, seed=1)
    assert data["summary"]["restarts"] == {"controller": count // 2, "recorder": count // 2}
    failed = [metric for metric in metrics if not metric.passed]
    machines = ("publish call", "longest gap")  # a busy machine may break these, too
    assert all(metric.what.startswith(machines) for metric in failed), failed
