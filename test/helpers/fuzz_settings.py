"""Extent of fuzzing."""

from typing import Any

from hypothesis import HealthCheck

CHECKS: dict[str, Any] = {"report_multiple_bugs": False, "suppress_health_check": list(HealthCheck)}


QUICK = CHECKS | {"max_examples": 100}


LONG = CHECKS | {"max_examples": 10_000, "print_blob": True, "database": None, "derandomize": False}
