"""The form of a scene file with an overhead crane."""

from functools import cached_property
from math import sqrt
from typing import Any, Literal

from crane_sim.forms.base_motion import BaseMotion
from crane_sim.forms.groups import Control, Method
from crane_sim.forms.hardware import HardwareGroups
from crane_sim.forms.limits import Limit, limits_of
from crane_sim.forms.method_choice import Demands, asks_frequency
from crane_sim.forms.overhead_base import on_base
from crane_sim.forms.overhead_checks import check, check_start
from crane_sim.forms.overhead_frequency import bending_error, stiffest
from crane_sim.forms.overhead_groups import (
    AxisGroup,
    CableGroup,
    Event,
    ForceGroup,
    FrictionGroup,
    HoistGroup,
    Inputs,
    JointsGroup,
    PayloadGroup,
    SizeOrZero,
    Start,
)
from crane_sim.forms.overhead_models import crane_of, switches_of
from crane_sim.forms.overhead_start import Cable, cable_of, start_of, what_is_modelled
from crane_sim.forms.reference import ReferenceGroup, target_of
from crane_sim.integrators.dop853 import DOP853
from crane_sim.quantities import Name, Positive, Seed
from crane_sim.sources import Inputs as Channels


class OverheadFile(HardwareGroups):
    """A scene with an overhead crane: a trolley, on a bridge in 3 dimensions, and a cable of one or many links."""

    crane: Literal["overhead"]  # which form the file has
    name: Name = ""  # of the scene, in one line; left out: the file's
    description: str = ""  # a line for the catalogue
    dimensions: Literal[2, 3] = 2  # `2`: the plane x-z; `3`: space, with a bridge
    duration: Positive  # s, scene time of a run; rounded to whole periods, which the summary says (`rounded`)
    gravity: SizeOrZero = 9.81  # m/s², acceleration of free fall
    seed: Seed = 0  # -, of all that is drawn at random and has no seed of its own
    trolley: AxisGroup  # runs along x, carried by the bridge
    bridge: AxisGroup | None = None  # runs along y, in 3 dimensions; left out: fixed
    cable: CableGroup  # links and nodes
    payload: PayloadGroup | None = None  # its mass, in place of the last node's
    hoist: HoistGroup | None = None  # changes the first link's length; left out: it is fixed
    joints: JointsGroup | None = None  # bending of the cable; also as `cable.joints`
    friction: FrictionGroup | None = None  # of the rails
    forces: tuple[ForceGroup, ...] = ()  # given forces on nodes
    events: tuple[Event, ...] = ()  # changes of the payload at given times
    base_motion: BaseMotion | None = None  # how the base moves; left out: it rests
    initial: Start = Start()  # the state at t = 0
    reference: ReferenceGroup | None = None  # where the crane should go
    control: Control | None = None  # the law; left out: open loop
    inputs: Inputs | None = None  # of the joints that a force drives, where there is no law
    integrator: Method = DOP853()  # method and its accuracy

    @cached_property
    def parts(self) -> Cable:
        """Lengths and masses of the cable's links, checked, massless nodes merged."""
        return cable_of(self)

    @cached_property
    def modelled(self) -> str:
        """The cable's model: rigid, elastic or straight."""
        return what_is_modelled(self)

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes that carry the cable's upper end."""
        return ("trolley",) if self.dimensions == 2 else ("trolley", "bridge")

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: axes, the hoist, then what tells where the links are."""
        n, hoist = len(self.parts.lengths), ("hoist",) if self.hoist else ()
        across = "xz" if self.dimensions == 2 else "xyz"
        if self.modelled == "elastic":
            cable = [f"node_{k}_{axis}" for k in range(1, n + 1) for axis in across]
        elif self.dimensions == 3:
            cable = [f"link_{k}_{axis}" for k in range(1, n + 1) for axis in across]
        else:
            cable = [f"swing_{k}" for k in range(1, 2 if self.modelled == "straight" else n + 1)]
        return (*self.axes, *hoist, *cable)

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions; directions of links have none."""
        unit = "m" if self.modelled == "elastic" else "1" if self.dimensions == 3 else "rad"
        metres = len(self.axes) + (self.hoist is not None)
        return ("m",) * metres + (unit,) * (len(self.joint_names) - metres)

    @property
    def actuated(self) -> tuple[str, ...]:
        """Joints that take commands."""
        groups = (("trolley", self.trolley), ("bridge", self.bridge), ("hoist", self.hoist))
        return tuple(name for name, group in groups if group is not None and group.drive == "force")

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
        return target_of(self.reference, self.actuated)

    @property
    def payload_mass(self) -> float:
        """Mass of the payload at t = 0 [kg]."""
        return self.parts.masses[-1]

    @property
    def rope_length(self) -> float:
        """Length of the whole cable at t = 0 [m]."""
        return sum(self.parts.lengths)

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return self._start[0]

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return self._start[1]

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Travel limits of the joints that have some."""
        groups = (("trolley", self.trolley), ("bridge", self.bridge), ("hoist", self.hoist))
        return limits_of(*((name, f"{name}.limits", group.limits) for name, group in groups if group is not None))

    @cached_property
    def _start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        return start_of(self)

    @property
    def notes(self) -> dict[str, Any]:
        """What was chosen for the scene."""
        found: dict[str, Any] = {"model": self.modelled} if self.cable.model == "auto" else {}
        if self.modelled == "straight" and len(self.parts.masses) > 1:
            found["model_error_estimate"] = bending_error(self)
        return found

    def demands(self, sampled: bool) -> Demands:
        """Return what the scene asks of its method."""
        smooth = not sampled and switches_of(self) is None
        continuous = self.control is not None and self.control.period == "continuous"
        frequency = stiffest(self) if asks_frequency(self.integrator) else None
        turns = self.duration * sqrt(self.gravity / sum(self.parts.lengths))
        return Demands(frequency, turns, self.modelled == "elastic", smooth, self.duration, continuous)

    def model(self) -> Any:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        check(self)
        check_start(self)
        return on_base(self, crane_of(self))

    def open_loop(self) -> Channels | tuple[float, ...]:
        """Return the open-loop inputs, zero where they are silent; efforts of zero, held, where there are none."""
        if self.inputs is None or not self.actuated:
            return (0.0,) * len(self.actuated)
        channels = None
        for name in reversed(self.actuated):
            channels = Channels(getattr(self.inputs, name), channels)
        assert channels is not None
        return channels
