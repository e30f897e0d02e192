"""What each optional group of a scene costs per evaluation and per step: `crane bench groups`.

What a scene does not name is not compiled for it: a base without optional groups pays for none of them, and each group
is measured against its base, interleaved. Evaluations follow each other as in an integrator, each at the state that the
last one led to. Steps are whole ones of order 8, the default method's, at a fixed size, with the guards of models that
switch.
"""

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.evaluation.bench.group_cases import CASES, Case, Changes
from crane_sim.evaluation.bench.measurement import describe_spread, machine, ratio
from crane_sim.integrators import Status, apply_pending_events, integrate_to, make_event_log, start
from crane_sim.integrators.dop853 import RK8
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.states import add_scaled, dimension
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.stepping.periods import begin

_TINY = 1e-9  # s, from one evaluation to the next: they depend on each other, and the crane stays where it is
_STEP = 1e-6  # s, of the method: safe for the stiffest case


@entry_point
def march(p, x, u, evaluations):
    """Return the state, nested tuples, after so many evaluations, each moving it on by a little."""
    for _ in range(evaluations):
        x = add_scaled(x, _TINY, system.rhs(p, 0.0, x, u))
    return x


@entry_point
def march_array(p, x, u, evaluations):
    """Return the state, an array, after so many evaluations, each moving it on by a little."""
    y, out, work = x.copy(), np.empty_like(x), system.workspace(p)
    for _ in range(evaluations):
        system.rhs_into(p, 0.0, y, u, out, work)
        for i in range(len(y)):
            y[i] += _TINY * out[i]
    return y


@entry_point
def pass_time(method, p, x, u, end):
    """Return the integration at time `end` [s] that began with state x at 0."""
    switches = system.switching(p)
    return integrate_to(
        method, p, u, apply_pending_events(switches, p, u, start(p, 0.0, x, make_event_log(switches))), end, end
    )


class Subject(NamedTuple):
    """A crane at its start, and what drives it."""

    model: Any
    x: Any
    u: Any

    def evaluate(self, times: int) -> float:
        """Return the nanoseconds of one of so many evaluations."""
        loop: Callable[..., Any] = march_array if isinstance(self.x, np.ndarray) else march
        began = time.perf_counter()
        loop(self.model, self.x, self.u, times)
        return (time.perf_counter() - began) / times * 1e9

    def step(self, times: int) -> float:
        """Return the nanoseconds of one of so many steps.

        Raises:
            RuntimeError: the integration failed.
        """
        began = time.perf_counter()
        flow = pass_time(RK8(_STEP), self.model, self.x, self.u, times * _STEP)
        elapsed = time.perf_counter() - began
        if flow.status != Status.OK:
            raise RuntimeError(
                f"{type(self.model).__name__}: the integration ended with status {Status(flow.status).name}"
            )
        return elapsed / flow.counters.steps * 1e9


def subject(scene: Scene) -> Subject:
    """Return the crane of a scene at its start, under its own inputs, or no effort where a law is sampled."""
    flow, _, _ = begin(scene.model, np.array(scene.initial_q), np.array(scene.initial_v))
    return Subject(scene.model, flow.x, (0.0,) * len(scene.actuated) if scene.sampled else scene.source)


def scene_pair(case: Case) -> tuple[Scene, Scene]:
    """Return the scenes without and with the group of a case."""
    before: Changes = {**case.base.changes, **case.common}
    # what both need must not undo what the group brings: the base of the meter has a law, the meter's scene has none
    after = {**case.base.changes, **(case.common if case.changes else {}), **case.changes}
    return load_scene(case.base.scene, before), load_scene(case.base.scene, after)


def cost(case: Case, rounds: int, times: int) -> dict[str, Any]:
    """Return what the group of a case costs, ns, and how many states it adds.

    Args:
        case: base and change.
        rounds: interleaved; what compiles comes before.
        times: evaluations per round, and twelve times the steps.
    """
    without, having = map(subject, scene_pair(case))
    figures: dict[str, Any] = {"crane": case.base.label, "group": case.group}
    figures["states"] = dimension(without.x)
    figures["states_added"] = dimension(having.x) - dimension(without.x)
    for what, count in (("evaluate", times), ("step", max(times // 12, 1))):
        for each in (without, having):
            getattr(each, what)(1)
        pairs = [(getattr(without, what)(count), getattr(having, what)(count)) for _ in range(rounds)]
        figures |= _compare({"evaluate": "evaluation", "step": "step"}[what], *zip(*pairs, strict=True))
    return figures


def _compare(unit: str, without: Sequence[float], having: Sequence[float]) -> dict[str, Any]:
    return {
        f"ns_per_{unit}_without": describe_spread(without),
        f"ns_per_{unit}_with": describe_spread(having),
        f"ns_per_{unit}_added": describe_spread([b - a for a, b in zip(without, having, strict=True)]),
        f"{unit}_ratio": ratio(having, without),
    }


def measure(rounds: int = 15, times: int = 20_000, cases: Sequence[Case] = CASES) -> dict[str, Any]:
    """Return the cost of every group of the table, ns per evaluation and per step; arguments as of `cost`."""
    return {"rounds": rounds, "cases": [cost(case, rounds, times) for case in cases], "machine": machine()}


def format_lines(results: dict[str, Any]) -> list[str]:
    """Return the table in lines."""
    lines = [
        f"ns per evaluation and per step of order 8, without and with the group; medians of {results['rounds']} pairs"
    ]
    lines.append(f"{'crane':<13} {'group':<26} {'evaluation':>20} {'':>6} {'step':>20} {'':>6} states")
    for row in results["cases"]:
        costs = f"{_format_pair(row, 'evaluation')} {_format_pair(row, 'step')}"
        lines.append(f"{row['crane']:<13} {row['group']:<26} {costs} {row['states']:>3} {row['states_added']:+}")
    return lines


def _format_pair(row: dict[str, Any], unit: str) -> str:
    without, having = (row[f"ns_per_{unit}_{which}"]["median"] for which in ("without", "with"))
    return f"{without:8.1f} -> {having:8.1f} {row[f'{unit}_ratio']['median']:5.2f}x"
