"""Evaluation of the benchmark's points: the cheapest of each engine at each error, ratios, targets."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from crane_sim.evaluation.bench.cases import LEVELS
from crane_sim.evaluation.bench.crane_sim_engine import NAME
from crane_sim.evaluation.bench.peers import GENERAL
from crane_sim.evaluation.bench.sweep import WorkPrecisionPoint, cheapest

HAND_C, GENERATED = "hand C", "CasADi C"
MAX_OF_HAND_C, MIN_OF_GENERAL, MIN_OF_S4 = 1.5, 15.0, 10.0
"""The targets: our time by that of hand-written C at most; general engines' time by ours at least, and on S4."""


class Target(NamedTuple):
    """The comparison of one scene at one error; None where there is nothing to compare with."""

    case: str
    level: float  # m
    of_hand_c: float | None  # our time by that of hand-written C
    general: str  # the best general multibody engine, "none" when none reaches the error
    of_general: float | None  # its time by ours
    of_generated: float | None  # the time of CasADi's generated C by ours

    def verdict(self) -> str:
        """Return "holds", or which of the targets are missed."""
        least = MIN_OF_S4 if self.case == "S4" else MIN_OF_GENERAL
        missed = []
        if self.of_hand_c is not None and self.of_hand_c > MAX_OF_HAND_C:
            missed.append("C")
        if self.of_general is not None and self.of_general < least:
            missed.append("general")
        if self.of_generated is not None and self.of_generated < 1.0:
            missed.append("CasADi")
        return f"misses {', '.join(missed)}" if missed else "holds"


def points_of(scene: dict[str, Any]) -> list[WorkPrecisionPoint]:
    """Return the points of a measured scene."""
    points = (WorkPrecisionPoint(*row) for row in scene["points"])
    return [point._replace(error=float("inf") if point.error is None else point.error) for point in points]


def best(points: Iterable[WorkPrecisionPoint]) -> dict[str, list[WorkPrecisionPoint | None]]:
    """Return for each engine its cheapest point at each of LEVELS."""
    by_engine: dict[str, list[WorkPrecisionPoint]] = {}
    for point in points:
        by_engine.setdefault(point.engine, []).append(point)
    return {engine: [cheapest(ours, level) for level in LEVELS] for engine, ours in by_engine.items()}


def targets(case: str, scene: dict[str, Any]) -> list[Target]:
    """Return the comparisons of a measured scene at every error that ours reaches."""
    best_points, rows = best(points_of(scene)), []
    for i, level in enumerate(LEVELS):
        ours = best_points.get(NAME, [None] * len(LEVELS))[i]
        if ours is None:
            continue
        times = {
            engine: point.us_per_s / ours.us_per_s
            for engine, cheapest_points in best_points.items()
            if (point := cheapest_points[i]) is not None
        }
        general = min(times.keys() & set(GENERAL), key=lambda engine: times[engine], default="none")
        hand_c = times.get(HAND_C)
        of_hand_c = 1.0 / hand_c if hand_c else None
        rows.append(Target(case, level, of_hand_c, general, times.get(general), times.get(GENERATED)))
    return rows
