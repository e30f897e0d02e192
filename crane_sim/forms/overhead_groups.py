"""The groups of a scene file with an overhead crane: what they may hold."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from crane_sim.forms.groups import Channel, Group, Profile
from crane_sim.overhead.axes import Friction
from crane_sim.quantities import Angle, NonNegative, Positive, Real
from crane_sim.sources import Constant


def _listed(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else (value,)


def _sized(value: float) -> float:
    if value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(f"must be 0 or of a size of {SMALLEST:g} to {LARGEST:g}")
    return value


def _bounded(value: float) -> float:
    if not abs(value) <= LARGEST:
        raise ValueError(f"must be within -{LARGEST:g} .. {LARGEST:g}")
    return value


SMALLEST, LARGEST = 1e-12, 1e12  # of masses, lengths, stiffness: products of several stay numbers of the machine
Size = Annotated[Positive, AfterValidator(_sized)]
SizeOrZero = Annotated[NonNegative, AfterValidator(_sized)]
Place = Annotated[Real, AfterValidator(_bounded)]
MOST_LINKS = 500
_Some = (BeforeValidator(_listed), Field(min_length=1, max_length=MOST_LINKS))
Lengths = Annotated[tuple[Size, ...], *_Some]
Masses = Annotated[tuple[SizeOrZero, ...], *_Some]
Vector = tuple[Place, Place, Place]


class AxisGroup(Group):
    """How the trolley (along x) or the bridge (along y) moves."""

    drive: Literal["force", "prescribed", "fixed"] = "force"
    mass: SizeOrZero | None = None  # kg; of a bridge: without its trolley
    motion: Profile = None  # of a prescribed drive
    limits: tuple[Real, Real] | None = None  # m; a run ends where one is reached


class CableGroup(Group):
    """Links and node masses from the top; the last node is the payload. One number stands for all `links`."""

    model: Literal["rigid", "elastic", "straight", "auto"] = "rigid"
    links: Annotated[int, Field(ge=1, le=MOST_LINKS)] | None = None
    lengths: Lengths  # m
    node_masses: Masses  # kg
    slack: Literal["allow", "stop"] = "allow"  # of rigid links
    inertia: Masses | None = None  # kg m², of links that turn as rods
    stiffness: Lengths | None = None  # N/m, of elastic links
    damping: Masses | None = None  # N s/m
    tension_only: bool = False
    joints: "JointsGroup | None" = None


class JointsGroup(Group):
    """Bending stiffness and damping between links, the first one between trolley and cable."""

    stiffness: Masses = (0.0,)  # N m/rad
    damping: Masses = (0.0,)  # N m s/rad


class PayloadGroup(Group):
    """The last node's mass, in place of the last one of node_masses."""

    mass: Size  # kg


class HoistGroup(Group):
    """How the first link's length changes. A force-driven hoist without inertia is the massless winch."""

    drive: Literal["prescribed", "force"]
    profile: Profile = None  # m, of a prescribed hoist
    inertia: SizeOrZero | None = None  # kg, of a force-driven one
    push: bool = False  # of a force-driven one: efforts that pay out are applied too, not as zero
    limits: tuple[NonNegative, Positive] | None = None  # m; a run ends where one is reached


class Start(Group):
    """Positions and velocities at t = 0: angles (2D), directions (3D) or, elastic, positions of the nodes."""

    x: Place = 0.0
    v: Place = 0.0
    y: Place = 0.0  # m, of the bridge
    vy: Place = 0.0
    length: Size | None = None  # m, of a force-driven hoist; its link's own when left out
    length_rate: Place = 0.0
    angles: Annotated[tuple[Angle, ...], BeforeValidator(_listed)] | None = None
    rates: Any = None  # rad/s, or the directions' rates of change (3D)
    directions: tuple[Vector, ...] | None = None
    positions: tuple[tuple[Place, ...], ...] | None = None
    velocities: tuple[tuple[Place, ...], ...] | None = None


class Change(Group):
    """What is set anew."""

    payload: PayloadGroup


class Event(Group):
    """Something that happens at a time."""

    at: NonNegative  # s
    set: Change


class FrictionGroup(Group):
    """Friction of the rails."""

    trolley: Friction | None = None
    bridge: Friction | None = None


class ForceGroup(Group):
    """A force on a node of the cable."""

    node: Annotated[int, Field(ge=1, le=MOST_LINKS)]
    axis: Literal["x", "y", "z"]
    force: Channel  # N


class Inputs(Group):
    """Open-loop inputs of the actuated joints; silent ones are zero."""

    trolley: Channel = Constant(0.0)
    bridge: Channel = Constant(0.0)
    hoist: Channel = Constant(0.0)
