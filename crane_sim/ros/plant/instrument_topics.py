"""The topics of a scene's instruments: `base/imu` and `camera/payload_pose`.

Each message is published at the time of its sample.
"""

from collections import deque
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu as ImuMessage

from crane_sim.description import IMU
from crane_sim.description.rotations import quaternion_of
from crane_sim.description.transforms import BASE
from crane_sim.hardware.instruments import Camera, Imu, Sampling
from crane_sim.ros.common import messages
from crane_sim.ros.plant.state_publisher import StatePublisher, set_quaternion, set_vector
from crane_sim.simulation.measurements import measure_imu, measure_payload
from crane_sim.simulation.plant import Plant

_UNAVAILABLE = (-1.0, *(0.0,) * 8)  # as sensor_msgs/Imu has it


class InstrumentTopic(StatePublisher):
    """Publisher of samples, taken at whole numbers of periods and sent after their delay."""

    def __init__(self, publisher: Any, sampling: Sampling, measure: Callable[[Plant], Any]) -> None:
        """Publish what `measure` makes of a plant: messages with a header."""
        super().__init__(publisher)
        self._sampling, self._measure = sampling, measure
        # periods in which they were taken, and messages
        self._samples: deque[tuple[int, Any]] = deque()
        self._last = -1  # period of the last sample
        self._period = 0  # of the last call

    def publish(self, stamp: int, plant: Plant) -> None:
        """See `StatePublisher`."""
        if not self._subscribers or plant.k < self._period:  # the run has begun anew
            self._samples.clear()
            self._last = -1
        self._period = plant.k
        if self._subscribers and plant.k % self._sampling.every == 0 and plant.k != self._last:
            message, self._last = self._measure(plant), plant.k
            messages.set_stamp(message.header.stamp, stamp)
            self._samples.append((plant.k, message))
        while self._samples and self._samples[0][0] + self._sampling.delay <= plant.k:
            self._publisher.publish(self._samples.popleft()[1])


def imu_topic(node: Node, prefix: str, imu: Imu) -> InstrumentTopic:
    """Return the publisher of an inertial measurement unit; frames begin with the prefix."""

    def measure(plant: Plant) -> ImuMessage:
        sample = measure_imu(plant.scene, imu, plant.k)
        message = ImuMessage()
        message.header.frame_id = prefix + IMU
        set_vector(message.linear_acceleration, sample.specific_force)
        set_vector(message.angular_velocity, sample.angular_velocity)
        message.linear_acceleration_covariance = _covariance(imu.acceleration[0])
        message.angular_velocity_covariance = _covariance(imu.angular_velocity[0])
        message.orientation_covariance = (
            _UNAVAILABLE if imu.orientation is None else _covariance(imu.orientation)
        )
        if sample.rotation is not None:
            set_quaternion(message.orientation, quaternion_of(sample.rotation))
        return message

    return InstrumentTopic(
        node.create_publisher(ImuMessage, "base/imu", messages.STREAM_QOS), imu.sampling, measure
    )


def camera_topic(node: Node, prefix: str, camera: Camera) -> InstrumentTopic:
    """Return the publisher of a camera that measures the payload; frames begin with the prefix."""

    def measure(plant: Plant) -> PoseStamped:
        message = PoseStamped()
        message.header.frame_id = prefix + BASE
        set_vector(
            message.pose.position, measure_payload(plant.scene, camera, plant.k, plant.payload)
        )
        return message

    publisher = node.create_publisher(PoseStamped, "camera/payload_pose", messages.STREAM_QOS)
    return InstrumentTopic(publisher, camera.sampling, measure)


def _covariance(deviation: float) -> list[float]:
    """Return the covariance (9,) of three components with the same standard deviation."""
    return [deviation * deviation if i % 4 == 0 else 0.0 for i in range(9)]
