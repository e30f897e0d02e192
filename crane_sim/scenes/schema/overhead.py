"""The schema of a scene file with an overhead crane."""

from itertools import accumulate
from math import cos, inf
from typing import Any

from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.overhead_cable import OverheadCrane, hoist_at_start
from crane_sim.scenes.schema.overhead_checks import check_groups, check_start
from crane_sim.scenes.schema.overhead_models import (
    crane_of,
    requirements_of,
    stretched_lengths,
)
from crane_sim.scenes.schema.overhead_stiffness import axis_mass, bending_error, massless_axes
from crane_sim.scenes.schema.reference import target_of
from crane_sim.trajectories.inputs import Inputs as Channels


class OverheadFile(OverheadCrane):
    """A scene with an overhead crane: a trolley, in 3 dimensions on a bridge, and a cable."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: axes, hoist, then the links' angles or directions or the nodes' positions."""
        n, hoist = len(self.parts.lengths), ("hoist",) if self.hoist else ()
        across = "xz" if self.dimensions == 2 else "xyz"
        if self.cable_model == "elastic":
            cable = [f"node_{k}_{axis}" for k in range(1, n + 1) for axis in across]
        elif self.dimensions == 3:
            cable = [f"link_{k}_{axis}" for k in range(1, n + 1) for axis in across]
        else:
            cable = [f"swing_{k}" for k in range(1, 2 if self.cable_model == "straight" else n + 1)]
        return (*self.axes, *hoist, *cable)

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions; directions of links have none."""
        unit = "m" if self.cable_model == "elastic" else "1" if self.dimensions == 3 else "rad"
        metres = len(self.axes) + (self.hoist is not None)
        return ("m",) * metres + (unit,) * (len(self.joint_names) - metres)

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands."""
        return ("N",) * len(self.actuated)

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints.

        Raises:
            SceneError: it has another number of values.
        """
        return target_of(self.reference, self.actuated)

    @property
    def payload_mass(self) -> float:
        """Mass of the payload at t = 0 [kg]."""
        return self.parts.masses[-1]

    @property
    def start_lengths(self) -> tuple[float, ...]:
        """Lengths of the links at t = 0 [m]."""
        hoisted = self.parts.lengths[:1] if self.hoist is None else (hoist_at_start(self)[0],)
        return (*hoisted, *self.parts.lengths[1:])

    @property
    def rope_length(self) -> float:
        """Length of the whole cable at t = 0 [m]."""
        return sum(self.start_lengths)

    @property
    def payload_height(self) -> float:
        """Height of the payload above the rails at t = 0 [m]."""
        if self.initial.positions:
            return self.initial.positions[-1][-1]
        # to the vertical
        cosines = [turn[-1] if self.dimensions == 3 else -cos(turn) for turn in self.parts.turns]
        return sum(
            length * cosine for length, cosine in zip(self.start_lengths, cosines, strict=True)
        )

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        return {"payload.windage": self.payload.windage if self.payload is not None else None}

    @property
    def lowest_pressure(self) -> float:
        """Height [m] above the base's origin below which no wind presses on the payload."""
        keeps = self.base_motion is None and self.hoist is None and self.cable_model != "elastic"
        return -sum(self.parts.lengths) if keeps else -inf

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        groups = (("trolley", self.trolley), ("bridge", self.bridge), ("hoist", self.hoist))
        return limits_of(
            *((name, f"{name}.limits", group.limits) for name, group in groups if group is not None)
        )

    @property
    def notes(self) -> dict[str, Any]:
        """Settings chosen automatically, entries of the summary."""
        notes: dict[str, Any] = {"model": self.cable_model} if self.cable.model == "auto" else {}
        if self.cable_model == "straight" and len(self.parts.masses) > 1:
            notes["model_error_estimate"] = bending_error(self)
        if massless := massless_axes(self):
            notes["rounded"] = [
                f"{name}.mass: 0 kg is taken as {axis_mass(self, name):.3g} kg" for name in massless
            ]
        return notes

    def rest_positions(self, target: tuple[float, ...]) -> tuple[float, ...] | None:
        """Return an elastic cable's joint positions (nq,) at rest at a target (nu,), else None.

        Its nodes are below the trolley, as far as their weights stretch the links. Wind and forces
        on nodes are not in.
        """
        if self.cable_model != "elastic":
            return None
        start = dict(zip(self.joint_names, self.initial_q, strict=True))
        at = start | dict(zip(self.actuated, target, strict=True))
        above, wound = (
            tuple(at[name] for name in self.axes),
            () if self.hoist is None else (at["hoist"],),
        )
        depths = accumulate(stretched_lengths(self, (*wound, *self.parts.lengths[len(wound) :])))
        return (*above, *wound, *(x for depth in depths for x in (*above, -depth)))

    def requirements(self) -> MethodRequirements:
        """Return the scene's requirements on its integration method."""
        return requirements_of(self)

    def model(self) -> Any:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        check_groups(self)
        check_start(self)
        return crane_of(self)

    def open_loop(self) -> Channels | tuple[float, ...]:
        """Return the open-loop inputs, zero where left out; a tuple of zeros without `inputs`."""
        if self.inputs is None or not self.actuated:
            return (0.0,) * len(self.actuated)
        return Channels(tuple(getattr(self.inputs, name) for name in self.actuated))
