"""Metrics of a run's summary as one level of names and plain values, as tables hold them."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

_NOT_METRICS = ("scene", "mode", "seed", "law", "error")


def leaves(summary: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the entries of a summary, those of nested groups by dotted key."""
    for key, value in summary.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", value


def flatten(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the metrics of a summary by dotted key; lists become JSON, other values stay."""
    return {key: cell_of(value) for key, value in leaves(summary) if key not in _NOT_METRICS}


def cell_of(value: Any) -> Any:
    """Return a value as a cell of a table holds it."""
    value = plain(value)
    if value is None or isinstance(value, bool | float | str):
        return value
    # whole numbers of metrics are counts; as parameters they are numbers like any other
    return value if isinstance(value, int) else json.dumps(value)


def metric_columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, npt.NDArray[Any]]:
    """Return the metrics of n runs, from `flatten`, as arrays (n,); missing numbers are NaN."""
    columns = {
        key: [row.get(key) for row in rows]
        for key in dict.fromkeys(key for row in rows for key in row)
    }
    return {key: _column(values) for key, values in columns.items()}


def _column(values: list[Any]) -> npt.NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values])


def one_run(metrics: Mapping[str, Any]) -> dict[str, Any]:
    """Return the metrics of the first of n runs, arrays (n,) in groups, as plain numbers."""
    return {
        key: one_run(value) if isinstance(value, Mapping) else plain(value[0])
        for key, value in metrics.items()
    }


def plain(value: Any) -> Any:
    """Return a number of NumPy as one of Python, anything else as it is."""
    return value.item() if isinstance(value, np.generic) else value


def or_none(values: npt.NDArray[np.float64], there: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """Return values where they are there, elsewhere None."""
    found = values.astype(object)
    found[~there] = None
    return found
