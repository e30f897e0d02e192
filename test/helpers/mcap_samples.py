"""Messages of a short run, written to and read from MCAP files."""

from pathlib import Path
from typing import Any

from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from crane_sim import load_scene
from crane_sim.recording.mcap.bag import Bag
from crane_sim.recording.mcap.topic import Topic
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec

SCENE = load_scene("knuckle_setpoint", {"duration": 2.0})


JOINT_STATE, STRING = "sensor_msgs/msg/JointState", "std_msgs/msg/String"


TOPICS = {
    "joint_states": Topic(
        "/knuckle/joint_states", JOINT_STATE, stamped=True, latched=False, reliable=True
    ),
    "applied_effort": Topic(
        "/knuckle/applied_effort", JOINT_STATE, stamped=True, latched=False, reliable=True
    ),
    "robot_description": Topic(
        "/knuckle/robot_description", STRING, stamped=False, latched=True, reliable=True
    ),
}


STATE_CODEC, EFFORT_CODEC = (
    JointStateCodec(SCENE.joint_names, STATE),
    JointStateCodec(SCENE.actuated, EFFORT),
)


DESCRIPTION = b"\0\1\0\0\6\0\0\0crane\0"


def read(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return times [ns] and messages of a file, by topic, by a reader independent of ours."""
    types = get_typestore(Stores.ROS2_JAZZY)
    with Reader(path) as reader:
        messages: dict[str, list[tuple[int, Any]]] = {
            connection.topic: [] for connection in reader.connections
        }
        for connection, time, data in reader.messages():
            messages[connection.topic].append(
                (time, types.deserialize_cdr(data, connection.msgtype))
            )
    return messages


def stamp_of(message: Any) -> int:
    """Return a message's stamp, ns."""
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def feed(bag: Bag, steps: int, after: int = 0) -> None:
    """Pass the messages of the steps after step `after` to the bag, and the state after them."""
    callbacks = bag.callbacks()
    for k in range(after + 1, steps + 2):
        callbacks["joint_states"](
            STATE_CODEC.encode(k * SCENE.period_ns, (float(k),) * 6, (0.0,) * 6, (0.0,) * 6)
        )
        if k <= steps:
            callbacks["applied_effort"](EFFORT_CODEC.encode(k * SCENE.period_ns, (float(k),) * 4))
