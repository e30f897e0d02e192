"""Topic names, QoS profiles and message helpers that the nodes share."""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from importlib import import_module
from typing import Any, cast

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.qos import (
    DurabilityPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rclpy.serialization import deserialize_message
from std_msgs.msg import UInt8
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

try:
    TFMessage: Any = import_module("tf2_msgs.msg").TFMessage
except ImportError:  # no wheel has it; `./crane interfaces` builds it
    TFMessage = None


class SimulationState(IntEnum):
    """Values of the topic simulation_state."""

    STOPPED = 0
    PLAYING = 1
    PAUSED = 2
    QUITTING = 3


STREAM_QOS = QoSProfile(depth=10)  # of topics with a message each step: reliable, volatile
# for publishers: a recorder that lags for seconds loses nothing
DEEP_STREAM_QOS = QoSProfile(depth=10_000)
LATCHED_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
CLOCK_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
SENSOR_QOS = qos_profile_sensor_data
TRANSFORM_QOS = QoSProfile(depth=100)  # as tf2_ros has it

NS_PER_S = 1_000_000_000
LIVELINESS_LEASE = 2.0
"""Liveliness lease of the middleware [s], after which a dead peer is removed, as in the profile in
`config/`."""


class MalformedMessage(ValueError):
    """Bytes that are no message of their topic's type, or a bad field, described in one line."""


def decode_simulation_state(data: bytes) -> int | None:
    """Return the value of a serialized message of simulation_state, None for any other bytes."""
    try:
        return deserialize(data, UInt8).data
    except MalformedMessage:
        return None


def deserialize(data: bytes, kind: Any) -> Any:
    """Return a deserialized message; raises MalformedMessage for bytes that are none.

    A topic may carry any bytes.
    """
    try:
        return deserialize_message(data, kind)
    except RuntimeError as error:  # the middleware's
        raise MalformedMessage(f"{len(data)} bytes that are no {kind.__name__}") from error


def describe_policy(kind: int) -> str:
    """Return what does not fit between publisher and subscriber, by the kind of the QoS policy."""
    possible = {
        QoSPolicyKind.RELIABILITY: "subscriptions to states may be reliable or best effort, "
        "commands must be reliable",
        QoSPolicyKind.DURABILITY: "states and commands are volatile",
    }
    policy = QoSPolicyKind(kind)
    return (
        f"its QoS policy {policy.name.lower()} does not fit: "
        f"{possible.get(policy, 'take the default')}"
    )


def describe_missing(package: str) -> str:
    """Return the line of diagnostics on what is off without a message package that no wheel has."""
    return f"off: the package {package} is not installed, `./crane interfaces` builds it"


def nanoseconds(stamp: Time) -> int:
    """Return a stamp as an integer number of nanoseconds.

    Raises:
        MalformedMessage: it is before zero, or its nanoseconds are more than a second.
    """
    if stamp.sec < 0 or stamp.nanosec >= NS_PER_S:
        given = f"{stamp.sec} s and {stamp.nanosec} ns"
        raise MalformedMessage(f"stamp of {given}: must be at least 0, and less than 1e9 ns")
    return stamp.sec * NS_PER_S + stamp.nanosec


def set_stamp(stamp: Time, ns: int) -> None:
    """Write `ns` nanoseconds into a stamp."""
    stamp.sec, stamp.nanosec = divmod(ns, NS_PER_S)


def reference_message(names: Sequence[str], positions: Sequence[float]) -> JointTrajectory:
    """Return a trajectory of one point: the constant reference of the named joints."""
    point = JointTrajectoryPoint(positions=list(positions), velocities=[0.0] * len(names))
    return JointTrajectory(joint_names=list(names), points=[point])


def setpoint_message(names: Sequence[str]) -> JointTrajectory:
    """Return a trajectory of one empty point: an outer loop's setpoint of the coordinates."""
    return JointTrajectory(joint_names=list(names), points=[JointTrajectoryPoint()])


def set_setpoint(message: JointTrajectory, ns: int, setpoint: Sequence[float]) -> None:
    """Write a setpoint (3 n,), positions, velocities, accelerations, and its stamp [ns]."""
    n = len(setpoint) // 3
    point = cast(Sequence[JointTrajectoryPoint], message.points)[0]
    point.positions, point.velocities, point.accelerations = (
        setpoint[:n],
        setpoint[n : 2 * n],
        setpoint[2 * n :],
    )
    set_stamp(message.header.stamp, ns)


def diagnostics(source: str, warning: str, values: Mapping[str, object]) -> DiagnosticArray:
    """Return one diagnostic status: OK, or WARN where there is a `warning`."""
    level = DiagnosticStatus.WARN if warning else DiagnosticStatus.OK
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    status = DiagnosticStatus(level=level, name=source, message=warning or "running", values=pairs)
    return DiagnosticArray(status=[status])
