"""Tests what worker processes of a study leave when their parent is killed."""

import os
import signal
import sys

from process_helpers import run_to_completion

PROGRAM = """
import os, signal
from crane_sim.study.workers import WorkerProcesses
if __name__ == "__main__":
    pool = WorkerProcesses(1)
    pool.submit(os.getpid).result()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_process_leaves_no_semaphores_and_no_line(tmp_path: os.PathLike[str]) -> None:
    """Python's resource tracker outlives it, removes its semaphores and prints nothing."""
    program = os.path.join(tmp_path, "program.py")
    with open(program, "w") as file:
        file.write(PROGRAM)
    before = set(os.listdir("/dev/shm"))
    ended = run_to_completion([sys.executable, program])  # its output ends with the tracker's
    assert (ended.returncode, ended.stdout, ended.stderr) == (-signal.SIGKILL, "", "")
    assert not {name for name in set(os.listdir("/dev/shm")) - before if name.startswith("sem.mp")}
