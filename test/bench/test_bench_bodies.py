"""Rigid loads beside other engines: each model is the scene's crane, and they agree with ours."""

import sys
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from crane_bench.speed import bodies
from crane_bench.speed.body_cases import CASES, BodyCase
from crane_bench.speed.crane_sim_engine import NAME, CraneSimEngine
from crane_bench.speed.engine import EngineUnavailable, Run
from crane_bench.speed.peers import mujoco_engine
from crane_bench.speed.peers.mechanism import (
    Mechanism,
    attitude_of,
    initial_state,
    load_pose,
    mechanism_of,
)
from crane_bench.speed.results import read_points
from crane_bench.speed.sweep import angle_between
from crane_sim.integrators.dop853 import RK8
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.derived import world_points

SHORT = 2.5  # s, with kinks of the inputs, and before the tests take long
START: dict[str, dict[str, Any]] = {
    "hook": {
        "initial.q": [-4.0, 0.5, 4.0, 0.1, 0.2],
        "initial.rigging": {
            "directions": [[0.6, 0.0, -0.8]],
            "orientation": [0.5, 0.5, 0.5, 0.5],
            "angular_velocity": [0.1, 0.2, 0.3],
        },
    },
    "falls": {},
    "slew": {"initial.q": [0.3, 25.0, 25.0, 0.1, -0.2], "initial.v": [0.0, 0.4, 0.0, 0.0, 0.0]},
}
"""Starts that are not straight down, where a scene can have them."""


def mechanism(
    case: BodyCase, duration: float = SHORT, changed: bool = False
) -> tuple[Any, Mechanism]:
    """Return (the scene of a case, its mechanism), with another duration [s].

    `changed`: with the start of START.
    """
    changes = {**case.changes, **(START[case.id] if changed else {}), "duration": duration}
    scene = load_scene(case.scene, changes)
    made = mechanism_of(scene)
    assert made is not None
    return scene, made


def available(engine: ModuleType) -> ModuleType:
    """Return the engine; skip the test where it is not installed."""
    try:
        engine.find_version()
    except EngineUnavailable as why:
        pytest.skip(str(why))
    return engine


def nearest_run(engine: ModuleType, made: Mechanism, method: str, setting: float) -> Run:
    """Return the run of a method with the setting nearest to this one."""
    return min(engine.runs(made, method), key=lambda run: abs(np.log(run.setting / setting)))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_the_mechanism_starts_as_the_crane(case: BodyCase) -> None:
    """Joints in series place and turn the load as the crane does, also from inclined ropes."""
    scene, made = mechanism(case, changed=True)
    q, v = initial_state(made)
    at, turn = load_pose(made, q)
    points, _ = world_points(scene.model, 0.0, np.array(scene.initial_q), np.array(scene.initial_v))
    assert at == pytest.approx(points[-1], abs=1e-13)  # rounding at 30 m
    assert turn == pytest.approx(attitude_of(scene.initial_q), abs=1e-14)
    h = 1e-6
    moved = [load_pose(made, q + sign * h * v) for sign in (-1.0, 1.0)]
    spin = turn.T @ (moved[1][1] - moved[0][1]) / (2.0 * h)
    omega = START[case.id].get("initial.rigging", {}).get("angular_velocity", [0.0, 0.0, 0.0])
    # of central differences
    assert [spin[2, 1], spin[0, 2], spin[1, 0]] == pytest.approx(omega, abs=1e-9)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_mujoco_converges_to_our_end(case: BodyCase) -> None:
    """The load's position and attitude converge to ours with the order of the engine's method."""
    scene, made = mechanism(case)
    ours = CraneSimEngine(scene).make_run(RK8(1.0 / 64.0))(1)
    runs = [nearest_run(available(mujoco_engine), made, "RK4", setting) for setting in (0.02, 0.01)]
    ends = [run.execute(1) for run in runs]
    errors = [float(np.linalg.norm(end.payload - ours.payload)) for end in ends]
    assert ours.attitude is not None and ends[1].attitude is not None
    slope = np.log(errors[0] / errors[1]) / np.log(runs[0].setting / runs[1].setting)
    assert slope > 3.5 or errors[0] < 1e-9  # m, where rounding ends it
    # a wrong model is off by centimetres; the method is at a third of this
    assert errors[1] < 1e-5 and angle_between(ends[1].attitude, ours.attitude) < 1e-5


def test_a_run_that_fails_stays_in_the_sweep() -> None:
    """A step far too long ends far away or in no number; the engine's next run is right again."""
    _, made = mechanism(CASES[0], 30.0)
    coarse, fine = (
        nearest_run(available(mujoco_engine), made, "RK4", setting) for setting in (0.2, 0.04)
    )
    assert not np.linalg.norm(coarse.execute(1).payload) < 1e3  # m; the load hangs within 20 m
    assert np.linalg.norm(fine.execute(1).payload) < 20.0


def test_a_missing_engine_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its package an engine is unavailable, named in a single line."""
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(EngineUnavailable, match="MuJoCo is not installed") as error_info:
        mujoco_engine.find_version()
    assert "\n" not in str(error_info.value)


def test_other_cranes_are_no_mechanism() -> None:
    """Cranes that these engines do not model are not taken for others.

    These have a law, wind, friction or play, or have no rigid load.
    """
    for name in (
        "tower_gust",
        "tandem_play",
        "tower_beam_turns",
        "mobile_lift",
        "overhead_swing",
        "knuckle_springs",
        "port_sts_container",
    ):
        assert mechanism_of(load_scene(name)) is None
    assert mechanism_of(load_scene("spreader_skew", {"falls.relaxation": 0.0})) is not None


def test_the_suite_without_engines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without other engines the suite measures ours and names the missing ones.

    Our errors fall below the finest level.
    """
    monkeypatch.setitem(sys.modules, "mujoco", None)
    results = bodies.measure_bodies(
        [CASES[1]._replace(changes={"duration": 0.25})], methods=("rk8",)
    )
    assert set(results["missing"]) == {"MuJoCo"} and set(results["engines"]) == {NAME}
    scene = results["scenes"]["falls"]
    closest = min(read_points(scene), key=lambda point: point.error)
    assert (
        closest.error < 1e-9
        and closest.attitude_error is not None
        and closest.attitude_error < 1e-9
    )
    lines = "\n".join(bodies.format_bodies(results))
    assert "not there: MuJoCo" in lines and "1 x ours" in lines and "closest" in lines
    scene["trusted"] = 1e-9
    lines = "\n".join(bodies.format_bodies(results))
    assert (
        "not compared, below 20 times the reference's error: 1e-09 m" in lines
        and "1e-09 m  " not in lines
    )
    assert "closest: within the reference's error" in lines
