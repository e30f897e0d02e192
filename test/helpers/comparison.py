"""Relative errors."""

from typing import Any

import numpy as np


def relative(actual: Any, expected: Any) -> float:
    """Return the largest difference relative to the largest expected value."""
    return float(np.max(np.abs(np.subtract(actual, expected))) / np.max(np.abs(expected)))
