"""Commands by velocity and position: message fields, bounds, and declarations to ros2_control."""

from typing import Any
from xml.etree import ElementTree

import pytest
import yaml
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from crane_sim import SceneError, load_scene
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.command_filter import CommandValidator, Refusal
from crane_sim.ros.common.ros2_control import controllers_file, urdf_with_ros2_control
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant

NAN = float("nan")
SERVO = {"gain": 1e4, "position_gain": 1.0, "max_speed": 0.4}
SPEED = {"drive": "velocity", "servo": {"gain": 1e4, "max_speed": 0.5}}
MIXED: dict[str, Any] = {"trolley": SPEED, "bridge": {"drive": "position", "servo": SERVO}}


def crane(actuators: dict[str, Any], **changes: Any) -> Scene:
    """Return a bridge crane, without a law, whose rope is driven by force."""
    bare = {"control": None, "actuators": actuators, "rope": {}}
    return load_scene("bridge_speed_drive", bare | changes)


def message(scene: Scene, **fields: list[float]) -> bytes:
    """Return the serialized command of the actuated joints with these fields."""
    return serialize_message(JointState(name=list(scene.actuated), **fields))


def read(scene: Scene, data: bytes) -> tuple[float, ...] | None:
    """Return the command in a message, None where it is refused."""
    codec = CommandCodec(scene)
    frame = codec.decode(data)
    return CommandValidator(scene.actuated, (1e5,) * 3).match_joints(
        frame.names, codec.values(frame)
    )


def test_each_joint_has_the_field_of_its_drive() -> None:
    """A message of mixed drives has each command in its joint's field, NaN in others, both ways."""
    scene = crane(MIXED)
    assert scene.commands == ("velocity", "position", "effort") and scene.command_units == (
        "m/s",
        "m",
        "N",
    )
    codec = CommandCodec(scene)
    decoded: Any = deserialize_message(codec.encode(7, (0.25, -3.0, 9.0)), JointState)
    assert decoded.velocity[0] == 0.25 and decoded.position[1] == -3.0 and decoded.effort[2] == 9.0
    assert str(decoded.velocity[1]) == str(decoded.position[0]) == "nan"
    assert read(scene, codec.encode(7, (0.25, -3.0, 9.0))) == (0.25, -3.0, 9.0)
    given = {"position": [NAN, 2.0, NAN], "velocity": [0.1, NAN, NAN], "effort": [NAN, NAN, 5.0]}
    assert read(scene, message(scene, **given)) == (0.1, 2.0, 5.0)
    backwards = JointState(
        name=["rope", "bridge", "trolley"],
        position=[0.0, 2.0, NAN],
        velocity=[0.0, NAN, 0.1],
        effort=[5.0, NAN, NAN],
    )
    assert read(scene, serialize_message(backwards)) == (0.1, 2.0, 5.0)
    assert not codec.kind and CommandCodec(crane({"all": SPEED})).kind == "velocity"


@pytest.mark.parametrize("fields", [{"effort": [1.0, 2.0, 3.0]}, {"velocity": [0.1, 0.2, 0.3]}])
def test_a_command_in_another_field_is_refused(fields: dict[str, list[float]]) -> None:
    """A message that lacks the field of a drive is refused, and so is NaN in it."""
    assert read(crane(MIXED), message(crane(MIXED), **fields)) is None
    validator, codec, scene = (
        CommandValidator(("a", "b", "c"), (1.0,) * 3),
        CommandCodec(crane(MIXED)),
        crane(MIXED),
    )
    frame = codec.decode(message(scene, velocity=[0.1] * 3, position=[NAN] * 3, effort=[0.0] * 3))
    assert validator.match_joints(["a", "b", "c"], codec.values(frame)) is None
    assert validator.refused[Refusal.NOT_FINITE] == 1


def test_ros2_control_has_the_interfaces_of_the_drives() -> None:
    """Command interfaces are those of the drives, with limits; the URDF has the largest speeds."""
    scene = crane(MIXED)
    tree = ElementTree.fromstring(urdf_with_ros2_control(scene))
    interfaces = {
        joint.get("name"): (interface.get("name"), [float(str(bound.text)) for bound in interface])
        for joint in tree.iterfind("ros2_control/joint")
        if (interface := joint.find("command_interface")) is not None
    }
    assert interfaces["trolley"] == ("velocity", [-0.5, 0.5, 0.0])  # least, largest, initial
    assert interfaces["bridge"] == ("position", [-5.0])  # no limits
    limit = tree.find("joint[@name='trolley']/limit")
    assert limit is not None and float(limit.attrib["velocity"]) == 0.5
    with pytest.raises(
        SceneError, match="velocity, bridge: position, rope: effort: a controller commands"
    ):
        controllers_file(scene)
    nodes = yaml.safe_load(controllers_file(crane({"all": SPEED})))
    assert (
        nodes["/**/velocity_forwarding_controller"]["ros__parameters"]["interface_name"]
        == "velocity"
    )
    assert nodes["/**/joint_trajectory_controller"]["ros__parameters"]["command_interfaces"] == [
        "velocity"
    ]


def test_position_drives_stay_where_they_are_until_they_are_commanded() -> None:
    """Before any command a position drive holds its initial position, a speed drive no speed."""
    assert crane(MIXED).idle_command == (0.0, -5.0, 0.0)


def test_a_suspension_point_stays_where_it_is_until_it_is_commanded() -> None:
    """A pendulum's point, without a servo of ours, is at first commanded its own position."""
    scene = load_scene("offshore_vision")
    assert scene.idle_command == scene.initial_q[:2] == (1.35, 0.0)
    plant = Plant(scene.with_external_commands())
    for _ in range(15):
        plant.advance(scene.idle_command)
    assert tuple(plant.q[:2]) == scene.initial_q[:2]
