"""What stands between a law and the crane: sensors, actuators, brakes, and what fails in them.

All of it is compiled code over a few small arrays, so that `simulate` and the plant node pass through the same lines.
"""
