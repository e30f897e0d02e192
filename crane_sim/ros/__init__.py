"""The ROS nodes: rclpy is imported here, and in the controller's node, and nowhere else."""
