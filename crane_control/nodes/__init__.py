"""The nodes that run laws."""

from crane_sim.ros.common import (
    node_host as node_host,
)  # before rclpy: it ends a process without ROS in one line
