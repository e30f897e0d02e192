"""A host and a stepper that stand in for the real ones in tests of real time."""

import time
from collections import deque
from contextlib import nullcontext
from types import SimpleNamespace

from crane_sim.ros.common.command_filter import CommandValidator

JOINTS = ("slew", "boom")


PERIOD = 0.01  # s


STEPS = 80


class NotingStepper:
    """A stepper that moves nothing."""

    def __init__(self) -> None:
        """Begin at the first state."""
        self.scene = SimpleNamespace(actuated=JOINTS, period=PERIOD, sampled=True)
        self.gate = CommandValidator(JOINTS, (1e9, 1e9))
        self.plant = SimpleNamespace(braking=False)
        self.efforts: list[tuple[float, ...]] = []
        self.times: list[float] = []  # s, of the steps
        self.warned = 0  # steps before the warning
        self.stamp, self.warning, self.paused, self.deadline_misses = 10_000_000, "", False, 0

    @property
    def running(self) -> bool:
        """Whether steps are left."""
        return len(self.efforts) < STEPS

    def step(self, effort: tuple[float, ...]) -> None:
        """Note the effort."""
        self.efforts.append(effort)
        self.times.append(time.monotonic())

    def warn(self, line: str, subject: str) -> None:
        """Keep the newest warning about commands."""
        if subject == "commands":
            self.warning, self.warned = line, len(self.efforts)

    def begin(self) -> None:
        """Publish nothing."""

    def heartbeat(self) -> None:
        """Report nothing."""


class Handle(nullcontext):
    """A subscription's, with messages that no executor hands on."""

    def __init__(self, publishers: int, waiting: deque[tuple[bytes, None]] | None = None) -> None:
        """Know the number of publishers; offer what waits, nothing unless it is given."""
        super().__init__()
        self.get_publisher_count = lambda: publishers
        self.take_message = lambda *_: waiting.popleft() if waiting else None


def settings(timeout: float, on_silence: str = "zero", rate: float = 1.0) -> SimpleNamespace:
    """Return the plant's parameters."""
    return SimpleNamespace(rate=rate, command_timeout=timeout, on_silence=on_silence, command_lease=0.2)
