"""Supervision of runs over ROS: processes, their pipes and reports; no rclpy here."""

from crane_sim.orchestration.runs import run

__all__ = ["run"]
