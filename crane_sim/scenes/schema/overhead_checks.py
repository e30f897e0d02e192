"""Cross-field validation of overhead scenes: groups in contradiction or without effect."""

from crane_sim.files.errors import SceneError
from crane_sim.scenes.schema.axes import AxisGroup, check_finite, check_mass
from crane_sim.scenes.schema.overhead_cable import OverheadCrane, fill_list
from crane_sim.scenes.schema.overhead_drives import drum_friction
from crane_sim.scenes.schema.overhead_models import check_straight

# relative; largest difference of the first link's length from the start of its hoist's profile
LENGTH_TOLERANCE = 1e-9


def check_groups(file: OverheadCrane) -> None:
    """Raise SceneError when groups of a scene contradict each other or would be ignored."""
    _check_plane(file)
    for name, group in (
        ("trolley", file.trolley),
        ("bridge", file.bridge or AxisGroup(drive="fixed")),
    ):
        _check_axis(file, name, group)
    _check_cable(file)
    _check_massless(file)
    _check_nodes(file)
    _check_hoist(file)
    _check_inputs(file)
    check_straight(file)


def check_start(file: OverheadCrane) -> None:
    """Raise SceneError when a hoist starts where its cable does not."""
    q = file.initial_q
    if file.hoist is None:
        return
    length, first = q[len(file.axes)], file.parts.lengths[0]
    if file.hoist.profile is not None and length <= 0.0:
        raise SceneError(f"hoist.profile: starts at {length:g} m, must start greater than 0")
    if file.hoist.profile is not None and abs(length - first) > LENGTH_TOLERANCE * first:
        raise SceneError(
            f"cable.lengths[0] = {first}: hoist.profile starts at {length!r} m; both must be the "
            "same"
        )


def _check_plane(file: OverheadCrane) -> None:
    """Reject groups that do not exist in 2 dimensions."""
    if file.dimensions == 3:
        return
    if file.bridge is not None:
        raise SceneError("bridge: belongs to 3 dimensions, here are 2")
    for key, group in (("friction", file.friction), ("lugre", file.lugre)):
        if group is not None and group.bridge is not None:
            raise SceneError(f"{key}.bridge: belongs to 3 dimensions, here are 2")
    if file.inputs is not None and "bridge" in file.inputs.model_fields_set:
        raise SceneError("inputs.bridge: belongs to 3 dimensions, here are 2")
    if file.payload_force is not None and "y" in file.payload_force.model_fields_set:
        raise SceneError("payload_force.y: leaves the plane; 2 dimensions have x and z")
    for name in ("y", "vy"):
        if name in file.initial.model_fields_set:
            raise SceneError(
                f"initial.{name} = {getattr(file.initial, name)}: belongs to 3 dimensions, here "
                "are 2"
            )


def _check_axis(file: OverheadCrane, name: str, group: AxisGroup) -> None:
    """Reject settings of an axis that is not driven by a force."""
    position, speed = ("x", "v") if name == "trolley" else ("y", "vy")
    start, drive = file.initial, group.drive
    carried = name == "trolley" and file.bridge is not None and file.bridge.drive == "force"
    check_mass(name, group, carried)
    if drive == "fixed" and getattr(start, speed) != 0.0:
        raise SceneError(
            f"initial.{speed} = {getattr(start, speed)}: a fixed {name} is at rest; must be 0"
        )
    for key in (position, speed):
        if drive == "prescribed" and key in start.model_fields_set:
            raise SceneError(
                f"initial.{key} = {getattr(start, key)}: a prescribed {name} starts as "
                f"{name}.motion does"
            )
    check_finite(f"{name}.motion", group.motion)


def _check_cable(file: OverheadCrane) -> None:
    """Reject two groups of joints, and empty lists of the initial state."""
    if file.joints is not None and file.cable.joints is not None:
        raise SceneError("joints: stand also in cable.joints; leave out one of the two")
    for name in ("angles", "directions", "positions", "velocities"):
        if getattr(file.initial, name) == ():
            raise SceneError(f"initial.{name} = []: must have at least one entry, or be left out")


def _check_massless(file: OverheadCrane) -> None:
    """Reject links of zero mass, which are merged, together with settings by link."""
    users = {
        "hoist": file.hoist,
        "forces": file.forces or None,
        "joints": file.joints or file.cable.joints,
        "cable.inertia": file.cable.inertia,
    }
    used = [name for name, group in users.items() if group is not None]
    group = file.cable
    n = group.links or max(len(group.lengths), len(group.node_masses))
    upper_masses = fill_list(group.node_masses, n, "cable.node_masses")[:-1]
    massless = next((k for k, mass in enumerate(upper_masses, 1) if mass == 0.0), 0)
    if used and massless:
        raise SceneError(
            f"cable.node_masses: node {massless} has no mass, which is not possible with "
            f"{used[0]}; give it a mass"
        )


def _check_nodes(file: OverheadCrane) -> None:
    """Reject positions of nodes if links have angles or directions, and the other way round."""
    start = file.initial
    for name in ("positions", "velocities"):
        if getattr(start, name) is not None and file.cable_model != "elastic":
            raise SceneError(
                f"initial.{name}: belong to cable.model: elastic, here it is {file.cable_model!r}"
            )
    for name in ("angles", "directions", "rates"):
        if start.positions is not None and getattr(start, name) is not None:
            raise SceneError(
                f"initial.{name}: say the same as initial.positions; leave out one of the two"
            )


def _check_hoist(file: OverheadCrane) -> None:
    """Reject an initial state of a hoist that is not driven by a force."""
    drive = file.hoist.drive if file.hoist is not None else None
    for name in ("length", "length_rate"):
        if (
            name in file.initial.model_fields_set
            and getattr(file.initial, name) is not None
            and drive != "force"
        ):
            raise SceneError(
                f"initial.{name} = {getattr(file.initial, name)}: belongs to a hoist driven by "
                "force, "
                f"here is {'none' if drive is None else f'a {drive} one'}"
            )
    if file.hoist is not None and file.hoist.push and drive != "force":
        raise SceneError(f"hoist.push = True: belongs to a drive by force, here it is {drive!r}")
    if file.hoist is not None:
        check_finite("hoist.profile", file.hoist.profile)
    drum_friction(file)


def _check_inputs(file: OverheadCrane) -> None:
    """Reject inputs without effect."""
    for name in ("trolley", "bridge", "hoist"):
        if (
            file.inputs is not None
            and name in file.inputs.model_fields_set
            and name not in file.actuated
        ):
            known = ", ".join(file.actuated) or "none"
            raise SceneError(f"inputs.{name}: no force drives the {name}; driven by force: {known}")
