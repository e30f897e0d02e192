"""Doubles of host, simulation and controller for tests of real time without ROS.

Some have a clock of their own.
"""

import time
from collections import deque
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim.ros.common.command_filter import CommandValidator
from crane_sim.ros.common.sender_subscription import MessageWithSender
from crane_sim.ros.common.serialization import EFFORT, JointStateCodec
from crane_sim.ros.plant.realtime import Realtime

JOINTS = ("slew", "boom")
SENDER = b"controller"
PERIOD = 0.01  # s
TIMEOUT = 0.5  # s without a command, of `make_bench`


class FakeSimulation:
    """A run in which nothing moves.

    Attributes:
        efforts: of the steps.
        times: s of the monotonic clock, of the steps.
        warned: number of steps before the newest warning about commands.
    """

    def __init__(self, steps: int = 80) -> None:
        """Begin at the first state; end after `steps` steps."""
        self.steps = steps
        self.scene = SimpleNamespace(
            actuated=JOINTS,
            period=PERIOD,
            sampled=True,
            commands=("effort",) * 2,
            zero_command=lambda last: (0.0, 0.0),
            idle_command=(0.0, 0.0),
        )
        self.validator = CommandValidator(JOINTS, (1e9, 1e9))
        self.plant = SimpleNamespace(braking=False)
        self.efforts: list[tuple[float, ...]] = []
        self.times: list[float] = []
        self.warned = 0
        self.stamp, self.warning, self.paused, self.deadline_misses = 10_000_000, "", False, 0

    @property
    def running(self) -> bool:
        """Whether steps remain."""
        return len(self.efforts) < self.steps

    def brake(self, on: bool, source: str) -> None:
        """Apply or release the brakes, which have one source here."""
        self.plant.braking = on

    def step(self, effort: tuple[float, ...]) -> None:
        """Record the effort."""
        self.efforts.append(effort)
        self.times.append(time.monotonic())

    def warn(self, line: str, subject: str) -> None:
        """Record the newest warning about commands."""
        if subject == "commands":
            self.warning, self.warned = line, len(self.efforts)

    def start(self) -> None:
        """Publish nothing."""

    def heartbeat(self) -> None:
        """Report nothing."""


def fake_subscription(
    topic: str, publishers: int, queue: deque[tuple[bytes, None]] | None = None
) -> Any:
    """Return a subscription with a number of publishers and messages, if any, to be taken."""

    def take() -> MessageWithSender | None:
        return MessageWithSender(queue.popleft()[0], SENDER) if queue else None

    return SimpleNamespace(topic=topic, count_publishers=lambda: publishers, take=take)


def deliver_to(callback: Any) -> Callable[[bytes], None]:
    """Return a function that delivers one message of the only controller."""
    return lambda data: callback([MessageWithSender(data, SENDER)])


class RealtimeBench(FakeSimulation):
    """A run, its host, and a controller that answers states after a delay; with its own clock.

    Attributes:
        now: s.
        delay: s from a state to its answer; None: the controller has died.
        events: functions that are called as soon as the clock has passed an instant [s], in that
            order.
        accepted: messages of accepted commands.
    """

    def __init__(self, steps: int, delay: float | None) -> None:
        """End after `steps` steps; time begins at zero."""
        super().__init__(steps)
        self.now, self.delay = 0.0, delay
        self.stop_reason = self.brake_reason = ""
        self.events: list[tuple[float, Callable[[], object]]] = []
        self._in_transit: deque[tuple[float, bytes]] = deque()
        self._queue: deque[tuple[bytes, None]] = deque()
        self.callbacks: dict[str, Any] = {}
        self.node = SimpleNamespace(get_publishers_info_by_topic=lambda _topic: [])
        self.accepted: list[bytes] = []
        publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=self.accepted.append)
        self.node.create_publisher = lambda *_: publisher
        self._send_answer()

    def subscribe_with_sender(self, _type: type, topic: str, callback: Any, *_: Any) -> Any:
        """Return a subscription to the answers, or to a topic without publishers."""
        self.callbacks[topic] = deliver_to(callback)
        return fake_subscription(topic, *((1, self._queue) if topic == "joint_commands" else (0,)))

    def step(self, effort: tuple[float, ...]) -> None:
        """Record the effort; publish the next state, which the controller answers."""
        super().step(effort)
        self.stamp += round(PERIOD * 1e9)
        self._send_answer()

    def publish_first_state(self) -> None:
        """Publish a first state that the controller answers; earlier answers are lost."""
        self._in_transit.clear()
        self._queue.clear()
        self._send_answer()

    def answer(self, step: int) -> tuple[float, float]:
        """Return the effort that answers the state before this step."""
        return (1.0 + step, 0.0)

    def advance_clock(self, seconds: float) -> None:
        """Advance the clock, a microsecond at least, and process what is due."""
        self.now += seconds + 1e-6
        while self._in_transit and self._in_transit[0][0] <= self.now:
            self._queue.append((self._in_transit.popleft()[1], None))
        while self.events and self.events[0][0] <= self.now:
            self.events.pop(0)[1]()

    def spin(self, timeout: float = 0.05) -> None:
        """Advance the clock, and deliver messages."""
        self.advance_clock(timeout)
        while self._queue:
            self.callbacks["joint_commands"](self._queue.popleft()[0])

    def poll(self) -> None:
        """Read no orders."""

    def _send_answer(self) -> None:
        if self.delay is not None:
            answer = JointStateCodec(JOINTS, EFFORT).encode(
                self.stamp, self.answer(len(self.efforts))
            )
            self._in_transit.append((self.now + self.delay, answer))


@pytest.fixture
def stepped_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let only sleeping advance the monotonic clock, 1 µs beyond: no stall counts."""
    now = [1000.0]

    def sleep(seconds: float) -> None:
        now[0] += seconds + 1e-6

    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time, "sleep", sleep)


def settings(timeout: float, on_silence: str = "zero", rate: float = 1.0) -> SimpleNamespace:
    """Return the plant's parameters."""
    return SimpleNamespace(
        rate=rate,
        command_timeout=timeout,
        on_silence=on_silence,
        command_lease=0.2,
        command_stamps="state",
        commanded=False,
    )


def make_bench(
    monkeypatch: pytest.MonkeyPatch,
    steps: int,
    delay: float | None,
    on_silence: str = "zero",
    rate: float = 1.0,
    timeout: float = TIMEOUT,
) -> tuple[RealtimeBench, Realtime]:
    """Return a bench, whose clock replaces the monotonic clock, and its scheduler."""
    bench = RealtimeBench(steps, delay)
    monkeypatch.setattr(time, "monotonic", lambda: bench.now)
    monkeypatch.setattr(time, "sleep", bench.advance_clock)
    return bench, Realtime(bench, bench, settings(timeout, on_silence, rate))  # type: ignore[arg-type]
