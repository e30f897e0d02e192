"""Lockstep and braking without ROS: reports of waiting, and cranes in sync on the same clock."""

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from lockstep_doubles import (
    SCENE,
    STEPS_TO_REST,
    TIMEOUT,
    ZERO,
    FakeHost,
    FakeTopics,
    make_lockstep,
    make_simulation,
)

from crane_sim.ros.common.messages import SimulationState
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec
from crane_sim.ros.plant import braking
from crane_sim.ros.plant import lockstep as lockstep_module
from crane_sim.ros.plant.braking import brake_to_rest
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.ros.plant_node import PlantNode

PERIOD = SCENE.period_ns
REASON = "controller: it was killed"  # of the braking


@pytest.mark.usefixtures("stepped_clock")
@pytest.mark.parametrize("contested", [False, True])
def test_waiting_is_reported_after_the_timeout(
    contested: bool, simulation: SimulationRun, topics: FakeTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The time-out is the same if states are sent again at the usual rate or a faster one.

    The latter is that with several publishers.
    """
    host = FakeHost()
    lockstep = make_lockstep(host, simulation)
    arbiter = SimpleNamespace(start=lambda: None, update=lambda: None, contested=contested)
    monkeypatch.setattr(lockstep, "_commands", arbiter)
    waits: list[tuple[float, str]] = []

    def record_waiting(why: str) -> None:
        waits.append((time.monotonic(), why))
        host.stop_reason = "finish"

    monkeypatch.setattr(simulation, "set_waiting", record_waiting)
    began = time.monotonic()
    lockstep.run()
    assert waits[0][0] - began >= TIMEOUT
    assert waits[0][1].startswith("no valid command for state 1 within 0.3 s")
    # 0.3 s at one in 0.05 s or 0.1 s, with the first
    assert topics.states in ((6, 7) if contested else (3, 4))


def test_a_repeated_state_comes_with_a_later_time(
    topics: FakeTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the clock leads, a repeated state advances it within the period.

    A node that missed the state wakes.
    """
    host, simulation = FakeHost(), make_simulation(topics, clock_leads=True)
    topics.acknowledged = True

    def spin(timeout: float = 0.01) -> None:
        host.stop_reason = "enough" if topics.states > 3 else ""
        time.sleep(timeout)

    monkeypatch.setattr(host, "spin", spin)
    make_lockstep(host, simulation, stamps="ros").run()
    standing, led = topics.clocks[0], [clock for clock in topics.clocks if clock > PERIOD]
    assert led[0] - standing >= PERIOD, (
        "ros2_control's loop begins a period after the first time that it reads"
    )
    assert len(set(led)) >= 3 and led == sorted(led) and led[-1] <= 2 * PERIOD


@pytest.mark.usefixtures("stepped_clock")
def test_the_clock_goes_on_for_a_newcomer(
    topics: FakeTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the clock leads, it goes on by periods while a publisher has sent nothing.

    One that has sent something is waited for.

    The command of a loop that these periods woke is taken, and the next state's answer is later
    than all of them.
    """
    host, simulation = FakeHost(), make_simulation(topics, clock_leads=True)
    lockstep = make_lockstep(host, simulation, stamps="ros")
    arbiter = SimpleNamespace(
        start=lambda: None, update=lambda: None, contested=False, has_newcomer=False
    )
    monkeypatch.setattr(lockstep, "_commands", arbiter)
    topics.acknowledged = True
    codec = JointStateCodec(SCENE.actuated, EFFORT)

    answers: list[int] = []  # stamps of commands that were taken

    def answer(stamp: int) -> bool:
        taken = lockstep._on_command(codec.encode(stamp, ZERO))
        answers.extend([stamp] * taken)
        return taken

    def run_until(condition: Callable[[], bool], answered: Callable[[], int] | None = None) -> None:
        def spin(timeout: float = 0.01) -> None:
            if condition():
                host.stop_reason = "enough"
                if answered:
                    answer(answered())
            time.sleep(timeout)

        monkeypatch.setattr(host, "spin", spin)
        host.stop_reason = ""
        lockstep.run()

    run_until(lambda: bool(simulation.waiting) and topics.states > 8)
    assert topics.clocks[-1] <= 2 * PERIOD
    arbiter.has_newcomer = True
    run_until(lambda: topics.clocks[-1] > 4 * PERIOD, lambda: topics.clocks[-2])
    woken = topics.clocks.index(answers[-1])
    assert simulation.plant.k == 1
    reading = topics.clocks[woken + 1]
    assert not answer(reading), "it may have been computed from the state before"
    arbiter.has_newcomer = False
    run_until(lambda: topics.clocks[-1] > reading, lambda: topics.clocks[-1])
    assert answers[-1] - reading == PERIOD
    assert simulation.plant.k == 2


@pytest.mark.usefixtures("stepped_clock")
def test_single_steps_stay_in_sync(simulation: SimulationRun) -> None:
    """A single step is taken when the other crane has come as far, and refused before.

    The refusal has the other crane's name.
    """
    host = FakeHost()
    lockstep, codec = (
        make_lockstep(host, simulation, beside="other"),
        JointStateCodec(SCENE.joint_names, STATE),
    )
    simulation.pause(True, "user")
    simulation.start()

    def step_after(command: int, peer_state: int) -> str:
        host.queues["joint_commands"].append(
            (JointStateCodec(SCENE.actuated, EFFORT).encode(command * PERIOD, ZERO), None)
        )
        host.queues["/other/joint_states"].append(
            (
                codec.encode(
                    peer_state * PERIOD, SCENE.initial_q, SCENE.initial_v, SCENE.initial_v
                ),
                None,
            )
        )
        return lockstep.step_once()

    assert step_after(1, 1) == ""
    assert step_after(2, 1) == "other, on the same clock, is behind"
    assert simulation.plant.k == 1
    assert step_after(2, 2) == ""
    assert simulation.plant.k == 2


def test_braking_stays_in_sync(simulation: SimulationRun, monkeypatch: pytest.MonkeyPatch) -> None:
    """While another crane is behind, a braking crane stands, serves callbacks, and then goes on."""
    monkeypatch.setattr(braking, "_POLL", 1e-3)
    host, in_sync = FakeHost(), iter([True] * 5 + [False] * 3 + [True] * 100)
    host.brake_reason = REASON
    simulation.start()
    reached: list[int] = []
    scheduler: Any = SimpleNamespace(in_sync=lambda: next(in_sync))
    monkeypatch.setattr(host, "spin", lambda _seconds: reached.append(simulation.plant.k))
    brake_to_rest(host, simulation, scheduler, 0.0)  # type: ignore[arg-type]
    assert reached.count(5) >= 3
    assert (simulation.plant.k, simulation.failure) == (STEPS_TO_REST, REASON)


@pytest.mark.usefixtures("stepped_clock")
def test_braking_waits_for_a_peer_only_up_to_a_timeout(
    simulation: SimulationRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A crane on the same clock that never comes is waited for once, and the run ends.

    The wait has a limit.
    """
    monkeypatch.setattr(braking, "_PEER_TIMEOUT", 0.5)
    host = FakeHost()
    host.brake_reason = REASON
    simulation.start()
    scheduler: Any = SimpleNamespace(in_sync=lambda: False)
    began = time.monotonic()
    brake_to_rest(host, simulation, scheduler, 0.0)  # type: ignore[arg-type]
    assert 0.5 <= time.monotonic() - began < 1.0  # s: once, not again with each of its 20 steps
    assert (simulation.plant.k, simulation.failure) == (STEPS_TO_REST, REASON)


def test_states_are_resent_to_peers_that_are_behind(
    simulation: SimulationRun, topics: FakeTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While another crane is behind, the present state, which it may have missed, is sent again."""
    monkeypatch.setattr(lockstep_module, "_RESEND_TO_PEERS", 0.0)
    lockstep = make_lockstep(FakeHost(), simulation, beside="other")
    simulation.start()
    sent = topics.states
    assert not lockstep.in_sync()
    assert topics.states == sent + 1


def test_every_crane_beside_is_waited_for_once(simulation: SimulationRun) -> None:
    """Commas without a name between them, slashes and repetitions add no subscriber to wait for."""
    host, beside = FakeHost(), "left, /right/,,left,"
    scheduler = make_lockstep(host, simulation, beside=beside)
    peers = {topic for topic in host.queues if topic.endswith("/joint_states")}
    assert peers == {"/left/joint_states", "/right/joint_states"}
    settings = {
        "expected_controllers": 1,
        "expected_trackers": 0,
        "expected_recorders": 0,
        "beside": beside,
    }
    topics = SimpleNamespace(missing=lambda state_subscribers, _: str(state_subscribers))
    plant: Any = PlantNode
    parts = {"_settings": SimpleNamespace(**settings), "_simulation": simulation, "_topics": topics}
    node = SimpleNamespace(**parts, _scheduler=scheduler)
    assert plant._missing(node) == str(1 + len(peers))


def test_two_pauses_end_one_by_one(simulation: SimulationRun, topics: FakeTopics) -> None:
    """A user's pause, and the mode, outlast one of a lifecycle manager that began and ended."""
    for paused, source in ((True, "user"), (True, "lifecycle"), (False, "lifecycle")):
        simulation.pause(paused, source)
        assert simulation.paused and topics.modes[-1] == SimulationState.PAUSED
    simulation.pause(False, "user")
    assert not simulation.paused and topics.modes[-1] == SimulationState.PLAYING


@pytest.mark.usefixtures("stepped_clock")
@pytest.mark.parametrize("paused", [False, True])
def test_commands_move_the_crane_in_the_run_alone(paused: bool, simulation: SimulationRun) -> None:
    """Each command in a run is a step, unless it is paused; one that comes later moves nothing."""
    host = FakeHost()
    lockstep, codec = make_lockstep(host, simulation), JointStateCodec(SCENE.actuated, EFFORT)

    def serve() -> bool:
        host.stop_reason = "finish" if len(commands) == 10 else ""
        commands.append(simulation.stamp)
        return lockstep._on_command(codec.encode(simulation.stamp, ZERO))

    commands: list[int] = []
    host.spin = lambda timeout=0.01: (serve(), time.sleep(timeout))  # type: ignore[method-assign]
    if paused:
        simulation.pause(True, "user")
    lockstep.run()
    assert simulation.plant.k == (0 if paused else 11)
    simulation.resume()
    assert serve() != paused
    assert simulation.plant.k == (0 if paused else 11)
