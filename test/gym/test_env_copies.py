"""Copies of environments in mid-episode go on equally, and share nothing with the original."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from crane_sim import load_scene
from crane_sim.gym import CraneEnv, CraneVectorEnv
from crane_sim.simulation.plant import BLOCK, Plant

COPIES: dict[str, Callable[[Any], Any]] = {
    "copied": copy.deepcopy,
    "pickled": lambda env: pickle.loads(pickle.dumps(env)),
}
DRIVES = {
    "sensors.all": {"noise": 0.01, "delay": 0.02},
    "actuators.trolley": {"lag": 0.1, "delay": 0.03, "limit": 100.0},
    "friction": {"trolley": {"coulomb": 5.0, "static": 8.0}},
}
SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    "sensors, late drives and friction": ("overhead_energy", DRIVES),
    "an elastic cable": ("overhead_chain", {"control": None, "reference.q": [1.0]}),
    "a path at sea": ("offshore_resonant", {}),
}


def act(env: Any, seed: int, steps: int) -> list[np.ndarray]:
    """Return the observations and rewards of steps with random commands."""
    generator, low, high = np.random.default_rng(seed), env.action_space.low, env.action_space.high
    answers = [env.step(generator.uniform(low, high)) for _ in range(steps)]
    return [np.append(observed, reward) for observed, reward, *_ in answers]


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("name", SCENES)
def test_a_copy_goes_on_equally(name: str, make: Callable[[Any], Any]) -> None:
    """A copy of an environment has the original's results, and is independent of it.

    Results are observations, rewards and metrics.
    """
    scene, changes = SCENES[name]
    env = CraneEnv(load_scene(scene, changes | {"duration": 1.0}), max_effort=5.0)
    env.reset(seed=5)
    act(env, 1, 4)
    disturbed, same = make(env), make(env)
    act(disturbed, 3, 4)  # which shows in the others, if anything is shared
    np.testing.assert_array_equal(act(env, 2, 4), act(same, 2, 4))
    assert env.plant.summary() == same.plant.summary()
    assert env.plant.summary() != disturbed.plant.summary()
    env.reset()
    same.reset()  # by a seed that is drawn
    assert env.scene.seed == same.scene.seed
    np.testing.assert_array_equal(act(env, 2, 2), act(same, 2, 2))


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
def test_a_copy_has_the_hash_of_the_whole_episode(make: Callable[[Any], Any]) -> None:
    """The hash of a copy is that of all states from the start on, over several blocks of them."""
    env = CraneEnv(load_scene("overhead_energy", {"duration": 30.0}), max_effort=5.0)
    env.reset(seed=5)
    act(env, 1, BLOCK + 5)
    same = make(make(env))
    act(env, 2, BLOCK)
    act(same, 2, BLOCK)
    assert env.plant.summary()["state_sha256"] == same.plant.summary()["state_sha256"]


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("threads", [1, 2])
def test_a_copy_of_many_cranes_goes_on_equally(threads: int, make: Callable[[Any], Any]) -> None:
    """A copy of a vector environment goes on as the original does, into the next episodes.

    It has threads of its own.
    """
    scene = load_scene("overhead_energy", DRIVES | {"duration": 0.1})
    env = CraneVectorEnv(3, scene, max_effort=5.0, threads=threads)
    env.reset(seed=5)
    act(env, 1, 4)
    disturbed, same = make(env), make(env)
    act(disturbed, 3, 4)
    np.testing.assert_array_equal(act(env, 2, 10), act(same, 2, 10))
    for each in (env, same, disturbed):
        each.close()


def test_a_plant_is_pickled_where_it_keeps_its_states() -> None:
    """A plant can be copied; it is pickled only where it keeps its states, as the error says."""
    scene = load_scene("overhead_energy", {"control": None})
    plant = Plant(scene)
    plant.advance()
    assert copy.deepcopy(plant).summary() == plant.summary()
    with pytest.raises(
        TypeError, match=r"pickled only where they are kept: Plant\(scene, picklable=True\)"
    ):
        pickle.dumps(plant)
    assert (
        pickle.loads(pickle.dumps(Plant(scene, picklable=True))).summary() == Plant(scene).summary()
    )
