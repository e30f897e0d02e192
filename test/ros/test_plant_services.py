"""The plant's services while it is paused or waits, also for dead subscribers; without DDS."""

import time
from types import SimpleNamespace
from typing import Any

import pytest
from lockstep_doubles import (
    SCENE,
    STEPS_TO_REST,
    TIMEOUT,
    ZERO,
    CountingPlant,
    FakeHost,
    FakeTopics,
    make_lockstep,
)

from crane_sim.ros.common import messages
from crane_sim.ros.plant import braking
from crane_sim.ros.plant.braking import brake_to_rest
from crane_sim.ros.plant.run_control import RunControl
from crane_sim.ros.plant.services import offer_services
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.ros.plant.topics import PlantTopics


def start_run(topics: Any, events: list[str] | None = None) -> SimulationRun:
    """Return a run that has begun and in which nothing moves; `events` gets its reports."""
    plant: Any = CountingPlant()
    plant.applied = ZERO
    pipes: Any = SimpleNamespace(
        report=lambda event, **_: (events if events is not None else []).append(event)
    )
    simulation = SimulationRun(SCENE, plant, topics, pipes, (1e9,) * len(ZERO))
    simulation.start()
    return simulation


class Services:
    """The services of a plant in lockstep without a controller."""

    def __init__(self) -> None:
        """Start the run."""
        host: Any = FakeHost()
        host.active = True
        self._callbacks: dict[str, Any] = {}
        host.node.create_service = lambda _kind, name, callback: self._callbacks.update(
            {name: callback}
        )
        self.simulation = start_run(FakeTopics())
        lockstep = make_lockstep(host, self.simulation)
        settings = SimpleNamespace(step_count=1)
        offer_services(host.node, RunControl(host, self.simulation, lockstep, settings), settings)

    def call(self, name: str, **request: Any) -> tuple[bool, str]:
        """Return success and message of an answer."""
        response = SimpleNamespace(success=False, message="")
        self._callbacks[f"~/{name}"](SimpleNamespace(**request), response)
        return response.success, response.message


def test_services_of_a_waiting_plant_reply_with_the_reason() -> None:
    """A waiting plant publishes the state paused, and services that would end a pause say why.

    So does a single step.
    """
    services = Services()
    assert services.call("set_pause", data=False) == (True, "")
    assert services.call("step_simulation") == (False, "the simulation is not paused")
    services.simulation.set_waiting("no valid command for state 1")
    waits = "the simulation is not paused, it waits: no valid command for state 1"
    assert services.call("set_pause", data=False) == (True, waits)
    assert services.call("step_simulation") == (False, waits)
    assert services.call("set_pause", data=True) == (True, "")
    assert services.call("step_simulation") == (False, "the command for state 1 has not come yet")


def test_a_paused_plant_does_not_report_waiting() -> None:
    """While the run is paused no command need come; the time-out restarts when it is resumed."""
    host: Any = FakeHost()
    events: list[str] = []
    simulation = start_run(FakeTopics(), events)
    lockstep = make_lockstep(host, simulation)
    began = time.monotonic()
    resumed: list[float] = []

    def spin(timeout: float = 0.01) -> None:
        time.sleep(timeout)
        host.stop_reason = simulation.waiting
        if not resumed and time.monotonic() - began > 2.0 * TIMEOUT:
            resumed.append(time.monotonic())
            assert "waiting" not in events
            simulation.pause(False, "user")
            lockstep.resume()

    host.spin = spin
    simulation.pause(True, "user")
    lockstep.run()
    assert "waiting" in events and time.monotonic() - resumed[0] >= TIMEOUT


@pytest.mark.usefixtures("stepped_clock")
def test_a_paused_run_sends_its_state_to_a_new_subscriber() -> None:
    """A subscriber that comes in a pause gets the present state, in a running run the next one."""
    topics: Any = FakeTopics()
    simulation = start_run(topics)
    counts: list[int] = []
    for paused, newcomer in ((False, True), (True, False), (True, True)):
        simulation.pause(paused, "user")
        topics.newcomer = newcomer
        time.sleep(1.0)
        simulation.heartbeat()
        counts.append(topics.states)
    assert counts == [1, 1, 2]


class UnacknowledgedPublisher:
    """A publisher with a subscriber that acknowledges nothing."""

    def wait_for_all_acked(self, timeout: Any) -> bool:
        """Wait for the time-out."""
        time.sleep(timeout.nanoseconds / 1e9)
        return False


@pytest.fixture
def topics() -> PlantTopics:
    """Return the topics of a plant, whose subscriber has died."""
    node: Any = SimpleNamespace(
        create_publisher=lambda *_, **__: UnacknowledgedPublisher(),
        get_namespace=lambda: "/knuckle",
    )
    return PlantTopics(node, SCENE.joint_names, SCENE.actuated)


@pytest.mark.usefixtures("stepped_clock")
def test_a_wait_for_a_dead_subscriber_can_be_interrupted(topics: PlantTopics) -> None:
    """The wait polls whether to stop, and then ends at once."""
    polls = iter([False, False, True])
    topics.flush(lambda: next(polls))
    assert next(polls, None) is None


@pytest.mark.usefixtures("stepped_clock")
def test_a_dead_subscriber_is_waited_for_until_its_lease_ends(
    topics: PlantTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The wait on both topics together ends with the liveliness lease of the middleware."""
    monkeypatch.setattr(messages, "LIVELINESS_LEASE", 2.0)
    began = time.monotonic()
    topics.flush()
    # s, and a slice of the wait; 4 s on one topic after the other
    assert 2.0 <= time.monotonic() - began < 2.5


@pytest.mark.parametrize(("period", "waits"), [(1e-4, 0), (0.0, 1)])
def test_brakes_in_real_time_wait_for_no_recorder(
    period: float, waits: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In real time a braking crane waits for no recorder; at full speed it lets one catch up."""
    monkeypatch.setattr(braking, "BLOCK", 10)
    host: Any = FakeHost()
    host.brake_reason = "controller: it was killed"
    topics: Any = FakeTopics()
    polls: list[bool] = []
    topics.update_subscribers = lambda: setattr(topics, "effort_subscribed", True)
    topics.publish_effort = lambda *_: None
    topics.flush = lambda should_stop: polls.append(should_stop())
    simulation = start_run(topics)
    scheduler: Any = SimpleNamespace(in_sync=lambda: True)
    brake_to_rest(host, simulation, scheduler, period)
    assert simulation.plant.k == STEPS_TO_REST
    assert polls == [False] * (2 * waits)


@pytest.mark.parametrize(("mode", "refusal"), [("realtime", ""), ("lockstep", "only in real time")])
def test_brakes_by_service(mode: str, refusal: str) -> None:
    """In real time brakes act while any source applies them, also over a reset, and warn.

    Lockstep refuses them.
    """
    simulation, host = start_run(FakeTopics()), SimpleNamespace(active=True)
    scheduler: Any = None
    plant: Any = simulation.plant
    plant.reset = lambda q, v: setattr(plant, "braking", False)
    control = RunControl(host, simulation, scheduler, SimpleNamespace(mode=mode))  # type: ignore[arg-type]
    answer = control.set_brakes(True)
    assert bool(answer) == bool(refusal) and answer.startswith(refusal)
    assert simulation.plant.braking == (not refusal)
    if refusal:
        return
    simulation.brake(True, "time-out")
    simulation.brake(False, "time-out")
    assert simulation.plant.braking and "~/set_brakes" in simulation.warning
    simulation.restart()
    assert simulation.plant.braking
    assert (
        control.set_brakes(False) == ""
        and not simulation.plant.braking
        and simulation.warning == ""
    )
