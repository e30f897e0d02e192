"""Process groups whose children are small programs in place of nodes."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from process_helpers import LIMIT as TIMEOUT

from crane_sim.orchestration.process_group import ProcessGroup

# s from an interruption to the end: 3 s on an idle machine, a minute or never without a deadline
LIMIT = 20.0
IGNORES_SIGTERM = """
import os, signal, sys, time

def main():
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    fd = next(int(word.partition(":=")[2]) for word in sys.argv if word.startswith("report_fd"))
    os.write(fd, b'{"event": "ready"}\\n')
    time.sleep(600)
"""


def make_group(
    folder: Path, program: str, env: dict[str, str], interrupts: Sequence[int] = ()
) -> ProcessGroup:
    """Return a process group in which the module `node` is this program."""
    (folder / "node.py").write_text(program)
    return ProcessGroup(env | {"PYTHONPATH": f"{folder}:{env['PYTHONPATH']}"}, interrupts)


def listen_until(group: ProcessGroup, done: Callable[[], bool]) -> None:
    """Read the reports of the children until it is done; fails after the time-out."""
    deadline = time.monotonic() + TIMEOUT
    while not done():
        states = [
            (child.name, "exited" if child.exited else "alive", child.fault)
            for child in group.children
        ]
        assert time.monotonic() < deadline, f"not within {TIMEOUT:g} s; the children: {states}"
        group.listen(0.5)
