"""What ends a process, from its first statement to its last: signals, a dead parent; nothing heavy is imported here.

Python's own handlers wait until compiled code comes back, which may take seconds, and then raise an exception wherever
the program happens to be. Here a thread hears of a signal at once, or a run collects it and ends in order. Nobody hears
of SIGKILL: what a process has started outlives it, unless the kernel is told otherwise.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NoReturn

NUMBERS = (signal.SIGINT, signal.SIGTERM)
_PDEATHSIG = 1  # of prctl(2)


def exit_on_signal(end: Callable[[], object]) -> None:
    """From now on, to the end of the process, call `end` in a thread of its own as soon as a signal comes."""
    heard, told = os.pipe()
    os.set_blocking(told, False)
    for number in NUMBERS:
        signal.signal(number, lambda *_: None)
    signal.set_wakeup_fd(told, warn_on_full_buffer=False)

    def wait() -> None:
        os.read(heard, 1)
        end()

    threading.Thread(target=wait, name="interruption", daemon=True).start()
    signal.pthread_sigmask(signal.SIG_UNBLOCK, NUMBERS)  # the start script holds them back until somebody listens


def exit_now(code: int) -> NoReturn:
    """End the process with an exit code now: it can take Python seconds to take down what it has loaded."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


@contextmanager
def collect_signals() -> Iterator[list[int]]:
    """Yield a list that signals are put into while the block runs; nobody else is told of them."""
    caught: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield caught  # only the main thread may have handlers
        return
    before = [signal.signal(number, lambda n, _: caught.append(n)) for number in NUMBERS]
    listener = signal.set_wakeup_fd(-1)
    try:
        yield caught
    finally:
        signal.set_wakeup_fd(listener, warn_on_full_buffer=False)
        for number, handler in zip(NUMBERS, before, strict=True):
            signal.signal(number, handler)


def set_parent_death_signal() -> Callable[[], None]:
    """Return what a child calls right after the fork, so that the kernel ends it together with this process.

    More exactly with the thread that forks; it holds beyond an exec.
    """
    import ctypes

    prctl, parent = ctypes.CDLL(None).prctl, os.getpid()

    def bind() -> None:
        prctl(_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)  # it had ended before

    return bind


def clear_parent_death_signal() -> None:
    """Let this process outlive its parent again."""
    import ctypes

    ctypes.CDLL(None).prctl(_PDEATHSIG, 0)
