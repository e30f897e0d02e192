"""Fixtures that tests of this folder share."""

from lockstep_doubles import simulation, topics

__all__ = ["simulation", "topics"]
