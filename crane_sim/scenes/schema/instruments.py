"""The groups of a scene file on more measurements: an inertial measurement unit, and a camera."""

from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.scenes.schema.groups import Group

Vector = tuple[Real, Real, Real]
NOTHING: Vector = (0.0, 0.0, 0.0)


class ImuGroup(Group):
    """An inertial measurement unit in the base's axes; on a ship, the motion reference unit.

    Over ROS it is the topic `base/imu`. It measures the specific force, acceleration less gravity,
    and the angular velocity. Random numbers depend on seed, signal and step: every run repeats to
    the last bit.
    """

    position: Vector = NOTHING  # m, in the axes of the base, from its origin
    acceleration_noise: NonNegative = 0.0  # m/s², standard deviation of each component of a sample
    acceleration_bias: Vector = NOTHING  # m/s², what is added to every sample
    angular_velocity_noise: NonNegative = 0.0  # rad/s, standard deviation of each component of a
    # sample
    angular_velocity_bias: Vector = NOTHING  # rad/s, what is added to every sample
    orientation_noise: NonNegative | None = None  # rad, standard deviation about each axis of the
    # base; left out: no orientation is measured, which the messages say
    rate: Positive | None = None  # Hz, of samples; rounded to whole periods; left out: every period
    delay: NonNegative = 0.0  # s, from a sample to its message, which has the time of the sample;
    # rounded to whole periods


class CameraGroup(Group):
    """A camera that measures the payload's position in the base's axes: a topic, no law's input.

    Over ROS it is the topic `camera/payload_pose`, beside the true one. Laws have a camera of their
    own (`control.vision`).
    """

    noise: NonNegative = 0.0  # m, standard deviation of each coordinate of a frame
    bias: Vector = NOTHING  # m, what is added to every frame
    rate: Positive | None = None  # Hz, of frames; rounded to whole periods; left out: every period
    delay: NonNegative = 0.0  # s, from a frame to its message, which has the time of the frame;
    # rounded to whole periods
