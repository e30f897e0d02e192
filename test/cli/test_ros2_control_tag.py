"""`crane check SCENE --ros2-control URDF`: a tag that cannot drive the crane is a line, exit 2."""

from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import crane_here

from crane_sim import load_scene
from crane_sim.ros.common.ros2_control import urdf_with_ros2_control

SCENE = "knuckle_setpoint"
EFFORT = '<command_interface name="effort">'
SWING = '<joint name="swing_radial">'


Change = Callable[[str], str]


def in_tag(old: str, new: str) -> Change:
    """Return a change of a URDF: in its tag, where `old` stands at least once."""

    def change(urdf: str) -> str:
        head, start, tag = urdf.partition("<ros2_control")
        assert old in tag
        return head + start + tag.replace(old, new, 1)

    return change


@pytest.fixture(scope="module")
def urdf() -> str:
    """Return the URDF with the tag that is written for the scene."""
    return urdf_with_ros2_control(load_scene(SCENE))


BROKEN: dict[str, tuple[str, Change]] = {
    "robot>": ("no XML: ", lambda urdf: urdf.replace("</robot>", "</robo>")),
    "no tag": (
        "no <ros2_control> tag in <robot>",
        lambda urdf: urdf.partition("<ros2_control")[0] + "</robot>",
    ),
    "plugin": (
        "plugin 'mock_components/GenericSystem': possible: "
        "joint_state_topic_hardware_interface/JointStateTopicSystem",
        in_tag(
            "joint_state_topic_hardware_interface/JointStateTopicSystem",
            "mock_components/GenericSystem",
        ),
    ),
    "topic": (
        "joint_commands_topic '/crane/commands': possible: /knuckle/joint_commands",
        in_tag("/knuckle/joint_commands", "/crane/commands"),
    ),
    "threshold": (
        "trigger_joint_command_threshold '1e-5': possible: -1",
        in_tag('threshold">-1<', 'threshold">1e-5<'),
    ),
    "unknown joint": (
        "joint 'turn': possible: slew, boom, jib, rope, ",
        in_tag('"slew"', '"turn"'),
    ),
    "joint left out": ("joint 'slew' is not in the tag", in_tag('"slew"', '"swing_radial"')),
    "unknown interface": (
        "command interface 'torque': possible: position, velocity, effort",
        in_tag(EFFORT, EFFORT.replace("effort", "torque")),
    ),
    "another drive": (
        "command interface 'position': its drive takes 'effort' alone",
        in_tag(EFFORT, EFFORT.replace("effort", "position")),
    ),
    "state interface": (
        "state interface 'acceleration': possible: position, velocity, effort",
        in_tag('<state_interface name="effort"', '<state_interface name="acceleration"'),
    ),
    "passive joint": (
        "nothing drives it; possible: none",
        in_tag(SWING, f"{SWING}{EFFORT}</command_interface>"),
    ),
    "no initial value": (
        "initial_value 'missing' of its command: possible: a number, else NaN is sent",
        in_tag('<param name="initial_value">0</param>', ""),
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_wrong_tag_is_one_line(
    case: str,
    urdf: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Every mistake that would leave the crane without commands is named with its value.

    The line also has what is possible.
    """
    line, change = BROKEN[case]
    file = tmp_path / "mine.urdf"
    file.write_text(change(urdf))
    result = crane_here(monkeypatch, capsys, "check", SCENE, "--ros2-control", str(file))
    assert result.returncode == 2
    error = result.stderr
    assert error.startswith(f"crane: {file}: ") and line in error and error.count("\n") == 1, error


def test_the_tag_that_is_written_passes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What `describe --ros2-control` writes is fine."""
    written = crane_here(
        monkeypatch, capsys, "describe", SCENE, "--ros2-control", "--save", str(tmp_path)
    )
    assert written.returncode == 0
    file = tmp_path / f"{SCENE}.urdf"
    result = crane_here(monkeypatch, capsys, "check", SCENE, "--ros2-control", str(file))
    assert (
        result.returncode == 0 and f"{file}: fine (commands slew, boom, jib, rope" in result.stdout
    )


def test_a_tag_of_the_root_namespace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The root namespace's tag is fine for the namespace `/`, and not for that of the crane."""
    file = tmp_path / "mine.urdf"
    file.write_text(urdf_with_ros2_control(load_scene(SCENE), "/"))
    result = crane_here(
        monkeypatch, capsys, "check", SCENE, "--ros2-control", str(file), "--namespace", "/"
    )
    assert result.returncode == 0, result.stderr
    result = crane_here(monkeypatch, capsys, "check", SCENE, "--ros2-control", str(file))
    assert "joint_states_topic '/joint_states': possible: /knuckle/joint_states" in result.stderr


def test_each_tag_on_the_topics_of_the_crane_is_checked(
    urdf: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Tags of other cranes in the same URDF do not count; a second one of this crane does.

    It does not matter whether they are before or behind.
    """
    begin, end = urdf.index("<ros2_control"), urdf.index("</ros2_control>") + len("</ros2_control>")
    own = urdf[begin:end]
    other, broken = (
        own.replace("/knuckle/", "/east/"),
        own.replace('name="velocity"', 'name="speed"'),
    )
    file = tmp_path / "mine.urdf"
    for tags, code in (
        (other + own, 0),
        (own + other, 0),
        (broken + own, 2),
        (own + broken, 2),
        (other, 2),
    ):
        file.write_text(urdf[:begin] + tags + urdf[end:])
        result = crane_here(monkeypatch, capsys, "check", SCENE, "--ros2-control", str(file))
        assert result.returncode == code, result.stderr
    file.write_text(urdf.replace("utf-8", "foo", 1))
    result = crane_here(monkeypatch, capsys, "check", SCENE, "--ros2-control", str(file))
    assert result.returncode == 2 and f"{file}: no XML: " in result.stderr
