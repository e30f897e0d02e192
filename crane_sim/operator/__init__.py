"""What an operator at a desk does with a crane: devices, levers, the desk's interlocks, drives by speed; no ROS."""
