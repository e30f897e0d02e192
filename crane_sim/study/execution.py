"""Execution of a study: blocks of its cases in processes on all cores; the same rows whatever runs them."""

import json
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import lru_cache
from pathlib import Path
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.process_signals import end_with_parent
from crane_sim.scenes.scene import load_scene
from crane_sim.study.cases import CaseList, cases
from crane_sim.study.form import Study, load_study, scene_document
from crane_sim.study.recordings import record_selected
from crane_sim.study.result import StudyResult
from crane_sim.study.runs import row_of
from crane_sim.study.store import Store, load_pyarrow

AHEAD = 2  # blocks for each worker that are submitted: memory does not grow with the study
ATTEMPTS = 3  # of a block whose process ended

Progress = Callable[[int, int], None]  # takes (runs that are done, all runs)


def run(
    study: Study | str | Path | dict[str, Any],
    folder: str | Path,
    workers: int | None = None,
    on_progress: Progress | None = None,
) -> StudyResult:
    """Run a study, or what is missing of it in the folder, and return its table.

    Args:
        study: the study, its file, or a dict of a file's shape.
        folder: where rows are written; the rows of an interrupted run of the same study there are kept.
        workers: processes; None: one for each core; 1: this process. They change no number but times.
        on_progress: called with (runs that are done, all runs) after each block.

    Raises:
        SceneError: the study is not possible, or the folder holds another one; nothing was started.
        RuntimeError: processes of the study ended again and again.
    """
    load_pyarrow()
    checked = load_study(study)
    listed = check_cases(checked)
    if workers is not None and workers < 1:
        raise SceneError(f"workers = {workers}: must be at least 1")
    store = Store(Path(folder), checked, len(listed))
    with store.locked():
        _run_missing(store, checked, workers or len(os.sched_getaffinity(0)), on_progress or (lambda *_: None))
        store.merge()
        result = StudyResult(checked, store.folder, store.read())
        record_selected(result)
    return result


def check_cases(study: Study) -> CaseList:
    """Return the cases of a study whose first sample is possible with every variant.

    Later samples are checked when they are run: one that is not possible is a row with the status `refused`.

    Raises:
        SceneError: a key or value is not possible.
    """
    listed, document = cases(study), scene_document(study)
    for case in (listed[i] for i in range(len(listed.variants))):
        try:
            load_scene(document, case.changes)
        except SceneError as error:
            where = f"variant {case.variant!r}: " if study.variants else ""
            raise SceneError(f"study: {where}{error}") from None
    return listed


def _run_missing(store: Store, study: Study, workers: int, on_progress: Progress) -> None:
    """Run the blocks that are missing."""
    missing = store.missing()
    done = store.cases - sum(len(store.cases_of(block)) for block in missing)
    on_progress(done, store.cases)
    if not missing:
        return
    for block in _completed(store, study, missing, min(workers, len(missing))):
        done += len(store.cases_of(block))
        on_progress(done, store.cases)


def _completed(store: Store, study: Study, missing: list[int], workers: int) -> Iterator[int]:
    """Yield blocks as they are written; those of a process that ended are tried again."""
    if workers == 1:
        yield from (_run_block(store, study.model_dump_json(), block) for block in missing)
        return
    left = dict.fromkeys(missing)
    for _ in range(ATTEMPTS):
        try:
            for block in _pool_results(store, study, list(left), workers):
                del left[block]
                yield block
            return
        except BrokenProcessPool:
            left = dict.fromkeys(store.missing())
    raise RuntimeError(f"processes of the study ended {ATTEMPTS} times; its next block is {min(left)}")


def _pool_results(store: Store, study: Study, blocks: list[int], workers: int) -> Iterator[int]:
    """Yield blocks as they are written by the processes of one pool."""
    context = multiprocessing.get_context("spawn")
    text = study.model_dump_json()
    with ProcessPoolExecutor(workers, context, _start_worker, (os.getpid(),)) as pool:
        futures, waiting = set[Future[int]](), iter(blocks)
        try:
            while True:
                while len(futures) < AHEAD * workers and (block := next(waiting, None)) is not None:
                    futures.add(pool.submit(_run_block, store, text, block))
                if not futures:
                    return
                finished, futures = wait(futures, return_when=FIRST_COMPLETED)
                for future in finished:
                    yield future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _start_worker(parent: int) -> None:
    """Leave interruptions to the process of the study, and end with it however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent(parent)


@lru_cache(maxsize=1)
def _cases_and_document(study: str) -> tuple[CaseList, dict[str, Any]]:
    """Return the cases of a study in JSON and the document of its scene: once for each process."""
    read = load_study(json.loads(study))
    return cases(read), scene_document(read)


def _run_block(store: Store, study: str, block: int) -> int:
    """Run the cases of a block and write its rows."""
    listed, document = _cases_and_document(study)
    store.write(block, [row_of(listed[i], document) for i in store.cases_of(block)])
    return block
