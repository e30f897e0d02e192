"""Compilation on two cores: a second process compiles what evaluates a run, while this one compiles what integrates it.

Compiled functions are cached on the disk, where each process finds those of the other one. A process that needs a
function which the other one is compiling waits for it.
"""

import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress

import numpy as np

from crane_sim.process_signals import set_parent_death_signal
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.hardware import HardwareRun
from crane_sim.simulation.rollout import RawRun, make_rollout, summarize
from crane_sim.stepping.periods import begin
from crane_sim.stepping.rows import row_width
from crane_sim.tracing.compile_time import watch_compiling


@contextmanager
def compile_evaluation_beside(scene: Scene) -> Iterator[None]:
    """Start the second process at the first function that is compiled within the block, and end it after the block.

    Nothing depends on it: where it does not start, or fails, this process compiles everything itself.
    """
    process = _SecondProcess(scene)
    try:
        with watch_compiling(process.start):
            yield
    finally:
        process.stop()


class _SecondProcess:
    """The second process, which is started once, and only where there is a second core."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._tried = scene, False
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start it at the first call; where that is not possible, nothing happens."""
        if self._tried or len(os.sched_getaffinity(0)) < 2:
            return
        self._tried = True
        with suppress(OSError, pickle.PicklingError), tempfile.TemporaryFile() as document:
            pickle.dump(self._scene.to_dict(), document)
            document.seek(0)
            command, silent = [sys.executable, "-m", __name__], subprocess.DEVNULL
            end_with_this_one = set_parent_death_signal()
            self._process = subprocess.Popen(
                command, stdin=document, stdout=silent, stderr=silent, preexec_fn=end_with_this_one
            )

    def stop(self) -> None:
        """End it, whatever it is doing."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()


def compile_evaluation(scene: Scene) -> None:
    """Compile what evaluates the runs of a scene: evaluate a run of one period in which nothing moves."""
    integration, q, v = begin(scene.model, np.array(scene.initial_q), np.array(scene.initial_v))
    nq, nu = len(q), len(scene.actuated)
    rows = np.zeros((2, row_width(scene.model, nq, nu)))
    rows[:, : 2 * nq] = (*q, *v)
    hardware = HardwareRun(scene) if scene.hardware is not None and not scene.hardware.ideal else None
    loads = np.empty((0, 2)) if hardware is None else np.array([[hardware.payload_mass, 0.0]] * 2)
    run = RawRun(rows, rows[:0], integration, 0, np.zeros((1, nu)), hardware, loads)
    periods = np.arange(2, dtype=np.float64) * scene.period
    make_rollout(scene, run, periods, rows, {}, summarize(scene, run), [])


if __name__ == "__main__":
    compile_evaluation(load_scene(pickle.load(sys.stdin.buffer)))
