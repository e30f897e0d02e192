"""Writes docs/identification.png: errors of identified parameters by half of their intervals.

There are 50 runs of each case.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "test" / "helpers"))
SEEDS = range(50)


def main() -> None:
    """Run all cases on two processes, print the shares, draw the figure."""
    from interval_coverage import CASES, errors_of

    figure = Figure(figsize=(10.0, 6.0), layout="constrained")
    axis, labels = figure.subplots(), list[str]()
    with ProcessPoolExecutor(2) as pool:
        for name, case in CASES.items():
            runs = list(pool.map(partial(errors_of, case), SEEDS))
            for key in case.truth:
                errors = np.array([run[key] for run in runs])
                inside = np.abs(errors) <= 1.0
                spread = np.linspace(-0.3, 0.3, len(errors)) - len(labels)
                axis.scatter(errors, spread, s=8.0, c=np.where(inside, "tab:blue", "tab:red"))
                labels.append(f"{name}: {key}, {inside.mean():.0%}")
                print(labels[-1], flush=True)
            every = np.array([list(run.values()) for run in runs])
            print(f"{name}: {np.mean(np.abs(every) <= 1.0):.1%} of {every.size}", flush=True)
    axis.axvspan(-1.0, 1.0, color="0.9", zorder=0)
    axis.set_yticks(-np.arange(len(labels)), labels)
    axis.set_xlabel("(estimate - truth) / half of the 95 % interval [-]")
    axis.set_title(
        f"{len(SEEDS)} runs with other noise; the share of intervals that hold the truth"
    )
    figure.savefig(ROOT / "docs" / "identification.png", dpi=90)


if __name__ == "__main__":
    main()
