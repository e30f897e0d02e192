"""Execution of a study: blocks of its cases by workers; the same rows whatever runs them."""

import itertools
import json
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache
from pathlib import Path
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.batch_metrics import MetricError
from crane_sim.study.cases import CaseList, cases
from crane_sim.study.named_functions import hash_functions
from crane_sim.study.own_metrics import UnusableMetrics, load_metrics
from crane_sim.study.recordings import check_recorder, check_worst_metric, record_selected
from crane_sim.study.result import StudyResult
from crane_sim.study.runs import OK, Table, rows_of, simulate_case
from crane_sim.study.schema import Study, load_study, scene_document
from crane_sim.study.store import IDENTITY, Store, block_needs, differing_keys, load_pyarrow
from crane_sim.study.versions import deciding_versions
from crane_sim.study.workers import Workers, errors_of_ended_workers, start_workers

AHEAD = 2  # blocks for each worker that are submitted: memory does not grow with the study
PATIENCE = 60.0  # s without a finished block, after which the reason is told
ATTEMPTS = 3  # in which no block is finished because processes end

Progress = Callable[[int, int], None]  # takes (runs that are done, all runs)


def run(
    study: Study | str | Path | dict[str, Any],
    folder: str | Path,
    workers: int | None = None,
    scheduler: str | None = None,
    on_progress: Progress | None = None,
    on_wait: Callable[[str], None] = warnings.warn,
    pool: Workers | None = None,
    check_first: bool = True,
) -> StudyResult:
    """Run a study, or what is missing of it in the folder, and return its table.

    Args:
        study: the study, its file, or a dict of a file's shape.
        folder: where rows are written; the rows of an interrupted run of the same study there are kept.
        workers: processes of this machine; None: one for each core; 1: this process. They change no number but times.
        scheduler: the address of a Dask scheduler, whose workers run the study in place of processes of this machine,
            or "local" for a Dask cluster on this machine. Workers need this package in the same version.
        on_progress: called with (runs that are done, all runs) after each block.
        on_wait: called with a line on why no run is finished, after a minute without one, where that is known.
        pool: workers that have been started already, and are used first.
        check_first: whether a study is refused whose first sample is not possible with every variant, whose own
            metrics cannot be columns there, or that has no metric there by which the worst runs shall be recorded;
            else that is in the rows of this sample, as of any other one, or an error at the end.

    Raises:
        SceneError: the study is not possible, the folder holds another one, or there is no such scheduler; nothing
            was started.
        RuntimeError: processes of the study ended again and again.
    """
    load_pyarrow()
    checked = load_study(study)
    if checked.tune is not None:
        raise SceneError("study: tune: is for crane tune; leave it out to run the study itself")
    check_recorder(checked)
    listed = check_cases(checked) if check_first else cases(checked)
    if workers is not None and workers < 1:
        raise SceneError(f"workers = {workers}: must be at least 1")
    if check_first and not (Path(folder) / IDENTITY).exists():
        check_metrics(listed)
        check_worst_metric(listed)
    store = Store(Path(folder), checked, len(listed))
    with store.locked():
        starts = itertools.chain(
            () if pool is None else (nullcontext(pool),), (start_workers(workers, scheduler) for _ in itertools.count())
        )
        _run_missing(store, checked, starts, (on_progress or (lambda *_: None), on_wait))
        store.merge()
        result = StudyResult(checked, store.folder)
        record_selected(result)
    return result


def check_cases(study: Study) -> CaseList:
    """Return the cases of a study whose first sample is possible with every variant.

    Later samples are checked when they are run: one that is not possible is a row with the status `refused`.

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
    """Run the first case of a study with metrics of its own, to see whether they can be columns of its table.

    An error that the function raises is not looked at here: it may be of this case only, and is in its row.

    Raises:
        SceneError: the function has names that the table has, or returns no numbers by name.
    """
    measure = load_metrics(listed.study)
    if measure is None:
        return
    run, status, _ = simulate_case(listed[0], scene_document(listed.study))
    if run is None or status != OK:
        return
    try:
        measure(run)
    except UnusableMetrics as error:
        raise SceneError(f"study: {error}") from None
    except MetricError:
        pass


def _run_missing(
    store: Store,
    study: Study,
    starts: Iterator[AbstractContextManager[Workers]],
    tell: tuple[Progress, Callable[[str], None]],
) -> None:
    """Run the blocks that are missing and write their rows; those of a process that ended are tried by new workers."""
    on_progress, on_wait = tell
    attempts = ATTEMPTS
    while missing := store.missing():
        done = store.cases - sum(len(store.cases_of(block)) for block in missing)
        on_progress(done, store.cases)
        try:
            with next(starts) as workers:
                for block, rows in _results(store, study, missing, workers, on_wait):
                    store.write(block, rows)
                    done, attempts = done + len(store.cases_of(block)), ATTEMPTS
                    on_progress(done, store.cases)
        except errors_of_ended_workers():
            attempts -= 1
            if not attempts:
                line = f"processes of the study ended {ATTEMPTS} times in a row; its next block is {min(missing)}"
                raise RuntimeError(line) from None
    on_progress(store.cases, store.cases)


def _results(
    store: Store, study: Study, blocks: list[int], workers: Workers, on_wait: Callable[[str], None]
) -> Iterator[tuple[int, Table]]:
    """Yield (block, rows) as workers finish them; call `on_wait` where they finish none for a known reason."""
    task = study.model_dump_json(), *block_needs(store.identity)
    pending, waiting = dict[Future[list[Table]], list[int]](), list(reversed(blocks))
    ahead = AHEAD * workers.parallel
    while True:
        while len(pending) < ahead and waiting:
            count = max(1, min(workers.blocks, len(waiting) // ahead))  # fewer at the end, so that workers end together
            together = [waiting.pop() for _ in range(count)]
            ranges = [(numbers.start, numbers.stop) for numbers in map(store.cases_of, together)]
            pending[workers.executor.submit(run_blocks, *task, ranges)] = together
        if not pending:
            return
        done = wait(pending, PATIENCE, FIRST_COMPLETED).done
        if not done and (reason := workers.unavailable_reason()) is not None:
            on_wait(reason)
        for future in done:
            yield from zip(pending.pop(future), future.result(), strict=True)


@lru_cache(maxsize=1)
def _cases_of(study: str, scene: str) -> tuple[CaseList, dict[str, Any]]:
    """Return the cases of a study and the document of its scene, both in JSON: once for each process."""
    document = json.loads(scene)
    return cases(load_study(json.loads(study) | {"scene": document})), document


def run_blocks(
    study: str,
    scene: str,
    versions: dict[str, str],
    functions: dict[str, str],
    ranges: Sequence[tuple[int, int]],
) -> list[Table]:
    """Return the rows of blocks of cases, each from a first to an end (excluded).

    Raises:
        SceneError: this process would compute with other versions, or with other functions of one's own.
    """
    if differing := differing_keys(deciding_versions(), versions):
        raise SceneError(f"a worker has other versions than this process: {differing}")
    listed, document = _cases_of(study, scene)
    mine = hash_functions(listed.study, document)
    if absent := ", ".join(sorted(functions.keys() - mine.keys())):
        raise SceneError(f"{absent}: is not there for a worker; workers need it under the same name")
    if changed := differing_keys(mine, functions):
        raise SceneError(f"{changed}: not as when the study began; undo that, or begin it in another folder")
    return [rows_of(listed, first, end, document) for first, end in ranges]
