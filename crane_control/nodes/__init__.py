"""The nodes that run laws."""

# before rclpy: it ends a process without ROS in one line
from crane_sim.ros.common import node_host as node_host
