"""Quantities of which comparisons draw one curve for each run; angles in degrees."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.layout import label
from crane_sim.recording.suspension import COORDINATES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from crane_sim.recording.layout import Array
    from crane_sim.recording.run import RecordedRun

MAX_SWINGS = 4  # swing coordinates of a cable that are drawn
MIN_SPAN = 1e-12  # in any unit: a smaller span is rounding


class Quantity(NamedTuple):
    """Title and unit of a plot with one curve for each run."""

    title: str
    unit: str


def shown_joints(run: RecordedRun) -> list[str]:
    """Return the names of the joints that are drawn: of a cable's many coordinates only a few swings."""
    names = run.crane.joint_names
    swings = [name for name in names if name.startswith("swing_")]
    return [name for name in names if not name.startswith(COORDINATES) and name not in "qwqxqyqz"] + swings[:MAX_SWINGS]


def quantities_of(run: RecordedRun) -> dict[Quantity, Array]:
    """Return the values (K,) of all quantities of a run; angles in degrees."""
    return dict(_quantities(run))


def common_quantities(runs: Sequence[RecordedRun]) -> dict[Quantity, tuple[Array, ...]]:
    """Return the quantities that all runs have, with the values (K,) of each run, in the order of the first run."""
    by_run = [quantities_of(run) for run in runs]
    shared = [key for key in by_run[0] if all(key in each for each in by_run)]
    return {key: tuple(each[key] for each in by_run) for key in shared}


def moving_quantities(runs: Sequence[RecordedRun]) -> dict[Quantity, tuple[Array, ...]]:
    """Return the common quantities without those that are constant and equal in all runs."""
    return {key: each for key, each in common_quantities(runs).items() if _moves(np.concatenate(each))}


def _moves(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return bool(finite.size and np.ptp(finite) > MIN_SPAN)


def _quantities(run: RecordedRun) -> Iterator[tuple[Quantity, Array]]:
    crane = run.crane
    for name in shown_joints(run):
        i = crane.joint_names.index(name)
        angle = crane.joint_units[i] == "rad"
        values = np.degrees(run.q[:, i]) if angle else run.q[:, i]
        yield Quantity(label(name), "°" if angle else crane.joint_units[i]), values
    yield Quantity("swing from the vertical", "°"), np.degrees(run.swing)
    for i, axis in enumerate("xyz"):
        yield Quantity(f"payload {axis}", "m"), run.payload[:, i]
    for k, name in enumerate(crane.actuated):
        yield Quantity(f"effort of {label(name)}", crane.effort_units[k]), run.u[:, k]
    yield Quantity("rope tension", "N"), run.tension
    yield Quantity("energy since the start", "J"), run.energy - run.energy[0]
