"""The model of an overhead scene: which one `crane_of` chooses, its parameters, and the base that it stands on."""

from math import sqrt
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.models.cables.chain import Chain, Joints, Rods
from crane_sim.models.overhead.double import DoubleCrane, TwoLinks
from crane_sim.models.overhead.elastic import ElasticCrane, Springs
from crane_sim.models.overhead.modes import EventLimits
from crane_sim.models.overhead.node_forces import NodeForce
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import Line, RodCrane
from crane_sim.models.overhead.spatial import SpatialCrane
from crane_sim.models.overhead.spring import Spring, SpringCrane
from crane_sim.models.stops import MIN_LENGTH
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import ForceHoist, Hoist, MasslessHoist, PrescribedHoist
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.supports.rails import Axis, FixedAxis, ForceAxis, PrescribedAxis
from crane_sim.scenes.schema.base_motion import Mount
from crane_sim.scenes.schema.friction_checks import check_friction
from crane_sim.scenes.schema.integrator import MethodRequirements, implicit, needs_frequency
from crane_sim.scenes.schema.motors import reflected_inertia
from crane_sim.scenes.schema.overhead_cable import OverheadCrane, fill_list
from crane_sim.scenes.schema.overhead_groups import AxisGroup, JointsGroup
from crane_sim.scenes.schema.overhead_stiffness import axis_mass, massless_axes, stiffest
from crane_sim.trajectories.base_motion import AXES, Base, MountedBase, SplineBase
from crane_sim.trajectories.profiles import Shape

IN_PLANE = ("surge", "heave", "pitch")  # motions of a base that keep a crane in its plane
ELASTIC_KEYS = ("stiffness", "damping", "tension_only")  # of a cable: only an elastic one has them


def crane_of(file: OverheadCrane) -> Any:
    """Return the parameters of a scene's crane, its base at rest; their type chooses the equations.

    The first row that applies; `plain`: no joints, no inertia of links, no forces on nodes, no wind; `steady`: nothing
    that switches or ends the run (friction, limits, hoist, events, slack); links: after massless nodes are merged.

    | cable    | dimensions | links | base  | besides                                       | model          |
    |----------|------------|-------|-------|-----------------------------------------------|----------------|
    | elastic  | 2          | 1     | rests | plain, no hoist, steady, explicit method      | `SpringCrane`  |
    | elastic  | 2 or 3     | any   | any   |                                               | `ElasticCrane` |
    | rigid    | 3          | any   | any   |                                               | `SpatialCrane` |
    | straight | 2          | any   | rests | plain                                         | `RodCrane`     |
    | rigid    | 2          | 1     | rests | plain                                         | `RodCrane`     |
    | rigid    | 2          | 2     | rests | plain, steady                                 | `DoubleCrane`  |
    | any      | 2          | any   | any   |                                               | `PlanarCrane`  |

    Raises:
        SceneError: groups contradict each other.
    """
    if file.cable_model == "elastic":
        return _elastic_crane(file)
    refuse_springs(file)
    if file.dimensions == 3:
        return _spatial_crane(file)
    straight, links, rests = file.cable_model == "straight", len(file.parts.lengths), file.base_motion is None
    plain = not (_bends(file) or file.cable.inertia or file.forces or file.is_windy)
    if straight and not plain:
        raise SceneError("cable.model = 'straight': takes neither joints nor inertia nor forces on nodes nor wind")
    if (straight or links == 1) and plain and rests:
        return _rod_crane(file)
    if links == 2 and plain and rests and make_event_limits(file) is None:
        return _double_crane(file)
    return _planar_crane(file)


def _bends(file: OverheadCrane) -> JointsGroup | None:
    return file.joints or file.cable.joints


def _planar_crane(file: OverheadCrane) -> PlanarCrane:
    n, lengths = len(file.parts.lengths), np.array(file.parts.lengths)
    bends, inertia, hoist = _bends(file), file.cable.inertia, hoist_of(file)
    joints = None
    if bends is not None:
        parts = (fill_list(getattr(bends, name), n, f"joints.{name}") for name in ("stiffness", "damping"))
        joints = Joints(*map(np.array, parts))
    if inertia is not None and isinstance(hoist, MasslessHoist):
        raise SceneError("cable.inertia: links that turn as rods need a hoist with inertia")
    rods = Rods(np.array(fill_list(inertia, n, "cable.inertia"))) if inertia is not None else None
    cable = Chain(np.array(file.parts.masses), lengths)
    trolley = axis_of(file, "trolley")
    return PlanarCrane(trolley, cable, hoist, file.gravity, joints, rods, forces_of(file), make_event_limits(file))


def _rod_crane(file: OverheadCrane) -> RodCrane:
    lengths, masses = np.array(file.parts.lengths), np.array(file.parts.masses)
    distances = np.cumsum(lengths) - lengths[0]
    light = masses[:-1]
    mass, first, second = (float(np.sum(light * distances[:-1] ** k)) for k in range(3)) if len(light) else (0.0,) * 3
    nodes, payload = np.array([masses, distances]), float(masses[-1])
    cable = Line(float(lengths[0]), mass, first, second, payload, float(distances[-1]), nodes)
    trolley = axis_of(file, "trolley")
    return RodCrane(trolley, cable, hoist_of(file), file.gravity, make_event_limits(file))


def _double_crane(file: OverheadCrane) -> DoubleCrane:
    return DoubleCrane(axis_of(file, "trolley"), TwoLinks(*file.parts.masses, *file.parts.lengths), file.gravity)


def _spatial_crane(file: OverheadCrane) -> SpatialCrane:
    for name, group in (("joints", _bends(file)), ("cable.inertia", file.cable.inertia)):
        if group is not None:
            raise SceneError(f"{name}: belongs to 2 dimensions; links in space bend freely and do not turn as rods")
    if file.cable_model == "straight":
        raise SceneError("cable.model = 'straight': belongs to 2 dimensions; 3 take rigid or elastic")
    cable = Chain(np.array(file.parts.masses), np.array(file.parts.lengths))
    return SpatialCrane(
        axis_of(file, "trolley"),
        axis_of(file, "bridge"),
        cable,
        hoist_of(file),
        file.gravity,
        forces_of(file),
        make_event_limits(file),
    )


def _elastic_crane(file: OverheadCrane) -> ElasticCrane | SpringCrane:
    hoist, trolley = hoist_of(file), axis_of(file, "trolley")
    bridge = axis_of(file, "bridge") if file.dimensions == 3 else None
    for name in massless_axes(file):
        raise SceneError(f"{name}.mass = 0: belongs to rigid links; above an elastic cable a {name} has a mass")
    springs, forces, limits = springs_of(file, hoist), forces_of(file), make_event_limits(file)
    alone = len(springs.masses) == 1 and file.dimensions == 2 and hoist is None and forces is None and limits is None
    plain = not (file.base_motion or file.is_windy)
    if alone and plain and not implicit(file.integrator, method_requirements_of(file, sampled=False)):
        cable = (springs.masses, springs.lengths, springs.stiffness, springs.damping)
        return SpringCrane(trolley, Spring(*(float(part[0]) for part in cable)), file.gravity)
    return ElasticCrane(trolley, bridge, springs, hoist, file.gravity, forces, limits)


def springs_of(file: OverheadCrane, hoist: Hoist | None) -> Springs:
    """Return the links of an elastic cable.

    Raises:
        SceneError: what it needs is missing, or there is something that it cannot have.
    """
    group, parts = file.cable, file.parts
    n = len(parts.lengths)
    if group.stiffness is None:
        raise SceneError("cable.stiffness = None: an elastic cable has one, in N/m, for each link or for all")
    if n != (group.links or max(len(group.lengths), len(group.node_masses))):
        raise SceneError("cable.node_masses: every node of an elastic cable has a mass greater than 0")
    for name, value in (("joints", file.joints or group.joints), ("cable.inertia", group.inertia)):
        if value is not None:
            raise SceneError(f"{name}: belongs to rigid links; an elastic cable neither bends nor turns as rods")
    if group.slack == "stop":
        raise SceneError("cable.slack = 'stop': belongs to rigid links; an elastic cable takes tension_only")
    if isinstance(hoist, MasslessHoist):
        raise SceneError("hoist.inertia = 0: the massless winch needs rigid links; give the hoist an inertia")
    stiffness, damping = fill_list(group.stiffness, n, "cable.stiffness"), group.damping or (0.0,)
    damping = fill_list(damping, n, "cable.damping")
    masses, lengths = np.array(parts.masses), np.array(parts.lengths)
    return Springs(masses, lengths, np.array(stiffness), np.array(damping), float(group.tension_only))


def stretched_lengths(file: OverheadCrane, lengths: tuple[float, ...]) -> tuple[float, ...]:
    """Return the lengths [m] of an elastic cable's links of rest lengths (N,) [m] that hang and carry what is below."""
    springs = springs_of(file, hoist_of(file))
    weights = file.gravity * np.cumsum(springs.masses[::-1])[::-1]
    return tuple(np.array(lengths) + weights / springs.stiffness)


def refuse_springs(file: OverheadCrane) -> None:
    """Raise SceneError when a cable that is not elastic has keys of an elastic one."""
    for name in ELASTIC_KEYS:
        if getattr(file.cable, name):
            raise SceneError(f"cable.{name}: belongs to cable.model: elastic, here it is {file.cable_model!r}")


def rail_friction(file: OverheadCrane, name: str) -> Friction | LuGre | None:
    """Return the friction of an axis on its rail, None without one.

    Raises:
        SceneError: the axis has two, or is not driven by force, the cable is elastic, or values do not fit.
    """
    by_events, by_bristles = getattr(file.friction, name, None), getattr(file.lugre, name, None)
    if by_events is None and by_bristles is None:
        return None
    if by_events is not None and by_bristles is not None:
        raise SceneError(f"lugre.{name}: stands beside friction.{name}; a joint has one of the two")
    key, drive = "lugre" if by_events is None else "friction", (getattr(file, name) or AxisGroup(drive="fixed")).drive
    if drive != "force":
        raise SceneError(f"{key}.{name}: belongs to a drive by force, here it is {drive!r}")
    if by_bristles is not None and file.cable_model == "elastic":
        raise SceneError(f"lugre.{name}: belongs to rigid links, here cable.model is 'elastic'")
    return check_friction(f"{key}.{name}", by_events or by_bristles)


def axis_of(file: OverheadCrane, name: str) -> Axis:
    """Return the trolley or the bridge.

    Raises:
        SceneError: mass, motor, friction or motion do not fit the drive.
    """
    group: AxisGroup = getattr(file, name) or AxisGroup(drive="fixed")
    friction, reflected = rail_friction(file, name), axis_motor(file, name)
    motion = group.motion
    _check_shape(f"{name}.motion", motion, group.drive)
    if group.drive == "force":
        if group.mass is None:
            raise SceneError(f"{name}.mass = None: a {name} driven by force has one, which may be 0")
        return ForceAxis(axis_mass(file, name) + reflected, friction)
    return FixedAxis() if motion is None else PrescribedAxis(motion.motion())


def axis_motor(file: OverheadCrane, name: str) -> float:
    """Return the mass [kg] that an axis' motor adds to it.

    Raises:
        SceneError: the motor does not fit the axis, or its axis is on a base that moves.
    """
    reflected = reflected_inertia(file, name)
    if reflected > 0.0 and file.base_motion is not None:
        raise SceneError(f"actuators.{name}.motor.inertia: belongs to a base that rests, here is base_motion")
    return reflected


def _check_shape(name: str, shape: Shape | None, drive: str) -> None:
    if shape is None and drive == "prescribed":
        raise SceneError(f"{name}: is missing, a prescribed drive needs one")
    if shape is not None and drive != "prescribed":
        raise SceneError(f"{name}: belongs to a prescribed drive, here it is {drive!r}")


def hoist_of(file: OverheadCrane) -> Hoist | None:
    """Return the hoist of a scene.

    Raises:
        SceneError: profile or inertia do not fit the drive.
    """
    if file.hoist is None:
        return None
    drive, profile, inertia = file.hoist.drive, file.hoist.profile, file.hoist.inertia
    _check_shape("hoist.profile", profile, drive)
    if profile is not None:
        if inertia is not None:
            raise SceneError(f"hoist.inertia = {inertia}: belongs to a drive by force, here it is {drive!r}")
        return PrescribedHoist(profile.motion())
    friction = drum_friction(file)
    reflected = reflected_inertia(file, "hoist")
    if reflected > 0.0 and not inertia:
        raise SceneError("actuators.hoist.motor.inertia: belongs to a hoist.inertia greater than 0, here is none")
    return ForceHoist(inertia + reflected, friction) if inertia else MasslessHoist(float(file.hoist.push))


def drum_friction(file: OverheadCrane) -> Friction | None:
    """Return the friction of the hoist.

    Raises:
        SceneError: no drum has it, or its values do not fit each other.
    """
    friction = file.friction.hoist if file.friction is not None else None
    if friction is not None and not (file.hoist and file.hoist.drive == "force" and file.hoist.inertia):
        raise SceneError("friction.hoist: belongs to a hoist driven by force with a hoist.inertia, here is none")
    if friction is not None and file.cable_model == "elastic":
        raise SceneError("friction.hoist: belongs to rigid links, here cable.model is 'elastic'")
    return check_friction("friction.hoist", friction)


def forces_of(file: OverheadCrane) -> tuple[NodeForce, ...] | None:
    """Return the forces on nodes, None without any.

    Raises:
        SceneError: no such node, or a force that leaves the plane.
    """
    for i, force in enumerate(file.forces):
        if force.node > len(file.parts.lengths):
            raise SceneError(f"forces[{i}].node = {force.node}: the cable has nodes 1 .. {len(file.parts.lengths)}")
        if force.axis == "y" and file.dimensions == 2:
            raise SceneError(f"forces[{i}].axis = 'y': leaves the plane; 2 dimensions have x and z")
    return tuple(NodeForce(force.node, "xyz".index(force.axis), force.force) for force in file.forces) or None


def make_event_limits(file: OverheadCrane) -> EventLimits | None:
    """Return the conditions that switch the model or end the run, None without any."""
    axes = [group.limits if group is not None else None for group in (file.trolley, file.bridge)]
    hoist = file.hoist.limits if file.hoist is not None else None
    groups = {"friction": file.friction, "lugre": file.lugre}
    has_friction = any(
        check_friction(f"{key}.{name}", part) for key, group in groups.items() for name, part in group or ()
    )
    has_hoist = file.hoist is not None  # a first link that is wound up to nothing ends the run
    switches = has_hoist or has_friction or file.events or file.cable.tension_only or file.is_in_kinked_wind
    if not (any(axes) or switches or file.cable.slack == "stop"):
        return None
    ends = [limits or (-np.inf, np.inf) for limits in axes]
    events = sorted(file.events, key=lambda event: event.at)
    return EventLimits(
        lower=(ends[0][0], ends[1][0]),
        upper=(ends[0][1], ends[1][1]),
        shortest=max(hoist[0], MIN_LENGTH) if hoist else MIN_LENGTH,
        longest=hoist[1] if hoist else np.inf,
        taut=float(file.cable.slack == "stop"),
        times=np.array([event.at for event in events]),
        masses=np.array([file.parts.masses[-1], *(event.set.payload.mass for event in events)]),
    )


def on_base(file: OverheadCrane, crane: Any) -> Any:
    """Return the crane on the scene's base: as it is where the base rests.

    Raises:
        SceneError: the base leaves the plane of a crane in the plane, or its group cannot be used.
    """
    if file.base_motion is None:
        return crane
    base = file.base_motion.base(file.seed, file.duration)
    if file.dimensions == 2:
        _check_plane(base.vessel if isinstance(base, MountedBase) else base)
        _check_mount(file.base_motion.mount)
        return crane._replace(base=base)
    carried, own = file.trolley.mass or 0.0, file.bridge.mass or 0.0 if file.bridge is not None else 0.0
    return crane._replace(base=base, share=carried / (carried + own) if carried + own > 0.0 else 1.0)


def in_wind(file: OverheadCrane, crane: Any) -> Any:
    """Return the crane in the scene's wind: as it is where none presses on its payload.

    Raises:
        SceneError: groups contradict each other.
    """
    wind = file.airflow()
    if wind is None or file.payload is None:
        return crane
    return crane._replace(wind=wind, windage=file.payload.windage)


def _check_plane(base: Base | SplineBase) -> None:
    tables = (base.coefficients,) if isinstance(base, SplineBase) else (base.offsets, base.amplitudes)
    for i, name in enumerate(AXES):
        if name not in IN_PLANE and any(np.any(table[i]) for table in tables):
            raise SceneError(
                f"base_motion: {name} leaves the plane; it takes dimensions: 3; 2 have {', '.join(IN_PLANE)}"
            )


def _check_mount(mount: Mount | None) -> None:
    if mount is not None and (mount.position[1] or mount.roll or mount.yaw):
        raise SceneError("base_motion.mount: leaves the plane; it takes dimensions: 3; 2 have x, z and pitch")


def check_straight(file: OverheadCrane) -> None:
    """Raise SceneError when a straight cable of several nodes hangs on a moving base."""
    if file.base_motion is not None and file.cable_model == "straight" and len(file.parts.lengths) > 1:
        raise SceneError("cable.model = 'straight': needs a base that rests; with base_motion take model: rigid")


def method_requirements_of(file: OverheadCrane, sampled: bool) -> MethodRequirements:
    """Return the scene's requirements on its integration method."""
    smooth = not sampled and make_event_limits(file) is None
    continuous = file.control is not None and file.control.period == "continuous"
    frequency = stiffest(file) if needs_frequency(file.integrator) else None
    swing_angle = file.duration * sqrt(file.gravity / sum(file.parts.lengths))
    return MethodRequirements(frequency, swing_angle, file.cable_model == "elastic", smooth, file.duration, continuous)
