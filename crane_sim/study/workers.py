"""Workers of a study: processes of this machine, or those of a Dask cluster, behind one interface."""

import gc
import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from multiprocessing import resource_tracker
from threading import Thread
from typing import Any, NamedTuple

from crane_sim.files.errors import SceneError
from crane_sim.files.installation import import_optional
from crane_sim.process_signals import blocked_interrupts, end_with_parent
from crane_sim.tracing.compile_time import watch_compiling

LOCAL = "local"
"""The scheduler of a Dask cluster on this machine, which lives as long as the study."""
_THREAD_COUNTS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_CONNECT_TIMEOUT = 10.0  # s, for an answer of the scheduler
_BLOCKS_OF_DASK = 4  # in a task, of which each costs the scheduler and its connections some milliseconds
_FIRST_WORKER_TIMEOUT = 60.0  # s, for a worker of a scheduler that has none yet


_QUIET: dict[str, Any] = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,  # pages that are given back are faulted in anew
}
"""Settings of a cluster on this machine: by default Dask watches itself, for a tenth of the processors' time."""


class Workers(NamedTuple):
    """An executor, how many tasks it runs at a time (`parallel`), and how many blocks of a study a task may have."""

    executor: Executor
    parallel: int
    blocks: int = 1
    unavailable_reason: Callable[[], str | None] = lambda: None  # returns why no task can be finished now, one line


def errors_of_ended_workers() -> tuple[type[BaseException], ...]:
    """Return the errors that say that a process ended, not that its task failed."""
    distributed = sys.modules.get("distributed")
    return (BrokenProcessPool,) if distributed is None else (BrokenProcessPool, distributed.KilledWorker)


class SerialExecutor(Executor):
    """An executor that runs a task in this process, when it is submitted."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return the finished future; raises what the task raises."""
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


_watchers = list[Callable[[], object]]()
_at_work = ExitStack()  # of a worker: what lasts until it ends


@contextmanager
def watch_compiling_everywhere(callback: Callable[[], object]) -> Iterator[None]:
    """Call `callback` whenever this process or one of its `WorkerProcesses` compiles a function within the block."""
    _watchers.append(callback)
    try:
        with watch_compiling(callback):
            yield
    finally:
        _watchers.remove(callback)


class WorkerProcesses(ProcessPoolExecutor):
    """Processes of this machine, which ignore SIGINT and end with this process, in whatever way."""

    def __init__(self, count: int) -> None:
        """Take the number of processes, which are started as tasks are submitted."""
        _start_resource_tracker()
        context = multiprocessing.get_context("spawn")
        notices, self._sender = context.Pipe(duplex=False)
        Thread(target=_call_watchers, args=(notices,), daemon=True).start()
        super().__init__(count, context, _begin_worker, (os.getpid(), self._sender))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """See `Executor`; the thread that waits for notices of the processes ends with them."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        self._sender.close()

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return the future of a task; a process that is started for it does not see SIGINT before it ignores it."""
        with blocked_interrupts():
            return super().submit(fn, *args, **kwargs)


def _start_resource_tracker() -> None:
    """Start the process that removes the semaphores of this one, should it be killed, and prints no warning of that."""
    quiet = "ignore:resource_tracker:UserWarning"
    sys.warnoptions.append(quiet)  # an argument of Python processes that are started now
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove(quiet)


@contextmanager
def start_workers(count: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Yield workers; those that were started here end with the block, or with this process.

    Args:
        count: processes of this machine; None: one for each core; 1: this process.
        scheduler: None, or the address of a Dask scheduler, or `LOCAL`.

    Raises:
        SceneError: there is no such scheduler, it has no workers, or Dask is not installed.
    """
    cores = len(os.sched_getaffinity(0))
    with ExitStack() as stack:
        if scheduler is not None:
            yield stack.enter_context(_dask_workers(scheduler, count or cores))
        elif (count or cores) == 1:
            yield Workers(SerialExecutor(), 1)
        else:
            stack.enter_context(_limit_threads())
            pool = WorkerProcesses(count or cores)
            stack.callback(pool.shutdown, cancel_futures=True)
            yield Workers(pool, count or cores)


@contextmanager
def _limit_threads() -> Iterator[None]:
    """Limit linear algebra to one thread in each process started in the block: more would wait for one another."""
    missing = [name for name in _THREAD_COUNTS if name not in os.environ]
    os.environ.update(dict.fromkeys(missing, "1"))
    try:
        yield
    finally:
        for name in missing:
            del os.environ[name]


def _call_watchers(notices: Any) -> None:
    """Call the watchers at each notice that a worker compiles, until all workers have ended."""
    with notices, suppress(EOFError):
        while True:
            notices.recv_bytes()
            for callback in tuple(_watchers):
                callback()


def _begin_worker(parent: int, sender: Any) -> None:
    """Ignore SIGINT, which the parent handles for all, and exit when the parent exits, in whatever way.

    `sender`: where it says that it compiles.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    end_with_parent(parent)
    gc.freeze()  # what is imported stays: collections look at the scenes of a block only
    _at_work.enter_context(watch_compiling(partial(sender.send_bytes, b"compiling")))


@contextmanager
def _dask_workers(scheduler: str, count: int) -> Iterator[Workers]:
    """Yield the workers of a Dask cluster."""
    dask, distributed = (import_optional(module, "--scheduler") for module in ("dask", "distributed"))
    with ExitStack() as stack:
        if scheduler == LOCAL:
            stack.enter_context(dask.config.set(_QUIET))
            options = {"threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
            scheduler = stack.enter_context(distributed.LocalCluster(n_workers=count, **options)).scheduler_address
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=_CONNECT_TIMEOUT))
        except (OSError, ValueError) as error:
            line = f"scheduler = {scheduler!r}: no Dask scheduler answers there ({str(error).splitlines()[0]})"
            raise SceneError(line) from None
        try:
            client.wait_for_workers(1, timeout=_FIRST_WORKER_TIMEOUT)
        except TimeoutError:
            raise SceneError(f"scheduler = {scheduler!r}: has no workers") from None

        def unavailable_reason() -> str | None:
            return (
                None if client.nthreads() else f"scheduler = {scheduler!r}: has lost all its workers; waiting for one"
            )

        executor, parallel = client.get_executor(pure=False), sum(client.nthreads().values())
        yield Workers(executor, parallel, _BLOCKS_OF_DASK, unavailable_reason)
