"""Runs over ROS from the outside: processes, their pipes, what they report; no rclpy here."""

from crane_sim.orchestration.runs import run

__all__ = ["run"]
