"""Fixtures that tests of this folder share."""

from lockstep_doubles import simulation, topics
from realtime_doubles import stepped_clock

__all__ = ["simulation", "stepped_clock", "topics"]
