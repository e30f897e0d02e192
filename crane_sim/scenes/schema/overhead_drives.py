"""Trolley, bridge and hoist of an overhead scene: their drives, friction and motors."""

from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.models.supports.bridge import Bridge, BridgeAxis, Fixed
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import ForceHoist, Hoist, MasslessHoist, PrescribedHoist
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.supports.rails import Axis, FixedAxis, ForceAxis, PrescribedAxis
from crane_sim.models.supports.support import Support
from crane_sim.scenes.schema.axes import AxisGroup, check_shape
from crane_sim.scenes.schema.friction_checks import check_friction
from crane_sim.scenes.schema.motors import reflected_inertia
from crane_sim.scenes.schema.overhead_cable import OverheadCrane
from crane_sim.scenes.schema.overhead_stiffness import axis_mass


def support_of(file: OverheadCrane) -> Support:
    """Return the support of a crane that is not a closed form: trolley and, in 3D, bridge.

    Raises:
        SceneError: as of `axis_of`.
    """
    names = file.axes
    motors, frictions = (
        [axis_motor(file, name) for name in names],
        [rail_friction(file, name) for name in names],
    )
    return Support(
        Bridge(
            *(
                BridgeAxis(mass, _limits(file, name), _motion(file, name))
                for name, mass in _own_masses(file)
            )
        ),
        tuple(motors) if any(motors) else None,
        tuple(frictions) if any(friction is not None for friction in frictions) else None,
    )


def _own_masses(file: OverheadCrane) -> list[tuple[str, float]]:
    """Return (name, mass [kg] without what it carries) of trolley and bridge."""
    trolley = (
        axis_mass(file, "trolley") if file.trolley.drive == "force" else file.trolley.mass or 0.0
    )
    masses = [("trolley", trolley)]
    if file.dimensions == 3:
        own = file.bridge.mass or 0.0 if file.bridge is not None else 0.0
        alone = file.bridge is not None and file.bridge.drive == "force" and not trolley + own > 0.0
        masses.append(("bridge", axis_mass(file, "bridge") if alone else own))
    return masses


def _limits(file: OverheadCrane, name: str) -> tuple[float, float] | None:
    group = getattr(file, name)
    return None if group is None else group.limits


def _motion(file: OverheadCrane, name: str) -> Any:
    """Return the motion of an axis as of `BridgeAxis`."""
    axis = axis_of(file, name)
    if isinstance(axis, ForceAxis):
        return None
    return axis.motion if isinstance(axis, PrescribedAxis) else Fixed()


def rail_friction(file: OverheadCrane, name: str) -> Friction | LuGre | None:
    """Return the friction of an axis on its rail, None without one.

    Raises:
        SceneError: the axis has two, or is not driven by force, the cable is elastic, or values do
            not fit.
    """
    by_events, by_bristles = getattr(file.friction, name, None), getattr(file.lugre, name, None)
    if by_events is None and by_bristles is None:
        return None
    if by_events is not None and by_bristles is not None:
        raise SceneError(f"lugre.{name}: stands beside friction.{name}; a joint has one of the two")
    key, drive = (
        "lugre" if by_events is None else "friction",
        (getattr(file, name) or AxisGroup(drive="fixed")).drive,
    )
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
    check_shape(f"{name}.motion", motion, group.drive)
    if group.drive == "force":
        if group.mass is None:
            raise SceneError(
                f"{name}.mass = None: a {name} driven by force has one, which may be 0"
            )
        return ForceAxis(axis_mass(file, name) + reflected, friction)
    return FixedAxis() if motion is None else PrescribedAxis(motion.motion())


def axis_motor(file: OverheadCrane, name: str) -> float:
    """Return the mass [kg] that an axis' motor adds to it.

    Raises:
        SceneError: the motor does not fit the axis, or its axis is on a base that moves.
    """
    reflected = reflected_inertia(file, name)
    on_rails = file.dimensions == 2 and file.cable_model != "elastic"
    if reflected > 0.0 and file.base_motion is not None and on_rails:
        raise SceneError(
            f"actuators.{name}.motor.inertia: belongs to a base that rests, here is base_motion"
        )
    return reflected


def hoist_of(file: OverheadCrane) -> Hoist | None:
    """Return the hoist of a scene.

    Raises:
        SceneError: profile or inertia do not fit the drive.
    """
    if file.hoist is None:
        return None
    drive, profile, inertia = file.hoist.drive, file.hoist.profile, file.hoist.inertia
    check_shape("hoist.profile", profile, drive)
    if profile is not None:
        if inertia is not None:
            raise SceneError(
                f"hoist.inertia = {inertia}: belongs to a drive by force, here it is {drive!r}"
            )
        return PrescribedHoist(profile.motion())
    friction = drum_friction(file)
    reflected = reflected_inertia(file, "hoist")
    if reflected > 0.0 and not inertia:
        raise SceneError(
            "actuators.hoist.motor.inertia: belongs to a hoist.inertia greater than 0, here is none"
        )
    return (
        ForceHoist(inertia + reflected, friction)
        if inertia
        else MasslessHoist(float(file.hoist.push))
    )


def drum_friction(file: OverheadCrane) -> Friction | None:
    """Return the friction of the hoist.

    Raises:
        SceneError: no drum has it, or its values do not fit each other.
    """
    friction = file.friction.hoist if file.friction is not None else None
    if friction is not None and not (
        file.hoist and file.hoist.drive == "force" and file.hoist.inertia
    ):
        raise SceneError(
            "friction.hoist: belongs to a hoist driven by force with a hoist.inertia, here is none"
        )
    return check_friction("friction.hoist", friction)
