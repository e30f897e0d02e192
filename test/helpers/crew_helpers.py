"""Crews of small programs in place of nodes."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from process_helpers import LIMIT as PATIENCE

from crane_sim.orchestration.process_group import ProcessGroup

LIMIT = 3.0  # s from an interruption to the end, as promised
STUBBORN = """
import os, signal, sys, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
fd = next(int(word.partition(":=")[2]) for word in sys.argv if word.startswith("report_fd"))
os.write(fd, b'{"event": "ready"}\\n')
time.sleep(600)
"""


def crew_of(folder: Path, program: str, env: dict[str, str], interrupts: Sequence[int] = ()) -> ProcessGroup:
    """Return a crew whose nodes can be of a module `node` that is this program."""
    (folder / "node.py").write_text(program)
    return ProcessGroup(env | {"PYTHONPATH": f"{folder}:{env['PYTHONPATH']}"}, interrupts)


def listen_until(crew: ProcessGroup, done: Callable[[], bool]) -> None:
    """Take in what the children report until it is done; fails where that takes too long."""
    deadline = time.monotonic() + PATIENCE
    while not done():
        states = [(child.name, "gone" if child.gone else "lives", child.fault) for child in crew.children]
        assert time.monotonic() < deadline, f"not within {PATIENCE:g} s; the children: {states}"
        crew.listen(0.5)
