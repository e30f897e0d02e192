"""Hand-written C, CasADi's C and scipy: their motion is that of the reference."""

import json
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from crane_bench.speed.compiler import Compiler
from crane_bench.speed.engine import Engine, EngineUnavailable
from crane_bench.speed.loops import Loops
from crane_bench.speed.peers.casadi_c import CasadiC
from crane_bench.speed.peers.hand_c import HandC, c_loop_input
from crane_bench.speed.peers.scipy_ivp import Scipy
from crane_bench.speed.problem import Chain, Problem, Spring, problem_of
from crane_sim import load_scene

ROOT = Path(__file__).parents[2]
# m, of the payload: rope or spring of 2 m at 60 degrees; of the knuckle crane below its tip, rope 2
# m
STARTS = {
    "overhead_swing": (2.0 * np.sin(np.pi / 3), 0.0, -2.0 * np.cos(np.pi / 3)),
    "overhead_spring": (2.0 * np.sin(np.pi / 3), 0.0, -2.0 * np.cos(np.pi / 3)),
    "overhead_chain": (2.0 * np.sin(np.pi / 6), 0.0, -2.0 * np.cos(np.pi / 6)),
}
# order, steps where it shows, and an error [m] at twice as many steps with a margin of two
ORDERS = [
    ("overhead_swing", "rk4", 4, 307, 2e-5),
    ("overhead_swing", "rk8", 8, 110, 3e-8),
    ("knuckle_springs", "rk4", 4, 566, 1.3e-5),
    ("knuckle_springs", "rk8", 8, 102, 1.2e-7),
    ("overhead_chain", "leapfrog", 2, 12360, 1e-4),
    ("overhead_chain", "rk4", 4, 3179, 9e-7),
    ("overhead_chain", "rk8", 8, 1590, 3e-10),
    ("overhead_spring", "leapfrog", 2, 91288, 4e-6),
    ("overhead_spring", "rk4", 4, 21909, 1.3e-7),
    ("overhead_spring", "rk8", 8, 3913, 1.3e-10),
]
SCENES = ("overhead_swing", "knuckle_springs", "overhead_chain", "overhead_spring")


@cache
def problem(name: str) -> Problem:
    """Return a scene in plain numbers."""
    scene = load_scene(name)
    plain = problem_of(scene, np.array(STARTS.get(name) or knuckle_start(scene.initial_q)))
    assert plain is not None
    return plain


def knuckle_start(q: tuple[float, ...]) -> tuple[float, float, float]:
    """Return the payload of the 5 m and 4 m crane at slew 0: θ1 leans sideways, θ2 outwards."""
    _, beta, gamma, rope, side, out = q
    r, h = 5.0 * np.cos(beta) + 4.0 * np.cos(gamma), 5.0 * np.sin(beta) + 4.0 * np.sin(gamma)
    return (
        r + rope * np.sin(out),
        rope * np.sin(side) * np.cos(out),
        h - rope * np.cos(side) * np.cos(out),
    )


@cache
def reference(name: str) -> np.ndarray:
    """Return the payload's end position by the independent solution."""
    cases = json.loads((ROOT / "config" / "references" / "hardcases.json").read_text())
    return np.array(cases[name]["nodes"][-1][-1])


@pytest.fixture(scope="module")
def compiler() -> Iterator[Compiler]:
    """Yield a compiler, or skip."""
    with TemporaryDirectory() as folder:
        try:
            yield Compiler(Path(folder))
        except EngineUnavailable as missing:
            pytest.skip(str(missing))


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest, compiler: Compiler) -> tuple[str, Loops]:
    """Return a scene's name and its compiled loops."""
    return request.param, Loops(compiler, c_loop_input(problem(request.param)))


def error(name: str, payload: np.ndarray) -> float:
    """Return the payload's distance from the reference [m]."""
    return float(np.max(np.abs(payload - reference(name))))


@pytest.mark.long(cases=["overhead_chain"])
def test_orders(scene: tuple[str, Loops]) -> None:
    """Every fixed-step method of the C converges to the independent reference at its order."""
    name, loops = scene
    for _, method, order, steps, bound in (row for row in ORDERS if row[0] == name):
        coarse, fine = (error(name, loops.fixed(method, n, 1).payload) for n in (steps, 2 * steps))
        assert fine < bound, method
        # 0.3: what the next order adds at these steps
        assert np.log2(coarse / fine) > order - 0.3, method


@pytest.mark.long(cases=["overhead_chain"])
def test_error_control(scene: tuple[str, Loops]) -> None:
    """The adaptive method's error at the end falls with its tolerance, to near rounding."""
    name, loops = scene
    errors = [error(name, loops.adaptive(rtol, 1).payload) for rtol in (1e-6, 1e-11)]
    # a thousand times the tolerance: 10 s of motion of some metres, errors add up
    assert errors[1] < 1e-8
    assert errors[1] < 1e-2 * errors[0]


@pytest.mark.long(cases=["overhead_chain"])
def test_repetitions_are_identical(scene: tuple[str, Loops]) -> None:
    """Each repetition begins at the start, so that its end is that of a single run to the bit."""
    loops = scene[1]
    for method in loops.problem.methods:
        assert np.array_equal(
            loops.fixed(method, 5000, 3).payload, loops.fixed(method, 5000, 1).payload
        )
    assert loops.adaptive(1e-8, 3).evaluations == loops.adaptive(1e-8, 1).evaluations


@pytest.mark.slow
@pytest.mark.parametrize("links", [2, 3, 17])
def test_crumpled_chains(links: int, compiler: Compiler) -> None:
    """The C of chains agrees with scipy on another elimination.

    Bends are up to a half turn, links few and many.
    """
    random = np.random.default_rng(links)
    masses, lengths = random.uniform(0.5, 2.0, links), random.uniform(0.5, 1.5, links)
    chain = Chain(3.0, masses, lengths, random.uniform(-1.5, 1.5, links), 9.81, 0.3)
    hand_c = Loops(compiler, c_loop_input(chain)).fixed("rk8", 400, 1).payload
    scipy = [run for run in Scipy().runs(chain) if run.method == "DOP853"][-1].execute(1).payload
    # tolerance 1e-12, and crumpled chains amplify some hundredfold
    assert np.max(np.abs(hand_c - scipy)) < 1e-9


def test_tension_of_a_spring_at_rest(compiler: Compiler) -> None:
    """A payload at rest on its spring stays there, and the tension is its weight."""
    weight, stiffness = 4.0 * 9.81, 1000.0
    start = np.array([0.0, -(2.0 + weight / stiffness)])
    hanging = Spring(3.0, 4.0, 2.0, stiffness, start, 9.81, 1.0)
    result = Loops(compiler, c_loop_input(hanging)).fixed("rk4", 1000, 1)
    # rounding of the length, times the stiffness
    assert result.tension == pytest.approx(weight, rel=1e-10)
    assert result.payload == pytest.approx((0.0, 0.0, start[1]), abs=1e-12)


@pytest.mark.parametrize(
    ("engine", "name"),
    [
        (HandC, "overhead_swing"),
        *((engine, name) for engine in (CasadiC, Scipy) for name in SCENES),
    ],
)
def test_sweeps_reach_the_reference(engine: type[Engine], name: str, compiler: Compiler) -> None:
    """Each engine's order 8 sweep comes within a micrometre of the independent reference."""
    if engine is CasadiC and find_spec("casadi") is None:
        pytest.skip("casadi is not installed")
    *runs, finest = (run for run in engine().runs(problem(name)) if run.method in ("rk8", "DOP853"))
    # of tolerances, 1e-9: tighter is slow
    run = next((run for run in runs if run.setting < 1.1e-9), finest)
    assert error(name, run.execute(1).payload) < 1e-6


def test_a_missing_compiler_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Without a compiler the hand-written C is unavailable, with a single-line error."""
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(EngineUnavailable, match=r"\Ano C compiler found[^\n]*\Z"):
        HandC()
