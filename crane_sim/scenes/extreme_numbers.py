"""Numbers of a scene that are so large or so small that its equations overflow."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import inf, log10
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError


@contextmanager
def refuse_extreme_numbers(document: Mapping[str, Any]) -> Iterator[None]:
    """Raise SceneError with the document's most extreme number where arithmetic fails."""
    try:
        yield
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        key, size = max(
            _sizes(document, ""), key=lambda each: abs(log10(each[1])), default=("a number", inf)
        )
        raise SceneError(
            f"{key} = {size:g}: the equations cannot be evaluated ({error}); this is the number of "
            "the scene "
            "that is the largest or smallest"
        ) from None


def _sizes(part: Any, path: str) -> Iterator[tuple[str, float]]:
    """Yield (dotted key, size) of all numbers in a part of a document that are finite and not 0."""
    if isinstance(part, Mapping | list | tuple):
        for name, each in part.items() if isinstance(part, Mapping) else enumerate(part):
            yield from _sizes(each, f"{path}.{name}" if path else str(name))
    elif isinstance(part, int | float) and 0.0 < abs(part) <= sys.float_info.max:
        yield path, float(abs(part))
