"""The model that `crane_of` chooses for an overhead scene, its parameters, and its base."""

from math import sqrt
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.models.cables.chain import Chain, Joints, Rods, make_chain
from crane_sim.models.carrier.exchange import COLUMNS, Exchange
from crane_sim.models.effects import NodeForce, PayloadForce
from crane_sim.models.elastic.crane import ElasticCrane, Slack, Springs
from crane_sim.models.loads import PointLoad
from crane_sim.models.overhead.double import DoubleCrane, TwoLinks
from crane_sim.models.overhead.events import EventLimits
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import Line, RodCrane
from crane_sim.models.overhead.spring import Spring, SpringCrane
from crane_sim.models.stops import MIN_LENGTH, Stops
from crane_sim.models.supports.hoist import Hoist, MasslessHoist
from crane_sim.models.suspended.crane import OverheadJoints, SuspendedCrane
from crane_sim.models.wind_load import Windage
from crane_sim.scenes.schema.base_motion import Mount
from crane_sim.scenes.schema.exchange import NO_WINDAGE, REST, order_of
from crane_sim.scenes.schema.friction_checks import check_friction
from crane_sim.scenes.schema.integrator import MethodRequirements, implicit, needs_frequency
from crane_sim.scenes.schema.overhead_cable import OverheadCrane, fill_list
from crane_sim.scenes.schema.overhead_drives import axis_of, hoist_of, support_of
from crane_sim.scenes.schema.overhead_groups import JointsGroup
from crane_sim.scenes.schema.overhead_stiffness import massless_axes, stiffest
from crane_sim.trajectories.base_motion import AXES, AnyBase, Base, MountedBase, SplineBase
from crane_sim.trajectories.wind import Wind

IN_PLANE = ("surge", "heave", "pitch")  # motions of a base that keep a crane in its plane
ELASTIC_KEYS = ("stiffness", "damping", "tension_only")  # of a cable: only an elastic one has them


def crane_of(file: OverheadCrane) -> Any:
    """Return the parameters of a scene's crane; their type chooses the equations.

    The first row that applies; `plain`: no joints, no inertia of links, no forces on nodes or
    payload; `steady`: nothing that switches or ends the run (friction, limits, hoist, events,
    slack); links: after massless nodes are merged.

    | cable    | dimensions | links | base  | besides                                       | model          |
    |----------|------------|-------|-------|-----------------------------------------------|----------------|
    | elastic  | 2          | 1     | rests | plain, no hoist, steady, explicit method      | `SpringCrane`  |
    | elastic  | 2 or 3     | any   | any   |                                               | `ElasticCrane` |
    | rigid    | 3          | any   | any   |                                               | `SuspendedCrane` |
    | straight | 2          | any   | rests | plain                                         | `RodCrane`     |
    | rigid    | 2          | 1     | rests | plain                                         | `RodCrane`     |
    | rigid    | 2          | 2     | rests | plain, steady                                 | `DoubleCrane`  |
    | any      | 2          | any   | any   |                                               | `PlanarCrane`  |

    Raises:
        SceneError: groups contradict each other.
    """  # noqa: E501
    if file.cable_model == "elastic":
        return _elastic_crane(file)
    refuse_springs(file)
    if file.dimensions == 3:
        return _suspended_crane(file)
    for i, event in enumerate(file.events):
        if event.velocity is not None:
            raise SceneError(
                f"events[{i}].velocity: takes 3 dimensions or an elastic cable; here the payload's "
                "holds"
            )
    straight = file.cable_model == "straight"
    links = len(file.parts.lengths)
    rests = file.base_motion is None
    plain = not (_bends(file) or file.cable.inertia or file.pushes_nodes)
    if straight and not plain:
        raise SceneError(
            "cable.model = 'straight': takes neither joints nor inertia nor forces nor wind"
        )
    if (straight or links == 1) and plain and rests:
        return _rod_crane(file)
    if links == 2 and plain and rests and make_event_limits(file) is None:
        return _double_crane(file)
    return _planar_crane(file)


def _bends(file: OverheadCrane) -> JointsGroup | None:
    return file.joints or file.cable.joints


def _planar_crane(file: OverheadCrane) -> PlanarCrane:
    n = len(file.parts.lengths)
    inertia, hoist = file.cable.inertia, hoist_of(file)
    if inertia is not None and isinstance(hoist, MasslessHoist):
        raise SceneError("cable.inertia: links that turn as rods need a hoist with inertia")
    rods = Rods(np.array(fill_list(inertia, n, "cable.inertia"))) if inertia is not None else None
    cable = make_chain(file.parts.masses, file.parts.lengths)
    trolley, (wind, windage) = axis_of(file, "trolley"), _wind_of(file)
    return PlanarCrane(
        trolley,
        cable,
        hoist,
        file.gravity,
        _joints_of(file, n),
        rods,
        forces_of(file),
        make_event_limits(file),
        base=_base_of(file),
        wind=wind,
        windage=windage,
        drag=file.payload_drag,
        force=_force_of(file),
    )


def _joints_of(file: OverheadCrane, n: int) -> Joints | None:
    """Return the joints between n links, None where nothing resists their bending."""
    bends = _bends(file)
    if bends is None:
        return None
    parts = (
        fill_list(getattr(bends, name), n, f"joints.{name}") for name in ("stiffness", "damping")
    )
    return Joints(*map(np.array, parts))


def _rod_crane(file: OverheadCrane) -> RodCrane:
    lengths, masses = np.array(file.parts.lengths), np.array(file.parts.masses)
    distances = np.cumsum(lengths) - lengths[0]
    light = masses[:-1]
    mass, first, second = (
        (float(np.sum(light * distances[:-1] ** k)) for k in range(3)) if len(light) else (0.0,) * 3
    )
    nodes, payload = np.array([masses, distances]), float(masses[-1])
    cable = Line(float(lengths[0]), mass, first, second, payload, float(distances[-1]), nodes)
    trolley = axis_of(file, "trolley")
    return RodCrane(trolley, cable, hoist_of(file), file.gravity, make_event_limits(file))


def _double_crane(file: OverheadCrane) -> DoubleCrane:
    return DoubleCrane(
        axis_of(file, "trolley"), TwoLinks(*file.parts.masses, *file.parts.lengths), file.gravity
    )


def _suspended_crane(file: OverheadCrane) -> SuspendedCrane:
    for name, group in (("joints", _bends(file)), ("cable.inertia", file.cable.inertia)):
        if group is not None:
            raise SceneError(
                f"{name}: belongs to 2 dimensions; links in space bend freely and do not turn as "
                "rods"
            )
    if file.cable_model == "straight":
        raise SceneError(
            "cable.model = 'straight': belongs to 2 dimensions; 3 take rigid or elastic"
        )
    cable = Chain(np.array(file.parts.masses), np.array(file.parts.lengths))
    return SuspendedCrane(
        support_of(file), cable, hoist=hoist_of(file), gravity=file.gravity, **_hanging_parts(file)
    )


def _elastic_crane(file: OverheadCrane) -> ElasticCrane | SpringCrane:
    hoist = hoist_of(file)
    for name in massless_axes(file):
        raise SceneError(
            f"{name}.mass = 0: belongs to rigid links; above an elastic cable a {name} has a mass"
        )
    springs, parts = springs_of(file, hoist), _hanging_parts(file)
    alone = len(springs.masses) == 1 and file.dimensions == 2 and hoist is None
    plain = all(
        parts[name] is None for name in ("forces", "stops", "base", "wind", "drag", "force")
    )
    if alone and plain and not implicit(file.integrator, requirements_of(file)):
        cable = (springs.masses, springs.lengths, springs.stiffness, springs.damping)
        return SpringCrane(
            axis_of(file, "trolley"), Spring(*(float(part[0]) for part in cable)), file.gravity
        )
    return ElasticCrane(support_of(file), springs, hoist=hoist, gravity=file.gravity, **parts)


def _hanging_parts(file: OverheadCrane) -> dict[str, Any]:
    """Return what cranes with a support have besides support, cable and hoist."""
    limits, (wind, windage) = make_event_limits(file), _wind_of(file)
    return {
        "load": PointLoad(float(file.parts.masses[-1]), windage),
        "base": _base_of(file),
        "wind": wind,
        "drag": file.payload_drag,
        "force": _force_of(file),
        "forces": forces_of(file),
        "stops": None if limits is None else limits.stops,
        "exchange": _exchange_of(file, limits, windage)
        if limits is not None and file.events
        else None,
        "overhead": OverheadJoints(),
    }


def _exchange_of(file: OverheadCrane, limits: EventLimits, windage: Windage | None) -> Exchange:
    """Return the changes of the payload; a load taken up moves with it unless told otherwise."""
    n, order = len(limits.times), order_of(file.events)
    given = [file.events[i].velocity for i in order]
    for k, (i, velocity) in enumerate(zip(order, given, strict=True)):
        if velocity is not None and not limits.masses[k + 1] > limits.masses[k]:
            raise SceneError(
                f"events[{i}].velocity: belongs to what is taken up; what is let go keeps its "
                "velocity"
            )
    carried = [velocity is None or velocity == "hook" for velocity in given]
    return Exchange(
        limits.times,
        velocities=np.array(
            [REST if own else v for own, v in zip(carried, given, strict=True)], dtype=float
        ),
        carried=np.array(carried, dtype=float),
        masses=limits.masses,
        bodies=np.zeros((n + 1, COLUMNS)),
        windages=np.tile(np.array(windage or NO_WINDAGE), (n + 1, 1)),
    )


def springs_of(file: OverheadCrane, hoist: Hoist | None) -> Springs:
    """Return the links of an elastic cable.

    Raises:
        SceneError: what it needs is missing, or there is something that it cannot have.
    """
    group, parts = file.cable, file.parts
    n = len(parts.lengths)
    if group.stiffness is None:
        raise SceneError(
            "cable.stiffness = None: an elastic cable has one, in N/m, for each link or for all"
        )
    if n != (group.links or max(len(group.lengths), len(group.node_masses))):
        raise SceneError(
            "cable.node_masses: every node of an elastic cable has a mass greater than 0"
        )
    _refuse_rigid_links(file, hoist)
    stiffness = fill_list(group.stiffness, n, "cable.stiffness")
    damping = fill_list(group.damping or (0.0,), n, "cable.damping")
    masses, lengths = np.array(parts.masses), np.array(parts.lengths)
    slack = Slack() if group.tension_only else None
    return Springs(masses, lengths, np.array(stiffness), np.array(damping), slack)


def _refuse_rigid_links(file: OverheadCrane, hoist: Hoist | None) -> None:
    """Raise SceneError for what an elastic cable cannot have."""
    cable = file.cable
    for name, value in (("joints", _bends(file)), ("cable.inertia", cable.inertia)):
        if value is not None:
            raise SceneError(
                f"{name}: belongs to rigid links; an elastic cable neither bends nor turns as rods"
            )
    if cable.slack == "stop":
        raise SceneError(
            "cable.slack = 'stop': belongs to rigid links; an elastic cable takes tension_only"
        )
    if isinstance(hoist, MasslessHoist):
        raise SceneError(
            "hoist.inertia = 0: the massless winch needs rigid links; give the hoist an inertia"
        )


def stretched_lengths(file: OverheadCrane, lengths: tuple[float, ...]) -> tuple[float, ...]:
    """Return the lengths [m] of an elastic cable's hanging links of rest lengths (N,) [m]."""
    springs = springs_of(file, hoist_of(file))
    weights = file.gravity * np.cumsum(springs.masses[::-1])[::-1]
    return tuple(np.array(lengths) + weights / springs.stiffness)


def refuse_springs(file: OverheadCrane) -> None:
    """Raise SceneError when a cable that is not elastic has keys of an elastic one."""
    for name in ELASTIC_KEYS:
        if getattr(file.cable, name):
            raise SceneError(
                f"cable.{name}: belongs to cable.model: elastic, here it is {file.cable_model!r}"
            )


def forces_of(file: OverheadCrane) -> tuple[NodeForce, ...] | None:
    """Return the forces on nodes, None without any.

    Raises:
        SceneError: no such node, or a force that leaves the plane.
    """
    for i, force in enumerate(file.forces):
        if force.node > len(file.parts.lengths):
            raise SceneError(
                f"forces[{i}].node = {force.node}: the cable has nodes 1 .. "
                f"{len(file.parts.lengths)}"
            )
        if force.axis == "y" and file.dimensions == 2:
            raise SceneError(f"forces[{i}].axis = 'y': leaves the plane; 2 dimensions have x and z")
    return (
        tuple(NodeForce(force.node, "xyz".index(force.axis), force.force) for force in file.forces)
        or None
    )


def make_event_limits(file: OverheadCrane) -> EventLimits | None:
    """Return the conditions that switch the model or end the run, None without any."""
    axes = [group.limits if group is not None else None for group in (file.trolley, file.bridge)]
    hoist = file.hoist.limits if file.hoist is not None else None
    has_friction = _has_friction(file)
    has_hoist = file.hoist is not None  # a first link that is wound up to nothing ends the run
    switches = (
        has_hoist
        or has_friction
        or file.events
        or file.cable.tension_only
        or file.is_in_kinked_wind
    )
    if not (any(axes) or switches or file.cable.slack == "stop"):
        return None
    trolley = axes[0] or (-np.inf, np.inf)
    events = sorted(file.events, key=lambda event: event.at)
    least = MIN_LENGTH if has_hoist else 0.0
    shortest, longest = hoist or (least, np.inf)
    return EventLimits(
        trolley,
        Stops(max(shortest, least), longest, taut=float(file.cable.slack == "stop")),
        times=np.array([event.at for event in events]),
        masses=np.array([file.parts.masses[-1], *(event.set.payload.mass for event in events)]),
    )


def _has_friction(file: OverheadCrane) -> bool:
    groups = {"friction": file.friction, "lugre": file.lugre}
    return any(
        check_friction(f"{key}.{name}", part)
        for key, group in groups.items()
        for name, part in group or ()
    )


def _base_of(file: OverheadCrane) -> AnyBase | None:
    """Return the motion of the scene's base, None where it rests.

    Raises:
        SceneError: the base leaves the plane of a crane in the plane, or its group cannot be used.
    """
    if file.base_motion is None:
        return None
    base = file.base_motion.base(file.seed, file.duration)
    if file.dimensions == 2:
        _check_plane(base.vessel if isinstance(base, MountedBase) else base)
        _check_mount(file.base_motion.mount)
    return base


def _force_of(file: OverheadCrane) -> PayloadForce | None:
    """Return the given force on the payload, None without one."""
    return None if file.payload_force is None else file.payload_force.force()


def _wind_of(file: OverheadCrane) -> tuple[Wind | None, Windage | None]:
    """Return the wind and the payload's windage, None where no wind presses on it.

    Raises:
        SceneError: groups contradict each other.
    """
    wind = file.airflow()
    return (None, None) if wind is None or file.payload is None else (wind, file.payload.windage)


def _check_plane(base: Base | SplineBase) -> None:
    tables = (
        (base.coefficients,) if isinstance(base, SplineBase) else (base.offsets, base.amplitudes)
    )
    for i, name in enumerate(AXES):
        if name not in IN_PLANE and any(np.any(table[i]) for table in tables):
            raise SceneError(
                f"base_motion: {name} leaves the plane; it takes dimensions: 3; 2 have "
                f"{', '.join(IN_PLANE)}"
            )


def _check_mount(mount: Mount | None) -> None:
    if mount is not None and (mount.position[1] or mount.roll or mount.yaw):
        raise SceneError(
            "base_motion.mount: leaves the plane; it takes dimensions: 3; 2 have x, z and pitch"
        )


def check_straight(file: OverheadCrane) -> None:
    """Raise SceneError when a straight cable of several nodes hangs on a moving base."""
    if (
        file.base_motion is not None
        and file.cable_model == "straight"
        and len(file.parts.lengths) > 1
    ):
        raise SceneError(
            "cable.model = 'straight': needs a base that rests; with base_motion take model: rigid"
        )


def requirements_of(file: OverheadCrane) -> MethodRequirements:
    """Return the scene's requirements on its integration method."""
    smooth = not (file.is_sampled or file.payload_drag) and make_event_limits(file) is None
    continuous = file.control is not None and not file.is_sampled
    frequency = stiffest(file) if needs_frequency(file.integrator) else None
    swing_angle = file.duration * sqrt(file.gravity / sum(file.parts.lengths))
    return MethodRequirements(
        frequency, swing_angle, file.cable_model == "elastic", smooth, file.duration, continuous
    )
