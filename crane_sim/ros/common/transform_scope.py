"""The values of the plant's parameter `publish_tf`."""

from enum import StrEnum


class TransformScope(StrEnum):
    """Which transforms the plant publishes."""

    ALL = "all"  # of every frame
    BASE = "base"  # of the base alone, beside a robot_state_publisher
    OFF = "off"


TRANSFORM_SCOPES = tuple(scope.value for scope in TransformScope)
