"""MCAP files of a run's ROS messages."""
