"""Runs of a study, as the rows of its table."""

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene, load_scenes
from crane_sim.simulation.batch_metrics import (
    Attempt,
    Measure,
    RunEnd,
    attempt_run,
    run_all,
    run_alone,
)
from crane_sim.simulation.flat_summary import cell_of
from crane_sim.simulation.rollout import Rollout
from crane_sim.study.cases import Case, CaseList
from crane_sim.study.columns import FIRST_COLUMNS, PARAMETER, OwnMetric
from crane_sim.study.identity import versions
from crane_sim.study.own_metrics import load_metrics

OK, FAILED, REFUSED = "ok", "failed", "refused"
"""Statuses of a row: the run reached its end; it ended before; its scene is not possible."""
Table = dict[str, Any]
"""Columns by name, a list or an array each, with an entry for each case."""


def rows_of(listed: CaseList, first: int, end: int, document: Mapping[str, Any]) -> Table:
    """Return the rows of the cases `first` to `end` (excluded).

    A row has the parameters, all metrics of the summary, status and error.

    Whatever ends a run is in its row: no error is raised. Scenes of one kind run in one compiled
    call; a case has the numbers of its single run, bit for bit.
    """
    start, count = time.perf_counter(), end - first
    own, measure = dict[str, None](), load_metrics(listed.study)

    def measure_and_note(run: Rollout) -> dict[str, float | None]:
        found = measure(run) if measure is not None else {}
        own.update(dict.fromkeys(found))
        return found

    listed_cases = [listed[number] for number in range(first, end)]
    rows = _run_cases(listed_cases, document, measure and measure_and_note)
    names = dict.fromkeys((*FIRST_COLUMNS, *(name for row in rows for name in row)))
    table = {name: [row.get(name) for row in rows] for name in names}
    table |= {name: OwnMetric(table[name]) for name in own}
    each = (time.perf_counter() - start) / count
    return table | {"versions": [json.dumps(versions())] * count, "wall_time": [each] * count}


def _run_cases(
    cases: Sequence[Case], document: Mapping[str, Any], measure: Measure | None
) -> list[dict[str, Any]]:
    """Return the rows of cases; `measure`: their further metrics."""
    scenes = load_scenes(document, [case.changes for case in cases])
    possible = [scene for scene in scenes if isinstance(scene, Scene)]
    ends = iter(
        run_all(possible) if measure is None else [run_alone(scene, measure) for scene in possible]
    )
    each = (
        RunEnd({}, str(scene), (), refused=True) if isinstance(scene, SceneError) else next(ends)
        for scene in scenes
    )
    return [_row(case, scene, end) for case, scene, end in zip(cases, scenes, each, strict=True)]


def _row(case: Case, scene: Any, end: RunEnd) -> dict[str, Any]:
    """Return the row of a case without versions and time."""
    row = {"case": case.number, "sample": case.sample, "variant": case.variant, "law": None}
    row |= {"seed": case.changes["seed"], "status": _status_of(end), "error": end.error}
    row |= {PARAMETER + key: cell_of(value) for key, value in case.parameters.items()}
    return (
        row | {"law": scene.law_name, "events": len(end.events)} | end.metrics
        if end.metrics
        else row
    )


def _status_of(end: RunEnd | Attempt) -> str:
    if end.refused:
        return REFUSED
    return OK if end.error is None else FAILED


def each_row(table: Table) -> Iterator[dict[str, Any]]:
    """Yield the rows of a table, values by the names of its columns."""
    return (dict(zip(table, values, strict=True)) for values in zip(*table.values(), strict=True))


def simulate_case(
    case: Case, document: Mapping[str, Any]
) -> tuple[Rollout | None, str, str | None]:
    """Return (run up to a failure, None without one; status; why it is not `ok`)."""
    (scene,) = load_scenes(document, [case.changes])
    found = (
        Attempt(None, str(scene), refused=True)
        if isinstance(scene, SceneError)
        else attempt_run(scene)
    )
    return found.run, _status_of(found), found.error
