"""The parts of a crane as entities of simulation_interfaces: the frames of its URDF, payload included.

No message types.
"""

from collections.abc import Collection
from contextlib import closing
from enum import IntEnum

from crane_sim.description import urdf
from crane_sim.description.frame_motion import FrameAcceleration, FrameMotion, frame_accelerations, frame_motions
from crane_sim.description.transforms import PAYLOAD, TransformTree
from crane_sim.ros.plant.name_filter import NameFilter
from crane_sim.ros.plant.standard_operations import Code, Outcome
from crane_sim.simulation.plant import Plant


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
        """Return the present acceleration of every entity, with those of the joints as means over the last period."""
        plant, period = self._plant, self._plant.scene.period
        mean = [(now - before) / period for now, before in zip(plant.v, plant.rates_before, strict=True)]
        found = frame_accelerations(plant.scene, self._tree, plant.t, plant.q, plant.v, mean)
        return {self._prefix + frame: acceleration for frame, acceleration in found.items()}

    def category(self, name: str) -> Category:
        """Return the kind of an entity."""
        return Category.DYNAMIC_OBJECT if name == self._prefix + PAYLOAD else Category.ROBOT

    def not_found(self, name: str) -> Outcome:
        """Return the outcome for a name that no entity has."""
        return Outcome(Code.NOT_FOUND, f"entity {name!r}: possible: {', '.join(self.names)}")

    def select(self, expression: str, categories: Collection[int]) -> list[str]:
        """Return the names that match an expression and are of one of the categories; empty ones exclude nothing.

        Raises:
            ValueError: it is no expression; the message is one line.
        """
        chosen = [name for name in self.names if not categories or self.category(name) in categories]
        if not expression:
            return chosen
        with closing(NameFilter(expression)) as accepted:
            return [name for name in chosen if accepted.matches(name)]
