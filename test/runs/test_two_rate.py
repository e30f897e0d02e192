"""A law in halves: a tracker at a rate of its own, in a process of its own, above a servo."""

import json
import os
import signal
import subprocess
import sys
import time
from math import ceil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from process_helpers import children, next_line, started_program
from trajectory_msgs.msg import JointTrajectory
from two_rate_messages import PERIOD, heard, message, state

from crane_control.nodes.tracker_node import halved_law
from crane_sim import load_scene, orchestration
from crane_sim.files.errors import SceneError
from crane_sim.laws import fast_half, fresh
from crane_sim.ros.common import messages
from crane_sim.ros.controller.states import ExecutionTime
from crane_sim.simulation.plant import Plant

SCENE = load_scene("offshore_two_rate", {"duration": 2.0})


def stepped(laws: Any) -> tuple[Plant, list[int]]:
    """Return the plant after a run with the efforts of `laws(t, q, v)`, and the steps at which its demand changed."""
    plant, changes, before = Plant(SCENE), [], None
    for k in range(SCENE.steps):
        effort, demand = laws(plant.t, plant.q, plant.v)
        if demand != before:
            changes.append(k)
        before = demand
        plant.advance(effort)
    return plant, changes


@pytest.fixture(scope="module")
def whole() -> tuple[Plant, list[int]]:
    """Return a run of the law in one piece."""
    law = fresh(SCENE.law)
    return stepped(lambda t, q, v: (law(t, q, v), law.slow_half.demand))


def test_the_tracker_is_asked_at_the_first_step_of_every_interval(whole: tuple[Plant, list[int]]) -> None:
    """Demands change at the first control steps at or after multiples of a thirtieth of a second, and hold between."""
    assert whole[1] == [ceil(j / 30.0 / PERIOD - 1e-6) for j in range(60)]


def test_halves_are_the_whole(whole: tuple[Plant, list[int]]) -> None:
    """A servo that is given the demands of a tracker elsewhere moves the crane as the law in one piece, bit for bit."""
    slow, fast = fresh(SCENE.law), fast_half(fresh(SCENE.law))

    def both(t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[tuple[float, ...], None]:
        if slow.slow_half.due(t):
            slow(t, q, v)
            fast.slow_half.take(slow.slow_half.demand)
        return fast(t, q, v), None

    assert stepped(both)[0].summary()["state_sha256"] == whole[0].summary()["state_sha256"]


def test_lockstep_waits_for_the_tracker(whole: tuple[Plant, list[int]], domain_id: int) -> None:
    """Plant, tracker and servo in processes of their own pass through the states of the law in one piece."""
    summary = orchestration.run(SCENE, record=None, domain_id=domain_id)
    assert "error" not in summary
    assert summary["state_sha256"] == whole[0].summary()["state_sha256"]
    assert summary["demands"]["received"] in (60, 61)  # the final state asks, too: the servo may have ended before
    assert summary["demands"]["late"] == 0
    assert summary["demands"]["longest_hold"] == pytest.approx(8 * PERIOD)  # 33 ms are 8 steps and a third
    assert 0.0 < summary["law_us"]["p50"] <= summary["law_us"]["max"]
    assert 0.0 < summary["tracker_us"]["p50"] <= summary["tracker_us"]["max"]


def test_realtime_goes_on_whatever_the_tracker_does(domain_id: int) -> None:
    """In real time the run takes every step with the demands as they come, and keeps the payload on its path."""
    summary = orchestration.run(SCENE, mode="realtime", record=None, domain_id=domain_id)
    assert "error" not in summary
    assert summary["steps"] == 500 and summary["demands"]["received"] > 0
    assert summary["tracking_peak"] < 0.5  # m; 1.35, the way to the origin, if a demand were taken before one came


KILLED = """
import json
from crane_sim import load_scene, orchestration
scene = load_scene("offshore_two_rate", {"duration": 1e5})
told = orchestration.run(scene, mode="realtime", record=None, on_progress=lambda *at: print(*at, flush=True))
print(json.dumps(told))
"""


@pytest.mark.slow
def test_a_killed_tracker_ends_the_run(tmp_path: Path) -> None:
    """The servo holds the last demand until the run is ended, which names the tracker and says how far it came."""
    env = os.environ | {"TMPDIR": str(tmp_path)}
    with started_program([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, env=env) as process:
        while int(next_line(process).split()[0]) < 10:
            pass
        os.kill(children(process.pid)["tracker"], signal.SIGKILL)
        summary = json.loads(process.communicate()[0].splitlines()[-1])
    assert summary["error"] == "tracker: it was killed by SIGKILL"
    assert summary["steps"] > 0 and summary["demands"]["received"] > 0


def test_lockstep_waits_for_the_demand_of_the_very_state() -> None:
    """A state that asks for a demand waits for the one with its stamp; others take the last one at once."""
    node, answered, demands, half = heard(patient=True)
    assert not demands.given_to(half, state(0))
    node.callback(message(0, 1.0))
    assert answered == [state(0)] and demands.given_to(half, state(0)) and half.demand[0] == 1.0
    assert demands.given_to(half, state(9)) and not demands.given_to(half, state(10))
    node.callback(message(10, 2.0))
    assert answered == [state(0), state(10)] and demands.given_to(half, state(10)) and half.demand[0] == 2.0
    node.callback(message(10, 2.0))  # the answer to a state that lockstep has sent again counts once
    assert not demands.given_to(half, state(0))  # the plant began anew: what is there is of the run before
    assert demands.figures() == {"received": 2, "late": 0, "longest_hold": 0.036}


def test_realtime_holds_and_counts() -> None:
    """Without patience the last demand holds, a late one is counted, and a long silence is warned of."""
    node, answered, demands, half = heard(patient=False)
    assert not demands.given_to(half, state(0))  # nothing has ever been demanded
    node.callback(message(0, 1.0))
    assert answered == [state(0)]
    assert demands.given_to(half, state(10)) and half.demand[0] == 1.0
    node.callback(message(10, 2.0))
    assert demands.given_to(half, state(11)) and half.demand[0] == 2.0 and demands.figures()["late"] == 0
    assert demands.given_to(half, state(21))
    node.callback(message(20, 3.0))
    assert demands.figures()["late"] == 1 and not demands.warning(half)
    assert demands.given_to(half, state(60)) and demands.warning(half) == "no demand for 0.16 s: the last one holds"


def test_what_is_no_demand_is_ignored() -> None:
    """Other joints, missing or further numbers and what is not finite change nothing, and are logged."""
    node, _, demands, half = heard(patient=False)
    short, other, nan = message(0, 1.0), message(0, 1.0), message(0, float("nan"))
    short.points[0].velocities, other.joint_names = [0.0], ["tip_x", "slew"]  # type: ignore[index]
    for bad in (short, other, nan, JointTrajectory()):
        node.callback(bad)
    assert not demands.given_to(half, state(0)) and len(node.lines) == 4


class PublishingNode:
    """A node that keeps what is published."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.messages: list[Any] = []

    def get_name(self) -> str:
        """Return a name."""
        return "controller"

    def get_namespace(self) -> str:
        """Return a namespace."""
        return "/pendulum"

    def create_publisher(self, _type: type, topic: str, _qos: Any) -> SimpleNamespace:
        """Return what keeps messages."""
        assert topic == "/diagnostics"
        return SimpleNamespace(publish=self.messages.append)


def test_diagnostics_tell_what_the_law_takes() -> None:
    """The time that a law takes is its node's own measurement, told once a second with a warning where there is one."""
    node = PublishingNode()
    workload = ExecutionTime(node)  # type: ignore[arg-type]

    def slow(t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        time.sleep(0.002)
        return (t, 2.0)

    assert workload.asked(slow, state(5), 2) == (5 * PERIOD, 2.0)
    assert workload.silent()
    workload.tell("no demand", {"received": 3})
    assert not workload.silent()
    status = node.messages[0].status[0]
    values = {pair.key: pair.value for pair in status.values}
    assert (status.name, status.message, values["received"]) == ("pendulum/controller", "no demand", "3")
    assert float(values["law p50 [us]"]) >= 2000.0 and float(values["law max [us]"]) >= 2000.0
    assert messages.nanoseconds(node.messages[0].header.stamp) == state(5).stamp


def test_states_must_come_as_often_as_the_tracker_wants_them() -> None:
    """A tracker that is asked more often than once a period is refused in one line; a law without one has no node."""
    with pytest.raises(SceneError, match=r"control.tracker_rate = 300: must be at most 1 / period = 250 Hz"):
        load_scene("offshore_two_rate", {"control.tracker_rate": 300.0})
    with pytest.raises(ValueError, match=r"offshore_resonant: its law has no slow half"):
        halved_law(SimpleNamespace(scene="offshore_resonant", law=""))
