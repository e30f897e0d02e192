"""The groups of a scene file with an overhead crane."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from crane_sim.files.types import NonNegative, Positive, Real, Tilt, as_list, reject_bool
from crane_sim.models.effects import PayloadDrag
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.wind_load import Windage
from crane_sim.scenes.schema.axes import LARGEST, AxisGroup, Size, SizeOrZero
from crane_sim.scenes.schema.exchange import Velocity
from crane_sim.scenes.schema.groups import BY_SPEED, Channel, Group, PayloadForceGroup, Profile
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.trajectories.inputs import Constant


def _check_bound(value: float) -> float:
    if not abs(value) <= LARGEST:
        raise ValueError(f"must be within -{LARGEST:g} .. {LARGEST:g}")
    return value


BoundedReal = Annotated[Real, AfterValidator(_check_bound)]
MAX_LINKS = 500
LinkCount = Annotated[int, BeforeValidator(reject_bool), Field(ge=1, le=MAX_LINKS)]
_Some = (BeforeValidator(as_list), Field(min_length=1, max_length=MAX_LINKS))
Lengths = Annotated[tuple[Size, ...], *_Some]
Masses = Annotated[tuple[SizeOrZero, ...], *_Some]
Vector = tuple[BoundedReal, BoundedReal, BoundedReal]


HoistDrive = Annotated[Literal["prescribed", "force"], BY_SPEED]


class CableGroup(Group):
    """Links and node masses from the top, the last the payload; one number stands for `links`."""

    model: Literal["rigid", "elastic", "straight", "auto"] = "rigid"  # `rigid` links; `elastic`
    # ones; `straight`: one rod; `auto`: `straight` where the cable is light and straight and
    # nothing bends it, else `rigid`
    links: LinkCount | None = None  # -, number of links; left out: as many as the
    # longer one of `lengths` and `node_masses`
    lengths: Lengths  # m, of the links, from the top; elastic: at rest
    node_masses: Masses  # kg, at the lower ends of the links; the last one is the payload; rigid
    # nodes without mass join two links
    slack: Literal["allow", "stop"] = "allow"  # what happens when a rigid link would push: nothing,
    # or the run ends; `tension_only` is that of elastic ones
    inertia: Masses | None = None  # kg m², about their own middle, of links that turn as rods; left
    # out: all mass is in the nodes
    stiffness: Lengths | None = None  # N/m, of elastic links
    damping: Masses | None = None  # N s/m, of elastic links
    tension_only: bool = False  # elastic links go slack instead of pushing
    joints: "JointsGroup | None" = None  # bending of the cable; also as `joints` of the scene


class JointsGroup(Group):
    """Bending stiffness and damping between links, the first one between trolley and cable."""

    stiffness: Masses = (0.0,)  # N m/rad, torque for a bend
    damping: Masses = (0.0,)  # N m s/rad, torque for its rate


class MassGroup(Group):
    """A mass of the payload."""

    mass: Size  # kg, of the payload


class PayloadGroup(MassGroup):
    """The payload: its windage, and the last node's mass in place of that in node_masses."""

    windage: Windage | None = None  # area and drag in the `wind`; left out: no wind acts on it


class HoistGroup(Group):
    """Drive of the first link's length; by force and without inertia it is the massless winch."""

    drive: HoistDrive  # by a given `profile`, or by a force on the length, positive pays out
    profile: Profile = None  # m, length over time, of a prescribed hoist
    inertia: SizeOrZero | None = None  # kg, drum inertia over radius squared, of a drive by force;
    # left out: the massless winch
    push: bool = False  # of the massless winch: efforts that would push the rope are applied too,
    # not as zero; a drum takes every effort, and what its rope may do is `cable.slack`
    limits: tuple[NonNegative, Positive] | None = None  # m, of the length; a run ends where one is
    # reached; left out: from 0.001 on


class Start(Group):
    """Positions and rates at t = 0: angles (2D), directions (3D) or, elastic, nodes' positions."""

    x: BoundedReal = 0.0  # m, of the trolley
    v: BoundedReal = 0.0  # m/s, of the trolley
    y: BoundedReal = 0.0  # m, of the bridge
    vy: BoundedReal = 0.0  # m/s, of the bridge
    length: Size | None = None  # m, of a force-driven hoist; left out: its link's
    length_rate: BoundedReal = 0.0  # m/s, of a force-driven hoist
    angles: Annotated[tuple[Tilt, ...], BeforeValidator(as_list)] | None = None  # rad, of the links
    # from the downward vertical (2D); left out: they hang
    rates: Any = None  # rad/s, of the angles (2D); 1/s, vectors of 3, of the directions (3D); left
    # out: at rest
    directions: tuple[Vector, ...] | None = None  # -, unit vectors down the links (3D); left out:
    # they hang
    positions: tuple[tuple[BoundedReal, ...], ...] | None = None  # m, of an elastic cable's nodes,
    # [x, z] or [x, y, z], in place of angles or directions
    velocities: tuple[tuple[BoundedReal, ...], ...] | None = None  # m/s, of the same nodes; left
    # out: at rest


class Change(Group):
    """Change of an event."""

    payload: MassGroup  # its new mass


class Event(Group):
    """A change of the payload at a given time."""

    at: NonNegative  # s, when it happens
    velocity: Velocity | None = None  # m/s, of what is taken up just before, relative to the base
    # and in its axes, in 3 dimensions or below an elastic cable; left out, or `hook`: it moves with
    # the payload, and nothing jumps
    set: Change  # what is new from then on


class FrictionGroup(Group):
    """Friction of joints that a force drives; sticking and slipping are located as events."""

    trolley: Friction | None = None  # on the rail along x
    bridge: Friction | None = None  # on the rails along y
    hoist: Friction | None = None  # of the drum of a hoist with inertia, in terms of the rope; with
    # rigid links


class BristleGroup(Group):
    """Dry friction of rails by bristles, for rigid links: smooth in contrast to `friction`."""

    trolley: LuGre | None = None  # on the rail along x
    bridge: LuGre | None = None  # on the rails along y


class ForceGroup(Group):
    """A given force on a node of the cable, along an axis of the base."""

    node: LinkCount  # -, from the top, 1 at the lower end of the first link
    axis: Literal["x", "y", "z"]  # of the base
    force: Channel  # N, over time


class Inputs(Group):
    """Open-loop inputs of the actuated joints; absent ones are zero."""

    trolley: Channel = Constant(0.0)  # N, force along x
    bridge: Channel = Constant(0.0)  # N, force along y
    hoist: Channel = Constant(0.0)  # N, force on the length, positive pays out


class OverheadGroups(SceneFile):
    """All groups of a scene file with an overhead crane."""

    crane: Literal["overhead"]  # the kind of crane
    dimensions: Literal[2, 3] = 2  # `2`: the plane x-z; `3`: space, with a bridge
    gravity: SizeOrZero = 9.81  # m/s², acceleration of free fall
    trolley: AxisGroup  # runs along x, carried by the bridge
    bridge: AxisGroup | None = None  # runs along y, in 3 dimensions; left out: fixed
    cable: CableGroup  # links and nodes
    payload: PayloadGroup | None = None  # its mass, in place of the last node's
    hoist: HoistGroup | None = None  # changes the first link's length; left out: it is fixed
    joints: JointsGroup | None = None  # bending of the cable; also as `cable.joints`
    friction: FrictionGroup | None = None  # of rails and drum
    lugre: BristleGroup | None = None  # the same by bristles, of rails without `friction`
    forces: tuple[ForceGroup, ...] = ()  # given forces on nodes
    payload_drag: PayloadDrag | None = None  # drag of still air on the payload
    payload_force: PayloadForceGroup | None = None  # a given force on the payload
    events: tuple[Event, ...] = ()  # changes of the payload at given times
    initial: Start = Start()  # the state at t = 0
    reference: ReferenceGroup | None = None  # where the crane should go
    inputs: Inputs | None = None  # of the joints that a force drives, where there is no law
