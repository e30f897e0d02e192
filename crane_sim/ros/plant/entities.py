"""The parts of a crane as entities of simulation_interfaces: its URDF's frames with the payload.

No message types. Filters of names are POSIX extended regular expressions, as simulation_interfaces
requires, by the C library: Python's `re` has another syntax, and may take exponential time.
Intervals {m,n}, back-references and many + are refused: the C library repeats what they apply to,
and a short expression, such as (((a+)+)+)+, can take all memory; (((a|b|…)+)+)+ takes a time that
grows with the third power of the number of alternatives.
"""

import ctypes
import re
from collections.abc import Collection, Sequence
from enum import IntEnum

from crane_sim.description import urdf
from crane_sim.description.frame_motion import (
    FrameAcceleration,
    FrameMotion,
    frame_accelerations,
    frame_motions,
)
from crane_sim.description.transforms import PAYLOAD, TransformTree
from crane_sim.ros.plant.standard_operations import Code, Outcome
from crane_sim.simulation.plant import Plant

_LONGEST = 100  # characters of an expression
_MOST_PLUS = 2  # with as many alternatives as have room half a second
_COSTLY = re.compile(r"\{|\\[0-9]")
_EXTENDED, _NO_POSITIONS = 1, 8  # flags of regcomp in glibc and musl: REG_EXTENDED, REG_NOSUB
_SIZE = 1024  # bytes, more than a regex_t of any C library has


class Category(IntEnum):
    """What kind of thing an entity is, numbered as in EntityCategory.msg."""

    ROBOT = 1
    DYNAMIC_OBJECT = 4


class Entities:
    """The entities of a plant; their names are those of the frames on /tf."""

    def __init__(self, plant: Plant, prefix: str) -> None:
        """Name the entities; names begin with the prefix."""
        self._plant, self._prefix = plant, prefix
        self._tree = TransformTree(urdf(plant.scene), plant.scene.joint_names)
        self.names = tuple(self.motions())

    def motions(self) -> dict[str, FrameMotion]:
        """Return the present motion of every entity, without error."""
        plant = self._plant
        motions = frame_motions(plant.scene, self._tree, plant.t, plant.q, plant.v)
        return {self._prefix + frame: motion for frame, motion in motions.items()}

    def accelerations(self) -> dict[str, FrameAcceleration]:
        """Return the present acceleration of every entity.

        Accelerations of joints are means over the last period.
        """
        plant, period = self._plant, self._plant.scene.period
        mean = [
            (now - before) / period for now, before in zip(plant.v, plant.rates_before, strict=True)
        ]
        found = frame_accelerations(plant.scene, self._tree, plant.t, plant.q, plant.v, mean)
        return {self._prefix + frame: acceleration for frame, acceleration in found.items()}

    def category(self, name: str) -> Category:
        """Return the kind of an entity."""
        return Category.DYNAMIC_OBJECT if name == self._prefix + PAYLOAD else Category.ROBOT

    def not_found(self, name: str) -> Outcome:
        """Return the outcome for a name that no entity has."""
        return Outcome(Code.NOT_FOUND, f"entity {name!r}: possible: {', '.join(self.names)}")

    def select(self, expression: str, categories: Collection[int]) -> list[str]:
        """Return the names that match an expression and a category; empty ones exclude nothing.

        Raises:
            ValueError: it is no expression; the message is one line.
        """
        chosen = [
            name for name in self.names if not categories or self.category(name) in categories
        ]
        return filter_names(expression, chosen) if expression else chosen


def filter_names(expression: str, names: Sequence[str]) -> list[str]:
    """Return the names of which a part matches an expression; ^ and $ are the ends of a name.

    Raises:
        ValueError: it is not a valid expression, or too costly; the message is one line.
    """
    if (
        len(expression) > _LONGEST
        or expression.count("+") > _MOST_PLUS
        or _COSTLY.search(expression)
    ):
        most = f"more than {_MOST_PLUS} + and more than {_LONGEST} characters"
        raise ValueError(f"filter: intervals, references back, {most} are not possible")
    library, compiled = ctypes.CDLL(None), ctypes.create_string_buffer(_SIZE)
    if code := library.regcomp(compiled, expression.encode(), _EXTENDED | _NO_POSITIONS):
        line = ctypes.create_string_buffer(100)
        library.regerror(code, compiled, line, len(line))
        raise ValueError(f"filter = {expression!r}: {line.value.decode()}")
    try:
        return [name for name in names if not library.regexec(compiled, name.encode(), 0, None, 0)]
    finally:
        library.regfree(compiled)
