"""Solve the hard cases of the overhead crane and store them: python test/reference/make.py [--case NAME]...

Writes test/data/overhead.json; each case is stored as soon as it is solved. Nothing here is shared with the simulator:
the chain is in Cartesian coordinates, the integrator extrapolates, the arithmetic is extended.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
from cases import CASES
from elastic_cases import ELASTIC
from solution import record

TARGET = Path(__file__).parents[1] / "data" / "overhead.json"


def store(name: str, found: dict[str, object]) -> None:
    """Put one case into the file, which keeps the order of the list."""
    known = json.loads(TARGET.read_text()) if TARGET.exists() else {}
    known[name] = found
    ordered = {key: known[key] for key in sorted(known)}
    TARGET.write_text(json.dumps(ordered, separators=(",", ":")).replace('},"', '},\n"') + "\n")


def main() -> None:
    """Solve the chosen cases, or all."""
    if np.finfo(np.longdouble).eps > 2e-19:
        raise SystemExit("numpy.longdouble has no extended precision on this machine")
    known = CASES | ELASTIC
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--case", action="append", choices=known, default=[])
    for name in parser.parse_args().case or known:
        begin = time.perf_counter()
        found = record(known[name]())
        store(name, found)
        print(
            f"{name}: {found['agreement_m']:.1e} m between two settings, {time.perf_counter() - begin:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
