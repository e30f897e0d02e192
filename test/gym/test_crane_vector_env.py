"""Vector environments compared with Gymnasium's own vector of single ones, bit for bit."""

import importlib
import re
import sys
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv, VectorEnv

from crane_sim import SceneError, load_scene
from crane_sim.files.installation import missing_package
from crane_sim.gym import DEFAULT_SCENES, CraneEnv, CraneVectorEnv

N = 3
UNIFORM: dict[str, Any] = {"distribution": "uniform"}
UNCERTAIN = {"payload.mass": UNIFORM | {"low": 0.5, "high": 2.0}}
NOISY = {"sensors.all.noise": [0.01, 0.01], "actuators.all.delay": 0.01}
LIMITED = {"trolley.limits": [-1.0, 0.05], "reference.q": [0.0]}
# m: behind its delay the trolley is at rest for one period of four
NEAR = {"trolley.limits": [-0.02, 0.02]}
KINDS: dict[str, tuple[str, dict[str, Any], float]] = {
    "sensors, drives and a limit that ends episodes": (
        "overhead_energy",
        NOISY | LIMITED | NEAR,
        3000.0,
    ),
    "uncertain load": ("knuckle_setpoint", {"uncertain": UNCERTAIN}, 5.0),
    "path on a moving base": ("offshore_resonant", {}, 1.0),
    "law evaluated in every stage": ("knuckle_continuous", {}, 5.0),
}


def step_both(ours: VectorEnv, theirs: VectorEnv, seed: Any, steps: int) -> list[str]:
    """Step two vector environments by the same commands; return the reasons of failures."""
    check_equal(ours.reset(seed=seed), theirs.reset(seed=seed))
    generator, reasons = np.random.default_rng(1), list[str]()
    space: Any = ours.action_space
    for _ in range(steps):
        actions = generator.uniform(space.low, space.high)
        answer, wanted = ours.step(actions), theirs.step(actions)
        check_equal(answer, wanted)
        check_infos(answer[-1], wanted[-1])
        reasons += [line for line in find_reasons(answer[-1]) if line]
    return reasons


def find_reasons(info: dict[str, Any]) -> Sequence[str | None]:
    """Return the reasons of failures, of this step or of episodes that ended in it."""
    return (*info.get("reason", ()), *info.get("final_info", {}).get("reason", ()))


def check_equal(ours: Sequence[Any], theirs: Sequence[Any]) -> None:
    """Check that all but the last items are the same arrays."""
    for own, other in zip(ours[:-1], theirs[:-1], strict=True):
        np.testing.assert_array_equal(own, other)
        assert own.dtype == other.dtype


def check_infos(ours: dict[str, Any], theirs: dict[str, Any]) -> None:
    """Check that the infos have the same entries, of the same cranes."""
    assert set(ours) == set(theirs)
    for key in [key for key in ours if not key.startswith("_")]:
        has = ours[f"_{key}"]
        np.testing.assert_array_equal(has, theirs[f"_{key}"])
        if isinstance(ours[key], dict):
            check_infos(ours[key], theirs[key])
        else:
            np.testing.assert_array_equal([*ours[key][has]], [*theirs[key][has]])


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_cranes_are_single_environments(kind: str, mode: str) -> None:
    """Three episodes equal those of Gymnasium's vector of `CraneEnv`.

    Observations, rewards, ends and infos are compared.
    """
    name, changes, effort = KINDS[kind]
    scene = load_scene(name, changes)
    scene = load_scene(scene, {"duration": 4 * scene.period})
    theirs = SyncVectorEnv([lambda: CraneEnv(scene, effort)] * N, autoreset_mode=mode)
    reasons = step_both(
        CraneVectorEnv(N, scene, effort, autoreset_mode=mode), theirs, [5, 2**31 + 7, 0], 14
    )
    assert bool(reasons) == ("limit" in kind)
    assert all("the trolley reached its travel limit" in reason for reason in reasons)


@pytest.mark.parametrize("crane", DEFAULT_SCENES)
def test_spaces_are_those_of_one_crane(crane: str) -> None:
    """`make_vec` makes them by default, with the spaces and names of n single environments."""
    (name,) = [name for name in gymnasium.registry if name == f"crane_sim/{crane.capitalize()}-v0"]
    ours, own = gymnasium.make_vec(name, num_envs=2), CraneEnv(crane=crane)
    assert isinstance(ours, CraneVectorEnv)
    assert (
        ours.single_action_space == own.action_space
        and ours.single_observation_space == own.observation_space
    )
    spaces: Any = ours.action_space, ours.observation_space
    assert [space.shape for space in spaces] == [
        (2, len(own.action_names)),
        (2, len(own.observation_names)),
    ]
    assert (ours.observation_names, ours.observation_units) == (
        own.observation_names,
        own.observation_units,
    )
    assert (ours.action_names, ours.action_units) == (own.action_names, own.action_units)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ({"num_envs": 0}, "num_envs = 0: must be at least 1"),
        ({"threads": 0}, "threads = 0: must be at least 1"),
        (
            {"autoreset_mode": "Disabled"},
            "autoreset_mode = 'Disabled': possible: NextStep, SameStep",
        ),
        (
            {"scene": "overhead_swing"},
            "scene overhead_swing: has neither a target (reference.q) nor a path",
        ),
        (
            {
                "scene": load_scene(
                    "overhead_energy", {"uncertain": {"duration": UNCERTAIN["payload.mass"]}}
                )
            },
            "scene overhead_energy: uncertain.duration: all episodes of an environment have one "
            "time",
        ),
    ],
)
def test_what_is_not_possible_is_refused_in_one_line(arguments: dict[str, Any], line: str) -> None:
    """Numbers, modes and scenes that make no vector environment are refused.

    The error names the culprit and what is possible.
    """
    with pytest.raises(SceneError) as refused:
        CraneVectorEnv(**arguments)
    assert line in str(refused.value) and "\n" not in str(refused.value)


def test_calls_are_checked() -> None:
    """Commands of another shape, other numbers of seeds, and steps before a reset are refused."""
    envs = CraneVectorEnv(2)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros((2, 1)))
    with pytest.raises(ValueError, match="seed: has 3 values for 2 cranes"):
        envs.reset(seed=[1, 2, 3])
    with pytest.raises(ValueError, match="a vector environment takes none"):
        envs.reset(options={"q": [0.0, 0.0]})
    envs.reset(seed=0)
    for actions in (np.zeros(2), np.full((2, 1), np.nan)):
        with pytest.raises(ValueError, match="a number for each of trolley of 2 cranes"):
            envs.step(actions)
    envs.scenes[1] = None  # pyright: ignore[reportArgumentType]  # a crane whose reset fails
    with pytest.raises(AttributeError):
        envs.reset(seed=0)
    with pytest.raises(
        gymnasium.error.ResetNeeded
    ):  # nor does the episode before go on with some cranes at its start
        envs.step(np.zeros((2, 1)))


PATH = {
    "kind": "point_to_point",
    "from": [1.35, 0.0],
    "to": [1.35, 1.0],
    "velocity": 0.9,
    "acceleration": 1.0,
}
UNLIKE: dict[str, dict[str, Any]] = {
    "path": {
        "reference.path": PATH,
        "uncertain": {"reference.path.velocity": UNIFORM | {"low": 0.8, "high": 1.2}},
    },
    "delay": {"uncertain": {"actuators.all.delay": UNIFORM | {"low": 0.0, "high": 0.12}}},
}


@pytest.mark.parametrize("case", UNLIKE)
def test_a_seed_that_draws_another_kind_is_one_line(case: str) -> None:
    """Another number of a path's pieces or a delay's periods is refused by `reset` and `step`.

    The error is the rule.
    """
    rule = "a batch takes one kind of model, method and law, path .*"
    base = {"actuators": {"all": {"delay": 0.04}}, "duration": 0.008}
    scene = load_scene("offshore_resonant", base | UNLIKE[case])
    envs = CraneVectorEnv(2, scene, max_effort=2.0)
    with pytest.raises(SceneError) as refused:
        for seed in range(0, 20, 2):
            envs.reset(seed=seed)
    assert re.fullmatch(rf"seed = \d+: {rule}", str(refused.value))
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros((2, 2)))
    # the same kind: an episode of two periods, after which seeds are drawn
    envs.reset(seed=[scene.seed] * 2)
    with pytest.raises(SceneError, match=rule):
        for _ in range(40):
            envs.step(np.zeros((2, 2)))


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without Gymnasium the import says in one line what to install."""
    monkeypatch.delitem(sys.modules, "crane_sim.gym")
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(SceneError) as refused:
        importlib.import_module("crane_sim.gym")
    assert str(refused.value) == missing_package("gymnasium", "an environment")
