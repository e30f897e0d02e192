"""Nodes are killed in the middle of a run: what is replaced, what is braked, what is recorded and what is told."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap_samples import read, stamp_of

from crane_sim import load_scene, orchestration
from crane_sim.evaluation.soak.kill import Kill, back_after
from crane_sim.evaluation.soak.kill import soak as kill_soak
from crane_sim.evaluation.soak.monitor import Received
from crane_sim.evaluation.soak.realtime import lateness
from crane_sim.orchestration.supervisor import Callbacks, RunError, Supervisor
from crane_sim.recording.rerun.reader import read_curves, read_summary
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.recorder.replay_buffer import SECONDS, ReplayBuffer
from crane_sim.simulation.plant import SLOW
from crane_sim.simulation.rollout import simulate

SCENE = load_scene("knuckle_setpoint", {"duration": 60.0})
STATE = JointWire(SCENE.joint_names, effort=False)


class Assassin:
    """Kills the nodes that fill given places of a run, each once, as soon as the run has come so far."""

    def __init__(self, victims: dict[str, int]) -> None:
        """Kill by name, at these steps."""
        self._victims, self._pids = dict(victims), dict[str, int]()
        self.news: list[str] = []
        self.at = 0.0  # s, when the last one was killed

    def filled(self, name: str, pid: int) -> None:
        """Take note of who fills a place."""
        self._pids[name] = pid

    def progress(self, step: int, _: int) -> None:
        """Kill who is due."""
        for name in [name for name, at in self._victims.items() if step >= at]:
            del self._victims[name]
            self.at = time.monotonic()
            os.kill(self._pids[name], signal.SIGKILL)

    def run(self, path: Path | None, **options: Any) -> dict[str, Any]:
        """Return the summary of a run with these interventions."""
        listeners: dict[str, Callable[..., object]] = {
            "on_filled": self.filled,
            "on_progress": self.progress,
            "on_news": self.news.append,
        }
        return orchestration.run(SCENE, record=path, **listeners, **options)


def test_whoever_is_killed_is_replaced_and_no_bit_changes(tmp_path: Path) -> None:
    """With replacements a run goes through the same states; the recording has them all, and so have the bags."""
    path = tmp_path / "run.rrd"
    summary = Assassin({"controller": 500, "recorder": 2000}).run(path, restart=True, mcap=tmp_path / "run.mcap")
    assert "error" not in summary and summary["restarts"] == {"controller": 1, "recorder": 1}
    assert summary["state_sha256"] == simulate(SCENE).summary["state_sha256"]
    assert summary["recorded_steps"] == read_summary(path)["recorded_steps"] == SCENE.steps
    assert summary["lost_steps"] == 0
    assert np.array_equal(np.unique(read_curves(path, "plots/q").step), np.arange(1, SCENE.steps + 1))
    bags = [tmp_path / name for name in ("run.recovered.mcap", "run.part2.mcap")]
    assert summary["bag_parts"] == [*map(str, bags)]
    for topic, count in (("/knuckle/joint_states", SCENE.steps + 1), ("/knuckle/applied_effort", SCENE.steps)):
        stamps = {stamp_of(message) for bag in bags for _, message in read(bag)[topic]}
        assert stamps == set(range(SCENE.period_ns, (count + 1) * SCENE.period_ns, SCENE.period_ns))
    assert summary["mcap"] == str(bags[-1])
    assert set(tmp_path.iterdir()) == {path, *bags}  # the parts of the recording have become one


def test_without_its_controller_the_crane_is_braked_to_rest(tmp_path: Path) -> None:
    """Where nobody replaces the controller the drives come to rest; the run ends with the fault, recorded whole."""
    path = tmp_path / "run.rrd"
    assassin = Assassin({"controller": 100})
    summary = assassin.run(path)
    assert summary["error"] == "controller: it was killed by SIGKILL"
    assert assassin.news == ["controller: it was killed by SIGKILL; the crane is braked to rest"]
    assert summary["recorded_steps"] == summary["steps"] < SCENE.steps
    rates = read_curves(path, "plots/v").values
    driven = [SCENE.joint_names.index(name) for name in SCENE.actuated]
    assert np.abs(rates[:100, driven]).max() > 10 * SLOW  # it did move
    assert np.abs(rates[-1, driven]).max() < SLOW  # what the plant itself calls rest


def test_without_its_recorder_the_plant_goes_on(tmp_path: Path) -> None:
    """A killed recorder costs no step of the run; what it wrote can be read, and the error says how much that is."""
    assassin = Assassin({"recorder": 2000})
    summary = assassin.run(tmp_path / "run.rrd")
    assert summary["steps"] == SCENE.steps
    assert summary["lost_steps"] == SCENE.steps - summary["recorded_steps"] > 0
    found = tmp_path / "run.recovered.rrd"
    assert summary["recording"] == str(found)
    counted = f"it has {summary['recorded_steps']} of {SCENE.steps} steps"
    assert summary["error"] == f"recorder: it was killed by SIGKILL; {found} is incomplete, {counted}"
    # what was on its way to the disk when the process died may be there, too
    assert len(read_curves(found, "plots/q").step) >= summary["recorded_steps"] > 0


def test_a_killed_plant_ends_the_run(tmp_path: Path) -> None:
    """When the plant is killed the run ends within 3 s, with one line why and a recording of all steps up to there."""
    path, assassin = tmp_path / "run.rrd", Assassin({"plant": 1000})
    summary = assassin.run(path)
    assert time.monotonic() - assassin.at < 3.0
    assert summary["error"] == "plant: it was killed by SIGKILL"
    steps = read_curves(path, "plots/q").step
    assert np.array_equal(steps, np.arange(1, len(steps) + 1))
    assert len(steps) == summary["recorded_steps"] >= 1000


def test_the_tail_keeps_what_nobody_has_written(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who stands by keeps the newest messages and what still holds, hands over both, and then passes on all."""
    now, heard = [0.0], []
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    tail = ReplayBuffer(["joint_states", "simulation_state"])
    takers = tail.takers()
    takers["simulation_state"](b"playing")
    messages = [STATE.encode(second * 10**9, (0.0,) * 6, (0.0,) * 6) for second in range(21)]
    for second in range(20):
        now[0] = float(second)
        takers["joint_states"](messages[second])
    tail.pass_to([{name: heard.append for name in takers}], behind=[11 * 10**9])
    takers["joint_states"](messages[20])
    assert heard == [b"playing", *messages[12:]]
    assert 19 - SECONDS < 11  # what was written already is what was skipped


def test_control_is_back_with_the_next_controller_s_command() -> None:
    """A command of the dead controller that is still held does not count, nor one that was not applied."""
    old, new = ("1.0",), ("2.0",)
    heard = {
        "c": [Received(100, 1, old), Received(900, 2, new)],
        "e": [Received(950, 1, old), Received(1200, 2, new), Received(1300, 3, new)],
        "s": [],
    }
    assert back_after(Kill("controller", 200, 800), heard) == pytest.approx(1000e-9)
    assert back_after(Kill("controller", 200, 0), heard) == float("inf")


class ScriptedCrew:
    """A plant without a process, to which one thing happens at every look."""

    def __init__(self, script: list[dict[str, Any]]) -> None:
        """Let these attributes of the plant change, one after the other."""
        self.plant = SimpleNamespace(name="plant", pid=1, ready=True, fault="", waiting="", summary=None, step=0)
        self.plant.order, self.plant.active = (lambda line: None), True
        self.children, self._script = [self.plant], list(script)

    def listen(self, timeout: float) -> bool:
        """Let the next thing happen; after the last one only time passes."""
        if not self._script:
            time.sleep(0.01)
            return False
        time.sleep(0.01)
        vars(self.plant).update(self._script.pop(0))
        return True


def played(script: list[dict[str, Any]], patience: float) -> list[str]:
    """Return the news of a run without a controller of our own."""
    crew, news = ScriptedCrew(script), list[str]()
    post: Any = SimpleNamespace(name="plant", active=crew.plant, failed="", standbys_ready=True)
    fake: Any = crew
    conductor = Supervisor(
        fake, [post], [], Callbacks(lambda step: None, news.append, lambda name, pid: None), patience
    )
    conductor.wait_ready()
    try:
        conductor.play()
    except RunError as error:
        news.append(f"error: {error}")
    return news


def test_a_plant_that_waits_for_the_user_s_node_says_so() -> None:
    """The terminal is told that the plant waits and that it goes on, and after too long a silence the run ends."""
    waits, goes_on = {"waiting": "no command for state 7"}, {"waiting": ""}
    told = ["the plant waits: no command for state 7", "the plant goes on"]
    assert played([waits, waits, goes_on, {"summary": {}}], patience=60.0) == told
    given_up = "error: plant: no command for state 7; that was 0.05 s ago"
    assert played([waits], patience=0.05) == [told[0], given_up]
    paused = [waits | {"active": False}] * 10  # 0.1 s, in which the user need not answer
    assert played([*paused, goes_on, {"summary": {}}], patience=0.05) == told


def test_overruns_are_counted_from_outside() -> None:
    """How late a step ends is seen in its last message, against the schedule that its most punctual state tells."""
    late = np.array([0, 400, 1100, 0, 2500, 900])  # ns, of periods of 1000 ns
    first = Received(-5000, 1000, ())  # from before the schedule
    states = [first, *(Received(k * 1000 + by, (k + 2) * 1000, ()) for k, by in enumerate(late.tolist()))]
    efforts = [Received(state.sent + 30, state.stamp - 1000, ()) for state in states[1:]]
    assert lateness(states, efforts, 1000).tolist() == (late + 30).tolist()


@pytest.mark.slow
@pytest.mark.parametrize("count", [20, 200])
def test_kills_in_real_time(count: int) -> None:
    """The soak keeps every promise: steps of plant, subscriber and recording, control back in time, no leak."""
    figures, data = kill_soak(count, seed=1)
    assert data["summary"]["restarts"] == {"controller": count // 2, "recorder": count // 2}
    broken = [figure for figure in figures if not figure.kept]
    machines = ("publish call", "longest gap")  # what a busy machine may break, too
    assert all(figure.what.startswith(machines) for figure in broken), broken
