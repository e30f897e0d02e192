"""One scene, one state_sha256 for all processes, executors, distributions and loads."""

import sys

import pytest

from crane_bench.soak.determinism import (
    KILTED,
    Setup,
    busy,
    determinism_scene,
    setups,
    soak_determinism,
    state_sha256,
)
from crane_sim import simulate

SCENE = determinism_scene(3.0)


def hash_in_process() -> str:
    """Return the hash of the run in this process."""
    return simulate(SCENE).summary["state_sha256"]


@pytest.mark.long(cases=["3-events"])
@pytest.mark.parametrize(("processes", "executor"), [(2, "single"), (3, "events")])
def test_processes_and_executors_change_no_bit(processes: int, executor: str) -> None:
    """Two processes or three, either executor: the states are those of a run in one process."""
    assert state_sha256(Setup(processes, executor), SCENE) == hash_in_process()


@pytest.mark.long
def test_a_loaded_machine_changes_no_bit() -> None:
    """Two busy loops beside the nodes make the run slower, and nothing else."""
    with busy(2):
        assert state_sha256(Setup(), SCENE) == hash_in_process()


@pytest.mark.skipif(not KILTED, reason="CRANE_SIM_KILTED_PYTHON names no Python with ROS 2 Kilted")
@pytest.mark.parametrize("executor", ["events", "single"])
@pytest.mark.parametrize("foreign", ["plant", "controller", "both"])
def test_another_distribution_changes_no_bit(foreign: str, executor: str) -> None:
    """Plant or controller or both on ROS 2 Kilted: still the same states."""
    jazzy, kilted = sys.executable, KILTED
    pythons = {"plant": (kilted, jazzy), "controller": (jazzy, kilted), "both": (kilted, kilted)}
    plant, controller = pythons[foreign]
    assert state_sha256(Setup(2, executor, plant, controller), SCENE) == hash_in_process()


def test_every_mixture_is_planned() -> None:
    """All numbers of processes and executors are tried, and for each node another interpreter.

    The latter needs that there is one.
    """
    assert {(each.processes, each.executor) for each in setups("")} == {
        (processes, executor) for processes in (2, 3) for executor in ("events", "single")
    }
    foreign = [(each.plant == "kilted", each.controller == "kilted") for each in setups("kilted")]
    assert {pair: foreign.count(pair) for pair in foreign} == {
        (False, False): 4,
        (True, False): 2,
        (False, True): 2,
        (True, True): 2,
    }


@pytest.mark.slow
def test_fifty_runs_are_one() -> None:
    """Fifty runs over every mixture of processes, executors and load have one hash."""
    metrics, data = soak_determinism(50)
    assert all(metric.passed for metric in metrics), metrics
    assert len(data["took_s"]) == 50
