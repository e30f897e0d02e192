"""Doubles of host, topics and plant for tests of lockstep without ROS."""

import time
from collections import deque
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim import load_scene
from crane_sim.ros.common.messages import SimulationState
from crane_sim.ros.common.sender_subscription import MessageWithSender
from crane_sim.ros.plant.lockstep import Lockstep
from crane_sim.ros.plant.simulation_run import SimulationRun

SCENE = load_scene("knuckle_setpoint")
ZERO = (0.0,) * len(SCENE.actuated)
TIMEOUT = 0.3  # s without a command until `make_lockstep` reports that the run waits
STEPS_TO_REST = 20


class FakeHost:
    """A host without middleware.

    Attributes:
        queues: messages to be taken, by topic; tests fill them.
    """

    def __init__(self) -> None:
        """Create it without subscriptions."""
        self.stop_reason, self.brake_reason = "", ""
        self.queues: dict[str, deque[tuple[bytes, None]]] = {}
        self._callbacks: dict[str, Callable[..., Any]] = {}
        self.node: Any = SimpleNamespace(
            create_publisher=lambda *_: SimpleNamespace(get_subscription_count=lambda: 0),
            get_publishers_info_by_topic=lambda _topic: [],
        )

    def subscribe_with_sender(
        self, _kind: type, topic: str, callback: Callable[..., Any], *_: Any
    ) -> Any:
        """Return a subscription whose messages tests put into its queue."""
        queue = self.queues.setdefault(topic, deque())

        def take() -> MessageWithSender | None:
            return MessageWithSender(queue.popleft()[0], b"controller") if queue else None

        self._callbacks[topic] = callback
        return SimpleNamespace(topic=topic, count_publishers=lambda: 1, take=take)

    def spin(self, timeout: float = 0.01) -> None:
        """Deliver what has come, and let time pass."""
        for topic, queue in self.queues.items():
            while queue:
                self._callbacks[topic]([MessageWithSender(queue.popleft()[0], b"controller")])
        time.sleep(timeout)

    def poll(self) -> None:
        """Read no orders."""


class FakeTopics:
    """The plant's topics without subscribers.

    Attributes:
        modes: values of simulation_state.
        acknowledged: whether all subscribers have acknowledged the joint states.
        states: number of joint states.
        clocks: times of the clock, ns.
        newcomer: whether the joint states have a new subscriber.
    """

    newcomer = clock_subscribed = effort_subscribed = payload_subscribed = False

    def __init__(self) -> None:
        """Create them before the first message."""
        self.modes: list[SimulationState] = []
        self.acknowledged = False
        self.states = 0
        self.clocks: list[int] = []

    def all_acknowledged(self, _timeout: float = 0.0) -> bool:
        """Return what tests set."""
        return self.acknowledged

    def publish_simulation_state(self, state: SimulationState) -> None:
        """Record it."""
        self.modes.append(state)

    def publish_state(self, *_: Any) -> None:
        """Count it."""
        self.states += 1

    def publish_true_state(self, *_: Any) -> None:
        """Publish nothing."""

    def publish_diagnostics(self, *_: Any) -> None:
        """Publish nothing."""

    def publish_clock(self, stamp: int) -> None:
        """Record it."""
        self.clocks.append(stamp)

    def update_subscribers(self) -> bool:
        """Find those that tests have set."""
        return self.newcomer


class CountingPlant:
    """A plant in which nothing moves.

    Attributes:
        k: periods passed.
    """

    def __init__(self) -> None:
        """Create it at the start."""
        self.k, self.braking, self.at_rest, self.seen = 0, False, False, (ZERO, ZERO)
        self.q = self.v = self.applied = ZERO

    def advance(self, _effort: Any) -> None:
        """Count a period; after some the crane rests."""
        self.k += 1
        self.at_rest = self.k >= STEPS_TO_REST

    def summary(self) -> dict[str, float]:
        """Return the entries of diagnostics."""
        return {"saturated_steps": 0, "min_rope_tension": 0.0}


@pytest.fixture
def topics() -> FakeTopics:
    """Return the plant's topics."""
    return FakeTopics()


@pytest.fixture
def simulation(topics: FakeTopics) -> SimulationRun:
    """Return a run without ROS."""
    return make_simulation(topics)


def make_simulation(topics: FakeTopics, clock_leads: bool = False) -> SimulationRun:
    """Return a run without ROS."""
    plant: Any = CountingPlant()
    fake_topics: Any = topics
    pipes: Any = SimpleNamespace(report=lambda *_, **__: None)
    return SimulationRun(SCENE, plant, fake_topics, pipes, (1e9,) * len(ZERO), clock_leads)


def make_lockstep(
    host: Any, simulation: SimulationRun, beside: str = "", stamps: str = "state"
) -> Lockstep:
    """Return a scheduler in lockstep with short time-outs."""
    settings = SimpleNamespace(
        step_timeout=0.1, resends=2, beside=beside, command_lease=0.3, command_stamps=stamps
    )
    settings.commander = ""
    return Lockstep(host, simulation, settings)
