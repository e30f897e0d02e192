"""Workers of a study: processes of this machine, or those of a Dask cluster, as executors."""

import gc
import multiprocessing
import os
import signal
import sys
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from multiprocessing import resource_tracker
from typing import Any, NamedTuple

from crane_sim.files.errors import SceneError
from crane_sim.files.installation import import_optional
from crane_sim.process_signals import blocked_interrupts, end_with_parent

LOCAL = "local"
"""The scheduler of a Dask cluster on this machine, which lives as long as the study."""
_THREAD_COUNTS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_CONNECT_TIMEOUT = 10.0  # s, for an answer of the scheduler
_FIRST_WORKER_TIMEOUT = 60.0  # s, for a worker of a scheduler that has none yet
_QUIET: dict[str, Any] = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.worker.memory.monitor-interval": "1s",
    # pages given back are faulted in anew
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
}
"""Settings of a cluster on this machine: by default Dask watches itself, for a tenth of the
processors' time."""


class Workers(NamedTuple):
    """An executor, and how many tasks it runs at a time."""

    executor: Executor
    parallel: int


def errors_of_ended_workers() -> tuple[type[BaseException], ...]:
    """Return the errors that say that a process ended, not that its task failed."""
    distributed = sys.modules.get("distributed")
    return (
        (BrokenProcessPool,)
        if distributed is None
        else (BrokenProcessPool, distributed.KilledWorker)
    )


class SerialExecutor(Executor):
    """An executor that runs a task in this process, when it is submitted."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return the finished future; raises what the task raises."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


class WorkerProcesses(ProcessPoolExecutor):
    """Processes of this machine, which ignore SIGINT and end with this process, in whatever way."""

    def __init__(self, count: int) -> None:
        """Take the number of processes, which are started as tasks are submitted."""
        _start_resource_tracker()
        super().__init__(count, multiprocessing.get_context("spawn"), _begin_worker, (os.getpid(),))

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return the future of a task; a new process blocks SIGINT until it ignores it."""
        with blocked_interrupts():
            return super().submit(fn, *args, **kwargs)


def _start_resource_tracker() -> None:
    """Start the process that removes this one's semaphores should it be killed, without a line."""
    quiet = "ignore:resource_tracker:UserWarning"
    sys.warnoptions.append(quiet)  # an argument of Python processes that are started now
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove(quiet)


def _begin_worker(parent: int) -> None:
    """Ignore SIGINT, which the parent handles for all, and exit when the parent exits."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    end_with_parent(parent)
    gc.freeze()  # what is imported stays: collections look at the scenes of a block only


@contextmanager
def start_workers(count: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Yield workers; those that were started here end with the block, or with this process.

    Args:
        count: processes of this machine; None: one for each core; 1: this process.
        scheduler: None, or the address of a Dask scheduler, or `LOCAL`.

    Raises:
        SceneError: there is no such scheduler, it has no workers, or Dask is not installed.
    """
    count = count or len(os.sched_getaffinity(0))
    with ExitStack() as stack:
        if scheduler is not None:
            yield stack.enter_context(_dask_workers(scheduler, count))
        elif count == 1:
            yield Workers(SerialExecutor(), 1)
        else:
            stack.enter_context(_limit_threads())
            pool = WorkerProcesses(count)
            stack.callback(pool.shutdown, cancel_futures=True)
            yield Workers(pool, count)


@contextmanager
def _limit_threads() -> Iterator[None]:
    """Limit linear algebra to one thread in each process started in the block.

    More threads would wait for one another.
    """
    missing = [name for name in _THREAD_COUNTS if name not in os.environ]
    os.environ.update(dict.fromkeys(missing, "1"))
    try:
        yield
    finally:
        for name in missing:
            del os.environ[name]


@contextmanager
def _dask_workers(scheduler: str, count: int) -> Iterator[Workers]:
    """Yield the workers of a Dask cluster."""
    dask, distributed = (
        import_optional(module, "--scheduler") for module in ("dask", "distributed")
    )
    with ExitStack() as stack:
        if scheduler == LOCAL:
            stack.enter_context(dask.config.set(_QUIET))
            options = {"threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
            scheduler = stack.enter_context(
                distributed.LocalCluster(n_workers=count, **options)
            ).scheduler_address
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=_CONNECT_TIMEOUT))
            client.wait_for_workers(1, timeout=_FIRST_WORKER_TIMEOUT)
        except (OSError, ValueError) as error:  # a TimeoutError is an OSError
            why = str(error).splitlines()[0]
            raise SceneError(
                f"scheduler = {scheduler!r}: no Dask scheduler with workers answers there ({why})"
            ) from None
        yield Workers(client.get_executor(pure=False), sum(client.nthreads().values()))
