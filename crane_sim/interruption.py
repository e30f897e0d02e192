"""SIGINT and SIGTERM, from the first statement of a process to its last; nothing heavy is imported here.

Python's own handlers wait until compiled code comes back, which may take seconds, and then raise an exception wherever
the program happens to be. Here a thread hears of a signal at once, or a run collects it and ends in order.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

NUMBERS = (signal.SIGINT, signal.SIGTERM)


def end_at_once(end: Callable[[], object]) -> None:
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


@contextmanager
def collected() -> Iterator[list[int]]:
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
