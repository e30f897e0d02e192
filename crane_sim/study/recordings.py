"""Recordings of selected runs of a study, which are run once more for that: with the same bits."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.files.installation import require
from crane_sim.recording.files import unfinished_name
from crane_sim.study.cases import CaseList, cases
from crane_sim.study.columns import is_better_larger, worst_joint
from crane_sim.study.result import StudyResult
from crane_sim.study.runs import OK, rows_of, simulate_case
from crane_sim.study.schema import Recordings, Study, scene_document


def selected_cases(result: StudyResult) -> list[int]:
    """Return the numbers of the cases that the study asks to record.

    Raises:
        SceneError: the metric of `worst` is not in the table, or is none.
    """
    wanted, number, status = result.study.recordings, result.column("case"), result.column("status")
    chosen = set(number[status != OK].tolist()) if wanted.failures else set[int]()
    if wanted.every is not None:
        chosen |= set(number[number % wanted.every == 0].tolist())
    if wanted.worst is not None:
        name = wanted.worst.metric
        columns = {each: result.column(each) if each == name else () for each in result.types}
        values = worst_joint(name, [_to_numbers(name, columns)]) * (
            -1.0 if is_better_larger(name) else 1.0
        )
        values[np.isnan(values) & (status == OK)] = np.inf  # as a run that never settles
        order = np.argsort(-np.where(np.isnan(values), -np.inf, values), kind="stable")[
            : wanted.worst.count
        ]
        chosen |= set(number[[i for i in order if not np.isnan(values[i])]].tolist())
    return sorted(chosen)


def check_recorder(study: Study) -> None:
    """Raise SceneError where a study asks for recordings that cannot be written here."""
    if study.recordings != Recordings():
        require("rerun", "study: recordings:")


def check_worst_metric(listed: CaseList) -> None:
    """Check by the first sample that the metric of the worst runs is a column of the table.

    Raises:
        SceneError: its runs have no such metric, or it is text.
    """
    if (worst := listed.study.recordings.worst) is not None:
        columns = rows_of(listed, 0, len(listed.variants), scene_document(listed.study))
        if worst.metric in columns or OK in columns["status"]:
            _to_numbers(worst.metric, columns)


def _to_numbers(metric: str, columns: Mapping[str, Any]) -> Any:
    """Return the column of `worst.metric` as numbers; raises SceneError if missing or text."""
    if metric not in columns:
        raise SceneError(
            f"study: {unknown_key(metric, list(columns), 'metric', 'of recordings.worst.metric')}"
        )
    if any(isinstance(value, str) for value in columns[metric]):
        raise SceneError(f"study: recordings.worst.metric = {metric!r}: is text, not a number")
    return np.array(columns[metric], dtype=float)


def record_selected(result: StudyResult) -> None:
    """Write the study's recordings that are missing: FOLDER/recordings/000012.rrd."""
    if result.study.recordings == Recordings() or not (chosen := selected_cases(result)):
        return
    folder, listed, document = (
        result.folder / "recordings",
        cases(result.study),
        scene_document(result.study),
    )
    folder.mkdir(exist_ok=True)
    for number in chosen:
        file = folder / f"{number:06d}.rrd"
        if file.exists():
            continue
        # of a process that was killed: the same run is recorded anew
        unfinished_name(file).unlink(missing_ok=True)
        run, _, _ = simulate_case(listed[number], document)
        if run is not None and len(run.t):  # a scene that was refused has no run
            run.record(file)
