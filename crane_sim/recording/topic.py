"""What a bag says of a topic; apart from its writer, which needs a package that not everyone has."""

from typing import NamedTuple


class Topic(NamedTuple):
    """A topic with the type and the quality of service that its publisher has."""

    name: str  # with its namespace
    kind: str  # "sensor_msgs/msg/JointState"
    stamped: bool  # its messages begin with a header
    latched: bool  # who comes late gets the last message, too
    reliable: bool
