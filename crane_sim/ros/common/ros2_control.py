"""The description of a crane for ros2_control: the tag of its URDF, and a file of controllers.

The tag is `<ros2_control>`.

The hardware interface is `joint_state_topic_hardware_interface`, which reads `joint_states` and
writes `joint_commands`. Passive joints have states only. The interface also writes before any
controller is active: then commands are those of the tag, which hold the joints at the start.
Without them they would be NaN, which is refused.
"""

from math import ceil, inf, isfinite
from typing import Any, NamedTuple
from xml.etree import ElementTree

import yaml

from crane_sim.description import urdf
from crane_sim.files.errors import SceneError
from crane_sim.ros.common.command_filter import required_efforts
from crane_sim.scenes.scene import Scene

PLUGIN = "joint_state_topic_hardware_interface/JointStateTopicSystem"
FREQUENCY = 2.0  # rad/s of the critically damped joints of the trajectory controller
INTEGRAL_RATIO = 0.5  # rate of the integral, which holds a joint against gravity, by that frequency
_CONTROLLERS = {
    "joint_state_broadcaster": "joint_state_broadcaster/JointStateBroadcaster",
    "joint_trajectory_controller": "joint_trajectory_controller/JointTrajectoryController",
}
_FORWARDING = "forward_command_controller/ForwardCommandController"
_CLAMP = 3.0  # times the effort that holds a joint at the start
_EFFORT_UNITS = ("N", "N m")
_STATES = ("position", "velocity", "effort")
_HEADER = """# Controllers of {name}: ros2 run controller_manager ros2_control_node --ros-args --params-file this file
# Commands of {joints}: {units}. Gains: for critically damped joints of {frequency:g} rad/s.
"""  # noqa: E501


class Gains(NamedTuple):
    """Gains of a joint of the trajectory controller, in units of its effort."""

    p: float
    i: float
    d: float
    i_clamp: float  # bound of the integral's effort

    def parameters(self) -> dict[str, float]:
        """Return them by the controller's names, to four digits."""
        values = {
            "p": self.p,
            "i": self.i,
            "d": self.d,
            "i_clamp_max": self.i_clamp,
            "i_clamp_min": -self.i_clamp,
        }
        return {name: float(f"{value:.4g}") + 0.0 for name, value in values.items()}


def prefix_of_topics(scene: Scene, namespace: str = "") -> str:
    """Return the prefix of a crane's topics in a namespace: "/knuckle"; empty in the root, "/"."""
    return f"/{(namespace or scene.crane).strip('/')}".rstrip("/")


def urdf_with_ros2_control(scene: Scene, namespace: str = "") -> str:
    """Return the URDF of a scene with the tag of ros2_control.

    `namespace` is that of its topics, by default the kind of crane; "/" is the root.
    """
    robot = ElementTree.fromstring(urdf(scene))
    control = ElementTree.SubElement(
        robot, "ros2_control", name=f"{scene.crane}_topics", type="system"
    )
    hardware = ElementTree.SubElement(control, "hardware")
    ElementTree.SubElement(hardware, "plugin").text = PLUGIN
    topics = prefix_of_topics(scene, namespace)
    parameters = {
        "joint_states_topic": f"{topics}/joint_states",
        "joint_commands_topic": f"{topics}/joint_commands",
        # a command that is the same as the last one is sent, too
        "trigger_joint_command_threshold": "-1",
    }
    for name, value in parameters.items():
        ElementTree.SubElement(hardware, "param", name=name).text = value
    holding = dict(zip(scene.actuated, holding_commands(scene), strict=True))
    for joint, position in zip(scene.joint_names, scene.initial_q, strict=True):
        _add_joint(control, scene, joint, position, holding.get(joint, 0.0))
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True)


def _add_joint(
    control: ElementTree.Element, scene: Scene, joint: str, position: float, holding: float
) -> None:
    element = ElementTree.SubElement(control, "joint", name=joint)
    if joint in scene.actuated:
        i = scene.actuated.index(joint)
        command = ElementTree.SubElement(element, "command_interface", name=scene.commands[i])
        lower, upper = command_limits(scene, i) or (-inf, inf)
        values = {"min": lower, "max": upper, "initial_value": min(max(holding, lower), upper)}
        for name, value in values.items():
            if isfinite(value):
                ElementTree.SubElement(command, "param", name=name).text = f"{value:.12g}"
    for name in _STATES:
        state = ElementTree.SubElement(element, "state_interface", name=name)
        if name == "position":
            ElementTree.SubElement(state, "param", name="initial_value").text = f"{position:.12g}"


def holding_commands(scene: Scene) -> tuple[float, ...]:
    """Return the commands (nu,) that hold the joints at the start.

    They are efforts against gravity, zero speeds or positions.
    """
    if not scene.actuated:
        return ()
    efforts = zip(
        scene.command_units,
        required_efforts(scene).gravity.tolist(),
        scene.idle_command,
        strict=True,
    )
    return tuple(gravity if unit in _EFFORT_UNITS else idle for unit, gravity, idle in efforts)


def command_limits(scene: Scene, i: int) -> tuple[float, ...]:
    """Return (least, largest) command of actuated joint i; empty where there is no actuator."""
    if scene.hardware is None:
        return ()
    drive, joint, kind = scene.hardware.drives[i], scene.actuated[i], scene.commands[i]
    if kind == "velocity":
        speed = scene.hardware.servos[i].max_speed
        return -speed, speed
    if kind == "position":
        return next(
            ((span.low, span.high) for span in scene.limits if span.joint == joint), (-inf, inf)
        )
    return drive.low, drive.high


def controllers_file(scene: Scene) -> str:
    """Return the parameters of a controller manager, a broadcaster and two controllers, in YAML.

    Raises:
        SceneError: the scene has no joint to command, or drives that are commanded differently.
    """
    if not scene.actuated:
        raise SceneError(
            f"{scene.name}: no joint of this crane is actuated, so there is nothing to command"
        )
    if len(set(scene.commands)) > 1:
        kinds = ", ".join(
            f"{joint}: {kind}" for joint, kind in zip(scene.actuated, scene.commands, strict=True)
        )
        raise SceneError(
            f"{scene.name}: {kinds}: a controller commands one interface; give all joints the same "
            "drive"
        )
    # also of the interface's own node
    document = {"/**": {"ros__parameters": {"use_sim_time": True}}}
    document |= {
        f"/**/{name}": {"ros__parameters": values} for name, values in _nodes(scene).items()
    }
    units = ", ".join(scene.command_units)
    header = _HEADER.format(
        name=scene.name, joints=", ".join(scene.actuated), units=units, frequency=FREQUENCY
    )
    return header + yaml.safe_dump(document, sort_keys=False)


def _nodes(scene: Scene) -> dict[str, dict[str, Any]]:
    """Return the parameters of controller manager, broadcaster and controllers, by node."""
    # a slower loop would miss periods
    manager: dict[str, Any] = {"update_rate": ceil(1.0 / scene.period - 1e-6)}
    manager |= {name: {"type": kind} for name, kind in _CONTROLLERS.items()}
    manager[f"{scene.commands[0]}_forwarding_controller"] = {"type": _FORWARDING}
    gains = dict(zip(scene.actuated, joint_gains(scene), strict=True))
    trajectory: dict[str, Any] = {
        "joints": list(scene.actuated),
        "command_interfaces": sorted(set(scene.commands)),
        "state_interfaces": ["position", "velocity"],
        "gains": {joint: gain.parameters() for joint, gain in gains.items()},
    }
    forwarding = {"joints": list(scene.actuated), "interface_name": scene.commands[0]}
    return {
        "controller_manager": manager,
        "joint_state_broadcaster": {
            "use_local_topics": True
        },  # else its topic would be read as the plant's
        "joint_trajectory_controller": trajectory,
        f"{scene.commands[0]}_forwarding_controller": forwarding,
    }


def joint_gains(scene: Scene) -> list[Gains]:
    """Return the gains of actuated joints: of the inertia for a force, else of the kinematics."""
    w, gains, required = FREQUENCY, [], required_efforts(scene)
    for unit, inertia, gravity in zip(scene.command_units, *required, strict=True):
        if unit in _EFFORT_UNITS:
            clamp = _CLAMP * abs(gravity)
            integral = INTEGRAL_RATIO * inertia * w**3 if clamp else 0.0
            gains.append(Gains(inertia * w * w, integral, 2.0 * inertia * w, clamp))
        elif unit.endswith("/s²"):
            gains.append(Gains(w * w, 0.0, 2.0 * w, 0.0))
        else:
            gains.append(Gains(w if unit.endswith("/s") else 1.0, 0.0, 0.0, 0.0))
    return gains
