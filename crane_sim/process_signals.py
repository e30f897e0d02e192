"""Signals of a process from its first statement to its last, and parent-death signals.

Nothing heavy is imported here.

Python's own handlers wait until compiled code returns, which may take seconds, and then raise an
exception at an arbitrary statement. Here a thread handles a signal at once, or a run collects it
and ends in order. SIGKILL has no handler: the children of a killed process outlive it, unless they
have a parent-death signal.
"""

import fcntl
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    import subprocess

NUMBERS = (signal.SIGINT, signal.SIGTERM)
_PDEATHSIG = 1  # of prctl(2)


def exit_on_signal(end: Callable[[], object]) -> None:
    """Call `end` in a thread of its own at a signal, from now on to the end of the process.

    Where compiled code hangs that lets no other thread run, the kernel ends the process ten seconds
    later.
    """
    read_end, write_end = os.pipe()
    os.set_blocking(write_end, False)
    _set_alarm_on_data(read_end)
    for number in NUMBERS:
        signal.signal(number, lambda *_: None)
    signal.set_wakeup_fd(write_end, warn_on_full_buffer=False)

    def wait() -> None:
        os.read(read_end, 1)
        end()

    threading.Thread(target=wait, name="signals", daemon=True).start()
    # the start script blocks them until there is a handler
    signal.pthread_sigmask(signal.SIG_UNBLOCK, NUMBERS)


def _set_alarm_on_data(read_end: int) -> None:
    """Have SIGALRM end the process ten seconds after a pipe's first byte, without Python code.

    The kernel announces the byte by SIGUSR1, and the handler is alarm(2) itself: 10, the signal's
    number, is its argument.
    """
    import ctypes

    library = ctypes.CDLL(None)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    library.signal(int(signal.SIGUSR1), library.alarm)
    fcntl.fcntl(read_end, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(read_end, fcntl.F_SETSIG, signal.SIGUSR1)
    fcntl.fcntl(read_end, fcntl.F_SETFL, os.O_ASYNC)


def replace_process(
    command: Sequence[str], environment: Mapping[str, str] | None = None
) -> NoReturn:
    """Go on as another program, which gets the signals; `environment`: its own, None: this one's.

    Handlers do not outlive that, and the kernel sends SIGUSR1 as it closes the pipe of
    `exit_on_signal`: ignored, it does not end the other program.
    """
    signal.signal(signal.SIGUSR1, signal.SIG_IGN)
    os.execve(command[0], list(command), os.environ if environment is None else environment)


def exit_now(code: int) -> NoReturn:
    """End the process with an exit code now: the interpreter's own shutdown can take seconds."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def end_process(process: "subprocess.Popen[bytes]", timeout: float) -> None:
    """End a child in order, or kill it after `timeout` seconds."""
    from subprocess import TimeoutExpired

    process.terminate()
    with suppress(TimeoutExpired):
        process.wait(timeout)
    process.kill()
    process.wait()


def end_workers() -> None:
    """Kill what `multiprocessing` has started, remove its semaphores: this process ends at once.

    Else a process of Python's own finds the semaphores after the end, removes them, and prints a
    warning.
    """
    processes, finalizers = (
        sys.modules.get(f"multiprocessing.{name}") for name in ("process", "util")
    )
    if processes is not None:
        for child in processes.active_children():
            with suppress(ValueError):  # another thread has seen it end
                child.kill()
    if finalizers is not None:
        # those of semaphores; they join no thread, and await no process
        finalizers._run_finalizers(0)


@contextmanager
def blocked_interrupts() -> Iterator[None]:
    """Block SIGINT in the block: it comes after it; processes started in it begin without it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def ignore_interrupts() -> None:
    """Ignore SIGINT from now on, also where it is blocked since the process was started."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})


@contextmanager
def collect_signals() -> Iterator[list[int]]:
    """Yield a list to which signals are appended in the block; no other handler is called."""
    received: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield received  # only the main thread may have handlers
        return
    previous = [signal.signal(number, lambda n, _: received.append(n)) for number in NUMBERS]
    previous_fd = signal.set_wakeup_fd(-1)
    try:
        yield received
    finally:
        signal.set_wakeup_fd(previous_fd, warn_on_full_buffer=False)
        for number, handler in zip(NUMBERS, previous, strict=True):
            signal.signal(number, handler)


def ignore_signals() -> None:
    """Ignore signals from now on: the process has done its work, and ends with its own exit code.

    Python would otherwise give the signals their default effect, the death of the process, on its
    way out.
    """
    for number in NUMBERS:
        signal.signal(number, signal.SIG_IGN)


def set_parent_death_signal() -> Callable[[], None]:
    """Return a function that a child calls after the fork, so that it is killed with this process.

    The kernel kills it.

    More exactly with the thread that forks; it holds beyond an exec.
    """
    import ctypes

    # a child of threads must not import
    return partial(_end_with, os.getpid(), ctypes.CDLL(None).prctl)


def end_with_parent(parent: int) -> None:
    """Do the same in this process, a worker that process `parent` has started."""
    import ctypes

    _end_with(parent, ctypes.CDLL(None).prctl)


def _end_with(parent: int, prctl: Callable[..., int]) -> None:
    prctl(_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)  # the parent had ended before


def clear_parent_death_signal() -> None:
    """Let this process outlive its parent again."""
    import ctypes

    ctypes.CDLL(None).prctl(_PDEATHSIG, 0)
