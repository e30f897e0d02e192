"""Environments of Gymnasium: motion and metrics of `simulate`, seeds, failures, spaces, errors."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from crane_bench.league.cells import compute_metrics
from crane_sim import SceneError, load_scene, simulate
from crane_sim.gym import CraneEnv, CraneVectorEnv

SHORT = {"duration": 0.3}


@pytest.mark.parametrize("crane", ["overhead", "knuckle"])
def test_gymnasium_accepts_the_environments(crane: str) -> None:
    """Registered environments pass Gymnasium's own check; its warnings concern physical units."""
    env = gymnasium.make(f"crane_sim/{crane.capitalize()}-v0")
    with warnings.catch_warnings(record=True) as noted:
        check_env(env.unwrapped, skip_render_check=True)
    # Gymnasium's, not numpy's
    own = [str(warning.message) for warning in noted if warning.category is UserWarning]
    assert own and all("normalized space" in line or "infinity" in line for line in own)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        (
            "overhead_energy",
            {
                "base_motion": {"surge": {"amplitude": 0.2, "frequency": 3.0}},
                "control.nominal": {"base_motion": None},
            },
        ),
        ("knuckle_setpoint", {}),
    ],
)
def test_a_law_as_policy_is_simulate(name: str, changes: dict[str, Any]) -> None:
    """A law that commands an environment has the run of `simulate`, bit for bit.

    The return is the league's metric.
    """
    scene = load_scene(name, SHORT | changes)
    assert scene.law is not None
    env = CraneEnv(scene, max_effort=1e6)
    env.reset(seed=scene.seed)
    total, ended = 0.0, False
    while not ended:
        command = scene.law(env.plant.t, *env.plant.seen)
        _, reward, failed, ended, _ = env.step(np.array(command))
        total += reward
        assert not failed
    run = simulate(scene)
    assert env.plant.summary()["state_sha256"] == run.summary["state_sha256"]
    # both are means of the same 31 distances, summed in another order: rounding
    assert total == pytest.approx(-compute_metrics(run, False).mae, rel=1e-13)


def episode(env: CraneEnv, seed: int | None) -> Any:
    """Return the observations of three steps."""
    seen = [env.reset(seed=seed)[0]]
    seen += [env.step(np.full(env.action_space.shape or (), 3.0))[0] for _ in range(3)]
    return np.array(seen)


def test_the_seed_is_the_scene_s() -> None:
    """A seed draws the parameters and noise of `load_scene`; without one episodes differ."""
    uncertain = {
        "payload.mass": 10.0,
        "uncertain": {"payload.mass": {"distribution": "uniform", "low": 2.0, "high": 20.0}},
    }
    for changes in (uncertain, {"sensors.all.noise": [0.01, 0.01]}):
        scene = load_scene("overhead_energy", SHORT | changes)
        env = CraneEnv(scene, max_effort=10.0)
        first, drawn = episode(env, 7), [episode(env, None) for _ in range(2)]
        np.testing.assert_array_equal(
            first, episode(CraneEnv(load_scene(scene, {"seed": 7}), max_effort=10.0), 7)
        )
        np.testing.assert_array_equal(first, episode(env, 7))
        np.testing.assert_array_equal(drawn[0], episode(env, None))
        assert len({part[-1].tobytes() for part in (first, *drawn)}) == 3


def test_a_failure_is_terminal_and_does_not_pay() -> None:
    """At a travel limit the episode terminates with the reason.

    What it lacks costs its largest error.
    """
    changes = {"reference.q": [0.5], "trolley.limits": [-1.0, 0.6], "duration": 2.0}
    env = CraneEnv(load_scene("overhead_energy", changes), max_effort=500.0)
    errors = [env.reset(seed=0)[1]["error"]]
    rewards, failed, info = list[float](), False, dict[str, Any]()
    while not failed:
        observation, reward, failed, over, info = env.step(np.array([500.0]))
        rewards.append(reward)
        errors += [] if failed else [info["error"]]
        assert observation in env.observation_space and not over
    assert "the trolley reached its travel limit" in info["reason"]
    lacking = 201 - len(errors)
    assert lacking > 100
    # sums of 201 terms in another order: rounding
    assert sum(rewards) == pytest.approx(-(sum(errors) + lacking * max(errors)) / 201, rel=1e-13)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.array([0.0]))


def test_a_path_is_followed() -> None:
    """Observations end with position and velocity of the payload's path, if it has one.

    The error is the distance from that position.
    """
    env = CraneEnv(load_scene("offshore_obstacle", {"duration": 0.02}), max_effort=1.0)
    (observation, info), scene = env.reset(seed=0), env.scene
    assert env.observation_names[-4:] == ("path x", "path y", "path x velocity", "path y velocity")
    assert env.observation_units[-4:] == ("m", "m", "m/s", "m/s")
    assert len(observation) == len(env.observation_names) == 2 * len(scene.joint_names) + 4
    run = simulate(scene, lambda t, q, v: (0.0, 0.0))
    # rounding
    assert info["error"] == pytest.approx(
        np.hypot(*(run.payload[0, :2] - observation[-4:-2])), rel=1e-12
    )
    total = sum(env.step([0.0, 0.0])[1] for _ in range(scene.steps))
    # sums in another order
    assert total == pytest.approx(-compute_metrics(run, True).mae, rel=1e-13)


def test_spaces_have_the_scene_s_bounds_and_units() -> None:
    """Drives and servos bound commands, travel limits bound positions, `max_effort` the rest."""
    env = CraneEnv(crane="bridge")
    assert (env.action_names, env.action_units) == (
        ("trolley", "bridge", "rope"),
        ("m/s", "m/s", "m/s"),
    )
    assert env.action_space == gymnasium.spaces.Box(
        -(b := np.array([0.4, 0.63, 0.2])), b, dtype=np.float64
    )
    space: Any = env.observation_space
    bounds = dict(
        zip(
            env.observation_names,
            zip(space.low.tolist(), space.high.tolist(), strict=True),
            strict=True,
        )
    )
    assert bounds["trolley"] == bounds["target trolley"] == (-9.0, 9.0)
    assert bounds["bridge"] == bounds["trolley velocity"] == (-np.inf, np.inf)
    wide: Any = CraneEnv("knuckle_setpoint", max_effort=(1.0, 2.0, 3.0, 4.0)).action_space
    assert wide.high.tolist() == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("scene", "max_effort", "line"),
    [
        (
            "overhead_energy",
            None,
            "max_effort: is missing, scene overhead_energy bounds no commands of trolley;",
        ),
        (
            "overhead_energy",
            -1.0,
            "max_effort = -1.0: must be a number greater than 0, or one for each of trolley",
        ),
        (
            "overhead_energy",
            (1.0, 2.0),
            "max_effort = (1.0, 2.0): must be a number greater than 0, or one for each",
        ),
        (
            "overhead_swing",
            1.0,
            "scene overhead_swing: has neither a target (reference.q) nor a path of the payload",
        ),
        ("overhead_sway", 1.0, "scene overhead_sway: has no joint that takes commands"),
    ],
)
def test_what_is_no_task_is_refused_in_one_line(scene: str, max_effort: Any, line: str) -> None:
    """A scene that is no task, or a bound that is none, is refused in one line that names it."""
    with pytest.raises(SceneError) as refused:
        CraneEnv(scene, max_effort)
    assert line in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("action", [[1.0, 2.0], 1.0, [np.nan], ["x"]])
def test_an_action_is_one_number_for_each_joint(action: Any) -> None:
    """Actions of another shape, or not numbers, are refused, and the crane stays where it is."""
    env = CraneEnv()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="must be a number for each of trolley"):
        env.step(action)
    assert env.plant.k == 0


def test_steps_before_an_episode_and_unknown_options_are_refused() -> None:
    """Before the first reset there is nothing to step; an unknown option of `reset` is named."""
    env = CraneEnv()
    with pytest.raises(gymnasium.error.ResetNeeded, match="none has begun"):
        env.step([0.0])
    with pytest.raises(SceneError, match="unknown option of reset 'x'"):
        env.reset(options={"x": 1})


@pytest.mark.parametrize(
    ("q", "line"), [([1.0], "has 1 values"), (0.5, "positions = 0.5: must be a number for each")]
)
def test_a_reset_that_fails_begins_no_episode(q: Any, line: str) -> None:
    """After an impossible state there is nothing to step, though an episode was under way."""
    env = CraneEnv()
    env.reset(seed=1)
    with pytest.raises(SceneError, match=line):
        env.reset(seed=2, options={"q": q})
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([0.0])


def test_a_crane_of_another_kind_has_no_place_in_the_spaces() -> None:
    """A seed that draws fewer joints, or another method, is an error in both environments.

    The error is one line.
    """
    load = {"payload.mass": {"distribution": "uniform", "low": 50.0, "high": 150.0}}
    document = load_scene("overhead_chain").to_dict() | {"uncertain": load, "duration": 0.03}
    document |= {
        "control": None,
        "inputs": None,
        "reference": {"q": [3.0]},
        "actuators": {"trolley": {"limit": 100.0}},
    }
    document["cable"] |= {"model": "auto"}
    with pytest.raises(
        SceneError, match=r"seed = 1: draws a crane of 2 joints .*that of the environment has 11"
    ):
        for seed in (0, 1):
            CraneEnv(document).reset(seed=seed)
    spring = load_scene("overhead_spring").to_dict() | {
        "duration": 0.03,
        "integrator": {"method": "auto"},
    }
    spring |= {
        "control": None,
        "inputs": None,
        "reference": {"q": [3.0]},
        "actuators": {"trolley": {"limit": 100.0}},
    }
    spring |= {
        "uncertain": {"cable.stiffness": {"distribution": "uniform", "low": 5e8, "high": 3e9}}
    }
    spring["trolley"] |= {"limits": [-50.0, 50.0]}
    environment = CraneVectorEnv(1, spring)
    with pytest.raises(SceneError, match="a batch takes one kind of model, method and law, path"):
        for seed in range(12):
            environment.reset(seed=seed)
