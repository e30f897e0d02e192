"""Worker processes of a study: what is left of them when their parent is killed, and what they say of compilation."""

import os
import signal
import sys
from threading import Event

from process_helpers import run_to_completion

from crane_sim.numerics.jit import entry_point
from crane_sim.study.workers import WorkerProcesses, watch_compiling_everywhere

PROGRAM = """
import os, signal
from crane_sim.study.workers import WorkerProcesses
if __name__ == "__main__":
    pool = WorkerProcesses(1)
    pool.submit(os.getpid).result()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_process_leaves_no_semaphores_and_no_line(tmp_path: os.PathLike[str]) -> None:
    """Python's resource tracker, which outlives a killed process, removes its semaphores and prints nothing."""
    program = os.path.join(tmp_path, "program.py")
    with open(program, "w") as file:
        file.write(PROGRAM)
    before = set(os.listdir("/dev/shm"))
    ended = run_to_completion([sys.executable, program])  # to the end of its output, which the tracker has, too
    assert (ended.returncode, ended.stdout, ended.stderr) == (-signal.SIGKILL, "", "")
    assert not {name for name in set(os.listdir("/dev/shm")) - before if name.startswith("sem.mp")}


def double(x: float) -> float:
    """Compile a function, and return what it returns."""
    factor = 2.0  # code of a function with variables around it is not on the disk
    return entry_point(lambda x: factor * x)(x)


def test_compilation_in_a_worker_is_seen() -> None:
    """Who watches compilation is called for that of worker processes, too, and for none where they compile nothing."""
    seen = Event()
    with watch_compiling_everywhere(seen.set), WorkerProcesses(1) as pool:
        pool.submit(os.getpid).result()
        assert not seen.is_set()
        assert pool.submit(double, 1.0).result() == 2.0
        assert seen.wait(60.0)  # s; a notice takes milliseconds
