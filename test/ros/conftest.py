"""Fixtures that tests of this folder share."""

from lockstep_doubles import stepper, topics

__all__ = ["stepper", "topics"]
