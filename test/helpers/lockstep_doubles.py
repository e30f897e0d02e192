"""Hosts, topics and plants that stand in for the real ones in tests of lockstep."""

import time
from collections import deque
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim import load_scene
from crane_sim.ros.plant.lockstep import Lockstep
from crane_sim.ros.plant.simulation_run import SimulationRun

SCENE = load_scene("knuckle_setpoint")


ZERO = (0.0,) * len(SCENE.actuated)


class Handle(SimpleNamespace):
    """A subscription's, which can be entered."""

    def __enter__(self) -> None:
        """Lock nothing."""

    def __exit__(self, *_: Any) -> None:
        """Unlock nothing."""


class QuietHost:
    """A host with no middleware: topics have queues, which tests fill.

    Attributes:
        queues: what waits, by topic.
    """

    def __init__(self) -> None:
        """Offer nothing yet."""
        self.stopping, self.brake = "", ""
        self.queues: dict[str, deque[tuple[bytes, None]]] = {}
        self.node: Any = SimpleNamespace(
            create_subscription=self._subscribe, get_publishers_info_by_topic=lambda _topic: []
        )

    def spin(self, timeout: float = 0.01) -> None:
        """Let time pass."""
        time.sleep(timeout)

    def _subscribe(self, _kind: type, topic: str, *_: Any, **__: Any) -> Any:
        queue = self.queues.setdefault(topic, deque())
        handle = Handle(get_publisher_count=lambda: 1, take_message=lambda *_: queue.popleft() if queue else None)
        return SimpleNamespace(topic_name=topic, handle=handle, get_publisher_count=lambda: 1)


class QuietTopics:
    """The plant's topics, which nobody hears.

    Attributes:
        modes: values of simulation_state.
        states: number of joint states.
    """

    acknowledged = clock_heard = effort_heard = payload_heard = False

    def __init__(self) -> None:
        """Have said nothing."""
        self.modes: list[int] = []
        self.states = 0

    def publish_simulation_state(self, state: int) -> None:
        """Note it."""
        self.modes.append(state)

    def publish_state(self, *_: Any) -> None:
        """Count it."""
        self.states += 1

    def publish_diagnostics(self, *_: Any) -> None:
        """Say nothing."""

    def publish_clock(self, *_: Any) -> None:
        """Say nothing."""

    def look_around(self) -> None:
        """See nobody."""


class CountingPlant:
    """A plant in which nothing moves.

    Attributes:
        k: periods passed.
    """

    def __init__(self) -> None:
        """Be at the start."""
        self.k, self.braking, self.at_rest, self.seen = 0, False, False, (ZERO, ZERO)

    def advance(self, _effort: Any) -> None:
        """Count a period; after 20 the crane rests."""
        self.k += 1
        self.at_rest = self.k >= 20

    def summary(self) -> dict[str, float]:
        """Return what diagnostics tell."""
        return {"saturated_steps": 0, "min_rope_tension": 0.0}


@pytest.fixture
def topics() -> QuietTopics:
    """Return the plant's topics."""
    return QuietTopics()


@pytest.fixture
def stepper(topics: QuietTopics) -> SimulationRun:
    """Return a stepper without ROS."""
    plant: Any = CountingPlant()
    heard: Any = topics
    pipes: Any = SimpleNamespace(report=lambda *_, **__: None)
    return SimulationRun(SCENE, plant, heard, pipes, (1e9,) * len(ZERO))


def lockstep(host: Any, stepper: SimulationRun, beside: str = "") -> Lockstep:
    """Return a lockstep whose patience is 0.3 s."""
    return Lockstep(host, stepper, SimpleNamespace(step_timeout=0.1, resends=2, beside=beside, command_lease=0.3))
