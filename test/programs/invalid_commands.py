"""Invalid commands: messages on `joint_commands` beside the right answer, and refusal reasons."""

import math
import random
from collections.abc import Callable, Sequence

from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

JOINTS = ["slew", "boom", "jib", "rope"]
PERIOD = 10_000_000  # ns, of the default scene
NS_PER_S = 1_000_000_000
Command = tuple[int, list[str], list[float]]  # stamp [ns], joints, efforts


def command_message(stamp: int, names: Sequence[str], efforts: Sequence[float]) -> bytes:
    """Return a serialized command; stamp in ns."""
    command = JointState(name=list(names), effort=list(efforts))
    command.header.stamp = Time(sec=stamp // NS_PER_S, nanosec=stamp % NS_PER_S)
    return serialize_message(command)


class InvalidCommands:
    """A generator of invalid commands, the same ones for the same seed."""

    def __init__(self, seed: int) -> None:
        """Generate from `seed`."""
        self._random = random.Random(seed)
        self._kinds: dict[str, Callable[[int], Command]] = {
            "not finite": self._not_finite,
            "huge": self._huge,
            "names": self._names,
            "length": self._length,
            "unstamped": lambda now: (0, JOINTS, [1e3] * 4),
            "future": lambda now: (now + self._random.randint(1, 10**18), JOINTS, [1e3] * 4),
            "late": lambda now: (now - PERIOD - self._random.randint(1, 10**18), JOINTS, [1e3] * 4),
            "duplicate": lambda now: (now - PERIOD, JOINTS, [1e3] * 4),
            "stale": lambda now: (now - self._random.randint(1, PERIOD - 1), JOINTS, [1e3] * 4),
        }
        self._reasons = [*self._kinds, "unreadable"]

    def generate(self, now: int) -> tuple[str, bytes]:
        """Return (reason to refuse it, message) while the state of stamp `now` lacks its answer.

        The answer to the state before it has been accepted.
        """
        reason = self._random.choice(self._reasons)
        if reason == "duplicate" and now == PERIOD:
            reason = "unstamped"  # the first state has none before it
        if reason == "unreadable":
            return reason, self._garbage(now)
        return reason, command_message(*self._kinds[reason](now))

    def _efforts_with(self, bad: float) -> list[float]:
        efforts = [self._random.uniform(-10.0, 10.0) for _ in JOINTS]
        efforts[self._random.randrange(4)] = bad
        return efforts

    def _not_finite(self, now: int) -> Command:
        return now, JOINTS, self._efforts_with(self._random.choice([math.nan, math.inf, -math.inf]))

    def _huge(self, now: int) -> Command:
        return (
            now,
            JOINTS,
            self._efforts_with(
                self._random.choice([-1.0, 1.0]) * 10.0 ** self._random.uniform(9.1, 308.0)
            ),
        )

    def _names(self, now: int) -> Command:
        wrong = self._random.choice(
            ["swing_radial", "", "Slew", "slew\n", "ß" * 50, "slew" * 100, "jib"]
        )
        names = self._random.choice(
            [[], [wrong], [wrong, *JOINTS[1:]], [*JOINTS, wrong], [wrong] * 100]
        )
        return now, names, [1.0] * len(names)

    def _length(self, now: int) -> Command:
        return now, JOINTS, [1.0] * self._random.choice([0, 1, 3, 5, 1000])

    def _garbage(self, now: int) -> bytes:
        """Return a message cut off somewhere after its header, or noise."""
        if self._random.random() < 0.5:
            whole = command_message(now, JOINTS, [1.0] * 4)
            return whole[: self._random.randrange(4, len(whole) - 20)]  # DDS pads to whole words
        return b"\x00\x01\x00\x00" + self._random.randbytes(self._random.randrange(0, 200))
