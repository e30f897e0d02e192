"""The description and the controllers that a stock ros2_control needs."""

from math import isfinite
from xml.etree import ElementTree

import pytest
import yaml

from crane_sim import SceneError, load_scene
from crane_sim.files.catalogue import scene_files
from crane_sim.files.document import read
from crane_sim.ros.common.ros2_control import (
    FREQUENCY,
    controllers_file,
    joint_gains,
    urdf_with_ros2_control,
)

# a scene of each
FORMS = {read(name)["crane"]: name for name in sorted(scene_files(), reverse=True)}


@pytest.mark.parametrize("name", FORMS.values())
def test_every_joint_has_its_interfaces(name: str) -> None:
    """The tag has the joints in order, commands for the driven ones, and the actuators' limits."""
    scene = load_scene(name)
    tag = ElementTree.fromstring(urdf_with_ros2_control(scene)).find("ros2_control")
    assert tag is not None and [joint.get("name") for joint in tag.findall("joint")] == list(
        scene.joint_names
    )
    driven = [
        joint.get("name")
        for joint in tag.findall("joint")
        if joint.find("command_interface") is not None
    ]
    assert sorted(map(str, driven)) == sorted(scene.actuated)
    topics = {parameter.get("name"): parameter.text for parameter in tag.findall("hardware/param")}
    assert topics["joint_commands_topic"] == f"/{scene.crane}/joint_commands"
    parameters = tag.findall("joint/command_interface/param")
    limits = [float(str(each.text)) for each in parameters if each.get("name") in ("min", "max")]
    drives = scene.hardware.drives if scene.hardware is not None else ()
    ends = [end for drive in drives for end in (drive.low, drive.high)]
    assert sorted(limits) == pytest.approx(sorted(filter(isfinite, ends)))


@pytest.mark.parametrize("name", FORMS.values())
def test_controllers_take_the_actuated_joints(name: str) -> None:
    """The file has one scene period per update; both controllers command all actuated joints."""
    scene = load_scene(name)
    if not scene.actuated:
        with pytest.raises(SceneError, match=f"{name}: no joint of this crane is actuated"):
            controllers_file(scene)
        return
    nodes = yaml.safe_load(controllers_file(scene))
    manager = nodes["/**/controller_manager"]["ros__parameters"]
    assert manager["update_rate"] * scene.period == pytest.approx(1.0)
    for controller in ("joint_trajectory_controller", "effort_forwarding_controller"):
        assert nodes[f"/**/{controller}"]["ros__parameters"]["joints"] == list(scene.actuated)


def test_gains_are_of_critically_damped_joints() -> None:
    """The slew's gains are those of its inertia at the start: J ω², 2 J ω, without gravity.

    The inertia includes load and rope.
    """
    slew = joint_gains(load_scene("knuckle_setpoint"))[0]
    assert slew.p == pytest.approx(slew.d * FREQUENCY / 2.0) and slew.i == slew.i_clamp == 0.0


def test_nothing_to_command_is_a_single_line() -> None:
    """A crane without an actuated joint has no controllers."""
    with pytest.raises(SceneError, match="overhead_sway: no joint of this crane is actuated"):
        controllers_file(load_scene("overhead_sway"))


def test_topics_of_the_root_namespace_are_the_nodes() -> None:
    """The tag's topics are in the namespace: by default the kind of crane, none below the root."""
    scene = load_scene("knuckle_setpoint")
    for namespace, topic in (("", "/knuckle"), ("/", ""), ("/rig/a", "/rig/a"), ("rig", "/rig")):
        hardware = ElementTree.fromstring(urdf_with_ros2_control(scene, namespace)).find(
            "ros2_control/hardware"
        )
        assert hardware is not None
        texts = [each.text for each in hardware.iter("param")]
        assert texts[:2] == [f"{topic}/joint_states", f"{topic}/joint_commands"]
