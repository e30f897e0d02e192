"""The tables of the benchmark's page."""

from typing import Any

from crane_bench.speed.cases import CASES, ERROR_LEVELS
from crane_bench.speed.crane_sim_engine import NAME
from crane_bench.speed.results import Target, cheapest_points, read_points, targets
from crane_bench.speed.sweep import WorkPrecisionPoint
from crane_bench.tables import markdown_table

_COLUMNS = [f"{level:.0e} m" for level in ERROR_LEVELS]
Scenes = dict[str, Any]


def cheapest_table(data: Scenes) -> str:
    """Return the cheapest setting of every engine at every error."""
    rows = []
    for case, scene in data["scenes"].items():
        for engine, points in cheapest_points(read_points(scene), scene["trusted"]).items():
            rows.append([case, engine, *map(_cost, points)])
        rows += [
            [case, engine, why, *[""] * (len(ERROR_LEVELS) - 1)]
            for engine, why in scene["refused"].items()
        ]
    title = (
        "## The cheapest setting that reaches an error: µs of wall time per simulated second\n\n"
    )
    return title + markdown_table(["scene", "engine", *_COLUMNS], rows)


_TARGETS = (
    "## Targets\n\nOurs is to take at most 1.3 times the time of hand-written C (S5: 1.5 times; "
    "the chains S3a, S3b and S4: 2 times); the best general engine (Pinocchio, MuJoCo) at least "
    "15 times ours (S4: 10 times); CasADi's generated C at least 1.2 times ours; heyoka 1.5 times "
    "ours from 1e-4 to 1e-9, 5 times on chains, and no less at 1e-12. The last column says what is "
    "missed; a dash: not measured on that scene, or not reached. S4r is S4 taken for a straight "
    "rod by the scene, beside the engines' chains.\n\n"
)


def target_table(data: Scenes) -> str:
    """Return the ratios and whether the targets hold."""
    rows = []
    for case in CASES:
        if scene := select_compared(data, case.id, case.engine_results_from):
            rows += [_format_target(row) for row in targets(case.id, scene)]
    ratios = ["/ hand C", "best general", "/ ours", "CasADi C / ours", "heyoka / ours"]
    return _TARGETS + markdown_table(["scene", "error", *ratios, ""], rows)


def select_compared(data: Scenes, case: str, engine_results_from: str) -> Scenes | None:
    """Return a measured scene with its compared engines; None where there are none."""
    scene = data["scenes"].get(case)
    engine_scene = data["scenes"].get(engine_results_from) if engine_results_from else scene
    if scene is None or engine_scene is None:
        return None
    ours = [row for row in scene["points"] if row[0] == NAME]
    peers = [row for row in engine_scene["points"] if row[0] != NAME]
    return scene | {"points": ours + peers} if peers else None


def tension_table(data: Scenes) -> str:
    """Return the errors of the rope's tension beside those of the payload's position."""
    rows = []
    for case, scene in data["scenes"].items():
        for engine, points in cheapest_points(read_points(scene), scene["trusted"]).items():
            if any(point is not None and point.tension_error is not None for point in points):
                rows.append(
                    [
                        case,
                        engine,
                        *("—" if p is None else _format_tension_error(p) for p in points),
                    ]
                )
    text = (
        "## An elastic rope's tension\n\nA coarse step that damps the rope's vibration may place "
        "the payload well and "
        "still miss its tension: errors in N at the end, of the runs above.\n\n"
    )
    return text + markdown_table(["scene", "engine", *_COLUMNS], rows) if rows else ""


def other_table(data: Scenes) -> str:
    """Return what the engines that were there cannot model of the other scenes."""
    rows = []
    for case in CASES:
        for engine, reasons in data["cannot"].items():
            if case.id in data["scenes"] and case.scene in reasons:
                rows.append([case.id, case.title, engine, reasons[case.scene]])
    title = "## What other engines do not model as it is meant\n\n"
    return title + markdown_table(["scene", "", "engine", "why"], rows) if rows else ""


def _cost(point: WorkPrecisionPoint | None) -> str:
    if point is None:
        return "—"
    counted = f", {point.evaluations} evals" if point.evaluations is not None else ""
    return f"**{point.us_per_s:.3g}** {point.method} {point.setting:.2g}{counted}"


def _format_tension_error(point: WorkPrecisionPoint) -> str:
    return "?" if point.tension_error is None else f"{point.tension_error:.1e}"


def _format_target(row: Target) -> list[str]:
    ratios = row.of_hand_c, row.of_generated, row.of_taylor
    hand_c, generated, taylor = ("—" if value is None else f"{value:.3g}" for value in ratios)
    general = "—" if row.of_general is None else f"{row.of_general:.0f}"
    return [
        row.case,
        f"{row.level:.0e}",
        hand_c,
        row.general,
        general,
        generated,
        taylor,
        row.verdict(),
    ]
