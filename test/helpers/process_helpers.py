"""Programs that tests start: each ends with the block that started it, or with this process, however that ends.

Nothing that is waited for here may last for ever: what takes too long fails with a line that says what it was.
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

LIMIT = 300.0  # s for a program or a wait, only so that a failure ends: the first of a scene compiles
_GONE = 20.0  # s for a process that was killed, and for what is left in its pipes


@contextmanager
def started_program(
    command: Sequence[str | Path], *, limit: float = LIMIT, patience: float = 0.0, **options: Any
) -> Iterator[subprocess.Popen[Any]]:
    """Yield a program that runs in a process group of its own; behind the block it has ended.

    Args:
        command: program and arguments.
        limit: after so many seconds the group is killed, which ends every wait for the program.
        patience: s from SIGTERM, at the end of the block, to SIGKILL; 0: SIGKILL at once.
        options: further arguments of `subprocess.Popen`.

    Raises:
        AssertionError: the program ran into the limit.
    """
    process = subprocess.Popen(
        command, **{"text": True, "process_group": 0, "preexec_fn": set_parent_death_signal()} | options
    )
    late: list[str] = []

    def expire() -> None:
        late.append(f"{shlex.join(map(str, command))[:300]}: still ran after {limit:g} s, and was killed")
        _kill(process)

    timer = threading.Timer(limit, expire)
    timer.daemon = True
    timer.start()
    try:
        yield process
    except Exception as error:
        if late:
            raise AssertionError(late[0]) from error
        raise
    finally:
        timer.cancel()
        end(process, patience)
    assert not late, late[0]


def completed(
    command: Sequence[str | Path], *, limit: float = LIMIT, check: bool = False, **options: Any
) -> subprocess.CompletedProcess[str]:
    """Return how a program ended, and what it wrote.

    Args:
        command: program and arguments.
        limit: as of `started_program`.
        check: fail where the exit code is not 0.
        options: further arguments of `subprocess.Popen`.
    """
    with started_program(
        command, limit=limit, **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    ) as it:
        out, err = it.communicate(timeout=limit + _GONE)
    assert not check or it.returncode == 0, f"exit code {it.returncode}: {err}"
    return subprocess.CompletedProcess(command, it.returncode, out, err)


def end(process: subprocess.Popen[Any], patience: float = 0.0) -> None:
    """End a program, and its process group where it has not ended by itself; arguments as of `started_program`."""
    if patience and process.poll() is None:
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(patience)
    _kill(process)
    process.wait(_GONE)
    for pipe in (process.stdin, process.stdout, process.stderr):
        if pipe:
            with suppress(BrokenPipeError):
                pipe.close()


def _kill(process: subprocess.Popen[Any]) -> None:
    if process.poll() is None:  # it has not been reaped: its number, and that of its group, is no other's
        with suppress(ProcessLookupError, PermissionError):  # it has not come to be a group yet, or is another user's
            os.killpg(process.pid, signal.SIGKILL)
        process.kill()


def next_line(process: subprocess.Popen[str]) -> str:
    """Return the next line that a program writes; fails where it ends before that."""
    assert process.stdout is not None
    line = process.stdout.readline()
    assert line, f"{process.args} ended, and did not write what it was waited for"
    return line


def wait_until(done: Callable[[], bool], what: str = "what the test waits for", patience: float = LIMIT) -> None:
    """Return as soon as it is done; fails after `patience` seconds."""
    deadline = time.monotonic() + patience
    while not done():
        assert time.monotonic() < deadline, f"{what}: not within {patience:g} s"
        time.sleep(0.002)


def gone(pid: int) -> bool:
    """Whether a process has ended: it is no more, or a zombie that has yet to be reaped."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] in "ZX"
    except OSError:
        return True


def ends_soon(pid: int) -> None:
    """Check that a process ends, as it does at once by the kernel, or within 50 ms by a look at its pipe."""
    wait_until(lambda: gone(pid), f"the end of process {pid}", 30.0)


def children(pid: int) -> dict[str, int]:
    """Return the process ids of the nodes that a process has started, by node name."""
    nodes = {}
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        command = Path(f"/proc/{child}/cmdline").read_bytes().decode()
        name = next((name for name in ("plant", "controller", "tracker", "recorder") if f"{name}_node" in command), "")
        nodes |= {name: int(child)} if name else {}
    return nodes
