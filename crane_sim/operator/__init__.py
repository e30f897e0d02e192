"""An operator at a desk: devices, levers, the desk's interlocks, drives by speed; without ROS."""
