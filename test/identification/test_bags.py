"""Bags of a rig: joints in any order, unequal, missing or no stamps; what is refused.

Samples may be missing, too.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_samples import write_bag as write_recorded_bag
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import crane_sim
from crane_sim.files.errors import SceneError
from crane_sim.identification import read_measurements

TYPES: Any = get_typestore(Stores.ROS2_JAZZY)
SCENE = "overhead_energy"
TRUTH = {"cable.lengths.0": 2.1, "trolley.mass": 22.0}
EPOCH = 1_790_000_000_000_000_000  # ns
NOISE = 1e-3  # m, rad
Row = tuple[int, dict[str, float]]  # ns, values by joint


def message(stamp: int, field: str, values: dict[str, float]) -> Any:
    """Return a JointState with one of its fields."""
    kinds, none = TYPES.types, np.empty(0)
    time = kinds["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
    arrays = {"position": none, "velocity": none, "effort": none} | {
        field: np.array([*values.values()])
    }
    header = kinds["std_msgs/msg/Header"](time, "")
    return kinds["sensor_msgs/msg/JointState"](header, [*values], **arrays)


def write_bag(
    path: Path, topics: Mapping[str, tuple[str, Sequence[Row]]], stamped: bool = True
) -> Path:
    """Write a rosbag2 folder in MCAP: (field, rows) by topic, received 1 ms after their stamps."""
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for topic, (field, rows) in topics.items():
            to = writer.add_connection(topic, "sensor_msgs/msg/JointState", typestore=TYPES)
            received = 0
            for t, values in rows:
                content = message(t if stamped else 0, field, values)
                received = max(received + 1, t + 10**6)
                writer.write(
                    to, received, TYPES.serialize_cdr(content, "sensor_msgs/msg/JointState")
                )
    return path


def rig(duration: float) -> dict[str, tuple[str, list[Row]]]:
    """Return a rig's messages: a fifth of the states is lost, every seventh lacks the swing."""
    run = crane_sim.simulate(SCENE, overrides=TRUTH | {"duration": duration})
    random = np.random.default_rng(1)
    q = run.q + random.normal(0.0, NOISE, run.q.shape)
    stamps = [EPOCH + round(1e9 * t) for t in run.t]
    states = [
        (t, {"swing_1": np.nan if k % 7 == 3 else angle, "other": 1.0, "trolley": x})
        for k, (t, (x, angle)) in enumerate(zip(stamps, q, strict=True))
        if k == 0 or random.random() > 0.2
    ]
    commands = [(t, {"trolley": force}) for t, (force,) in zip(stamps, run.commands, strict=False)]
    return {"/rig/joint_states": ("position", states), "/rig/joint_commands": ("effort", commands)}


def test_a_bag_gives_the_true_parameters(tmp_path: Path) -> None:
    """From lost and partial states, true values are within three standard errors.

    The chance to fail is 5e-3.
    """
    bag = write_bag(tmp_path / "bag", rig(10.0))
    found = crane_sim.identify(SCENE, bag, [*TRUTH])
    for each in found.estimates:
        assert abs(each.value - TRUTH[each.key]) < 3.0 * each.deviation < 0.01 * each.value
    assert (
        found.residual == pytest.approx({"trolley": NOISE, "swing_1": NOISE}, rel=0.1)
        and not found.warnings
    )
    file = next((tmp_path / "bag").glob("*.mcap"))
    assert crane_sim.identify(SCENE, file, [*TRUTH]).overrides() == found.overrides()


def test_without_stamps_the_times_of_reception_count(tmp_path: Path) -> None:
    """A bag without stamps from its senders has the same times between messages.

    The values are the same, too.
    """
    scene, topics = crane_sim.load_scene(SCENE), rig(0.5)
    stamped, unstamped = (
        read_measurements(write_bag(tmp_path / str(kind), topics, kind), scene)
        for kind in (True, False)
    )
    for one, other in zip(stamped, unstamped, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_gap_in_the_commands_of_a_damaged_bag_is_refused(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Commands lost in the middle of a bag are refused by time; a damaged end costs only that."""
    run = crane_sim.simulate("knuckle_setpoint", duration=0.3)
    whole = write_recorded_bag(tmp_path / "whole.mcap", run, save_every=10)  # steps in a chunk
    for step, name in ((15, "middle"), (25, "end")):
        data = bytearray(whole.read_bytes())
        data[data.index(run.q[step, 0].tobytes())] ^= 1
        (tmp_path / f"{name}.mcap").write_bytes(data)
    with pytest.raises(
        SceneError, match=r"middle.mcap: is damaged: commands after t = 0.09 s are missing"
    ):
        read_measurements(tmp_path / "middle.mcap", run.scene)
    assert len(read_measurements(tmp_path / "end.mcap", run.scene).commands) == 20
    assert "end.mcap is damaged" in caplog.text


def test_bags_that_are_no_use_are_refused(tmp_path: Path) -> None:
    """A missing topic, two cranes, missing commands of a joint, and a reset are one line each."""
    scene, topics = crane_sim.load_scene(SCENE), rig(0.1)
    states, commands = topics["/rig/joint_states"], topics["/rig/joint_commands"]
    other = ("effort", [(t, {"jib": 0.0}) for t, _ in commands[1]])
    bags: dict[str, dict[str, Any]] = {
        "no messages of a topic joint_commands": {"/joint_states": states},
        "several topics, /a/joint_states, /b/joint_states": {
            "/a/joint_states": states,
            "/b/joint_states": states,
        },
        "has no commands of trolley": {"/joint_states": states, "/joint_commands": other},
        "times go back": {
            "/joint_states": ("position", [*states[1], states[1][0]]),
            "/joint_commands": commands,
        },
    }
    for k, (line, messages) in enumerate(bags.items()):
        with pytest.raises(SceneError) as raised:
            read_measurements(write_bag(tmp_path / str(k), messages), scene)
        assert line in str(raised.value) and "\n" not in str(raised.value)
    (tmp_path / "noise.mcap").write_bytes(b"noise")
    for name in ("noise.mcap", "nowhere"):
        with pytest.raises(SceneError, match="cannot be read|there is no such file"):
            read_measurements(tmp_path / name, scene)
