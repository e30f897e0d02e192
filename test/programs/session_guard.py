"""Ends what a test session leaves behind when its process is killed: PID MARK. Python's own library alone.

It waits for the end of the process PID, and then kills every process whose environment has MARK in the value of
`CRANE_SIM_TEST_SESSION`: what a test has started inherits it, in whatever session or process group it is.
"""

import ctypes
import os
import select
import signal
import sys
import time
from pathlib import Path

VARIABLE = "CRANE_SIM_TEST_SESSION"
PDEATHSIG = 1  # of prctl(2)
ROUNDS = 20  # looks, 0.1 s apart, for what was just being started


def tie_to_parent() -> None:
    """Let the kernel end this process together with the thread that started it."""
    ctypes.CDLL(None).prctl(PDEATHSIG, signal.SIGKILL)


def marked(mark: str) -> dict[int, str]:
    """Return the command line of every living process with this mark, by process id."""
    living = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            environment = (folder / "environ").read_bytes().split(b"\0")  # of a zombie it is empty
            values = [entry for entry in environment if entry.startswith(VARIABLE.encode() + b"=")]
            if values and mark.encode() in values[0]:
                living[int(folder.name)] = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode().strip()
        except OSError:
            continue
    return {pid: command for pid, command in living.items() if pid != os.getpid()}


def end_all(mark: str) -> None:
    """Kill every process with this mark."""
    for pid in marked(mark):
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            continue


def main(pid: int, mark: str) -> None:
    """Wait for the end of a process, and end what it leaves."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    try:
        handle = os.pidfd_open(pid)
    except ProcessLookupError:
        handle = -1  # it has ended already
    print("ready", flush=True)
    if handle >= 0:
        select.select([handle], [], [])
    for _ in range(ROUNDS):
        end_all(mark)
        time.sleep(0.1)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
