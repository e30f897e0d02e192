"""Lockstep and braking without ROS: when they complain, and that they never leave a crane on the same clock behind."""

import time
from types import SimpleNamespace
from typing import Any

import pytest
from lockstep_doubles import SCENE, ZERO, QuietHost, QuietTopics, lockstep

from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.plant import braking
from crane_sim.ros.plant import lockstep as lockstep_module
from crane_sim.ros.plant.braking import brake_to_rest
from crane_sim.ros.plant.simulation_run import SimulationRun

PERIOD = SCENE.period_ns


@pytest.mark.parametrize("several", [False, True])
def test_waiting_is_told_after_the_time_that_is_told(
    several: bool, stepper: SimulationRun, topics: QuietTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether states are sent again at the usual pace or, with several publishers, faster: the time is the same."""
    host = QuietHost()
    pace = lockstep(host, stepper)
    quick = SimpleNamespace(begin=lambda: None, look=lambda: None, several=several, wait=time.sleep, poll=lambda: None)
    monkeypatch.setattr(pace, "_commands", quick)
    waits: list[tuple[float, str]] = []

    def wait(why: str) -> None:
        waits.append((time.monotonic(), why))
        host.stopping = "finish"

    monkeypatch.setattr(stepper, "wait", wait)
    began = time.monotonic()
    pace.run()
    assert waits[0][0] - began >= 0.3
    assert waits[0][1].startswith("no valid command for state 1 within 0.3 s")
    assert topics.states >= (4 if several else 2)  # 0.3 s at one in 0.05 s or 0.1 s, less what a busy machine loses


def test_single_steps_leave_no_crane_behind(stepper: SimulationRun) -> None:
    """A step that is asked for is taken when the other crane has come as far, and refused with its name before."""
    host = QuietHost()
    pace, wire = lockstep(host, stepper, beside="other"), JointWire(SCENE.joint_names, effort=False)
    stepper.pause(True, "user")
    stepper.begin()

    def answered_and_seen(k: int, seen: int) -> str:
        host.queues["joint_commands"].append((JointWire(SCENE.actuated, effort=True).encode(k * PERIOD, ZERO), None))
        host.queues["/other/joint_states"].append((wire.encode(seen * PERIOD, SCENE.initial_q, SCENE.initial_v), None))
        return pace.step_once()

    assert answered_and_seen(1, 1) == ""
    assert answered_and_seen(2, 1) == "other, on the same clock, is behind"
    assert stepper.plant.k == 1
    assert answered_and_seen(2, 2) == ""
    assert stepper.plant.k == 2


def test_braking_leaves_no_crane_behind(stepper: SimulationRun, monkeypatch: pytest.MonkeyPatch) -> None:
    """While another crane is behind, a crane that brakes stands, serves everyone, and goes on when that has come."""
    monkeypatch.setattr(braking, "_LOOK", 1e-3)
    host, asked = QuietHost(), iter([True] * 5 + [False] * 3 + [True] * 100)
    host.brake = "nobody commands"
    stepper.begin()
    reached: list[int] = []
    pace: Any = SimpleNamespace(level=lambda: next(asked))
    monkeypatch.setattr(host, "spin", lambda _seconds: reached.append(stepper.plant.k))
    brake_to_rest(host, stepper, pace, 0.0)  # type: ignore[arg-type]
    assert reached.count(5) >= 3
    assert (stepper.plant.k, stepper.fault) == (20, "nobody commands")


def test_braking_waits_for_nobody_for_ever(stepper: SimulationRun, monkeypatch: pytest.MonkeyPatch) -> None:
    """A crane on the same clock that never comes is left behind once, after so long, and the run ends."""
    monkeypatch.setattr(braking, "_ALONE", 0.05)
    host = QuietHost()
    host.brake = "nobody commands"
    stepper.begin()
    pace: Any = SimpleNamespace(level=lambda: False)
    began = time.monotonic()
    brake_to_rest(host, stepper, pace, 0.0)  # type: ignore[arg-type]
    assert 0.05 <= time.monotonic() - began < 0.5  # s: once, not again with each of its 20 steps
    assert (stepper.plant.k, stepper.fault) == (20, "nobody commands")


def test_a_crane_that_brakes_tells_those_behind_again(
    stepper: SimulationRun, topics: QuietTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While another crane is behind, the present state is sent again now and then: that one may have missed it."""
    monkeypatch.setattr(lockstep_module, "_COMPANY", 0.0)
    pace = lockstep(QuietHost(), stepper, beside="other")
    stepper.begin()
    sent = topics.states
    assert not pace.level()
    assert topics.states == sent + 1


def test_two_pauses_end_one_by_one(stepper: SimulationRun, topics: QuietTopics) -> None:
    """A user's pause outlasts one that a manager of nodes began and ended meanwhile, and the mode says so."""
    for paused, whose in ((True, "user"), (True, "lifecycle"), (False, "lifecycle")):
        stepper.pause(paused, whose)
        assert stepper.paused and topics.modes[-1] == messages.PAUSED
    stepper.pause(False, "user")
    assert not stepper.paused and topics.modes[-1] == messages.PLAYING
