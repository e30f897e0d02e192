"""The form of a scene file with an overhead crane in the vertical plane, and the model that it describes."""

from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from crane_sim.cables.chain import Chain, ForceHoist, PrescribedHoist
from crane_sim.explain import SceneError
from crane_sim.integrators.dop853 import DOP853
from crane_sim.motions import position_at
from crane_sim.overhead import OverheadCrane
from crane_sim.quantities import Angle, NonNegative, Positive, Real
from crane_sim.scene_groups import Channel, Control, Group, Method, Profile
from crane_sim.sources import Constant, Inputs, NoInputs
from crane_sim.supports.trolley import FixedTrolley, ForceTrolley, PrescribedTrolley

Lengths = Annotated[tuple[Positive, ...], Field(min_length=1, max_length=500)]


class TrolleyGroup(Group):
    """How the trolley moves."""

    drive: Literal["force", "prescribed", "fixed"] = "force"
    mass: Positive | None = None  # kg, of a force-driven trolley
    motion: Profile = None  # of a prescribed one


class CableGroup(Group):
    """Links and node masses from the top; the last node is the payload."""

    model: Literal["rigid"] = "rigid"
    lengths: Lengths  # m
    node_masses: Lengths  # kg


class HoistGroup(Group):
    """How the first link's length changes."""

    drive: Literal["prescribed", "force"]
    profile: Profile = None  # m, of a prescribed hoist
    inertia: Positive | None = None  # kg, of a force-driven one


class PlanarStart(Group):
    """Trolley position and velocity, link angles from the downward vertical and their rates, at t = 0."""

    x: Real = 0.0
    v: Real = 0.0
    angles: tuple[Angle, ...]
    rates: tuple[Real, ...] = ()


class PlanarReference(Group):
    """Where the actuated joints should go."""

    q: tuple[Real, ...]


class PlanarInputs(Group):
    """Open-loop inputs of the actuated joints; silent ones are zero."""

    trolley: Channel = Constant(0.0)
    hoist: Channel = Constant(0.0)


class OverheadFile(Group):
    """A scene with an overhead crane."""

    crane: Literal["overhead"]
    name: str = ""
    description: str = ""
    dimensions: Literal[2] = 2
    duration: Positive  # s
    gravity: NonNegative = 9.81  # m/s²
    seed: int = 0
    trolley: TrolleyGroup
    cable: CableGroup
    hoist: HoistGroup | None = None
    initial: PlanarStart
    reference: PlanarReference | None = None
    control: Control | None = None
    inputs: PlanarInputs | None = None
    integrator: Method = DOP853()

    @property
    def n(self) -> int:
        """Number of links."""
        return len(self.cable.lengths)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints, the actuated ones first."""
        hoist = ("hoist",) if self.hoist else ()
        return ("trolley", *hoist, *(f"swing_{k}" for k in range(1, self.n + 1)))

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions."""
        return ("m",) * (2 if self.hoist else 1) + ("rad",) * self.n

    @property
    def actuated(self) -> tuple[str, ...]:
        """Joints that take commands."""
        hoist = ("hoist",) if self.hoist and self.hoist.drive == "force" else ()
        return (*(("trolley",) if self.trolley.drive == "force" else ()), *hoist)

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands."""
        return ("N",) * len(self.actuated)

    @property
    def target(self) -> tuple[float, ...] | None:
        """Where the actuated joints should go.

        Raises:
            SceneError: it has another number of values.
        """
        if self.reference is None:
            return None
        if len(self.reference.q) != len(self.actuated):
            raise SceneError(f"reference.q: has {len(self.reference.q)} values, actuated are {self.actuated}")
        return self.reference.q

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return self._start[0]

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return self._start[1]

    @cached_property
    def _start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        start = self.initial
        rates = start.rates or (0.0,) * self.n
        for name, values in (("angles", start.angles), ("rates", rates)):
            if len(values) != self.n:
                raise SceneError(f"initial.{name}: has {len(values)} values, the cable has {self.n} links")
        x, v = position_at(self.trolley.motion, 0.0) if self.trolley.motion else (start.x, start.v)
        length = position_at(self.hoist.profile, 0.0) if self.hoist and self.hoist.profile else None
        length = length or (self.cable.lengths[0], 0.0)
        hoist, paid = ((length[0],), (length[1],)) if self.hoist else ((), ())
        return (x, *hoist, *start.angles), (v, *paid, *rates)

    def model(self) -> OverheadCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        if len(self.cable.node_masses) != self.n:
            raise SceneError(f"cable.node_masses: has {len(self.cable.node_masses)} values, lengths has {self.n}")
        chain = Chain(np.array(self.cable.node_masses), np.array(self.cable.lengths))
        return OverheadCrane(self._trolley(), chain, self._hoist(), self.gravity)

    def _trolley(self) -> ForceTrolley | PrescribedTrolley | FixedTrolley:
        drive, mass, motion = self.trolley.drive, self.trolley.mass, self.trolley.motion
        if (mass is None) == (drive == "force"):
            raise SceneError(f"trolley.mass = {mass}: a trolley has one when its drive is force, here it is {drive!r}")
        if (motion is None) == (drive == "prescribed"):
            raise SceneError(f"trolley.motion: belongs to a prescribed drive and to no other, here it is {drive!r}")
        if mass is not None:
            return ForceTrolley(mass)
        return FixedTrolley() if motion is None else PrescribedTrolley(motion)

    def _hoist(self) -> PrescribedHoist | ForceHoist | None:
        if self.hoist is None:
            return None
        drive, profile, inertia = self.hoist.drive, self.hoist.profile, self.hoist.inertia
        if (profile is None) == (drive == "prescribed"):
            raise SceneError(f"hoist.profile: belongs to a prescribed drive and to no other, here it is {drive!r}")
        if (inertia is None) == (drive == "force"):
            raise SceneError(
                f"hoist.inertia = {inertia}: a hoist has one when its drive is force, here it is {drive!r}"
            )
        return ForceHoist(inertia) if inertia is not None else PrescribedHoist(profile)

    def open_loop(self) -> Inputs | NoInputs:
        """Return the open-loop inputs, zero where the file is silent."""
        given = self.inputs or PlanarInputs()
        inputs = None
        for name in reversed(self.actuated):
            inputs = Inputs(getattr(given, name), inputs)
        return inputs or NoInputs()
