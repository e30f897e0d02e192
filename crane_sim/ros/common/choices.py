"""Values of parameters that are chosen from a few, with descriptions for options; no rclpy here."""

from enum import StrEnum


class RunMode(StrEnum):
    """Values of the parameter `mode`: when the plant takes its steps."""

    LOCKSTEP = "lockstep"
    REALTIME = "realtime"


class CommandStamps(StrEnum):
    """Values of the parameter `command_stamps`."""

    STATE = "state"
    ROS = "ros"
    ANY = "any"


class CommandTimeoutAction(StrEnum):
    """Values of the parameter `on_silence`: actions of the plant at the time-out of commands."""

    ZERO = "zero"
    HOLD = "hold"
    BRAKE = "brake"


class TransformScope(StrEnum):
    """Values of the parameter `publish_tf`: which transforms the plant publishes."""

    ALL = "all"  # of every frame
    BASE = "base"  # of the base alone, beside a robot_state_publisher
    OFF = "off"


RUN_MODES = tuple(mode.value for mode in RunMode)
COMMAND_STAMPS = tuple(stamps.value for stamps in CommandStamps)
COMMAND_TIMEOUT_ACTIONS = {
    CommandTimeoutAction.ZERO.value: "zero effort",
    CommandTimeoutAction.HOLD.value: "the last effort holds",
    CommandTimeoutAction.BRAKE.value: "the brakes act",
}
"""Descriptions of the actions, by their names."""
TRANSFORM_SCOPES = tuple(scope.value for scope in TransformScope)
