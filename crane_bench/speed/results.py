"""Evaluation of the benchmark: each engine's cheapest point at each error, ratios, targets."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from crane_bench.speed.cases import ERROR_LEVELS, is_asked
from crane_bench.speed.crane_sim_engine import NAME
from crane_bench.speed.peers import GENERAL
from crane_bench.speed.sweep import WorkPrecisionPoint, cheapest

HAND_C, GENERATED, TAYLOR = "hand C", "CasADi C", "heyoka"
CHAINS, MIN_OF_TAYLOR_ON_CHAINS = ("S3a", "S3b", "S4"), 5.0
MAX_OF_HAND_C, MAX_OF_HAND_C_ELSEWHERE = {"S5": 1.5} | dict.fromkeys(CHAINS, 2.0), 1.3
"""The largest ratio of our time to that of hand-written C, by scene."""
MIN_OF_GENERAL, MIN_OF_S4, MIN_OF_GENERATED = 15.0, 10.0, 1.2
"""The smallest ratio of the time of general engines, also on S4, and of CasADi's generated C to
ours."""
MIN_OF_TAYLOR = {1e-4: 1.5, 1e-6: 1.5, 1e-9: 1.5, 1e-12: 1.0}
"""The smallest ratio of heyoka's time to ours on chains, and by the error [m] on other scenes."""


class Target(NamedTuple):
    """The comparison of one scene at one error; None where there is nothing to compare with."""

    case: str
    level: float  # m
    of_hand_c: float | None  # our time by that of hand-written C
    general: str  # the best general multibody engine, "none" when none reaches the error
    of_general: float | None  # its time by ours
    of_generated: float | None  # the time of CasADi's generated C by ours
    of_taylor: float | None = None  # heyoka's time by ours

    def verdict(self) -> str:
        """Return "holds", or which of the targets are missed."""
        least = MIN_OF_S4 if self.case == "S4" else MIN_OF_GENERAL
        missed = []
        if self.of_hand_c is not None and self.of_hand_c > MAX_OF_HAND_C.get(
            self.case, MAX_OF_HAND_C_ELSEWHERE
        ):
            missed.append("C")
        if self.of_general is not None and self.of_general < least:
            missed.append("general")
        if self.of_generated is not None and self.of_generated < MIN_OF_GENERATED:
            missed.append("CasADi")
        of_chains = (
            MIN_OF_TAYLOR_ON_CHAINS if self.case in CHAINS else MIN_OF_TAYLOR.get(self.level, 0.0)
        )
        if self.of_taylor is not None and self.of_taylor < of_chains:
            missed.append("heyoka")
        return f"misses {', '.join(missed)}" if missed else "holds"


def read_points(scene: dict[str, Any]) -> list[WorkPrecisionPoint]:
    """Return the points of a measured scene."""
    points = (WorkPrecisionPoint(*row) for row in scene["points"])
    return [
        point._replace(error=float("inf") if point.error is None else point.error)
        for point in points
    ]


def cheapest_points(
    points: Iterable[WorkPrecisionPoint], error_bound: float = 0.0
) -> dict[str, list[WorkPrecisionPoint | None]]:
    """Return each engine's cheapest point at each of ERROR_LEVELS.

    It is None where the reference is too coarse.
    """
    by_engine: dict[str, list[WorkPrecisionPoint]] = {}
    for point in points:
        by_engine.setdefault(point.engine, []).append(point)
    asked = [level if is_asked(level, error_bound) else -1.0 for level in ERROR_LEVELS]
    return {
        engine: [cheapest(ours, level) for level in asked] for engine, ours in by_engine.items()
    }


def targets(case: str, scene: dict[str, Any]) -> list[Target]:
    """Return the comparisons of a measured scene at every error that ours reaches."""
    cheapest_of, rows = cheapest_points(read_points(scene), scene.get("trusted", 0.0)), []
    for i, level in enumerate(ERROR_LEVELS):
        ours = cheapest_of.get(NAME, [None] * len(ERROR_LEVELS))[i]
        if ours is None:
            continue
        times = {
            engine: point.us_per_s / ours.us_per_s
            for engine, points_at_levels in cheapest_of.items()
            if (point := points_at_levels[i]) is not None
        }
        general = min(times.keys() & set(GENERAL), key=lambda engine: times[engine], default="none")
        hand_c = times.get(HAND_C)
        of_hand_c = 1.0 / hand_c if hand_c else None
        generals = general, times.get(general), times.get(GENERATED)
        rows.append(Target(case, level, of_hand_c, *generals, times.get(TAYLOR)))
    return rows
