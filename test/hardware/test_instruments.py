"""Instruments: an inertial measurement unit and a camera, each against its own computation.

The unit is on the base.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from random_reference import normal
from scipy.spatial.transform import Rotation

from crane_sim import load_scene
from crane_sim.files.errors import SceneError
from crane_sim.hardware.instruments import CAMERA_STREAM, IMU_STREAM, Sampling
from crane_sim.recording.base_frame import to_base
from crane_sim.ros.plant.instrument_topics import InstrumentTopic, camera_topic, imu_topic
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.base_state import base_state
from crane_sim.simulation.measurements import measure_imu, measure_payload
from crane_sim.simulation.plant import Plant
from crane_sim.trajectories.base_motion import base_positions

MOTION = {
    "sway": {"amplitude": 0.6, "frequency": 0.8},
    "roll": {"amplitude": "7 deg", "frequency": 0.9},
    "yaw": {"amplitude": "4 deg", "frequency": 0.4, "offset": "30 deg"},
}
ERRORS = {
    "acceleration_noise": 0.02,
    "acceleration_bias": [0.1, -0.05, 0.03],
    "angular_velocity_noise": 0.001,
    "angular_velocity_bias": [1e-3, 2e-3, -1e-3],
    "orientation_noise": 0.01,
}
ARM = [3.0, -2.0, 1.5]


def ship(**groups: Any) -> Scene:
    """Return a knuckle crane on a ship, with further groups."""
    return load_scene(
        "knuckle_setpoint", {"base_motion": MOTION, "seed": 41, "duration": 1.0} | groups
    )


def imu_of(scene: Scene) -> Any:
    """Return the inertial measurement unit of a scene."""
    assert scene.instruments is not None
    return scene.instruments.imu


def camera_of(scene: Scene) -> Any:
    """Return the camera of a scene."""
    assert scene.instruments is not None
    return scene.instruments.camera


def test_a_unit_beside_the_origin_feels_what_a_base_there_does() -> None:
    """A unit at a point of the base measures what a base with its origin there does.

    This is the lever arm.
    """
    scene, there = (
        ship(imu={"position": ARM}),
        ship(base_motion=MOTION | {"mount": {"position": ARM}}),
    )
    for k in (0, 50, 90):
        sample, expected = measure_imu(scene, imu_of(scene), k), base_state(there, k * scene.period)
        # rounding
        assert sample.specific_force == pytest.approx(expected.specific_force, abs=1e-13)
        assert sample.angular_velocity == pytest.approx(expected.angular_velocity, abs=1e-15)
        assert sample.rotation is None


def test_a_unit_at_rest_shows_gravity_upwards() -> None:
    """On a base that rests the specific force is g upwards, and nothing turns."""
    scene = load_scene("overhead_energy", {"imu": {"orientation_noise": 0.0}})
    sample = measure_imu(scene, imu_of(scene), 7)
    assert sample.specific_force.tolist() == [0.0, 0.0, scene.model.gravity]
    assert sample.angular_velocity.tolist() == [0.0, 0.0, 0.0]
    assert sample.rotation is not None and np.array_equal(sample.rotation, np.eye(3))


def test_errors_are_drawn_by_seed_signal_and_period() -> None:
    """Every sample is truth, bias and the normal numbers of its seed, signals and period."""
    scene, exact = ship(imu=ERRORS), ship(imu={"orientation_noise": 0.0})
    for k in (0, 3, 60):
        noise = np.array([normal(41, IMU_STREAM + 2 * i, k) for i in range(9)]).reshape(3, 3)
        sample, truth = measure_imu(scene, imu_of(scene), k), measure_imu(exact, imu_of(exact), k)
        force = truth.specific_force + ERRORS["acceleration_bias"] + 0.02 * noise[0]
        assert sample.specific_force == pytest.approx(force, abs=1e-14)  # rounding
        turning = truth.angular_velocity + ERRORS["angular_velocity_bias"] + 0.001 * noise[1]
        assert sample.angular_velocity == pytest.approx(turning, abs=1e-16)
        assert truth.rotation is not None and sample.rotation is not None
        turned = truth.rotation @ Rotation.from_rotvec(0.01 * noise[2]).as_matrix()
        assert sample.rotation == pytest.approx(turned, abs=1e-15)


def test_a_camera_sees_the_payload_from_the_base() -> None:
    """A frame is the payload in the base frame, with bias and the noise of seed and period."""
    scene = ship(camera={"noise": 0.02, "bias": [0.1, 0.0, -0.1]})
    payload, k = (4.0, 1.0, -2.0), 33
    aboard = to_base(
        np.array([[payload]]), base_positions(scene.model.base, np.array([k * scene.period]))
    )[0, 0]
    noise = [normal(41, CAMERA_STREAM + 2 * i, k) for i in range(3)]
    expected = aboard + [0.1, 0.0, -0.1] + 0.02 * np.array(noise)
    # rounding
    assert measure_payload(scene, camera_of(scene), k, payload) == pytest.approx(
        expected, abs=1e-14
    )


class Publisher:
    """A publisher whose messages are kept.

    Attributes:
        messages: published so far.
        subscribers: their number.
    """

    def __init__(self) -> None:
        """Begin with one subscriber."""
        self.messages: list[Any] = []
        self.subscribers = 1

    def publish(self, message: Any) -> None:
        """Keep a message."""
        self.messages.append(message)

    def get_subscription_count(self) -> int:
        """Return the number of subscribers."""
        return self.subscribers


def watch(topic: InstrumentTopic, plant: Plant, steps: int) -> None:
    """Advance a plant by steps, each published as the node does."""
    topic.update_subscribers()
    for _ in range(steps):
        topic.publish((plant.k + 1) * plant.scene.period_ns, plant)
        plant.advance((0.0,) * len(plant.scene.actuated))


def test_messages_come_late_and_say_when_they_were_taken() -> None:
    """Each message has the time and numbers of its sample, and comes some periods later.

    It has a rate and a delay.
    """
    scene, publisher = (
        ship(imu=ERRORS | {"rate": 25.0, "delay": 0.03, "position": ARM}),
        Publisher(),
    )
    node: Any = SimpleNamespace(create_publisher=lambda *_: publisher)
    imu, plant = imu_of(scene), Plant(scene)
    topic, every, late = (
        imu_topic(node, "a/", imu),
        round(0.04 / scene.period),
        round(0.03 / scene.period),
    )
    for k in range(1, 30):
        watch(topic, plant, 1)  # the state of period k - 1 has been published
        taken = range(0, k - late, every)
        assert len(publisher.messages) == len(taken)
        if taken:
            message, sample = publisher.messages[-1], measure_imu(scene, imu, taken[-1])
            stamp = message.header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == (taken[-1] + 1) * scene.period_ns
            force = message.linear_acceleration
            assert [force.x, force.y, force.z] == sample.specific_force.tolist()
            assert message.header.frame_id == "a/imu_link"
            assert message.linear_acceleration_covariance[4] == 0.02**2
            assert message.orientation_covariance[0] == 0.01**2
    plant.reset()
    before = len(publisher.messages)
    watch(topic, plant, late + 1)  # what was under way at the reset never comes
    assert len(publisher.messages) == before + 1
    assert publisher.messages[-1].header.stamp.nanosec == scene.period_ns


def test_a_reset_drops_samples_of_the_run_before() -> None:
    """A run begun anew after its first period sends samples of its own only, and all of them."""
    sent: list[str] = []
    publisher = SimpleNamespace(
        get_subscription_count=lambda: 1, publish=lambda message: sent.append(message.run)
    )
    stamp = SimpleNamespace(sec=0, nanosec=0)
    header = SimpleNamespace(stamp=stamp)
    topic = InstrumentTopic(
        publisher, Sampling(10, 2), lambda plant: SimpleNamespace(run=plant.run, header=header)
    )
    topic.update_subscribers()
    plant: Any = SimpleNamespace()
    for plant.k, plant.run in (
        (0, "before"),
        (1, "before"),
        (0, "after"),
        (1, "after"),
        (2, "after"),
        (3, "after"),
    ):
        topic.publish(0, plant)
    assert sent == ["after"]


def test_without_orientation_a_message_says_so() -> None:
    """A unit that measures no orientation marks it as unavailable, as sensor_msgs/Imu has it."""
    scene, publisher = ship(imu={}), Publisher()
    node: Any = SimpleNamespace(create_publisher=lambda *_: publisher)
    watch(imu_topic(node, "", imu_of(scene)), Plant(scene), 1)
    assert publisher.messages[0].orientation_covariance[0] == -1.0


def test_a_camera_without_subscribers_takes_no_frames() -> None:
    """Without subscribers no frame is taken; the first one for a new subscriber is a new one."""
    scene, publisher = ship(camera={"delay": 0.02}), Publisher()
    node: Any = SimpleNamespace(create_publisher=lambda *_: publisher)
    topic, plant = camera_topic(node, "", camera_of(scene)), Plant(scene)
    publisher.subscribers = 0
    watch(topic, plant, 5)
    publisher.subscribers = 1
    late = round(0.02 / scene.period)
    watch(topic, plant, late)
    assert not publisher.messages
    watch(topic, plant, 1)
    assert publisher.messages[0].header.stamp.nanosec == 6 * scene.period_ns


@pytest.mark.parametrize(
    ("group", "line"),
    [
        ({"imu": {"delay": 1e6}}, "imu.delay: 1e"),
        ({"camera": {"rate": 1e-6}}, "camera.rate: 1e"),
        ({"imu": {"noise": 1.0}}, "imu: unknown key 'noise'"),
        ({"camera": {"noise": -1.0}}, "camera.noise = -1"),
        ({"imu": {"position": [1.0, 2.0]}}, "imu.position"),
    ],
    ids=str,
)
def test_what_no_instrument_can_be_is_refused(group: dict[str, Any], line: str) -> None:
    """A scene with such a group is refused in one line that names the key."""
    with pytest.raises(SceneError, match=line) as error:
        ship(**group)
    assert "\n" not in str(error.value)


def test_instruments_change_no_state() -> None:
    """A run with instruments has the bits of one without, and a law's nominal crane has none."""
    with_them, without = ship(imu=ERRORS, camera={"noise": 0.1}), ship()
    plants = [Plant(with_them), Plant(without)]
    for plant in plants:
        for _ in range(5):
            plant.advance((10.0,) * len(plant.scene.actuated))
    assert plants[0].summary()["state_sha256"] == plants[1].summary()["state_sha256"]
