"""Which model an overhead scene is, and its parameters."""

from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.explain import SceneError
from crane_sim.forms.method_choice import implicit
from crane_sim.forms.overhead_elastic import refuse_springs, springs_of
from crane_sim.forms.overhead_groups import AxisGroup, FrictionGroup, JointsGroup
from crane_sim.forms.overhead_start import filled
from crane_sim.overhead import base_energies as _base_energies  # noqa: F401  registers what the models answer
from crane_sim.overhead import elastic_linear as _springs  # noqa: F401
from crane_sim.overhead import elastic_modes as _elastic  # noqa: F401
from crane_sim.overhead import planar_modes as _planar  # noqa: F401
from crane_sim.overhead import rod_outputs as _rod  # noqa: F401
from crane_sim.overhead import rods as _rods  # noqa: F401
from crane_sim.overhead import spatial_modes as _spatial  # noqa: F401
from crane_sim.overhead.axes import Axis, FixedAxis, ForceAxis, Friction, PrescribedAxis
from crane_sim.overhead.chain import Chain, Rods
from crane_sim.overhead.double import DoubleCrane, Pair
from crane_sim.overhead.elastic import ElasticCrane
from crane_sim.overhead.forces import NodeForces
from crane_sim.overhead.hoists import ForceHoist, Hoist, MasslessHoist, PrescribedHoist
from crane_sim.overhead.joints import Joints
from crane_sim.overhead.motions import Shape
from crane_sim.overhead.planar import PlanarCrane
from crane_sim.overhead.rod import Line, RodCrane
from crane_sim.overhead.spatial import SpatialCrane
from crane_sim.overhead.spring import Spring, SpringCrane
from crane_sim.overhead.switches import Switches
from crane_sim.stops import SHORTEST

if TYPE_CHECKING:
    from crane_sim.forms.overhead import OverheadFile


def crane_of(file: "OverheadFile") -> Any:
    """Return the parameters of a scene's crane, its base at rest; their type chooses the equations.

    Raises:
        SceneError: groups contradict each other.
    """
    if file.modelled == "elastic":
        return _elastic_crane(file)
    refuse_springs(file)
    if file.dimensions == 3:
        return _spatial_crane(file)
    plain = not (_bends(file) or file.cable.inertia or file.forces)
    if file.modelled == "straight" or (len(file.parts.lengths) == 1 and plain):
        if not plain:
            raise SceneError("cable.model = 'straight': takes neither joints nor inertia nor forces on nodes")
        return _planar_crane(file) if file.base_motion else _rod_crane(file)
    if len(file.parts.lengths) == 2 and plain and not file.base_motion and switches_of(file) is None:
        return _double_crane(file)
    return _planar_crane(file)


def _bends(file: "OverheadFile") -> JointsGroup | None:
    return file.joints or file.cable.joints


def _planar_crane(file: "OverheadFile") -> PlanarCrane:
    n, lengths = len(file.parts.lengths), np.array(file.parts.lengths)
    bends, inertia, hoist = _bends(file), file.cable.inertia, hoist_of(file)
    joints = None
    if bends is not None:
        parts = (filled(getattr(bends, name), n, f"joints.{name}") for name in ("stiffness", "damping"))
        joints = Joints(*map(np.array, parts))
    if inertia is not None and isinstance(hoist, MasslessHoist):
        raise SceneError("cable.inertia: links that turn as rods need a hoist with inertia")
    rods = Rods(np.array(filled(inertia, n, "cable.inertia"))) if inertia is not None else None
    cable = Chain(np.array(file.parts.masses), lengths)
    trolley = axis_of("trolley", file.trolley, 0.0, file.friction.trolley if file.friction else None)
    return PlanarCrane(trolley, cable, hoist, file.gravity, joints, rods, forces_of(file), switches_of(file))


def _rod_crane(file: "OverheadFile") -> RodCrane:
    lengths, masses = np.array(file.parts.lengths), np.array(file.parts.masses)
    distances = np.cumsum(lengths) - lengths[0]
    light = masses[:-1]
    mass, first, second = (float(np.sum(light * distances[:-1] ** k)) for k in range(3))
    nodes, payload = np.stack([masses, distances]), float(masses[-1])
    cable = Line(float(lengths[0]), mass, first, second, payload, float(distances[-1]), nodes)
    trolley = axis_of("trolley", file.trolley, 0.0, file.friction.trolley if file.friction else None)
    return RodCrane(trolley, cable, hoist_of(file), file.gravity, switches_of(file))


def _double_crane(file: "OverheadFile") -> DoubleCrane:
    return DoubleCrane(
        axis_of("trolley", file.trolley, 0.0, None), Pair(*file.parts.masses, *file.parts.lengths), file.gravity
    )


def _spatial_crane(file: "OverheadFile") -> SpatialCrane:
    for name, group in (("joints", _bends(file)), ("cable.inertia", file.cable.inertia)):
        if group is not None:
            raise SceneError(f"{name}: belongs to 2 dimensions; links in space bend freely and do not turn as rods")
    if file.modelled == "straight":
        raise SceneError("cable.model = 'straight': belongs to 2 dimensions; 3 take rigid or elastic")
    cable = Chain(np.array(file.parts.masses), np.array(file.parts.lengths))
    rubs, carried = file.friction or FrictionGroup(), file.trolley.mass or 0.0
    trolley = axis_of("trolley", file.trolley, 0.0, rubs.trolley)
    bridge = axis_of("bridge", file.bridge, carried, rubs.bridge)
    return SpatialCrane(trolley, bridge, cable, hoist_of(file), file.gravity, forces_of(file), switches_of(file))


def _elastic_crane(file: "OverheadFile") -> ElasticCrane | SpringCrane:
    hoist, rubs, bridge = hoist_of(file), file.friction or FrictionGroup(), None
    trolley = axis_of("trolley", file.trolley, 0.0, rubs.trolley)
    if file.dimensions == 3:
        bridge = axis_of("bridge", file.bridge, file.trolley.mass or 0.0, rubs.bridge)
    springs, forces, switches = springs_of(file, hoist), forces_of(file), switches_of(file)
    alone = len(springs.masses) == 1 and file.dimensions == 2 and hoist is None and forces is None and switches is None
    if alone and not file.base_motion and not implicit(file.integrator, file.demands(sampled=False)):
        cable = (springs.masses, springs.lengths, springs.stiffness, springs.damping)
        return SpringCrane(trolley, Spring(*(float(part[0]) for part in cable)), file.gravity)
    return ElasticCrane(trolley, bridge, springs, hoist, file.gravity, forces, switches)


def axis_of(name: str, group: AxisGroup | None, carried: float, friction: Friction | None) -> Axis:
    """Return an axis that also moves the mass `carried` [kg].

    Raises:
        SceneError: mass, motion or friction do not fit the drive.
    """
    group = group or AxisGroup(drive="fixed")
    drive, mass, motion = group.drive, group.mass, group.motion
    _check_shape(f"{name}.motion", motion, drive)
    if friction is not None and drive != "force":
        raise SceneError(f"friction.{name}: belongs to a drive by force, here it is {drive!r}")
    if friction is not None and friction.static < friction.coulomb:
        raise SceneError(f"friction.{name}.static = {friction.static}: must be at least coulomb = {friction.coulomb}")
    if drive == "force":
        if mass is None or not mass + carried > 0.0:
            raise SceneError(
                f"{name}.mass = {mass}: a {name} driven by force has one; with what it carries, greater than 0"
            )
        return ForceAxis(mass + carried, friction)
    return FixedAxis() if motion is None else PrescribedAxis(motion.motion())


def _check_shape(name: str, shape: Shape | None, drive: str) -> None:
    if shape is None and drive == "prescribed":
        raise SceneError(f"{name}: is missing, a prescribed drive needs one")
    if shape is not None and drive != "prescribed":
        raise SceneError(f"{name}: belongs to a prescribed drive, here it is {drive!r}")


def hoist_of(file: "OverheadFile") -> Hoist | None:
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
    push = float(file.hoist.push)
    return ForceHoist(inertia, push) if inertia else MasslessHoist(push)


def forces_of(file: "OverheadFile") -> NodeForces | None:
    """Return the forces on nodes as the list that kernels walk.

    Raises:
        SceneError: no such node, or a force that leaves the plane.
    """
    found = None
    for i, force in reversed(list(enumerate(file.forces))):
        if force.node > len(file.parts.lengths):
            raise SceneError(f"forces[{i}].node = {force.node}: the cable has nodes 1 .. {len(file.parts.lengths)}")
        if force.axis == "y" and file.dimensions == 2:
            raise SceneError(f"forces[{i}].axis = 'y': leaves the plane; 2 dimensions have x and z")
        found = NodeForces(force.node, "xyz".index(force.axis), force.force, found)
    return found


def switches_of(file: "OverheadFile") -> Switches | None:
    """Return what can switch or end the run, None when nothing can."""
    axes = [group.limits if group is not None else None for group in (file.trolley, file.bridge)]
    hoist = file.hoist.limits if file.hoist is not None else None
    rubs = file.friction is not None and (file.friction.trolley or file.friction.bridge)
    winds = file.hoist is not None  # a first link that is wound up to nothing ends the run
    if not (any(axes) or winds or rubs or file.events or file.cable.slack == "stop" or file.cable.tension_only):
        return None
    ends = [limits or (-np.inf, np.inf) for limits in axes]
    events = sorted(file.events, key=lambda event: event.at)
    return Switches(
        lower=(ends[0][0], ends[1][0]),
        upper=(ends[0][1], ends[1][1]),
        shortest=max(hoist[0], SHORTEST) if hoist else SHORTEST,
        longest=hoist[1] if hoist else np.inf,
        taut=float(file.cable.slack == "stop"),
        times=np.array([event.at for event in events]),
        masses=np.array([file.parts.masses[-1], *(event.set.payload.mass for event in events)]),
    )
