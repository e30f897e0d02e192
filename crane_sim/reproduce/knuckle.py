"""Section 4 of the knuckle paper (Ambrosino et al.): its energy law beside its LQR, figure by figure.

The paper describes its figures in words and gives neither start nor target. Both laws make the same manoeuvre, and then
others, because what they are compared for depends on the manoeuvre. Verdicts follow from the numbers of the run.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from crane_sim.reproduce.table import Shown
from crane_sim.rollout import Rollout, simulate
from crane_sim.scene import Scene, load_scene

ARRIVED = 0.02  # of the way, as for settling times
MUCH = 2.0  # "much less" is less than half, "slightly" is within a factor of two
SIMILAR = 1.25  # "almost similar" is within a quarter
QUIET = 0.5  # deg, of a load that has stopped swinging
OTHERS: dict[str, dict[str, Any]] = {
    "half of the way": {"initial.q": ["22.5 deg", "37.5 deg", "-5 deg", 1.75, 0, 0]},
    "slew alone": {"initial.q": [0, "45 deg", 0, 1.5, 0, 0]},
    "boom and jib alone": {"initial.q": ["45 deg", "30 deg", "-10 deg", 1.5, 0, 0]},
    "rope alone": {"initial.q": ["45 deg", "45 deg", 0, 2.0, 0, 0]},
    "swinging at the target": {"initial.q": ["45 deg", "45 deg", 0, 1.5, "10 deg", "10 deg"]},
    "swing friction": {"swing_friction": {"model": "linear", "tangential": 0.1, "radial": 0.1}},
}
"""What else the paper's manoeuvre may have been, as changes of the scenes."""


class Compared(NamedTuple):
    """One sentence of the paper about its two laws, and the runs."""

    claim: str  # with its figure
    paper: str
    energy_law: Shown
    lqr: Shown
    difference: float | None  # of ours: energy law less LQR
    assumption: str
    verdict: str


class Pair(NamedTuple):
    """The same manoeuvre under both laws."""

    energy: Rollout
    lqr: Rollout
    assumption: str


def pair(changes: dict[str, Any] | None = None) -> Pair:
    """Run both laws with the same changes of their scenes."""
    energy, lqr = (simulate(load_scene(name, changes or {})) for name in ("knuckle_setpoint", "knuckle_lqr"))
    return Pair(energy, lqr, manoeuvre(energy.scene))


def manoeuvre(scene: Scene) -> str:
    """Return start and target in words."""
    assert scene.reference is not None
    ends = []
    for q in (scene.initial_q[:4], scene.reference):
        angles = " / ".join(f"{x:g}" for x in np.round(np.degrees(q[:3]), 9))
        ends.append(f"{angles} deg, {q[3]:g} m")
    return " to ".join(ends)


def rows() -> list[Compared]:
    """Return the paper's sentences about the scene's manoeuvre, then those about the load for the other ones."""
    return [*section_4(pair()), *(row for name in OTHERS for row in another(name))]


def section_4(runs: Pair) -> Iterator[Compared]:
    """Yield what section 4 says of figures 3 to 10."""
    yield from _arrivals(runs)
    yield from _rope(runs)
    yield from _swing(runs)
    yield from _efforts(runs)


def _arrivals(runs: Pair) -> Iterator[Compared]:
    """Yield whether and when tower, boom and jib arrive, figures 3 to 5."""
    for i, figure in enumerate(("Fig. 3, tower", "Fig. 4, boom", "Fig. 5, jib")):
        way, left = (np.degrees(runs.energy.scene.reference[i] - np.array(q)) for q in _ends(runs, i))
        found = "reproduced" if np.all(np.abs(left) < ARRIVED * abs(way)) else "not reproduced"
        claim = f"{figure}: |error| at the end, deg"
        yield _row(claim, "both arrive", tuple(np.abs(left)), runs.assumption, found)
        times = _settled(runs, i)
        yield _row(f"{figure}: settled to 2 %, s", "LQR slightly faster", times, runs.assumption, _faster(*times))


def _ends(runs: Pair, i: int) -> tuple[float, list[float]]:
    return runs.energy.scene.initial_q[i], [run.q[-1, i] for run in runs[:2]]


def _settled(runs: Pair, i: int) -> tuple[float, float]:
    name = runs.energy.scene.actuated[i]
    found = [run.summary["settling_time"][name] for run in runs[:2]]
    return tuple(np.inf if time is None else float(time) for time in found)  # pyright: ignore[reportReturnType]


def _faster(energy: float, lqr: float) -> str:
    if lqr >= energy:
        return "not reproduced"
    return "reproduced" if energy <= MUCH * lqr else f"faster, and {energy / lqr:.2g} times"


def _rope(runs: Pair) -> Iterator[Compared]:
    """Yield how the length of the rope oscillates, figure 6."""
    lengths = [run.q[:, 3] for run in runs[:2]]
    ways = tuple(float(np.sum(np.abs(np.diff(d))) - abs(d[-1] - d[0])) for d in lengths)
    claim = "Fig. 6, rope: way to and fro beyond start to end, m"
    yield _row(claim, "much less with the energy law", ways, runs.assumption, much_less(*ways))
    times = _settled(runs, 3)
    yield _row("Fig. 6, rope: settled to 2 %, s", "-", times, runs.assumption, "-")


def _swing(runs: Pair) -> Iterator[Compared]:
    """Yield how the load swings, figures 7 and 8, and when it is quiet."""
    for figure, column in (("Fig. 7, theta1", 4), ("Fig. 8, theta2", 5)):
        for after in (0.0, 10.0, 20.0):
            sizes = tuple(_largest(run, np.degrees(run.q[:, column]), after) for run in runs[:2])
            claim = f"{figure}: largest" + (f" after {after:g} s" if after else "") + ", deg"
            yield _row(claim, "much less with the energy law", sizes, runs.assumption, much_less(*sizes))
    yield _quiet("Section 4: load quiet (0.5 deg), s", runs)


def another(name: str) -> Iterator[Compared]:
    """Yield what is said of the load, for one of the other manoeuvres."""
    runs = pair(OTHERS[name])
    sizes = tuple(_largest(run, np.degrees(run.derived.swing), 0.0) for run in runs[:2])
    claim = f"{name}: largest swing, deg"
    yield _row(claim, "much less with the energy law", sizes, runs.assumption, much_less(*sizes))
    yield _quiet(f"{name}: load quiet (0.5 deg), s", runs)


def _quiet(claim: str, runs: Pair) -> Compared:
    times = tuple(float(run.t[np.degrees(run.derived.swing) > QUIET].max(initial=0.0)) for run in runs[:2])
    found = "reproduced" if times[0] < times[1] else "not reproduced"
    return _row(claim, "earlier with the energy law", times, runs.assumption, found)


def _largest(run: Rollout, angles: Any, after: float) -> float:
    return float(np.max(np.abs(angles[run.t >= after])))


def much_less(energy: float, lqr: float) -> str:
    """Return whether the first is much less than the second, in words."""
    if energy >= lqr:
        return "not reproduced"
    return "reproduced" if MUCH * energy <= lqr else "less, not much less"


def _efforts(runs: Pair) -> Iterator[Compared]:
    """Yield the largest efforts, figures 9 and 10."""
    for i, unit in enumerate(("N m", "N m", "N m", "N")):
        peaks = tuple(float(np.max(np.abs(run.u[:, i]))) for run in runs[:2])
        found = "reproduced" if max(peaks) <= SIMILAR * min(peaks) else "not reproduced"
        yield _row(f"Fig. {9 + i // 2}, u{i + 1}: largest, {unit}", "almost the same", peaks, runs.assumption, found)
    limits = "no limits are printed: not checked"
    yield Compared("Figs. 9, 10", "within the usual limits", "-", "-", None, runs.assumption, limits)


def _row(claim: str, paper: str, values: tuple[float, ...], assumption: str, verdict: str) -> Compared:
    energy, lqr = values
    shown = tuple("never" if np.isinf(value) else float(value) for value in values)
    difference = float(energy - lqr) if np.all(np.isfinite(values)) else None
    return Compared(claim, paper, *shown, difference, assumption, verdict)
