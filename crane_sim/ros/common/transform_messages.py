"""Messages and qualities of service of `/tf` and `/tf_static`, as tf2_ros has them."""

from importlib import import_module
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile

try:
    TFMessage: Any = import_module("tf2_msgs.msg").TFMessage
except ImportError:  # no wheel has it; `./crane interfaces` builds it
    TFMessage = None

DYNAMIC = QoSProfile(depth=100)
STATIC = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
