"""Kills what a test session leaves when its process is killed: PID MARK. Standard library alone.

It waits for the end of the process PID, and then kills every process whose environment has MARK in
the value of `CRANE_SIM_TEST_SESSION`: the processes of a test inherit it, whatever their session or
process group.
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
ROUNDS = 20  # searches, 0.1 s apart, for processes that were just being started


def tie_to_parent() -> None:
    """Let the kernel end this process together with the thread that started it."""
    ctypes.CDLL(None).prctl(PDEATHSIG, signal.SIGKILL)


def find_marked(mark: str) -> dict[int, str]:
    """Return the command line of every process with this mark, by process id."""
    commands = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            environment = (folder / "environ").read_bytes().split(b"\0")  # of a zombie it is empty
            values = [entry for entry in environment if entry.startswith(VARIABLE.encode() + b"=")]
            if values and mark.encode() in values[0]:
                commands[int(folder.name)] = (
                    (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode().strip()
                )
        except OSError:
            continue
    return {pid: command for pid, command in commands.items() if pid != os.getpid()}


def kill_all(mark: str) -> None:
    """Kill every process with this mark."""
    for pid in find_marked(mark):
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            continue


def main(pid: int, mark: str) -> None:
    """Wait for the exit of a process, and kill those that it leaves."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    try:
        handle = os.pidfd_open(pid)
    except ProcessLookupError:
        handle = -1  # it has exited already
    print("ready", flush=True)
    if handle >= 0:
        select.select([handle], [], [])
    for _ in range(ROUNDS):
        kill_all(mark)
        time.sleep(0.1)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
