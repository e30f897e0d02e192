"""The group `reeving` of a scene file, in `rope` or `hoist`: a rope over sheaves and a drum."""

from math import exp, inf, pi
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, NonNegative, Positive, reject_bool
from crane_sim.models.supports.reeving import Drum, Layers, Reeving, SheaveLoss
from crane_sim.scenes.schema.groups import Group, tagged_union_validator

MAX_RATIO = 1e3  # of the tensions on both sides of a sheave

Falls = Annotated[int, BeforeValidator(reject_bool), Field(ge=1, le=32)]
Count = Annotated[int, BeforeValidator(reject_bool), Field(ge=0, le=32)]
LayerCount = Annotated[int, BeforeValidator(reject_bool), Field(ge=1, le=30)]


class SheaveEfficiency(NamedTuple):
    """Bearings and bending of the rope in one number."""

    efficiency: Positive  # -, of one sheave: pull that leaves it over pull that enters; 0.98 on
    # rolling bearings

    def ratio(self, radius: float) -> float:
        """Return the tension on the side that the rope goes to over the other one."""
        return 1.0 / self.efficiency

    def find_error(self) -> str:
        """Return an error of the values, or an empty line."""
        return (
            "" if self.efficiency <= 1.0 else f"efficiency = {self.efficiency:g}: must be at most 1"
        )


class SheaveBearing(NamedTuple):
    """Friction of a plain bearing under the resultant of two parallel falls."""

    friction: NonNegative  # -, coefficient of friction on the pin
    pin_radius: Positive  # m, of the bearing

    def ratio(self, radius: float) -> float:
        """Return the ratio of tensions, outgoing to incoming, infinite where the rope is stuck."""
        share = self.friction * self.pin_radius / radius
        return (1.0 + share) / (1.0 - share) if share < 1.0 else inf

    def find_error(self) -> str:
        """Return an error of the values, or an empty line."""
        return ""


class RopeSlip(NamedTuple):
    """A sheave that does not turn, over which the rope slides: T2 = T1 exp(friction × wrap)."""

    friction: NonNegative  # -, coefficient of friction of rope on sheave
    wrap: Angle = pi  # rad, angle of contact

    def ratio(self, radius: float) -> float:
        """Return the tension on the side that the rope goes to over the other one."""
        return exp(min(self.friction * self.wrap, 100.0))

    def find_error(self) -> str:
        """Return an error of the values, or an empty line."""
        return "" if self.wrap >= 0.0 else f"wrap = {self.wrap:g}: must not be negative"


LOSSES = {"efficiency": SheaveEfficiency, "bearing": SheaveBearing, "capstan": RopeSlip}
Loss = Annotated[Any, tagged_union_validator("kind", LOSSES, optional=True)]


class Sheaves(Group):
    """All sheaves, which are alike."""

    radius: Positive  # m, of the rope's centre line
    inertia: NonNegative = 0.0  # kg m², of each about its axis
    loss: Loss = None  # what the rope loses on each; left out: nothing


class DrumGroup(Group):
    """The drum of the winch."""

    radius: Positive  # m, of the rope's centre line in the first layer
    inertia: NonNegative = 0.0  # kg m², of the drum with gear and motor, about the drum's axis
    turns: Positive | None = None  # -, of rope in a full layer
    layers: LayerCount = 1  # -, that the drum can take
    layer_height: Positive | None = None  # m, from one layer to the next: 0.87 to 1 times the
    # rope's diameter

    def check(self, length: float | None, group: str) -> None:
        """Raise SceneError for keys that are missing or have no effect.

        The arguments are those of `ReevingGroup.check`.
        """
        if self.layers == 1:
            if self.layer_height is not None:
                raise SceneError(
                    f"{group}.reeving.drum.layer_height: belongs to a drum with more than one of "
                    "its `layers`"
                )
            return
        given = {"drum.turns": self.turns, "drum.layer_height": self.layer_height, "length": length}
        for key in (key for key, value in given.items() if value is None):
            raise SceneError(
                f"{group}.reeving.{key}: is missing; a drum with {self.layers} layers needs it"
            )

    def capacities(self) -> Any:
        """Return the rope [m] that each layer holds (layers,), infinite without `turns`."""
        radii = self.radius + (self.layer_height or 0.0) * np.arange(self.layers)
        return 2.0 * pi * radii * (self.turns or inf)

    def model(self, more_inertia: float) -> Drum:
        """Return the drum, with the inertia [kg m²] that motors add."""
        layers, lengths = None, self.capacities()
        if self.layers > 1 and self.layer_height is not None and self.turns is not None:
            layers = Layers(np.cumsum(lengths)[:-1], lengths[:-1] / self.turns, self.layer_height)
        return Drum(self.radius, self.inertia + more_inertia, layers)


class ReevingGroup(Group):
    """A rope over sheaves: `falls` of equal length from tip to block, a lead line to a drum."""

    falls: Falls  # -, parts of rope that carry the block
    lead_sheaves: Count = 1  # -, between falls and drum
    sheaves: Sheaves | None = None  # left out: without inertia and loss
    drum: DrumGroup | None = None  # left out: without inertia
    mass_per_length: Positive | None = None  # kg/m, of the rope; left out: it weighs nothing
    length: Positive | None = None  # m, of the rope on the drum and in the falls; where rope has a
    # mass or layers

    @property
    def longest(self) -> float:
        """Longest falls [m] that the rope suffices for."""
        return inf if self.length is None else self.length / self.falls

    def loss(self, group: str) -> SheaveLoss | None:
        """Return a sheave's loss, None without; `group`: of the scene, with the reeving.

        Raises:
            SceneError: a sheave cannot turn.
        """
        if self.sheaves is None or self.sheaves.loss is None:
            return None
        ratio = self.sheaves.loss.ratio(self.sheaves.radius)
        if not ratio <= MAX_RATIO:
            raise SceneError(
                f"{group}.reeving.sheaves.loss: one sheave holds {ratio:.3g} times what pulls it; "
                f"at most {MAX_RATIO:g}"
            )
        return SheaveLoss(ratio) if ratio > 1.0 else None

    def least_mass(self, ropes: int) -> float:
        """Return the mass [kg] that sheaves and drum add to the length, without the rope.

        The drum is on its last layer.
        """
        n, mass = self.falls, 0.0
        if self.drum is not None:
            radius = self.drum.radius + (self.drum.layer_height or 0.0) * (self.drum.layers - 1)
            mass += self.drum.inertia * (n / radius) ** 2
        if self.sheaves is not None:
            # squares, over that of the length
            speeds = sum(k * k for k in range(1, n)) + self.lead_sheaves * n * n
            mass += ropes * self.sheaves.inertia / self.sheaves.radius**2 * speeds
        return mass

    def check(self, shortest: float, longest: float, group: str) -> None:
        """Raise SceneError unless rope and drum suffice for falls between these lengths [m].

        Args:
            shortest, longest: of the falls [m].
            group: of the scene that has the reeving.
        """
        sheaves = self.sheaves
        if sheaves is not None and sheaves.inertia > 0.0 and isinstance(sheaves.loss, RopeSlip):
            raise SceneError(
                f"{group}.reeving.sheaves.inertia = {sheaves.inertia:g}: sheaves with the loss "
                "'capstan' stand still; must be 0"
            )
        if self.drum is not None:
            self.drum.check(self.length, group)
        if self.length is not None:
            self._check_length(self.length, shortest, longest, group)
        elif self.mass_per_length is not None:
            raise SceneError(
                f"{group}.reeving.length: is missing; a rope with a mass_per_length needs it"
            )

    def _check_length(self, length: float, shortest: float, longest: float, group: str) -> None:
        """Raise SceneError for a rope [m] that is too short, or too long for its drum."""
        needed = self.falls * longest
        if needed > length:
            raise SceneError(
                f"{group}.reeving.length = {length:g}: too short, {self.falls} falls of "
                f"{longest:g} m take {needed:g} m"
            )
        capacity = inf if self.drum is None else float(sum(self.drum.capacities()))
        wound = length - self.falls * shortest
        if wound > capacity:
            raise SceneError(
                f"{group}.reeving.drum: its layers hold {capacity:g} m of rope, and falls of "
                f"{shortest:g} m leave {wound:g} m to it"
            )

    def model(self, motor: float, group: str, ropes: int = 1) -> Reeving:
        """Return the reeving.

        Args:
            motor: mass [kg] that the winch's motor adds to the length.
            group: of the scene that has the reeving.
            ropes: that run alike over sheaves of their own.

        Raises:
            SceneError: a sheave cannot turn, or a motor has no drum of one radius.
        """
        if motor > 0.0 and (self.drum is None or self.drum.layers > 1):
            raise SceneError(
                "actuators.rope.motor.inertia: belongs to a rope.reeving.drum with one layer; "
                "with more, give drum.inertia what gear and motor add"
            )
        drum, sheaves = None, self.sheaves
        if self.drum is not None:
            drum = self.drum.model(motor * (self.drum.radius / self.falls) ** 2)
        mass = 0.0 if sheaves is None else ropes * sheaves.inertia / sheaves.radius**2
        loss, length = self.loss(group), self.length or inf
        return Reeving(
            self.falls, self.lead_sheaves, mass, loss, drum, self.mass_per_length, length
        )
