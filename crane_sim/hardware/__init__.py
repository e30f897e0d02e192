"""Hardware between a law and the crane: sensors, actuators, brakes, and their faults.

All of it is compiled code over a few small arrays, so that `simulate` and the plant node run the
same code.
"""
