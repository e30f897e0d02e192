"""Two-rate laws: a tracker at a rate of its own, in a process of its own, above a servo."""

import time
from math import ceil
from types import SimpleNamespace
from typing import Any

import pytest
from fake_node import fake_sources
from trajectory_msgs.msg import JointTrajectory
from two_rate_messages import PERIOD, make_setpoint_fixture, make_setpoint_message, make_state

from crane_control.nodes.tracker_node import make_two_rate_law
from crane_sim import load_scene, orchestration
from crane_sim.files.errors import SceneError
from crane_sim.laws import inner_loop_of, with_initial_state
from crane_sim.ros.common import messages
from crane_sim.ros.controller import states
from crane_sim.ros.controller.states import ExecutionTime
from crane_sim.simulation.plant import Plant

__all__ = ["fake_sources"]

pytestmark = pytest.mark.usefixtures("fake_sources")

SCENE = load_scene("offshore_two_rate", {"duration": 0.5})


def run_plant(law: Any) -> tuple[Plant, list[int]]:
    """Return the plant after a run of `law(t, q, v)`, and the steps where its setpoint changed."""
    plant, changes, previous = Plant(SCENE), [], None
    for k in range(SCENE.steps):
        effort, setpoint = law(plant.t, plant.q, plant.v)
        if setpoint != previous:
            changes.append(k)
        previous = setpoint
        plant.advance(effort)
    return plant, changes


@pytest.fixture(scope="module")
def whole() -> tuple[Plant, list[int]]:
    """Return a run of the law in one process."""
    law = with_initial_state(SCENE.law)
    return run_plant(lambda t, q, v: (law(t, q, v), law.outer_loop.demand))


def test_the_tracker_is_evaluated_at_the_first_step_of_every_interval(
    whole: tuple[Plant, list[int]],
) -> None:
    """Demands change at first control steps at or after multiples of 1/30 s, and hold between."""
    assert whole[1] == [ceil(j / 30.0 / PERIOD - 1e-6) for j in range(15)]


def test_the_two_halves_equal_the_whole_law(whole: tuple[Plant, list[int]]) -> None:
    """A servo with a separate tracker's setpoints moves the crane as the law does, bit for bit."""
    slow, fast = with_initial_state(SCENE.law), inner_loop_of(with_initial_state(SCENE.law))

    def both(
        t: float, q: tuple[float, ...], v: tuple[float, ...]
    ) -> tuple[tuple[float, ...], None]:
        if slow.outer_loop.due(t):
            slow(t, q, v)
            fast.outer_loop.take(slow.outer_loop.demand)
        return fast(t, q, v), None

    assert run_plant(both)[0].summary()["state_sha256"] == whole[0].summary()["state_sha256"]


@pytest.mark.long
def test_lockstep_waits_for_the_tracker(whole: tuple[Plant, list[int]], domain_id: int) -> None:
    """Plant, tracker and servo in processes of their own pass through the whole law's states."""
    summary = orchestration.run(SCENE, record=None, domain_id=domain_id)
    assert "error" not in summary
    assert summary["state_sha256"] == whole[0].summary()["state_sha256"]
    assert summary["demands"]["received"] in (15, 16)  # the servo may exit before the last one
    assert summary["demands"]["late"] == 0
    # 33 ms are 8 steps and a third
    assert summary["demands"]["longest_hold"] == pytest.approx(8 * PERIOD)
    assert 0.0 < summary["law_us"]["p50"] <= summary["law_us"]["max"]
    assert 0.0 < summary["tracker_us"]["p50"] <= summary["tracker_us"]["max"]


@pytest.mark.long
def test_realtime_does_not_wait_for_the_tracker(domain_id: int) -> None:
    """In real time the run takes every step with setpoints as they come, and follows the path."""
    scene = load_scene("offshore_two_rate", {"duration": 2.0})
    summary = orchestration.run(scene, mode="realtime", record=None, domain_id=domain_id)
    assert "error" not in summary
    assert summary["steps"] == 500 and summary["demands"]["received"] > 0
    # m; 1.35, the distance to the origin, if zeros held until the first setpoint
    assert summary["tracking_peak"] < 0.5


def test_lockstep_waits_for_the_setpoint_of_the_state() -> None:
    """A state that requires a setpoint waits for its stamp's; others take the last one at once."""
    node, answered, setpoints, outer = make_setpoint_fixture(lockstep=True)
    assert not setpoints.apply_to(outer, make_state(0))
    node.callback(make_setpoint_message(0, 1.0))
    assert (
        answered == [make_state(0)]
        and setpoints.apply_to(outer, make_state(0))
        and outer.demand[0] == 1.0
    )
    assert setpoints.apply_to(outer, make_state(9)) and not setpoints.apply_to(
        outer, make_state(10)
    )
    node.callback(make_setpoint_message(10, 2.0))
    assert (
        answered == [make_state(0), make_state(10)]
        and setpoints.apply_to(outer, make_state(10))
        and outer.demand[0] == 2.0
    )
    # the answer to a state that lockstep has sent again counts once
    node.callback(make_setpoint_message(10, 2.0))
    # the plant was reset: the setpoint is of the previous run
    assert not setpoints.apply_to(outer, make_state(0))
    assert setpoints.metrics() == {"received": 2, "late": 0, "longest_hold": 0.036}


def test_realtime_holds_and_counts() -> None:
    """In real time the last setpoint holds, and a late one is counted.

    There is a warning when none comes for long.
    """
    node, answered, setpoints, outer = make_setpoint_fixture(lockstep=False)
    assert not setpoints.apply_to(outer, make_state(0))  # there has been no setpoint yet
    node.callback(make_setpoint_message(0, 1.0))
    assert answered == [make_state(0)]
    assert setpoints.apply_to(outer, make_state(10)) and outer.demand[0] == 1.0
    node.callback(make_setpoint_message(10, 2.0))
    assert (
        setpoints.apply_to(outer, make_state(11))
        and outer.demand[0] == 2.0
        and setpoints.metrics()["late"] == 0
    )
    assert setpoints.apply_to(outer, make_state(21))
    node.callback(make_setpoint_message(20, 3.0))
    assert setpoints.metrics()["late"] == 1 and not setpoints.warning(outer)
    assert (
        setpoints.apply_to(outer, make_state(60))
        and setpoints.warning(outer) == "no setpoint for 0.16 s: the last one holds"
    )


def test_invalid_setpoints_are_ignored() -> None:
    """Setpoints with other joints, missing, excess or non-finite numbers are ignored and logged."""
    node, _, setpoints, outer = make_setpoint_fixture(lockstep=False)
    short, other, nan = (
        make_setpoint_message(0, 1.0),
        make_setpoint_message(0, 1.0),
        make_setpoint_message(0, float("nan")),
    )
    short.points[0].velocities, other.joint_names = [0.0], ["tip_x", "slew"]  # type: ignore[index]
    for bad in (short, other, nan, JointTrajectory()):
        node.callback(bad)
    assert not setpoints.apply_to(outer, make_state(0)) and len(node.lines) == 4


def test_diagnostics_have_the_execution_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A law's execution time is measured in its node, and published each second, with warnings."""
    published: list[Any] = []
    publisher = SimpleNamespace(publish=published.append)
    names = {"get_name": lambda: "controller", "get_namespace": lambda: "/pendulum"}
    node: Any = SimpleNamespace(create_publisher=lambda *_: publisher, **names)
    execution_time = ExecutionTime(node)

    def slow(t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        time.sleep(0.002)
        return (t, 2.0)

    assert execution_time.evaluate(slow, make_state(5), 2) == (5 * PERIOD, 2.0)
    assert execution_time.is_due()
    # s, in which a busy machine comes to the next line
    monkeypatch.setattr(states, "_DIAGNOSTICS_PERIOD", 60.0)
    execution_time.publish("no setpoint", {"received": 3})
    assert not execution_time.is_due()
    status = published[0].status[0]
    values = {pair.key: pair.value for pair in status.values}
    assert (status.name, status.message, values["received"]) == (
        "pendulum/controller",
        "no setpoint",
        "3",
    )
    assert float(values["law p50 [us]"]) >= 2000.0 and float(values["law max [us]"]) >= 2000.0
    assert messages.nanoseconds(published[0].header.stamp) == make_state(5).stamp


def test_the_tracker_rate_is_limited_by_the_period() -> None:
    """A tracker rate above one a period, and a law's node without tracker, are one-line errors."""
    with pytest.raises(
        SceneError, match=r"control.tracker_rate = 300: must be at most 1 / period = 250 Hz"
    ):
        load_scene("offshore_two_rate", {"control.tracker_rate": 300.0})
    with pytest.raises(ValueError, match=r"offshore_resonant: its law has no outer loop"):
        make_two_rate_law(SimpleNamespace(scene="offshore_resonant", law=""))
