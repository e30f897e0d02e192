"""Execution of a study: blocks of its cases by workers; the same rows whatever runs them."""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache
from itertools import chain, count
from pathlib import Path
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.batch_metrics import MetricError
from crane_sim.study.cases import CaseList, cases
from crane_sim.study.identity import block_needs, deciding_versions, differing_keys, hash_functions
from crane_sim.study.own_metrics import UnusableMetrics, load_metrics
from crane_sim.study.recordings import check_recorder, check_worst_metric, record_selected
from crane_sim.study.result import StudyResult
from crane_sim.study.runs import OK, Table, rows_of, simulate_case
from crane_sim.study.schema import Study, load_study, scene_document
from crane_sim.study.store import IDENTITY, Store, load_pyarrow
from crane_sim.study.workers import Workers, errors_of_ended_workers, start_workers

AHEAD = 2  # blocks for each worker that are submitted: memory does not grow with the study
ATTEMPTS = 3  # in which no block is finished because processes end

Progress = Callable[[int, int], None]  # takes (runs that are done, all runs)


def run(
    study: Study | str | Path | dict[str, Any],
    folder: str | Path,
    workers: int | None = None,
    scheduler: str | None = None,
    on_progress: Progress | None = None,
    pool: Workers | None = None,
    check_first: bool = True,
) -> StudyResult:
    """Run a study, or what is missing of it in the folder, and return its table.

    Args:
        study: the study, its file, or a dict of a file's shape.
        folder: where rows are written; the rows of an interrupted run of the same study there are
            kept.
        workers: processes of this machine; None: one for each core; 1: this process. They change no
            number but times.
        scheduler: the address of a Dask scheduler, whose workers run the study in place of
            processes of this machine, or "local" for a Dask cluster on this machine. Workers need
            this package in the same version.
        on_progress: called with (runs that are done, all runs) after each block.
        pool: workers that have been started already, and are used first.
        check_first: whether a study is refused whose first sample is not possible with every
            variant, whose own metrics cannot be columns there, or that has no metric there by which
            the worst runs shall be recorded; else that is in the rows of this sample, as of any
            other one, or an error at the end.

    Raises:
        SceneError: the study is not possible, the folder holds another one, or there is no such
            scheduler; nothing was started.
        RuntimeError: processes of the study ended again and again.
    """
    load_pyarrow()
    checked = load_study(study)
    if checked.tune is not None:
        raise SceneError("study: tune: is for crane tune; leave it out to run the study itself")
    if workers is not None and workers < 1:
        raise SceneError(f"workers = {workers}: must be at least 1")
    check_recorder(checked)
    listed = check_cases(checked) if check_first else cases(checked)
    if check_first and not (Path(folder) / IDENTITY).exists():
        check_metrics(listed)
        check_worst_metric(listed)
    store = Store(Path(folder), checked, len(listed))
    with store.locked():
        started = (start_workers(workers, scheduler) for _ in count())
        pools = started if pool is None else chain([nullcontext(pool)], started)
        _run_missing(store, checked, pools, on_progress or (lambda *_: None))
        store.merge()
        result = StudyResult(checked, store.folder)
        record_selected(result)
    return result


def check_cases(study: Study) -> CaseList:
    """Return the cases of a study whose first sample is possible with every variant.

    Later samples are checked when they are run: one that is not possible is a row with the status
    `refused`.

    Raises:
        SceneError: a key or value is not possible.
    """
    listed, document = cases(study), scene_document(study)
    load_metrics(study)
    for case in (listed[i] for i in range(len(listed.variants))):
        try:
            load_scene(document, case.changes)
        except SceneError as error:
            where = f"variant {case.variant!r}: " if study.variants else ""
            raise SceneError(f"study: {where}{error}") from None
    return listed


def check_metrics(listed: CaseList) -> None:
    """Check that a study's own metrics of its first case can be columns of its table.

    An error that the function raises may be of this case only, and is in its row.

    Raises:
        SceneError: the function has names that the table has, or returns no numbers by name.
    """
    if (measure := load_metrics(listed.study)) is None:
        return
    run, status, _ = simulate_case(listed[0], scene_document(listed.study))
    try:
        if run is not None and status == OK:
            measure(run)
    except UnusableMetrics as error:
        raise SceneError(f"study: {error}") from None
    except MetricError:
        pass


def _run_missing(
    store: Store,
    study: Study,
    pools: Iterator[AbstractContextManager[Workers]],
    on_progress: Progress,
) -> None:
    """Run the missing blocks and write their rows.

    Blocks of a process that ended are tried again by new workers.
    """
    attempts = ATTEMPTS
    while missing := store.missing():
        done = store.cases - sum(len(store.cases_of(block)) for block in missing)
        on_progress(done, store.cases)
        try:
            with next(pools) as workers:
                for block, rows in _results(store, study, missing, workers):
                    store.write(block, rows)
                    attempts = ATTEMPTS
                    done += len(store.cases_of(block))
                    on_progress(done, store.cases)
        except errors_of_ended_workers():
            attempts -= 1
            if not attempts:
                line = (
                    f"processes of the study ended {ATTEMPTS} times in a row; its next block is "
                    f"{min(missing)}"
                )
                raise RuntimeError(line) from None
    on_progress(store.cases, store.cases)


def _results(
    store: Store, study: Study, blocks: list[int], workers: Workers
) -> Iterator[tuple[int, Table]]:
    """Yield (block, rows) as workers finish them."""
    task = study.model_dump_json(), *block_needs(store.identity)
    pending, waiting = dict[Future[Table], int](), iter(blocks)
    while True:
        for block in waiting if len(pending) < AHEAD * workers.parallel else ():
            cases = store.cases_of(block)
            pending[workers.executor.submit(run_block, *task, cases.start, cases.stop)] = block
            if len(pending) == AHEAD * workers.parallel:
                break
        if not pending:
            return
        for future in wait(pending, return_when=FIRST_COMPLETED).done:
            yield pending.pop(future), future.result()


@lru_cache(maxsize=1)
def _cases_of(study: str, scene: str) -> tuple[CaseList, dict[str, Any]]:
    """Return the cases of a study and its scene's document, both in JSON: once per process."""
    document = json.loads(scene)
    return cases(load_study(json.loads(study) | {"scene": document})), document


def run_block(
    study: str,
    scene: str,
    versions: dict[str, str],
    functions: dict[str, str],
    first: int,
    end: int,
) -> Table:
    """Return the rows of the cases `first` to `end` (excluded).

    Raises:
        SceneError: this process would compute with other versions, or with other functions of one's
            own.
    """
    if differing := differing_keys(deciding_versions(), versions):
        raise SceneError(f"a worker has other versions than this process: {differing}")
    listed, document = _cases_of(study, scene)
    mine = hash_functions(listed.study, document)
    if absent := ", ".join(sorted(functions.keys() - mine.keys())):
        raise SceneError(
            f"{absent}: is not there for a worker; workers need it under the same name"
        )
    if changed := differing_keys(mine, functions):
        raise SceneError(
            f"{changed}: not as when the study began; undo that, or begin it in another folder"
        )
    return rows_of(listed, first, end, document)
