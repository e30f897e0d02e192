"""Programs started by tests: each ends with the block that started it, or with this process.

Every wait here has a time limit, beyond which it fails with a line on its subject.
"""

import os
import shlex
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from crane_sim.process_signals import set_parent_death_signal

# s for a program or a wait, only so that a failure ends: the first of a scene compiles
LIMIT = 500.0
_EXIT_TIMEOUT = 20.0  # s for a killed process to exit, and for reading the rest of its pipes


@contextmanager
def started_program(
    command: Sequence[str | Path], *, limit: float = LIMIT, grace: float = 0.0, **options: Any
) -> Iterator[subprocess.Popen[Any]]:
    """Yield a program that runs in a process group of its own; after the block it has exited.

    Args:
        command: program and arguments.
        limit: s after which the group is killed, which ends every wait for the program.
        grace: s from SIGTERM, at the end of the block, to SIGKILL; 0: SIGKILL at once.
        options: further arguments of `subprocess.Popen`.

    Raises:
        AssertionError: the program ran into the limit.
    """
    process = subprocess.Popen(
        command,
        **{"text": True, "process_group": 0, "preexec_fn": set_parent_death_signal()} | options,
    )
    overrun: list[str] = []

    def expire() -> None:
        overrun.append(
            f"{shlex.join(map(str, command))[:300]}: still ran after {limit:g} s, and was killed"
        )
        _kill(process)

    timer = threading.Timer(limit, expire)
    timer.daemon = True
    timer.start()
    try:
        yield process
    except Exception as error:
        if overrun:
            raise AssertionError(overrun[0]) from error
        raise
    finally:
        timer.cancel()
        end(process, grace)
    assert not overrun, overrun[0]


def run_to_completion(
    command: Sequence[str | Path], *, limit: float = LIMIT, check: bool = False, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Run a program; return its exit code and output.

    Args:
        command: program and arguments.
        limit: see `started_program`.
        check: fail where the exit code is not 0.
        options: further arguments of `subprocess.Popen`.
    """
    with started_program(
        command, limit=limit, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    ) as process:
        out, err = process.communicate(timeout=limit + _EXIT_TIMEOUT)
    assert not check or process.returncode == 0, f"exit code {process.returncode}: {err}"
    return subprocess.CompletedProcess(command, process.returncode, out, err)


def end(process: subprocess.Popen[Any], grace: float = 0.0) -> None:
    """End a program, with its process group if it has not exited; see `started_program`."""
    if grace and process.poll() is None:
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(grace)
    _kill(process)
    process.wait(_EXIT_TIMEOUT)
    for pipe in (process.stdin, process.stdout, process.stderr):
        if pipe:
            with suppress(BrokenPipeError):
                pipe.close()


def _kill(process: subprocess.Popen[Any]) -> None:
    if process.poll() is None:  # not reaped yet: its id, and that of its group, is not in use again
        with suppress(ProcessLookupError, PermissionError):  # it is no group yet, or another user's
            os.killpg(process.pid, signal.SIGKILL)
        process.kill()


def next_line(process: subprocess.Popen[str]) -> str:
    """Return the next line that a program writes; fails where it exits before that."""
    assert process.stdout is not None
    line = process.stdout.readline()
    assert line, f"{process.args} exited without writing the line that the test waits for"
    return line


def wait_until(
    condition: Callable[[], bool], what: str = "the condition of the test", timeout: float = LIMIT
) -> None:
    """Return as soon as the condition holds; fails after `timeout` seconds, naming `what`."""
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, f"{what}: not within {timeout:g} s"
        time.sleep(0.002)


def has_exited(pid: int) -> bool:
    """Return whether a process has exited: no such id, or a zombie that has yet to be reaped."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] in "ZX"
    except OSError:
        return True


def wait_exited(pid: int) -> None:
    """Wait for the exit of a process.

    It takes the kernel no time, and a node that polls its pipe 50 ms.
    """
    wait_until(lambda: has_exited(pid), f"the end of process {pid}", 30.0)


def children(pid: int) -> list[int]:
    """Return the process ids of the children of a process's main thread."""
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def nodes_of(pid: int) -> dict[str, int]:
    """Return the process ids of a run's nodes, forked by a child of its process, by name."""
    nodes = {}
    for node in (node for child in children(pid) for node in children(child)):
        name, _, kind = Path(f"/proc/{node}/comm").read_text().strip().rpartition("_")
        nodes |= {name: node} if kind == "node" else {}
    return nodes
