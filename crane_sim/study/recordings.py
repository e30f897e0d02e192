"""Recordings of selected runs of a study, which are run once more for that: with the same bits."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.study.cases import cases
from crane_sim.study.runs import OK, simulate_case
from crane_sim.study.schema import scene_document

if TYPE_CHECKING:
    from crane_sim.study.result import StudyResult


def selected_cases(result: StudyResult) -> list[int]:
    """Return the numbers of the cases that the study asks to record.

    Raises:
        SceneError: the metric of `worst` is not in the table, or is none.
    """
    wanted = result.study.recordings
    if not (wanted.failures or wanted.every or wanted.worst):
        return []
    number, status = result.column("case"), result.column("status")
    chosen: set[int] = set()
    if wanted.failures:
        chosen |= set(number[status != OK].tolist())
    if wanted.every is not None:
        chosen |= set(number[number % wanted.every == 0].tolist())
    if wanted.worst is not None:
        values = _metric(result, wanted.worst.metric)
        order = np.argsort(-np.where(np.isnan(values), -np.inf, values), kind="stable")[: wanted.worst.count]
        chosen |= set(number[[i for i in order if not np.isnan(values[i])]].tolist())
    return sorted(chosen)


def _metric(result: StudyResult, metric: str) -> Any:
    if metric not in result.types:
        raise SceneError(f"study: {unknown_key(metric, list(result.types), 'metric', 'of recordings.worst.metric')}")
    try:
        return np.array(result.column(metric), dtype=float)
    except (TypeError, ValueError):
        raise SceneError(f"study: recordings.worst.metric = {metric!r}: is text, not a number") from None


def record_selected(result: StudyResult) -> None:
    """Write the recordings that the study asks for and that are not there: FOLDER/recordings/000012.rrd."""
    chosen = selected_cases(result)
    if not chosen:
        return
    folder, listed, document = result.folder / "recordings", cases(result.study), scene_document(result.study)
    folder.mkdir(exist_ok=True)
    for number in chosen:
        file = folder / f"{number:06d}.rrd"
        if file.exists():
            continue
        run, _, _ = simulate_case(listed[number], document)
        if run is not None and len(run.t):  # a scene that was refused has no run
            run.record(file)
