"""Extent of fuzzing."""

from collections.abc import Callable
from typing import Any

from hypothesis import HealthCheck, given, seed, settings
from hypothesis.strategies import SearchStrategy

CHECKS: dict[str, Any] = {"report_multiple_bugs": False, "suppress_health_check": list(HealthCheck)}


QUICK = CHECKS | {"max_examples": 100}


PART = CHECKS | {"max_examples": 500, "print_blob": True, "database": None}


LONG = CHECKS | {"max_examples": 10_000, "print_blob": True, "database": None, "derandomize": False}


def explore(part: int, check: Callable[..., None], *drawn: SearchStrategy[Any]) -> None:
    """Call a check with 500 examples of its arguments, drawn with its part's number as seed."""
    seed(part)(settings(**PART)(given(*drawn)(check)))()
