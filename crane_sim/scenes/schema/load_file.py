"""Base class of scene files of cranes with a load below any support: on rope and links, or on elastic falls."""

from typing import Any

from crane_sim.files.types import NonNegative
from crane_sim.models.effects import PaperFriction, PayloadDrag, QuadraticFriction
from crane_sim.scenes.schema.groups import PayloadForceGroup
from crane_sim.scenes.schema.reference import ReferenceGroup, compile_path
from crane_sim.scenes.schema.rigging import Payload
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.trajectories.trajectory import Trajectory


class LoadFile(SceneFile):
    """The groups of all such cranes: gravity, and what acts on the load."""

    gravity: NonNegative = 9.81  # m/s², acceleration of free fall
    payload: Payload  # at the end of rope or links
    payload_drag: PayloadDrag | None = None  # drag of still air on the payload
    payload_force: PayloadForceGroup | None = None  # a given force on the payload

    @property
    def _reference(self) -> ReferenceGroup | None:
        return getattr(self, "reference", None)

    @property
    def has_quadratic_loss(self) -> bool:
        """Whether a loss |v| v acts, which has a kink in its slope at each reversal: no step ends there."""
        rubs = isinstance(getattr(self, "swing_friction", None), QuadraticFriction | PaperFriction)
        return rubs or self.payload_drag is not None

    @property
    def payload_mass(self) -> float:
        """Mass of the payload at t = 0 [kg]."""
        return self.payload.mass

    def base(self) -> Any:
        """Return the motion of the base, None where it rests."""
        return self.base_motion.base(self.seed, self.duration) if self.base_motion is not None else None

    def force(self) -> Any:
        """Return the given force on the payload, None without one."""
        return self.payload_force.force() if self.payload_force is not None else None

    def trajectory(self) -> Trajectory | None:
        """Return the compiled path, None where the scene has none."""
        return compile_path(self._reference, self)
