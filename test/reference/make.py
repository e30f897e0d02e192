"""Solve the hard cases of the overhead crane and store them.

Usage: python test/reference/make.py [--case NAME]...

Writes test/data/overhead.json; each case is stored as soon as it is solved. Nothing here is shared
with the simulator: the chain is in Cartesian coordinates, the integrator extrapolates, the
arithmetic is extended. What is stored of each:

- spec; t; positions and velocities of nodes 1..N (K, N, 3), world frame with z up; trolley x, xdot
  (y, ydot); tension [N] (K, N);
- event_times and modes_after_event (friction: +1, -1 slip, 0 stick; cable: +k link k taut, -k
  slack);
- agreement_m: largest distance between the tight solution, which is stored, and one of lower order
  and wider tolerance;
- trusted_abs_error_m: that, and no less than the rounding of what is stored;
- agreement_second_m: distance from a second derivation in angles and double precision (--second):
  an error of its own.

The knuckle crane has a solver of its own, `knuckle.py`.
"""

import argparse
import json
import time
from pathlib import Path

import lagrange
import numpy as np
from cases import CASES
from elastic_cases import ELASTIC
from solution import Case, record, store

TARGET = Path(__file__).parents[1] / "data" / "overhead.json"


def compare(name: str, case: Case) -> float:
    """Store and return the distance [m] of a stored case from its second derivation."""
    found = json.loads(TARGET.read_text())[name]
    apart = np.abs(lagrange.course(case)[:, 1:] - np.array(found["node_positions_xyz"]))
    store(TARGET, name, found | {"agreement_second_m": float(np.max(apart))})
    return float(np.max(apart))


def main() -> None:
    """Solve the chosen cases, or all."""
    if np.finfo(np.longdouble).eps > 2e-19:
        raise SystemExit("numpy.longdouble has no extended precision on this machine")
    known = CASES | ELASTIC
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", action="append", choices=known, default=[])
    parser.add_argument(
        "--second",
        action="store_true",
        help="only compare what is stored with the second derivation",
    )
    chosen = parser.parse_args()
    for name in chosen.case or known:
        begin, case, words = time.perf_counter(), known[name](), []
        if not chosen.second:
            found = record(case)
            store(TARGET, name, found)
            words.append(f"{found['agreement_m']:.1e} m between two settings")
        if lagrange.covers(case):
            words.append(f"{compare(name, case):.1e} m from the second derivation")
        print(f"{name}: {', '.join(words)}, {time.perf_counter() - begin:.0f} s", flush=True)


if __name__ == "__main__":
    main()
