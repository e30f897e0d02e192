"""Check of a `<ros2_control>` tag that a user wrote: whether it can drive the crane of a scene."""

from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from crane_sim.files.errors import SceneError
from crane_sim.ros.common.ros2_control import PLUGIN, prefix_of_topics
from crane_sim.scenes.scene import Scene

_PLUGINS = (PLUGIN, "topic_based_ros2_control/TopicBasedSystem")  # the second is its former name
_INTERFACES = ("position", "velocity", "effort")  # the fields of a JointState
_TOPICS = {"joint_states_topic": "joint_states", "joint_commands_topic": "joint_commands"}
_THRESHOLD = "trigger_joint_command_threshold"


def check_tag(scene: Scene, path: Path, namespace: str = "") -> None:
    """Check a URDF's tags of the hardware interface: those on its topics, else the first one.

    Args:
        scene: of the crane.
        path: of the URDF.
        namespace: of the crane's topics, default: the kind of crane; "/" is the root.

    Raises:
        SceneError: it cannot drive the crane: one line with what is wrong and what is possible.
    """
    tags, topics = _find_tags(path), prefix_of_topics(scene, namespace)
    name, topic = next(iter(_TOPICS.items()))
    own = [tag for tag in tags if _parameters(tag).get(name) == f"{topics}/{topic}"]
    for tag in own or tags[:1]:
        _check_parameters(tag, path, topics)
        _check_joints(tag, scene, path)


def _check_joints(tag: Element, scene: Scene, path: Path) -> None:
    """Raise SceneError where joints or interfaces of a tag are not the scene's."""
    kinds = dict(zip(scene.actuated, scene.commands, strict=True))
    joints = {str(joint.get("name")): joint for joint in tag.findall("joint")}
    if unknown := [name for name in joints if name not in scene.joint_names]:
        raise SceneError(f"{path}: joint {unknown[0]!r}: possible: {', '.join(scene.joint_names)}")
    if missing := [name for name in scene.actuated if name not in joints]:
        raise SceneError(
            f"{path}: joint {missing[0]!r} is not in the tag; the actuated ones are all commanded "
            "at once"
        )
    for name, joint in joints.items():
        _check_commands(
            joint.findall("command_interface"), kinds.get(name, ""), f"{path}: joint {name!r}"
        )
        for state in joint.findall("state_interface"):
            if state.get("name") not in _INTERFACES:
                raise SceneError(
                    f"{path}: joint {name!r}: state interface {_quoted_name(state)}: "
                    f"{_possible(_INTERFACES)}"
                )


def _find_tags(path: Path) -> list[Element]:
    """Return the tags whose plugin is the hardware interface of topics, at least one."""
    try:
        robot = ElementTree.parse(path).getroot()
    except OSError as error:
        raise SceneError(f"{path}: {error.strerror}") from None
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        # the latter two: of an unknown encoding
        raise SceneError(f"{path}: no XML: {error}") from None
    tags = [
        (str(tag.findtext("hardware/plugin", "")).strip(), tag)
        for tag in robot.findall("ros2_control")
    ]
    if found := [tag for plugin, tag in tags if plugin in _PLUGINS]:
        return found
    if not tags:
        raise SceneError(
            f"{path}: no <ros2_control> tag in <{robot.tag}>: crane describe --ros2-control writes "
            "one"
        )
    raise SceneError(f"{path}: plugin {tags[0][0]!r}: possible: {PLUGIN}")


def _parameters(tag: Element) -> dict[str, str]:
    return {str(each.get("name")): str(each.text).strip() for each in tag.findall("hardware/param")}


def _check_parameters(tag: Element, path: Path, topics: str) -> None:
    given = _parameters(tag)
    for name, topic in _TOPICS.items():
        if given.get(name) != f"{topics}/{topic}":
            raise SceneError(
                f"{path}: {name} {given.get(name, 'missing')!r}: possible: {topics}/{topic}"
            )
    threshold = _number(given.get(_THRESHOLD, ""))
    if threshold is None or threshold >= 0.0:
        what = given.get(_THRESHOLD, "missing")
        raise SceneError(
            f"{path}: {_THRESHOLD} {what!r}: possible: -1; else a command like the state is not "
            "sent"
        )


def _check_commands(interfaces: Sequence[Element], kind: str, where: str) -> None:
    """Check the command interfaces of a joint, whose drive takes `kind`; empty: it has none."""
    if unknown := [each for each in interfaces if each.get("name") not in _INTERFACES]:
        raise SceneError(
            f"{where}: command interface {_quoted_name(unknown[0])}: {_possible(_INTERFACES)}"
        )
    if not kind and interfaces:
        raise SceneError(
            f"{where}: command interface {_quoted_name(interfaces[0])}: nothing drives it; "
            "possible: none"
        )
    if kind and [each.get("name") for each in interfaces] != [kind]:
        found = ", ".join(_quoted_name(each) for each in interfaces) or "none"
        raise SceneError(f"{where}: command interface {found}: its drive takes {kind!r} alone")
    for interface in interfaces:
        values = {each.get("name"): str(each.text) for each in interface.findall("param")}
        if _number(values.get("initial_value", "")) is None:
            found = values.get("initial_value", "missing")
            raise SceneError(
                f"{where}: initial_value {found!r} of its command: possible: a number, else NaN is "
                "sent"
            )


def _quoted_name(interface: Element) -> str:
    return repr(interface.get("name", ""))


def _possible(names: Sequence[str]) -> str:
    return f"possible: {', '.join(names)}"


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None
