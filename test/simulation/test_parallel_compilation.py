"""The second process that compiles what evaluates a run: it is of use, harms nothing, and ends with its block."""

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from process_helpers import children, run_to_completion

import crane_sim
from crane_sim.simulation import parallel_compilation
from crane_sim.simulation.parallel_compilation import compile_evaluation, compile_evaluation_beside

SCENE = "overhead_energy"
COMPILED = f"""
import json
from numba.core.dispatcher import Dispatcher
import crane_sim

compiled, nested, compile_one = [], [], Dispatcher.compile

def watch(self, signature):
    hits = sum(self.stats.cache_hits.values()) if self._cache else 0
    nested.append(self)
    try:
        return compile_one(self, signature)
    finally:
        nested.pop()
        if not nested and hits == sum(self.stats.cache_hits.values()):
            compiled.append(self.py_func.__name__)

Dispatcher.compile = watch
hash = crane_sim.simulate("{SCENE}", duration=0.01).summary["state_sha256"]
print(json.dumps([compiled, hash]))
"""


@pytest.mark.long
def test_the_second_process_leaves_the_integration_alone(tmp_path: Path) -> None:
    """After it has run in an empty cache, a run has to compile the loop over periods only, and has the usual states."""
    document = tmp_path / "document"
    document.write_bytes(pickle.dumps(crane_sim.load_scene(SCENE).to_dict()))
    environment = os.environ | {"CRANE_SIM_CACHE": str(tmp_path / "cache")}
    with document.open("rb") as stdin:
        command = [sys.executable, "-m", parallel_compilation.__name__]
        subprocess.run(command, stdin=stdin, env=environment, check=True, timeout=300.0)
    done = run_to_completion([sys.executable, "-c", COMPILED], env=environment, check=True)
    compiled, state_sha256 = json.loads(done.stdout)
    assert compiled == ["zero_order_hold_rollout"]
    assert state_sha256 == crane_sim.simulate(SCENE, duration=0.01).summary["state_sha256"]


def test_it_ends_with_the_block() -> None:
    """It is started by the first function that is compiled in the block, once, and is gone after it."""

    @numba.njit
    def double(x):
        return 2.0 * x

    before = set(children(os.getpid()))
    with compile_evaluation_beside(crane_sim.load_scene(SCENE)):
        assert set(children(os.getpid())) == before
        assert double(1) == 2.0 and double(1.5) == 3.0
        started = set(children(os.getpid())) - before
        assert len(started) == (len(os.sched_getaffinity(0)) > 1)
    assert set(children(os.getpid())) == before


def test_a_block_goes_on_without_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no process can be started, functions are compiled in the block as ever."""

    def fail(*_: object, **__: object) -> None:
        raise OSError("no memory")

    monkeypatch.setattr(subprocess, "Popen", fail)
    with compile_evaluation_beside(crane_sim.load_scene(SCENE)):
        assert numba.njit(lambda x: 3.0 * x)(1) == 3.0


@pytest.mark.interpreted
@pytest.mark.parametrize("scene", [SCENE, "knuckle_sea", "overhead_bench", "tower_gust", "reeved_twelve_falls"])
def test_every_kind_of_crane_can_be_evaluated(scene: str) -> None:
    """The run in which nothing moves passes through metrics and derived quantities, with hardware and falls, too."""
    compile_evaluation(crane_sim.load_scene(scene))
