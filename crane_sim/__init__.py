"""An accurate and fast crane simulator of ROS 2 nodes."""
