"""Runs of a study, as the rows of its table."""

import json
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.scenes.many import load_scenes
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.varied import load_columns
from crane_sim.simulation.batch_metrics import Attempt, Measure, RunEnd, attempt_run, run_all, run_alone, run_columns
from crane_sim.simulation.flat_summary import cell_of
from crane_sim.simulation.rollout import Rollout
from crane_sim.study.cases import Case, CaseColumns, CaseList
from crane_sim.study.columns import FIRST_COLUMNS, PARAMETER, OwnMetric
from crane_sim.study.own_metrics import load_metrics
from crane_sim.study.versions import versions

OK, FAILED, REFUSED = "ok", "failed", "refused"
"""Statuses of a row: the run reached its end; it ended before; its scene is not possible."""


Table = dict[str, Any]
"""Columns by name, a list or an array each, with an entry for each case."""


def rows_of(listed: CaseList, first: int, end: int, document: Mapping[str, Any]) -> Table:
    """Return the rows of the cases `first` to `end` (excluded): parameters, all metrics of the summary, status, error.

    Whatever ends a run is in its row: no error is raised. Scenes that differ in numbers only are made together and run
    in one compiled call; a case has the numbers of its single run, bit for bit.
    """
    start, parts, count = time.perf_counter(), list[tuple[list[int], Table]](), end - first
    measure, own = _collect_names(load_metrics(listed.study))
    for cases in listed.columns(first, end):
        together, alone = _run_together(cases, document) if measure is None else ([], cases.numbers)
        parts += together
        parts += _run_each([listed[number] for number in alone], document, measure) if alone else []
    table = _join([([number - first for number in numbers], part) for numbers, part in parts], count)
    table |= {name: OwnMetric(table[name]) for name in own}
    each = (time.perf_counter() - start) / count
    return table | {"versions": [_versions()] * count, "wall_time": [each] * count}


def _collect_names(measure: Measure | None) -> tuple[Measure | None, dict[str, None]]:
    """Return a function of further metrics, and their names, in order, which it adds as it is called."""
    names = dict[str, None]()
    if measure is None:
        return None, names

    def collecting(run: Rollout) -> dict[str, float | None]:
        found = measure(run)
        names.update(dict.fromkeys(found))
        return found

    return collecting, names


def _run_together(cases: CaseColumns, document: Mapping[str, Any]) -> tuple[list[tuple[list[int], Table]], list[int]]:
    """Return (numbers and rows of the cases that are made and run together, the numbers of the others)."""
    varied = ({} if "seed" in cases.always else {"seed": cases.seeds}) | cases.parameters
    scenes = None
    if cases.numbers and not cases.always.keys() & varied.keys():
        scenes = load_columns(document, cases.always, varied)
    ended = None if scenes is None else run_columns(scenes)
    if scenes is None or ended is None:
        return [], cases.numbers
    chosen = np.flatnonzero(scenes.covered).tolist()
    numbers, samples = [cases.numbers[i] for i in chosen], [cases.samples[i] for i in chosen]
    table = {"case": numbers, "sample": samples, "variant": [cases.variant] * len(chosen)}
    seeds = varied.get("seed", [cases.always.get("seed")] * len(cases.numbers))
    table |= {"law": [scenes.scene.law_name] * len(chosen), "seed": [seeds[i] for i in chosen]}
    table |= {"status": [OK if error is None else FAILED for error in ended.errors], "error": ended.errors}
    table |= {PARAMETER + key: [cell_of(column[i]) for i in chosen] for key, column in cases.parameters.items()}
    others = np.flatnonzero(~scenes.covered).tolist()
    return [(numbers, table | {"events": [0] * len(chosen)} | ended.metrics)], [cases.numbers[i] for i in others]


def _run_each(
    cases: Sequence[Case], document: Mapping[str, Any], measure: Measure | None
) -> list[tuple[list[int], Table]]:
    """Return numbers and rows of cases whose scenes are made one by one; `measure`: their further metrics."""
    scenes = load_scenes(document, [case.changes for case in cases])
    possible = [scene for scene in scenes if isinstance(scene, Scene)]
    ends = iter(run_all(possible) if measure is None else [run_alone(scene, measure) for scene in possible])
    each = (
        RunEnd({}, str(scene), (), refused=True) if isinstance(scene, SceneError) else next(ends) for scene in scenes
    )
    rows = [_row(case, scene, end) for case, scene, end in zip(cases, scenes, each, strict=True)]
    columns = {key: [row.get(key) for row in rows] for key in dict.fromkeys(key for row in rows for key in row)}
    return [([case.number for case in cases], columns)]


def _join(parts: Sequence[tuple[Sequence[int], Table]], count: int) -> Table:
    """Return tables as one of `count` rows, those of each part at its numbers; what a part lacks is None."""
    names = dict.fromkeys((*FIRST_COLUMNS, *(name for _, part in parts for name in part)))
    if len(parts) == 1:
        return {name: parts[0][1][name] for name in names}
    table: Table = {name: [None] * count for name in names}
    for numbers, part in parts:
        for name, column in part.items():
            values = column.tolist() if isinstance(column, np.ndarray) else column
            for number, value in zip(numbers, values, strict=True):
                table[name][number] = value
    return table


def _row(case: Case, scene: Any, end: RunEnd) -> dict[str, Any]:
    """Return the row of a case without versions and time."""
    row = {"case": case.number, "sample": case.sample, "variant": case.variant, "law": None}
    row |= {"seed": case.changes["seed"], "status": _status_of(end), "error": end.error}
    row |= {PARAMETER + key: cell_of(value) for key, value in case.parameters.items()}
    return row | {"law": scene.law_name, "events": len(end.events)} | end.metrics if end.metrics else row


def _status_of(end: RunEnd | Attempt) -> str:
    return REFUSED if end.refused else OK if end.error is None else FAILED


@cache
def _versions() -> str:
    """Return the versions and the processor of this process in JSON."""
    return json.dumps(versions())


def each_row(table: Table) -> Iterator[dict[str, Any]]:
    """Yield the rows of a table, values by the names of its columns."""
    for values in zip(*table.values(), strict=True):
        yield dict(zip(table, values, strict=True))


def simulate_case(case: Case, document: Mapping[str, Any]) -> tuple[Rollout | None, str, str | None]:
    """Return (the run, up to where it failed; None without one), its status, and why it is not `ok`."""
    (scene,) = load_scenes(document, [case.changes])
    found = Attempt(None, str(scene), refused=True) if isinstance(scene, SceneError) else attempt_run(scene)
    return found.run, _status_of(found), found.error
