"""Between a frame that turns about the vertical and inertial space; axes are the frame's."""


def inertial_velocity(position, velocity, w):
    """Return the inertial velocity (3,) of a point with this `velocity` in the frame.

    w is the yaw rate of the frame.
    """
    return velocity[0] - w * position[1], velocity[1] + w * position[0], velocity[2]


def inertial_acceleration(second, position, velocity, w, w_dot):
    """Return the inertial acceleration (3,) from the second rate of change of frame coordinates."""
    return (
        second[0] - 2.0 * w * velocity[1] - w_dot * position[1] - w * w * position[0],
        second[1] + 2.0 * w * velocity[0] + w_dot * position[0] - w * w * position[1],
        second[2],
    )


def frame_acceleration(inertial, position, velocity, w, w_dot):
    """Return the frame coordinates' second derivative (3,).

    This is the inverse of `inertial_acceleration`.
    """
    return (
        inertial[0] + 2.0 * w * velocity[1] + w_dot * position[1] + w * w * position[0],
        inertial[1] - 2.0 * w * velocity[0] - w_dot * position[0] + w * w * position[1],
        inertial[2],
    )
