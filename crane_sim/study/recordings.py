"""Recordings of selected runs of a study, which are run once more for that: with the same bits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.files.installation import require
from crane_sim.recording.files import unfinished_name
from crane_sim.study.cases import CaseList, cases
from crane_sim.study.columns import is_better_larger, worst_joint
from crane_sim.study.runs import OK, rows_of, simulate_case
from crane_sim.study.schema import scene_document

if TYPE_CHECKING:
    from crane_sim.study.result import StudyResult
    from crane_sim.study.schema import Study


def selected_cases(result: StudyResult) -> list[int]:
    """Return the numbers of the cases that the study asks to record.

    Raises:
        SceneError: the metric of `worst` is not in the table, or is none.
    """
    wanted = result.study.recordings
    if not _records_runs(result.study):
        return []
    number, status = result.column("case"), result.column("status")
    chosen: set[int] = set()
    if wanted.failures:
        chosen |= set(number[status != OK].tolist())
    if wanted.every is not None:
        chosen |= set(number[number % wanted.every == 0].tolist())
    if wanted.worst is not None:
        values = _larger_is_worse(result, wanted.worst.metric)
        values[np.isnan(values) & (status == OK)] = np.inf  # as a run that never settles
        order = np.argsort(-np.where(np.isnan(values), -np.inf, values), kind="stable")[: wanted.worst.count]
        chosen |= set(number[[i for i in order if not np.isnan(values[i])]].tolist())
    return sorted(chosen)


def _records_runs(study: Study) -> bool:
    return bool(study.recordings.failures or study.recordings.every or study.recordings.worst)


def check_recorder(study: Study) -> None:
    """Raise SceneError where a study asks for recordings that cannot be written here."""
    if _records_runs(study):
        require("rerun", "study: recordings:")


def check_worst_metric(listed: CaseList) -> None:
    """Run the first sample of a study that records its worst runs, to see whether the metric is a column of its table.

    Raises:
        SceneError: its runs have no such metric, or it is text.
    """
    worst, count = listed.study.recordings.worst, len(listed.variants)
    if worst is None:
        return
    columns = rows_of(listed, 0, count, scene_document(listed.study))
    if worst.metric in columns or OK in columns["status"]:
        _to_numbers(worst.metric, columns)


def _larger_is_worse(result: StudyResult, metric: str) -> Any:
    """Return the column of `worst.metric` as numbers that are larger where runs are worse, NaN where they have none."""
    columns = {name: result.column(name) if name == metric else () for name in result.types}
    values = worst_joint(metric, [_to_numbers(metric, columns)])
    return -values if is_better_larger(metric) else values


def _to_numbers(metric: str, columns: Mapping[str, Any]) -> Any:
    """Return the column of `worst.metric` as numbers; raises SceneError where there is none, or it is text."""
    if metric not in columns:
        raise SceneError(f"study: {unknown_key(metric, list(columns), 'metric', 'of recordings.worst.metric')}")
    if any(isinstance(value, str) for value in columns[metric]):
        raise SceneError(f"study: recordings.worst.metric = {metric!r}: is text, not a number")
    return np.array(columns[metric], dtype=float)


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
        unfinished_name(file).unlink(missing_ok=True)  # of a process that was killed: the same run is recorded anew
        run, _, _ = simulate_case(listed[number], document)
        if run is not None and len(run.t):  # a scene that was refused has no run
            run.record(file)
