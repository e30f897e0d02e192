"""A plant in real time that stands in for the real one, with a clock of its own."""

import time
from collections import deque
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from realtime_doubles import JOINTS, PERIOD, Handle, NotingStepper, settings

from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.plant.realtime import Realtime

TIMEOUT = 0.5  # s


class Bench(NotingStepper):
    """A stepper, its host, and a controller that answers each state some time after it has left.

    Attributes:
        now: s.
        delay: s from a state to its answer; None: the controller is dead.
        plan: what happens at the first look after an instant [s].
    """

    def __init__(self, steps: int, delay: float | None) -> None:
        """End after so many steps; time begins now."""
        super().__init__()
        self.now, self.delay, self.steps = 0.0, delay, steps
        self.stopping = self.brake = ""
        self.plan: list[tuple[float, Callable[[], object]]] = []
        self._coming: deque[tuple[float, bytes]] = deque()
        self._waiting: deque[tuple[bytes, None]] = deque()
        self._takers: dict[str, Any] = {}
        self.node = SimpleNamespace(create_subscription=self._subscribe, get_publishers_info_by_topic=lambda _topic: [])
        self.accept_effort: list[bytes] = []
        publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=self.accept_effort.append)
        self.node.create_publisher = lambda *_: publisher
        self._send()

    @property
    def running(self) -> bool:
        """Whether steps are left."""
        return len(self.efforts) < self.steps

    def step(self, effort: tuple[float, ...]) -> None:
        """Note the effort; the next state leaves, and the controller hears it."""
        super().step(effort)
        self.stamp += round(PERIOD * 1e9)
        self._send()

    def answer(self, step: int) -> tuple[float, float]:
        """Return the effort that answers the state before this step."""
        return (1.0 + step, 0.0)

    def pass_time(self, seconds: float) -> None:
        """Let time pass, a microsecond at least, and what is due happen."""
        self.now += seconds + 1e-6
        while self._coming and self._coming[0][0] <= self.now:
            self._waiting.append((self._coming.popleft()[1], None))
        while self.plan and self.plan[0][0] <= self.now:
            self.plan.pop(0)[1]()

    def spin(self, timeout: float = 0.05) -> None:
        """Let so much time pass, and hand on what has come."""
        self.pass_time(timeout)
        while self._waiting:
            self._takers["joint_commands"](self._waiting.popleft()[0])

    def poll(self) -> None:
        """Hear of no order."""

    def _send(self) -> None:
        if self.delay is not None:
            answer = JointWire(JOINTS, effort=True).encode(self.stamp, self.answer(len(self.efforts)))
            self._coming.append((self.now + self.delay, answer))

    def _subscribe(self, _type: type, topic: str, callback: Any, _qos: Any, **_options: Any) -> Any:
        self._takers[topic] = callback
        handle = Handle(1, self._waiting) if topic == "joint_commands" else Handle(0)
        return SimpleNamespace(topic_name=topic, handle=handle)


def begun(
    monkeypatch: pytest.MonkeyPatch, steps: int, delay: float | None, on_silence: str = "zero", rate: float = 1.0
) -> tuple[Bench, Realtime]:
    """Return a bench whose clock is everybody's, and the pace."""
    bench = Bench(steps, delay)
    monkeypatch.setattr(time, "monotonic", lambda: bench.now)
    monkeypatch.setattr(time, "sleep", bench.pass_time)
    return bench, Realtime(bench, bench, settings(TIMEOUT, on_silence, rate))  # type: ignore[arg-type]
