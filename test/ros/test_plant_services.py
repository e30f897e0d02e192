"""What the plant's services answer while it stands, and what a subscriber that has died costs; without DDS."""

import time
from types import SimpleNamespace
from typing import Any

import pytest
from lockstep_doubles import SCENE, ZERO, CountingPlant, QuietHost, QuietTopics, lockstep

from crane_sim.ros.common import messages
from crane_sim.ros.plant import braking
from crane_sim.ros.plant.braking import brake_to_rest
from crane_sim.ros.plant.services import PlantServices
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.ros.plant.topics import PlantTopics


def begun(topics: Any, events: list[str] | None = None) -> SimulationRun:
    """Return a stepper in the midst of a run in which nothing moves; events are what it reports."""
    plant: Any = CountingPlant()
    plant.applied = ZERO
    pipes: Any = SimpleNamespace(report=lambda event, **_: (events if events is not None else []).append(event))
    stepper = SimulationRun(SCENE, plant, topics, pipes, (1e9,) * len(ZERO))
    stepper.begin()
    return stepper


class Services:
    """The services of a plant in lockstep that nobody commands."""

    def __init__(self) -> None:
        """Begin the run."""
        host: Any = QuietHost()
        host.active, host.poll = True, lambda: None
        self._served: dict[str, Any] = {}
        host.node.create_service = lambda _kind, name, callback: self._served.update({name: callback})
        self.stepper = begun(QuietTopics())
        PlantServices(host, self.stepper, lockstep(host, self.stepper), SimpleNamespace(step_count=1))

    def call(self, name: str, **request: Any) -> tuple[bool, str]:
        """Return success and message of an answer."""
        response = SimpleNamespace(success=False, message="")
        self._served[f"~/{name}"](SimpleNamespace(**request), response)
        return response.success, response.message


def test_who_asks_a_waiting_plant_hears_what_it_waits_for() -> None:
    """A plant that waits looks paused: who ends that pause or wants a step hears that it is none, and what it is."""
    services = Services()
    assert services.call("set_pause", data=False) == (True, "")
    assert services.call("step_simulation") == (False, "the simulation is not paused")
    services.stepper.wait("no valid command for state 1")
    told = "the simulation is not paused, it waits: no valid command for state 1"
    assert services.call("set_pause", data=False) == (True, told)
    assert services.call("step_simulation") == (False, told)
    assert services.call("set_pause", data=True) == (True, "")
    assert services.call("step_simulation") == (False, "the command for state 1 has not come yet")


def test_a_paused_plant_complains_of_nobody() -> None:
    """While the user has it stand nobody need answer; the patience begins anew when he lets it go on."""
    host: Any = QuietHost()
    events: list[str] = []
    stepper = begun(QuietTopics(), events)
    pace = lockstep(host, stepper)  # complains after 0.3 s
    began = time.monotonic()
    released: list[float] = []

    def spin(timeout: float = 0.01) -> None:
        time.sleep(timeout)
        host.stopping = stepper.waiting
        if not released and time.monotonic() - began > 0.6:
            released.append(time.monotonic())
            assert "waiting" not in events
            stepper.pause(False, "user")
            pace.go_on()

    host.spin = spin
    stepper.pause(True, "user")
    pace.run()
    assert "waiting" in events and time.monotonic() - released[0] >= 0.3


class DeadEar:
    """A publisher with a subscriber that acknowledges nothing."""

    def wait_for_all_acked(self, timeout: Any) -> bool:
        """Wait in vain."""
        time.sleep(timeout.nanoseconds / 1e9)
        return False


@pytest.fixture
def topics() -> PlantTopics:
    """Return the topics of a plant, whose subscriber has died."""
    node: Any = SimpleNamespace(create_publisher=lambda *_: DeadEar(), get_namespace=lambda: "/knuckle")
    return PlantTopics(node, SCENE.joint_names, SCENE.actuated)


def test_a_dead_subscriber_keeps_no_signal_waiting(topics: PlantTopics) -> None:
    """Whoever waits for him asks again and again whether to go on, and leaves at once when not."""
    looks = iter([False, False, True])
    began = time.monotonic()
    topics.flush(lambda: next(looks))
    assert time.monotonic() - began < 0.5  # s; three looks 20 ms apart, on a busy machine
    assert next(looks, None) is None


def test_a_dead_subscriber_is_waited_for_as_long_as_he_may_live(
    topics: PlantTopics, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On both topics together it is the time after which the middleware counts him no longer."""
    monkeypatch.setattr(messages, "LEASE", 0.2)
    began = time.monotonic()
    topics.flush()
    assert 0.2 <= time.monotonic() - began < 0.4  # s; twice that on two topics one after the other


@pytest.mark.parametrize(("period", "waits"), [(1e-4, 0), (0.0, 1)])
def test_brakes_in_real_time_wait_for_no_subscriber(period: float, waits: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the wall clock's pace a crane that brakes stops for nobody; as fast as it goes it lets a recorder catch up."""
    monkeypatch.setattr(braking, "BLOCK", 10)
    host: Any = QuietHost()
    host.brake, host.poll = "nobody commands", lambda: None
    heard: Any = QuietTopics()
    asked: list[bool] = []
    heard.look_around = lambda: setattr(heard, "effort_heard", True)
    heard.publish_effort = lambda *_: None
    heard.flush = lambda given_up: asked.append(given_up())
    stepper = begun(heard)
    pace: Any = SimpleNamespace(level=lambda: True)
    brake_to_rest(host, stepper, pace, period)
    assert stepper.plant.k == 20
    assert asked == [False] * (2 * waits)
