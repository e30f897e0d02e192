"""Check the benchmark's references by Taylor's method in extended precision.

Usage: python test/reference/taylor.py.

heyoka (requirements/peers.lock) at tolerance 1e-24, where its order is 29, and at 1e-21, in numbers
of 113 bits; where that takes hours (S3b, S4), at 1e-18 (order 22) and 1e-17 in numbers of 64 bits.
Equations and coordinates are those of `crane_bench/speed/peers/heyoka_taylor.py`. It shares neither
equations nor method with `make.py` and `knuckle.py`, which extrapolate in Cartesian coordinates.

Prints how far the payload is from what is stored in test/data. With --store, of cases that
`make.py` has just solved, it writes this distance (`agreement_taylor_m`), the nodes of chains, and
how far they are to be trusted: what both tolerances agree on, of other cases the distance, and no
less than the rounding of what is stored.
"""

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
from collect import SCENES
from solution import store

sys.path.insert(0, str(Path(__file__).parents[2]))  # for a tree that is not installed


from crane_bench.speed.cases import CASES, Case, case_scene
from crane_bench.speed.peers.heyoka_taylor import load_heyoka, start_and_outputs, state_equations
from crane_bench.speed.problem import Chain, KnuckleCrane, problem_of
from crane_sim.simulation.derived import world_points

DATA = Path(__file__).parents[1] / "data"
QUADRUPLE, EXTENDED = ("1e-24", "1e-21"), ("1e-18", "1e-17")  # tolerances
SLOW = ("S3b", "S4")
ROUNDING = 1e-15  # m, of what is stored
mpmath.mp.dps = 34


def problem_of_case(case: Case) -> Any:
    """Return a case in plain numbers."""
    scene = case_scene(case)
    points, _ = world_points(scene.model, 0.0, np.array(scene.initial_q), np.array(scene.initial_v))
    return problem_of(scene, np.array(points[-1]))


def course(problem: Any, times: list[float], number: Any, tolerance: str) -> list[list[Any]]:
    """Return the states at the times as numbers of mpmath; `number` is the class to use."""
    hy = load_heyoka()
    equations, (start, _) = state_equations(hy, problem, number), start_and_outputs(problem)
    state = np.array([number(value) for value in start.tolist()])
    long = isinstance(problem, Chain) and len(problem.masses) > 1
    ta = hy.taylor_adaptive(
        equations,
        state,
        fp_type=number,
        tol=number(tolerance),
        compact_mode=long,
        high_accuracy=True,
    )
    states = []
    for t in times:
        ta.propagate_until(number(t))
        states.append([mpmath.mpf(str(value)) for value in ta.state])
    return states


def nodes_of(problem: Any, state: list[Any]) -> list[list[Any]]:
    """Return the positions [m] of a chain's nodes, or of the payload alone."""
    if isinstance(problem, Chain):
        (x, *rest), z, nodes = state, mpmath.mpf(0), []
        for angle, length in zip(rest, problem.lengths.tolist(), strict=False):
            x, z = x + length * mpmath.sin(angle), z - length * mpmath.cos(angle)
            nodes.append([x, mpmath.mpf(0), z])
        return nodes
    if isinstance(problem, KnuckleCrane):
        s, c = mpmath.sin(state[0]), mpmath.cos(state[0])
        return [[c * state[3] - s * state[4], s * state[3] + c * state[4], state[5]]]
    return [[state[1], mpmath.mpf(0), state[2]]]


def distance(first: list[list[Any]], second: list[list[Any]]) -> float:
    """Return the largest difference [m] of coordinates at the end of two rows of points."""
    count = min(len(first), len(second))
    pairs = zip(first[-count:], second[-count:], strict=True)
    return float(max(abs(a - b) for p, q in pairs for a, b in zip(p, q, strict=True)))


def check(case: Case, write: bool) -> str:
    """Compare a case with its reference and store the result; return a line about it."""
    began, key = time.perf_counter(), SCENES[case.scene]
    target = DATA / ("knuckle_springs.json" if case.id == "S2k" else "overhead.json")
    found, problem = json.loads(target.read_text())[key], problem_of_case(case)
    number, tolerances = (
        (np.longdouble, EXTENDED) if case.id in SLOW else (load_heyoka().real128, QUADRUPLE)
    )
    tight, loose = (
        [nodes_of(problem, x) for x in course(problem, found["t"], number, tol)]
        for tol in tolerances
    )
    stored = np.array(found["node_positions_xyz"]).reshape(len(found["t"]), -1, 3).tolist()
    agreement = max(map(distance, tight, loose))
    apart = max(map(distance, tight, stored))
    line = f"{case.id}: {apart:.1e} m from what is stored, {agreement:.1e} m between two tolerances"
    if write and isinstance(problem, Chain):
        found["node_positions_xyz"] = [
            [[float(value) for value in node] for node in nodes] for nodes in tight
        ]
    if write:
        found["trusted_abs_error_m"] = max(
            agreement if isinstance(problem, Chain) else apart, ROUNDING
        )
        found["agreement_taylor_m"] = apart
        store(target, key, found)
    return f"{line}, {time.perf_counter() - began:.0f} s"


def main() -> None:
    """Check the chosen cases, or all that other engines are compared on."""
    known = {case.id: case for case in CASES if case.compare_engines}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", action="append", choices=known, default=[])
    parser.add_argument(
        "--store",
        action="store_true",
        help="store the distance, the trust, and the nodes of chains",
    )
    chosen = parser.parse_args()
    for name in chosen.case or known:
        print(check(known[name], chosen.store), flush=True)


if __name__ == "__main__":
    main()
