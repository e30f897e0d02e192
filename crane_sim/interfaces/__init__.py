"""Message packages that ROS 2's wheels lack: which are importable, and how they are built."""
