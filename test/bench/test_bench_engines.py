"""The multibody engines of the benchmark: each one's model is the crane of the problem."""

import sys

import numpy as np
import pytest

from crane_bench.reproduce.hardcases import hardcase_references
from crane_bench.speed.engine import Engine, EngineUnavailable, Run, RunResult
from crane_bench.speed.peers import heyoka_taylor, mujoco_engine, pinocchio_engine
from crane_bench.speed.peers.heyoka_taylor import Heyoka
from crane_bench.speed.peers.joints import (
    model_joints,
    payload_position,
    tension,
)
from crane_bench.speed.peers.mujoco_engine import MuJoCo
from crane_bench.speed.peers.pinocchio_engine import Pinocchio
from crane_bench.speed.problem import Chain, KnuckleCrane, Problem, RodParameters, Spring

SWING = Chain(5.0, np.array([10.0]), np.array([2.0]), np.radians([60.0]), 9.81, 10.0)
TEN = Chain(
    5.0, np.array([*[0.1] * 9, 100.0]), np.full(10, 0.2), np.radians([30.0] * 10), 9.81, 5.0
)
SPRING = Spring(5.0, 10.0, 2.0, 1e6, np.array([2.0 * np.sin(np.pi / 3), -1.0]), 9.81, 10.0)
KNUCKLE = KnuckleCrane(
    tower=10.0,
    boom=RodParameters(5.0, 2.0, 50.0 / 12.0, 0.01),
    jib=RodParameters(4.0, 3.0, 4.0, 0.01),
    payload=1.0,
    stiffness=(2000.0, 1000.0, 200.0),
    neutral=(np.pi / 4, -np.pi / 3, 2.0),
    q=np.radians([0.0, 45.0, -15.0]),
    # a rope of 2 m below the tip, 20 degrees outwards and 30 sideways
    start=np.array(
        [
            5.0 * np.cos(np.pi / 4) + 4.0 * np.cos(np.pi / 12) + 2.0 * np.sin(np.radians(20.0)),
            2.0 * np.sin(np.pi / 6) * np.cos(np.radians(20.0)),
            5.0 * np.sin(np.pi / 4)
            - 4.0 * np.sin(np.pi / 12)
            - 2.0 * np.cos(np.pi / 6) * np.cos(np.radians(20.0)),
        ]
    ),
    gravity=9.81,
    duration=10.0,
)
PROBLEMS = {
    "overhead_swing": SWING,
    "knuckle_springs": KNUCKLE,
    "overhead_chain": TEN,
    "overhead_spring": SPRING,
}
# engine, method, its order, scene, and a step [s] from which on the order shows
ORDERS = [
    (MuJoCo, "RK4", 4, "overhead_swing", 0.01),
    (MuJoCo, "RK4", 4, "knuckle_springs", 6e-3),
    (MuJoCo, "RK4", 4, "overhead_chain", 1e-3),
    (Pinocchio, "aba, rk4", 4, "overhead_swing", 0.01),
    (Pinocchio, "aba, rk4", 4, "overhead_chain", 1e-3),
    (Pinocchio, "aba, rk8", 8, "overhead_swing", 0.06),
    (Pinocchio, "aba, rk8", 8, "knuckle_springs", 0.06),
]
STIFF = [(MuJoCo, "RK4", 2.5e-4), (Pinocchio, "aba, rk8", 2e-3)]


def engine(kind: type[Engine]) -> Engine:
    """Return the engine; skip the test where it is not installed."""
    try:
        return kind()
    except EngineUnavailable as why:
        pytest.skip(str(why))


def nearest_run(tested_engine: Engine, problem: Problem, method: str, setting: float) -> Run:
    """Return the run of a method with the setting nearest to this one."""
    runs = [run for run in tested_engine.runs(problem) if run.method == method]
    return min(runs, key=lambda run: abs(np.log(run.setting / setting)))


def error(name: str, outcome: RunResult) -> float:
    """Return the payload's distance [m] from its end position in extended precision."""
    return float(np.linalg.norm(outcome.payload - hardcase_references()[name]["nodes"][-1][-1]))


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_joints_start_at_the_cranes_initial_position(name: str) -> None:
    """The common chain of joints puts the payload at the problem's initial position.

    Its spring is at its free length.
    """
    problem = PROBLEMS[name]
    joints = model_joints(problem)
    q = np.array([joint.initial for joint in joints])
    if isinstance(problem, Chain):
        angles, lengths = problem.angles, problem.lengths
        expected = np.array([lengths @ np.sin(angles), 0.0, -lengths @ np.cos(angles)])
    else:
        expected = (
            problem.start
            if isinstance(problem, KnuckleCrane)
            else problem.start[[0, 0, 1]] * (1.0, 0.0, 1.0)
        )
        assert tension(joints, q) == pytest.approx(0.0, abs=1e-8)  # 1e6 N/m on a rounding error
    assert payload_position(joints, q) == pytest.approx(expected, abs=1e-14)


def test_the_joints_turn_and_slide_in_space() -> None:
    """A slewed knuckle crane's payload turns with the tower.

    That holds also in coordinates where nothing is zero.
    """
    angle = 0.7
    rotation = np.array(
        [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
    )
    slewed = KNUCKLE._replace(q=KNUCKLE.q + [angle, 0.0, 0.0], start=rotation @ KNUCKLE.start)
    chains = model_joints(KNUCKLE), model_joints(slewed)
    starts = [np.array([joint.initial for joint in row]) for row in chains]
    assert starts[1] - starts[0] == pytest.approx([angle, 0.0, 0.0, 0.0, 0.0, 0.0], abs=1e-14)
    assert payload_position(chains[1], starts[1]) == pytest.approx(
        rotation @ KNUCKLE.start, abs=1e-14
    )


@pytest.mark.parametrize(("kind", "method", "order", "name", "step"), ORDERS)
def test_errors_fall_with_the_order_of_the_method(
    kind: type[Engine], method: str, order: int, name: str, step: float
) -> None:
    """The engine's end of the motion converges to the reference with the method's order."""
    tested_engine = engine(kind)
    runs = [
        nearest_run(tested_engine, PROBLEMS[name], method, setting)
        for setting in (step, 0.5 * step)
    ]
    errors = [error(name, run.execute(1)) for run in runs]
    # all converge faster than this here, by at least a tenth
    assert np.log(errors[0] / errors[1]) / np.log(runs[0].setting / runs[1].setting) > order - 0.5
    assert errors[1] < 1e-5  # a wrong model is off by centimetres


@pytest.mark.parametrize(("kind", "method", "step"), STIFF)
def test_the_tension_of_the_stiff_spring(kind: type[Engine], method: str, step: float) -> None:
    """Position and tension of the stiff spring's payload meet the reference.

    A run repeats itself exactly.
    """
    run = nearest_run(engine(kind), SPRING, method, step)
    outcome = run.execute(1)
    assert error("overhead_spring", outcome) < 3e-7  # at these steps the worst one is 9e-8
    exact = hardcase_references()["overhead_spring"]["tension"][-1][-1]
    # N of 383: 1e6 N/m times the position error above
    assert outcome.tension == pytest.approx(exact, abs=0.3)
    assert np.array_equal(run.execute(2).payload, outcome.payload)


def test_a_failed_run_does_not_affect_the_next() -> None:
    """A step far too long ends in no number, and the engine's next run is right all the same."""
    for kind, method in ((MuJoCo, "RK4"), (Pinocchio, "aba, rk4")):
        tested_engine = engine(kind)
        runs = [run for run in tested_engine.runs(TEN) if run.method == method]
        assert not np.isfinite(runs[0].execute(1).payload).all()
        good = min(runs, key=lambda run: abs(np.log(run.setting / 1e-3)))
        assert error("overhead_chain", good.execute(1)) < 1e-5  # 1e-6 at this step


def test_a_batch_ends_like_single_runs() -> None:
    """Each crane of MuJoCo's batch ends at the end of a single run from the same start."""
    run = nearest_run(engine(MuJoCo), SWING, "RK4", 0.01)
    ends, seconds = mujoco_engine.batch(SWING, 3, run.setting, 2)
    assert (
        ends == pytest.approx(np.tile(run.execute(1).payload, (3, 1)), abs=1e-12) and seconds > 0.0
    )
    starts = np.array([[0.0, -1.0], [0.0, 0.5]])
    ends, _ = mujoco_engine.batch(SWING, starts, run.setting, 1)
    mirrored = SWING._replace(angles=np.array([-0.5]))
    assert ends[1] == pytest.approx(
        nearest_run(engine(MuJoCo), mirrored, "RK4", 0.01).execute(1).payload, abs=1e-12
    )


@pytest.mark.parametrize("name", PROBLEMS)
def test_heyokas_equations_are_those_of_the_scene(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At a tight tolerance each crane ends where extended precision does.

    A run repeats itself exactly.
    """
    tested_engine = engine(Heyoka)
    monkeypatch.setattr(heyoka_taylor, "TOLERANCES", [1e-11])
    monkeypatch.setattr(heyoka_taylor, "COARSE_TOLERANCES", [1e-11])
    # recurrences of ten links take half a minute to compile
    monkeypatch.setattr(heyoka_taylor, "MAX_UNROLLED", 1)
    (taylor,) = tested_engine.runs(PROBLEMS[name])
    outcome = taylor.execute(1)
    # its tolerance is per step and relative; chaotic terms of the chain double it
    assert error(name, outcome) < 2e-11
    assert np.array_equal(taylor.execute(2).payload, outcome.payload)


@pytest.mark.parametrize("kind", [MuJoCo, Pinocchio, Heyoka])
def test_a_missing_engine_is_named(kind: type[Engine], monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its package an engine is unavailable, named in a single-line error."""
    for name in ("mujoco", "heyoka"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(pinocchio_engine, "find_spec", lambda name: None)
    with pytest.raises(
        EngineUnavailable, match=f"(?i){kind.name}.* is not installed"
    ) as error_info:
        kind()
    assert "\n" not in str(error_info.value)
