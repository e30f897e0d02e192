"""Section 4 of the knuckle paper (Ambrosino et al.): energy law beside LQR, figure by figure.

The paper describes its figures in words and gives neither start nor target. Both laws make the
scenes' manoeuvre, and then others, because the comparison depends on it. Every verdict follows from
the numbers of its row.
"""

from collections.abc import Callable, Iterator
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from crane_bench.tables import Shown
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.rollout import Rollout, simulate
from crane_sim.simulation.settling import SETTLED

MUCH = 2.0  # "much less" is less than half, "slightly faster" up to twice as fast
SIMILAR = 1.25  # "almost the same" is within a quarter
QUIET = 0.5  # deg, of a load that has stopped swinging
VARIANTS: dict[str, dict[str, Any]] = {
    "half of the way": {"initial.q": ["22.5 deg", "37.5 deg", "-5 deg", 1.75, 0, 0]},
    "slew alone": {"initial.q": [0, "45 deg", 0, 1.5, 0, 0]},
    "boom and jib alone": {"initial.q": ["45 deg", "30 deg", "-10 deg", 1.5, 0, 0]},
    "rope alone": {"initial.q": ["45 deg", "45 deg", 0, 2.0, 0, 0]},
    "swing friction": {"swing_friction": {"model": "linear", "tangential": 0.1, "radial": 0.1}},
}
"""Other possible manoeuvres of the paper's experiment, as changes of the scenes."""
LESS = "much less with the energy law"
ARRIVALS = ("Fig. 3, tower", "Fig. 4, boom", "Fig. 5, jib")
SWINGS = {"Fig. 7, theta1": 4, "Fig. 8, theta2": 5}
LATER = {"": 0.0, " after 10 s": 10.0, " after 20 s": 20.0}
AT_END, AFTER, LARGEST = (
    "{}: error at the end, deg",
    "{}: settled to 2 % after, s",
    "{}: largest{}, deg",
)
WAY, WINCH = "Fig. 6, rope: way to and fro, m", "Fig. 6, rope"
EFFORTS = tuple(
    f"Fig. {9 + i // 2}, u{i + 1}: largest, {unit}"
    for i, unit in enumerate(("N m", "N m", "N m", "N"))
)
LIMITS = "Figs. 9, 10: efforts"
CALM = "Section 4: load swings by 0.5 deg until, s"
OTHERWISE = (
    "Figs. 7, 8, otherwise: largest swing, deg",
    "Section 4, otherwise: load swings by 0.5 deg until, s",
)
"""Claims of the rows: sentences of the paper, with its figures."""


class ClaimResult(NamedTuple):
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

    def of(self, metric: Callable[[Rollout], float]) -> tuple[float, float]:
        """Return a metric of both runs."""
        return float(metric(self.energy)), float(metric(self.lqr))


def claims() -> list[str]:
    """Return the claims of all rows, without running any."""
    arrivals = [claim.format(figure) for figure in ARRIVALS for claim in (AT_END, AFTER)]
    swings = [LARGEST.format(figure, words) for figure in SWINGS for words in LATER]
    section = [*arrivals, WAY, AFTER.format(WINCH), *swings, CALM, *EFFORTS, LIMITS]
    return [*section, *(claim for _ in VARIANTS for claim in OTHERWISE)]


def measure_knuckle_claims() -> list[ClaimResult]:
    """Return the paper's sentences for the scenes' manoeuvre, then on the load for others."""
    return [*section_4(run_both_laws()), *(row for name in VARIANTS for row in variant_rows(name))]


def run_both_laws(changes: dict[str, Any] | None = None) -> Pair:
    """Run both laws with the same changes of their scenes."""
    energy, lqr = (
        simulate(load_scene(name, changes or {})) for name in ("knuckle_setpoint", "knuckle_lqr")
    )
    return Pair(energy, lqr, manoeuvre(energy.scene))


def target_position(scene: Scene) -> tuple[float, ...]:
    """Return the target of slew, boom, jib [rad] and rope [m]."""
    assert scene.reference is not None, "both scenes have a target"
    return scene.reference


def manoeuvre(scene: Scene) -> str:
    """Return start and target in words: slew, boom, jib, rope."""
    ends = []
    for q in (scene.initial_q, target_position(scene)):
        angles = ", ".join(f"{x:g}" for x in np.round(np.degrees(q[:3]), 9))
        ends.append(f"{angles} deg, {q[3]:g} m")
    return " to ".join(ends)


def section_4(runs: Pair) -> Iterator[ClaimResult]:
    """Yield the claims of section 4 on figures 3 to 10."""
    for i, figure in enumerate(ARRIVALS):
        yield from _arrival(runs, figure, i)
    yield from _rope(runs)
    for figure, i in SWINGS.items():
        yield from _payload_swing(runs, figure, i)
    yield _quiet(runs, CALM, runs.assumption)
    yield from _largest_efforts(runs)


def _arrival(runs: Pair, figure: str, i: int) -> Iterator[ClaimResult]:
    """Yield whether and when joint i arrives."""
    goal = target_position(runs.energy.scene)[i]
    errors = runs.of(lambda run: abs(np.degrees(goal - run.q[-1, i])))
    arrived = max(errors) < SETTLED * abs(np.degrees(goal - runs.energy.scene.initial_q[i]))
    verdict = "reproduced" if arrived else "not reproduced"
    yield _claim_row(AT_END.format(figure), "both arrive", errors, runs.assumption, verdict)
    times = _settling_times(runs, i)
    yield _claim_row(
        AFTER.format(figure), "LQR slightly faster", times, runs.assumption, verdict_faster(*times)
    )


def _settling_times(runs: Pair, i: int) -> tuple[float, float]:
    """Return settling times [s] of joint i, infinite where it has not settled."""
    name = runs.energy.scene.actuated[i]
    return runs.of(
        lambda run: inf if (time := run.summary["settling_time"][name]) is None else time
    )


def verdict_faster(energy: float, lqr: float) -> str:
    """Return in words whether LQR is slightly faster, from times [s]."""
    if lqr >= energy:
        return "not reproduced"
    return "reproduced" if energy <= MUCH * lqr else f"faster, but {energy / lqr:.2g} times"


def _rope(runs: Pair) -> Iterator[ClaimResult]:
    """Yield the oscillation of the rope's length."""
    lengths = runs.of(
        lambda run: np.sum(np.abs(np.diff(run.q[:, 3]))) - abs(run.q[-1, 3] - run.q[0, 3])
    )
    yield _claim_row(WAY, LESS, lengths, runs.assumption, verdict_much_less(*lengths))
    times = _settling_times(runs, 3)
    yield _claim_row(AFTER.format(WINCH), "not said", times, runs.assumption, "-")


def _payload_swing(runs: Pair, figure: str, i: int) -> Iterator[ClaimResult]:
    """Yield the largest swing of joint i: of the whole run, after 10 s and after 20 s."""
    for words, after in LATER.items():
        sizes = runs.of(
            lambda run, after=after: np.degrees(np.max(np.abs(run.q[run.t >= after, i])))
        )
        yield _claim_row(
            LARGEST.format(figure, words), LESS, sizes, runs.assumption, verdict_much_less(*sizes)
        )


def verdict_much_less(energy: float, lqr: float) -> str:
    """Return in words whether a metric is much less with the energy law."""
    if energy >= lqr:
        return "not reproduced"
    return "reproduced" if MUCH * energy <= lqr else "less, not much less"


def _quiet(runs: Pair, claim: str, assumption: str) -> ClaimResult:
    """Return the time from which on the load swings by less than QUIET."""
    times = runs.of(lambda run: run.t[np.degrees(run.derived.swing) > QUIET].max(initial=0.0))
    verdict = "reproduced" if times[0] < times[1] else "not reproduced"
    return _claim_row(claim, "earlier with the energy law", times, assumption, verdict)


def _largest_efforts(runs: Pair) -> Iterator[ClaimResult]:
    """Yield the largest efforts."""
    for i, claim in enumerate(EFFORTS):
        peaks = runs.of(lambda run, i=i: np.max(np.abs(run.u[:, i])))
        verdict = "reproduced" if max(peaks) <= SIMILAR * min(peaks) else "not reproduced"
        yield _claim_row(claim, "almost the same", peaks, runs.assumption, verdict)
    unchecked = "no limits are printed: not checked"
    yield ClaimResult(LIMITS, "within usual limits", "-", "-", None, runs.assumption, unchecked)


def variant_rows(name: str) -> Iterator[ClaimResult]:
    """Yield the paper's claims on the load, for one of the other manoeuvres."""
    runs = run_both_laws(VARIANTS[name])
    assumption = f"{name}: {runs.assumption}"
    sizes = runs.of(lambda run: np.degrees(np.max(run.derived.swing)))
    yield _claim_row(OTHERWISE[0], LESS, sizes, assumption, verdict_much_less(*sizes))
    yield _quiet(runs, OTHERWISE[1], assumption)


def _claim_row(
    claim: str, paper: str, values: tuple[float, float], assumption: str, verdict: str
) -> ClaimResult:
    energy, lqr = ("never" if value == inf else value for value in values)
    difference = values[0] - values[1]
    return ClaimResult(
        claim, paper, energy, lqr, difference if isfinite(difference) else None, assumption, verdict
    )
