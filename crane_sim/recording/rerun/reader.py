"""Reads a recording back as arrays."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from rerun.chunk import RrdReader

SCALARS = "Scalars:scalars"


class Curves(NamedTuple):
    """The rows of one entity, in the order of steps."""

    step: NDArray[np.int64]  # (K,)
    time: NDArray[np.float64]  # (K,) s, scene time
    values: NDArray[np.float64]  # (K, curves)


def read_curves(path: Path, entity: str) -> Curves:
    """Return the curves of an entity such as `plots/q`, each step once.

    Raises:
        KeyError: the recording has no such curves.
    """
    batches = [
        chunk.to_record_batch()
        for chunk in _open_recording(path).stream()
        if chunk.entity_path == f"/{entity}" and not chunk.is_static
    ]
    batches = [batch for batch in batches if SCALARS in batch.schema.names]
    if not batches:
        raise KeyError(f"{path} has no curves {entity!r}")
    step = np.concatenate([batch["step"].to_numpy() for batch in batches])
    time = np.concatenate([batch["sim_time"].cast(pa.int64()).to_numpy() for batch in batches])
    values = np.concatenate([_rows(batch[SCALARS], batch.num_rows) for batch in batches])
    _, order = np.unique(step, return_index=True)  # where two recorders wrote one step, they wrote the same
    return Curves(step[order], time[order] * 1e-9, values[order])


def read_summary(path: Path) -> dict[str, Any]:
    """Return the summary of a complete recording.

    Raises:
        KeyError: it has none: its recorder was killed.
    """
    for chunk in _open_recording(path).stream():
        if chunk.entity_path == "/__properties/summary":
            return json.loads(chunk.to_record_batch()["json"][0].as_py()[0])
    raise KeyError(f"{path} has no summary")


def _open_recording(path: Path) -> RrdReader:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "RRD file has no footer")  # that of a long run, or of a killed recorder
        return RrdReader(path)


def _rows(column: pa.Array, rows: int) -> NDArray[np.float64]:
    return column.flatten().to_numpy(zero_copy_only=False).reshape(rows, -1)
