"""A scene file: the groups of any crane, and what it describes, an assembly."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import inf
from typing import Any, NamedTuple

from crane_sim.files.types import Name, Positive, Seed
from crane_sim.integrators.dop853 import DOP853
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.base_motion import BaseMotion
from crane_sim.scenes.schema.groups import Control, Method
from crane_sim.scenes.schema.hardware import HardwareGroups
from crane_sim.scenes.schema.instruments import CameraGroup, ImuGroup
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits
from crane_sim.scenes.schema.reference import compile_path
from crane_sim.scenes.schema.uncertain import Distribution
from crane_sim.scenes.schema.wind import WindGroup, blows
from crane_sim.trajectories.inputs import Inputs
from crane_sim.trajectories.trajectory import Trajectory
from crane_sim.trajectories.wind import Wind


class Assembly(NamedTuple):
    """What a scene file describes: nq joints in their order, nu of them actuated."""

    model: Any  # parameters of the crane, whose type chooses the equations (`crane_sim.system`)
    joint_names: tuple[str, ...]  # (nq,)
    joint_units: tuple[str, ...]  # (nq,) m, rad, or 1 for a component of a direction
    actuated: tuple[str, ...]  # (nu,) joints that take commands
    effort_units: tuple[str, ...]  # (nu,)
    initial_q: tuple[float, ...]  # (nq,) at t = 0
    initial_v: tuple[float, ...]  # (nq,) at t = 0
    limits: tuple[TravelLimits, ...]  # of the joints that have some
    target: tuple[float, ...] | None  # (nu,) None without `reference.q`
    trajectory: Trajectory | None  # the compiled path, None without `reference.path`
    open_loop: Inputs | tuple[float, ...]  # efforts without a law: functions of time, or held ones
    # (nu,)
    requirements: MethodRequirements  # on the method of a scene that is not sampled
    notes: dict[str, Any]  # settings chosen automatically, entries of the summary


class SceneFile(HardwareGroups, ABC):
    """The groups of any crane; a crane's file adds `crane: Literal["NAME"]` and its own groups."""

    name: Name = ""  # of the scene, in one line; left out: the file's
    description: str = ""  # a line for the catalogue
    duration: Positive  # s, scene time of a run; rounded to whole periods, which the summary says
    # (`rounded`)
    seed: Seed = 0  # -, of all that is drawn at random and has no seed of its own
    uncertain: dict[str, Distribution] | None = None  # distributions of parameters by dotted key,
    # such as `payload.mass`; the seed draws their values, which stand in the summary as `drawn`
    base_motion: BaseMotion | None = None  # how the base moves; left out: it rests
    imu: ImuGroup | None = None  # an inertial measurement unit on the base; left out: none
    camera: CameraGroup | None = None  # a camera that measures the payload; left out: none
    wind: WindGroup | None = None  # presses on bodies with a `windage`; left out: the air rests,
    # and nothing feels it
    control: Control | None = None  # the law; left out: open loop
    integrator: Method = DOP853()  # method and its accuracy

    @property
    def is_sampled(self) -> bool:
        """Whether a law commands the drives once a period."""
        return self.control is not None and self.control.period != "continuous"

    def build(self) -> Assembly:
        """Return what the file describes.

        Raises:
            SceneError: groups contradict each other; one line that names the key.
        """
        model = self.model()  # first: it rejects files of which nothing else can be computed
        return Assembly(
            model=model,
            joint_names=self.joint_names,
            joint_units=self.joint_units,
            actuated=self.actuated,
            effort_units=self.effort_units,
            initial_q=self.initial_q,
            initial_v=self.initial_v,
            limits=self.limits,
            target=self.target,
            trajectory=compile_path(getattr(self, "reference", None), self),
            open_loop=self.open_loop() if self.control is None else (),
            requirements=self.requirements(),
            notes=self.notes,
        )

    @abstractmethod
    def model(self) -> Any:
        """Return the parameters of the crane."""

    @property
    @abstractmethod
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints (nq,)."""

    @property
    @abstractmethod
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions (nq,)."""

    @property
    @abstractmethod
    def actuated(self) -> tuple[str, ...]:
        """Joints that take commands (nu,)."""

    @property
    @abstractmethod
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands (nu,)."""

    @property
    @abstractmethod
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0 (nq,)."""

    @property
    @abstractmethod
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0 (nq,)."""

    @property
    @abstractmethod
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""

    @property
    @abstractmethod
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints (nu,), None without `reference.q`."""

    @abstractmethod
    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the efforts where there is no law."""

    @abstractmethod
    def requirements(self) -> MethodRequirements:
        """Return the scene's requirements on its integrator, where nothing is sampled."""

    @property
    @abstractmethod
    def payload_mass(self) -> float:
        """Mass of the payload at t = 0 [kg]."""

    @property
    @abstractmethod
    def rope_length(self) -> float:
        """Length of the rope, or of the whole cable, at t = 0 [m]."""

    @property
    @abstractmethod
    def payload_height(self) -> float:
        """Height of the payload above the base's origin at t = 0 [m]."""

    @property
    @abstractmethod
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key of the file, None where a body has none."""

    @property
    def lowest_pressure(self) -> float:
        """Height [m] above the base's origin below which no wind presses on moving bodies."""
        return -inf

    @property
    def notes(self) -> dict[str, Any]:
        """Settings chosen automatically, entries of the summary."""
        return {}

    @property
    def is_windy(self) -> bool:
        """Whether a wind presses on a body; SceneError: groups contradict each other."""
        return blows(self.wind, self.windages, getattr(self, "payload_drag", None) is not None)

    @property
    def is_in_kinked_wind(self) -> bool:
        """Whether the payload may come to where the profile of the mean wind has a kink.

        That is the lowest height of the wind's profile.
        """
        if not self.is_windy or self.wind is None or self.wind.profile is None:
            return False
        return self.wind.origin_height + self.lowest_pressure <= self.wind.profile.lowest

    def airflow(self) -> Wind | None:
        """Return the wind, None where it has no effect; SceneError: contradictory groups."""
        if not self.is_windy or self.wind is None:
            return None
        self.wind.check_ground(self.payload_height)
        return self.wind.wind(self.seed, self.duration, self.is_in_kinked_wind)

    def base(self) -> Any:
        """Return the motion of the base, None where it rests."""
        return (
            self.base_motion.base(self.seed, self.duration)
            if self.base_motion is not None
            else None
        )

    def rest_positions(self, target: tuple[float, ...]) -> tuple[float, ...] | None:
        """Return the joint positions (nq,) of the crane at rest at the target (nu,).

        None where they are known without the file: the cable hangs straight down.
        """
        return None

    def resting_joints(self, target: tuple[float, ...]) -> Mapping[str, float]:
        """Return the positions of joints, by name, that are known at rest at a target (nu,).

        All other joints are at the target, or the cable hangs straight down.

        Raises:
            SceneError: the crane cannot rest there.
        """
        rest = self.rest_positions(target)
        return {} if rest is None else dict(zip(self.joint_names, rest, strict=True))
