"""Cost of each optional group of a scene per evaluation and per step: `crane bench groups`.

Groups absent from a scene are not compiled for it: a baseline without optional groups pays for none
of them, and each group is measured against its baseline, interleaved. Evaluations follow each other
as in an integrator, each at the state that results from the one before. Steps are those of order 8,
the default method, of fixed size, with the event functions of switching models. Times are those of
the processor, so that other programs on it cost no more than caches.
"""

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from crane_bench.speed.group_cases import CASES, Changes, GroupCase
from crane_bench.speed.measurement import describe_spread, machine, ratio
from crane_sim import system
from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.integrators import Status, apply_pending_events, integrate_to, make_event_log, start
from crane_sim.integrators.dop853 import RK8
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.states import add_scaled, dimension
from crane_sim.recording.provenance import processor
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.stepping.periods import begin

_EVALUATION_STEP = 1e-9  # s: evaluations depend on each other, and the state hardly changes
_METHOD_STEP = 1e-6  # s: stable for the stiffest case


@entry_point
def evaluate_repeatedly(p, x, u, evaluations):
    """Return the state, nested tuples, after one Euler step per evaluation.

    A step is `_EVALUATION_STEP` long.
    """
    for _ in range(evaluations):
        x = add_scaled(x, _EVALUATION_STEP, system.rhs(p, 0.0, x, u))
    return x


@entry_point
def evaluate_repeatedly_array(p, x, u, evaluations):
    """Return the state, an array, after one Euler step per evaluation.

    A step is `_EVALUATION_STEP` long.
    """
    y, out, work = x.copy(), np.empty_like(x), system.workspace(p)
    for _ in range(evaluations):
        system.rhs_into(p, 0.0, y, u, out, work)
        for i in range(len(y)):
            y[i] += _EVALUATION_STEP * out[i]
    return y


@entry_point
def integrate_until(method, p, x, u, end):
    """Return the integration from state x at 0 to time `end` [s]."""
    switching = system.switching(p)
    return integrate_to(
        method,
        p,
        u,
        apply_pending_events(switching, p, u, start(p, 0.0, x, make_event_log(switching))),
        end,
        end,
    )


class TimedCrane(NamedTuple):
    """A crane, its initial state and its inputs, whose evaluations and steps are timed."""

    model: Any
    x: Any
    u: Any

    def time_evaluations(self, repetitions: int) -> float:
        """Return the mean time [ns] of that many evaluations."""
        loop: Callable[..., Any] = (
            evaluate_repeatedly_array if isinstance(self.x, np.ndarray) else evaluate_repeatedly
        )
        start = time.thread_time()
        loop(self.model, self.x, self.u, repetitions)
        return (time.thread_time() - start) / repetitions * 1e9

    def time_steps(self, repetitions: int) -> float:
        """Return the mean time [ns] of that many steps.

        Raises:
            RuntimeError: the integration failed.
        """
        start = time.thread_time()
        integration = integrate_until(
            RK8(_METHOD_STEP), self.model, self.x, self.u, repetitions * _METHOD_STEP
        )
        elapsed = time.thread_time() - start
        if integration.status != Status.OK:
            raise RuntimeError(
                f"{type(self.model).__name__}: the integration ended with status "
                f"{Status(integration.status).name}"
            )
        return elapsed / integration.steps * 1e9


def make_timed_crane(scene: Scene) -> TimedCrane:
    """Return a scene's crane at its initial state, with its inputs, zero for a sampled law."""
    integration, _, _ = begin(scene.model, np.array(scene.initial_q), np.array(scene.initial_v))
    return TimedCrane(
        scene.model, integration.x, (0.0,) * len(scene.actuated) if scene.sampled else scene.source
    )


def scene_pair(case: GroupCase) -> tuple[Scene, Scene]:
    """Return the scenes without and with the group of a case."""
    baseline_changes: Changes = {**case.baseline.changes, **case.common}
    # `common` must not undo the group: the energy meter's baseline has a control law, the case
    # itself has none
    group_changes = {
        **case.baseline.changes,
        **(case.common if case.changes else {}),
        **case.changes,
    }
    return load_scene(case.baseline.scene, baseline_changes), load_scene(
        case.baseline.scene, group_changes
    )


def measure_cost(case: GroupCase, rounds: int, repetitions: int) -> dict[str, Any]:
    """Return the cost [ns] of a case's group, and the number of states it adds.

    Args:
        case: baseline and change.
        rounds: interleaved, after compilation.
        repetitions: evaluations per round; a twelfth as many steps, which have twelve evaluations
            each.
    """
    without, with_group = map(make_timed_crane, scene_pair(case))
    metrics: dict[str, Any] = {
        "crane": case.baseline.label,
        "group": case.group,
        "parts": list(case.parts),
    }
    metrics["processor"] = processor()
    metrics["states"] = dimension(without.x)
    metrics["states_added"] = dimension(with_group.x) - dimension(without.x)
    timers = {"evaluation": TimedCrane.time_evaluations, "step": TimedCrane.time_steps}
    for unit, measure_time in timers.items():
        repeat = repetitions if unit == "evaluation" else max(repetitions // 12, 1)
        for crane in (without, with_group):
            measure_time(crane, 1)
        pairs = [
            (measure_time(without, repeat), measure_time(with_group, repeat)) for _ in range(rounds)
        ]
        metrics |= _compare(unit, *zip(*pairs, strict=True))
    return metrics


def _compare(unit: str, without: Sequence[float], with_group: Sequence[float]) -> dict[str, Any]:
    """Return the row's entries on the times [ns] of one unit of work, measured in pairs."""
    return {
        f"ns_per_{unit}_without": describe_spread(without),
        f"ns_per_{unit}_with": describe_spread(with_group),
        f"ns_per_{unit}_added": describe_spread(
            [b - a for a, b in zip(without, with_group, strict=True)]
        ),
        f"{unit}_ratio": ratio(with_group, without),
    }


def select_cases(cranes: Sequence[str]) -> Sequence[GroupCase]:
    """Return the cases of cranes with these labels, all without any.

    Raises:
        SceneError: there is no such crane.
    """
    known = list(dict.fromkeys(case.baseline.label for case in CASES))
    for crane in cranes:
        if crane not in known:
            raise SceneError(unknown_key(crane, known, "--crane"))
    return [case for case in CASES if not cranes or case.baseline.label in cranes]


def measure_groups(
    rounds: int = 15, repetitions: int = 20_000, cases: Sequence[GroupCase] = CASES
) -> dict[str, Any]:
    """Return the cost of each case's group, ns per evaluation and step; see `measure_cost`."""
    return {
        "rounds": rounds,
        "cases": [measure_cost(case, rounds, repetitions) for case in cases],
        "machine": machine(),
    }


def join(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """Return new results with old rows of unmeasured cranes; each row keeps its processor."""
    measured = {row["crane"] for row in new["cases"]}
    rows = [row for row in old["cases"] if row["crane"] not in measured] + new["cases"]
    place = {(case.baseline.label, case.group): i for i, case in enumerate(CASES)}
    kept = [
        {"processor": old["machine"]["processor"]} | row
        for row in rows
        if (row["crane"], row["group"]) in place
    ]
    return new | {"cases": sorted(kept, key=lambda row: place[row["crane"], row["group"]])}


def format_groups(results: dict[str, Any]) -> list[str]:
    """Return the table in lines."""
    rows = results["cases"]
    lines = [
        "ns per evaluation and per step of order 8, without and with the group; medians of "
        "interleaved pairs",
        f"{'crane':<13} {'group':<26} {'evaluation':>20} {'':>6} {'step':>20} {'':>6} states",
    ]
    for row in rows:
        costs = f"{_format_pair(row, 'evaluation')} {_format_pair(row, 'step')}"
        lines.append(
            f"{row['crane']:<13} {row['group']:<26} {costs} {row['states']:>3} "
            f"{row['states_added']:+}"
        )
    together = [
        f"  {row['crane']:<13} {_format_ratio(row, rows)}" for row in rows if row.get("parts")
    ]
    if together:
        lines.append(
            "ratio of the cost that several groups add jointly to the sum of the costs that each "
            "adds alone"
        )
    return [*lines, *together, *_describe_processors(rows)]


def _describe_processors(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return lines on the processor of each crane's measurement; none where all are the same."""
    cranes = dict[str, dict[str, None]]()
    for row in rows:
        cranes.setdefault(row.get("processor", ""), {})[row["crane"]] = None
    return (
        [f"on {name}: {', '.join(labels)}" for name, labels in cranes.items()]
        if len(cranes) > 1
        else []
    )


def joint_to_separate_cost(row: dict[str, Any], rows: Sequence[dict[str, Any]], unit: str) -> float:
    """Return the ratio of the joint case's added cost to the sum of its groups' own.

    The cost is that of an evaluation or a step.
    """
    alone = {other["group"]: other for other in rows if other["crane"] == row["crane"]}
    added = f"ns_per_{unit}_added"
    return row[added]["median"] / sum(alone[part][added]["median"] for part in row["parts"])


def _format_ratio(row: dict[str, Any], rows: Sequence[dict[str, Any]]) -> str:
    costs = (
        f"{unit} {joint_to_separate_cost(row, rows, unit):.2f}x" for unit in ("evaluation", "step")
    )
    return f"{', '.join(costs)}: {', '.join(row['parts'])}"


def _format_pair(row: dict[str, Any], unit: str) -> str:
    without, with_group = (row[f"ns_per_{unit}_{which}"]["median"] for which in ("without", "with"))
    return f"{without:8.1f} -> {with_group:8.1f} {row[f'{unit}_ratio']['median']:5.2f}x"
