"""Hostile messages, the same for the same seed, on all topics: out of range or broken."""

import random
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Float64MultiArray, String, UInt8
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

NS_PER_S = 1_000_000_000
_STREAM, _LATCHED = (
    QoSProfile(depth=1000),
    QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL),
)
_NUMBERS = (
    float("nan"),
    float("inf"),
    float("-inf"),
    0.0,
    -0.0,
    1.0,
    -3.0,
    1e-310,
    1e9,
    1.7e308,
    -1.7e308,
)
_SECONDS = (0, 1, -1, -(2**31), 2**31 - 1)
_NANOSECONDS = (0, 1, NS_PER_S - 1, NS_PER_S, 2**32 - 1)


class Kind(NamedTuple):
    """A topic's type and the quality of service that reaches its subscribers."""

    message: Any
    qos: QoSProfile = _STREAM


TOPICS = {
    **dict.fromkeys(
        ("joint_states", "true_states", "applied_effort", "joint_commands"), Kind(JointState)
    ),
    **dict.fromkeys(("accepted_command", "held_command"), Kind(JointState)),
    **dict.fromkeys(("joint_trajectory", "tip_demand"), Kind(JointTrajectory)),
    **dict.fromkeys(("payload_pose", "camera/payload_pose"), Kind(PoseStamped)),
    "effort_controller/commands": Kind(Float64MultiArray),
    "base/odometry": Kind(Odometry),
    "base/imu": Kind(Imu),
    "robot_description": Kind(String, _LATCHED),
    "simulation_state": Kind(UInt8, _LATCHED),
    "/clock": Kind(Clock),
    "/diagnostics": Kind(DiagnosticArray),
}


class HostileMessages:
    """A generator of serialized messages."""

    def __init__(
        self, seed: int, namespace: str, joints: Sequence[str], actuated: Sequence[str]
    ) -> None:
        """Generate from a seed for a crane with these joints."""
        self._random, self._namespace = random.Random(seed), namespace
        self._joints, self._actuated = list(joints), list(actuated)
        self._fill: Mapping[Any, Callable[[int], Any]] = {
            JointState: self._joint_state,
            JointTrajectory: self._trajectory,
            Float64MultiArray: lambda _: Float64MultiArray(data=self._numbers()),
            DiagnosticArray: self._diagnostics,
            String: lambda _: String(data=self._choice(("", "<robot/>", "ß" * 1000))),
            UInt8: lambda _: UInt8(data=self._random.randrange(256)),
            Clock: lambda now: Clock(clock=self._time(now)),
            **{kind: self._stamped(kind) for kind in (PoseStamped, Odometry, Imu)},
        }

    def generate(self, topic: str, now: int) -> bytes:
        """Return a message for a topic while the newest state has the stamp `now` [ns]."""
        data = serialize_message(self._fill[TOPICS[topic].message](now))
        return self._corrupt(data) if self._random.random() < 0.3 else data

    def _choice(self, values: Sequence[Any]) -> Any:
        return self._random.choice(values)

    def _time(self, now: int) -> Time:
        if self._random.random() < 0.5:
            near = max(0, now + self._choice((0, 0, 1, -1, 10_000_000, -10_000_000, 50_000_000)))
            return Time(sec=near // NS_PER_S, nanosec=near % NS_PER_S)
        return Time(sec=self._choice(_SECONDS), nanosec=self._choice(_NANOSECONDS))

    def _numbers(self, count: int | None = None) -> list[float]:
        count = self._choice((0, 1, 2, 3, 100)) if count is None else count
        if self._random.random() < 0.5:
            return [self._random.uniform(-10.0, 10.0) for _ in range(count)]
        return [self._choice(_NUMBERS) for _ in range(count)]

    def _names(self) -> list[str]:
        right = self._choice((self._joints, self._actuated))
        wrong = self._choice(([], [""], ["ß" * 50], [*right, "hoist"], right[::-1], right * 50))
        return list(right) if self._random.random() < 0.6 else list(wrong)

    def _joint_state(self, now: int) -> JointState:
        names, whole = self._names(), self._random.random() < 0.6
        fields = {
            name: self._numbers(len(names) if whole else None)
            for name in ("position", "velocity", "effort")
        }
        message = JointState(name=names, **fields)
        message.header.stamp = self._time(now)
        return message

    def _trajectory(self, now: int) -> JointTrajectory:
        names = self._choice((self._names(), ["x", "y"], ["tip_x", "tip_y"]))
        points = []
        for _ in range(self._choice((0, 1, 1, 2, 5))):
            vectors = {
                name: self._numbers(len(names))
                for name in ("positions", "velocities", "accelerations")
            }
            point = JointTrajectoryPoint(**vectors)
            point.time_from_start.sec = self._choice(_SECONDS)
            point.time_from_start.nanosec = self._choice(_NANOSECONDS)
            points.append(point)
        message = JointTrajectory(joint_names=names, points=points)
        message.header.stamp = self._time(now)
        return message

    def _diagnostics(self, now: int) -> DiagnosticArray:
        """Return diagnostics in the name of the plant: brakes, and commands that were refused."""
        values = [
            KeyValue(key=key, value="7")
            for key in ("warning: brakes", "warning: commands", "refused: huge")
        ]
        name = self._choice(("", f"{self._namespace}/plant", f"{self._namespace}/controller"))
        message = DiagnosticArray(status=[DiagnosticStatus(name=name, values=values)])
        message.header.stamp = self._time(now)
        return message

    def _stamped(self, kind: Any) -> Callable[[int], Any]:
        def fill(now: int) -> Any:
            message = kind()
            message.header.stamp = self._time(now)
            return message

        return fill

    def _corrupt(self, data: bytes) -> bytes:
        """Return a message cut off, with flipped bits, an impossible length, or noise.

        DDS wants 4 bytes.
        """
        size = self._random.randrange(4, len(data) + 1)
        flipped = bytearray(data)
        for _ in range(self._choice((1, 1, 8))):
            flipped[self._random.randrange(len(flipped))] ^= 1 << self._random.randrange(8)
        long = data[:size] + (2**32 - 1).to_bytes(4, "little") + data[size:]
        return self._choice(
            (data[:size], bytes(flipped), long, data[:4] + self._random.randbytes(size))
        )
