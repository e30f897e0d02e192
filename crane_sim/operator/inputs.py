"""Inputs of an operator's device: levers and buttons, from keys or a controller's axes.

A terminal reports that a key is pressed, and repeats it while it is held, but never that it is
released. So a key moves its joint until no repetition has come for a while: longer after the first
press, since repetition begins late.
"""

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

from crane_sim.operator.levers import Assignment

DEVICES = ("keyboard", "gamepad", "joy")
"""The kinds of device."""
DEAD_ZONE = 0.05
"""Fraction of an axis's travel within which it counts as released: sticks do not return exactly."""
FIRST_HOLD = 0.7
"""Seconds for which a key holds after its first press: usual terminals begin to repeat after 0.25
to 0.66 s."""
REPEAT_HOLD = 0.2
"""Seconds for which a key holds after a repetition: usual terminals repeat 10 to 40 times a
second."""
STOP, RELEASE, ASSISTANCE = "space", "enter", "tab"
"""Keys of the emergency stop, of its release and of the assistance."""
LEVELS = (0.1, 0.25, 0.5, 1.0)
"""Fractions of the largest speed that keys may command."""


class Demand(NamedTuple):
    """The operator's demand at an instant."""

    axes: tuple[float, ...]  # (nu,) of the joints, -1 .. 1
    enabled: bool  # the dead man's switch
    stop: bool = False  # emergency stop is pressed
    release: bool = False  # so is its release
    assistance: bool = False  # so is what switches the assistance


class Sample(NamedTuple):
    """Positions of a controller's axes, -1 .. 1, and buttons, as in sensor_msgs/Joy."""

    axes: Sequence[float]
    buttons: Sequence[int]


def demand_of(sample: Sample, assignment: Assignment) -> Demand:
    """Return the demand of a controller; axes and buttons that it lacks are at rest."""
    axes, buttons = sample.axes, sample.buttons

    def axis(number: int) -> float:
        value = float(axes[number]) if 0 <= number < len(axes) else 0.0
        # also where it is no number
        return min(max(value, -1.0), 1.0) if DEAD_ZONE < abs(value) < inf else 0.0

    pressed = [
        0 <= number < len(buttons) and bool(buttons[number]) for number in assignment.buttons
    ]
    return Demand(tuple(lever.sign * axis(lever.axis) for lever in assignment.levers), *pressed)


class Keyboard:
    """The keys of a terminal as levers; a held or pressed key is the dead man's switch as well.

    Attributes:
        level: index in LEVELS of the fraction of the largest speed that keys command.
    """

    def __init__(self, assignment: Assignment) -> None:
        """Begin with no key pressed."""
        self._bindings = {
            key: (i, sign)
            for i, lever in enumerate(assignment.levers)
            for key, sign in zip(lever.keys, (1.0, -1.0), strict=True)
            if key
        }
        self._count, self.level = len(assignment.levers), len(LEVELS) - 1
        self._until: dict[str, float] = {}  # s, until when each key holds
        self._pressed: set[str] = set()  # keys that act once

    def press(self, key: str, now: float) -> None:
        """Take a key at `now` [s]: pressed, or repeated."""
        if key in self._bindings:
            i, _ = self._bindings[key]
            for other in [
                other for other in self._until if other != key and self._bindings[other][0] == i
            ]:
                del self._until[other]  # the opposite direction
            repeated = self._until.get(key, now) > now
            self._until[key] = max(
                self._until.get(key, now), now + (REPEAT_HOLD if repeated else FIRST_HOLD)
            )
        elif key in ("+", "-"):
            self.level = min(max(self.level + (1 if key == "+" else -1), 0), len(LEVELS) - 1)
        else:
            self._pressed.add(key)

    def demand(self, now: float, tail: float = 0.0) -> Demand:
        """Return the demand at `now` [s]; `tail` [s] keeps the switch closed after the last key."""
        axes = [0.0] * self._count
        for key, until in self._until.items():
            if now < until:
                i, sign = self._bindings[key]
                axes[i] = sign * LEVELS[self.level]
        pressed, self._pressed = self._pressed, set()
        enabled = any(now < until + tail for until in self._until.values())
        return Demand(
            tuple(axes), enabled, *(key in pressed for key in (STOP, RELEASE, ASSISTANCE))
        )
