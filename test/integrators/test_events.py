"""Event detection: samples within a step, evaluations, and guards that are briefly negative."""

from typing import Any, NamedTuple

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.integrators import Status, integrate_to, make_event_log, start
from crane_sim.integrators.dop853 import RK8
from crane_sim.integrators.events import GUARD_SAMPLES, EventLog, events_until
from crane_sim.numerics.jit import entry_point
from crane_sim.simulation.rollout import simulate

STEP = 2.0  # s


class Throw(NamedTuple):
    """z'' = -1 below a ceiling that ends the run; state (z, z')."""

    ceiling: float
    forced: float  # 1: the guard is said to need an evaluation of its own, and all of the state


class ThrowArray(NamedTuple):
    """The same with an array as state."""

    ceiling: float
    forced: float


@system.rhs.register(Throw)
def _throw_rhs(p, t, x, u):
    return x[1], -1.0


@system.rhs_into.register(ThrowArray)
def _throw_array_rhs_into(p, t, x, u, out, work):
    out[0], out[1] = x[1], -1.0


@system.switching.register(Throw)
@system.switching.register(ThrowArray)
def _throw_switching(p):
    return system.Switching(10, 0 if p.forced > 0.0 else 1)


@system.guard.register(Throw)
@system.guard.register(ThrowArray)
def _throw_guard(p, t, x, u, work):
    return p.ceiling - x[0], 3, int(p.forced)


@system.apply_reset_map.register(Throw)
@system.apply_reset_map.register(ThrowArray)
def _throw_apply_reset_map(p, t, x, u, which):
    return x, which, False


@entry_point
def thrown(p, x, end):
    """Return the integration from (0, x) to `end`, or to the ceiling."""
    return integrate_to(
        RK8(STEP), p, (), start(p, 0.0, x, make_event_log(system.switching(p))), end, end
    )


def cases(ceiling: float, forced: float, v: float) -> list[tuple[Any, Any]]:
    """Return models and states of a throw from 0 with velocity v."""
    return [(Throw(ceiling, forced), (0.0, v)), (ThrowArray(ceiling, forced), np.array([0.0, v]))]


@pytest.mark.parametrize("forced", [0.0, 1.0])
@pytest.mark.parametrize("top", np.linspace(0.3, 1.7, 8))
def test_a_short_stay_beyond_a_guard_is_seen(top: float, forced: float) -> None:
    """A guard that is negative for just over 1 / GUARD_SAMPLES of a step ends the run on time.

    It is not negative at the ends of the step.
    """
    half = 0.51 * STEP / GUARD_SAMPLES
    for p, x in cases(0.5 * top**2 - 0.5 * half**2, forced, top):
        integration = thrown(p, x, STEP)
        assert (integration.status, integration.terminal_guard) == (
            Status.TERMINATED,
            3,
        ) and integration.event_log.total == 1
        # the method is exact for a parabola
        assert integration.t == pytest.approx(top - half, abs=1e-13)


@pytest.mark.parametrize("forced", [0, 1])
def test_what_looking_costs_is_counted(forced: int) -> None:
    """Guards of positions alone cost no evaluation, others what each takes.

    Both ends of a tuple cost theirs.
    """
    for (p, x), at_ends in zip(cases(1.0, forced, 1.0), (2, 0), strict=True):
        integration = thrown(p, x, 5 * STEP)
        assert (integration.steps, integration.evaluations) == (
            5,
            5 * (12 + forced * (at_ends + GUARD_SAMPLES)),
        )


def test_a_guard_that_is_only_touched_does_not_fail() -> None:
    """A ceiling just above the highest point does not end the run."""
    for p, x in cases(
        0.5 + 1e-12, 0.0, 1.0
    ):  # above rounding, far below what any look between could tell apart
        assert thrown(p, x, STEP).t == STEP


@pytest.mark.parametrize(
    ("groups", "each"),
    [
        ({"trolley.limits": [-100.0, 100.0]}, 12),
        ({"friction": {"trolley": {"coulomb": 10.0, "static": 1e4}}}, 12 + 2 + GUARD_SAMPLES),
        ({"cable.slack": "stop"}, 12 + 2 + GUARD_SAMPLES),
    ],
    ids=["limits", "sticking", "slack"],
)
def test_only_guards_of_forces_solve_for_them(groups: dict[str, Any], each: int) -> None:
    """A crane that only travel limits can stop costs no more evaluations than one without.

    The evaluations are those per step.
    """
    changes = {"duration": 0.5, "integrator": {"method": "rk8", "step": 0.05}}
    stats = simulate(crane_sim.load_scene("overhead_swing", changes | groups)).stats
    at_start = int(each > 12)  # where guards are evaluated before the first step
    assert stats["steps"] > 0 and stats["rhs_evaluations"] == stats["steps"] * each + at_start


def test_a_log_without_what_is_later() -> None:
    """Events up to an instant stay.

    Those that a full log only counted go with the last one that it kept.
    """
    rows = np.array([[1.0, 7.0], [2.0, 8.0]])
    assert [events_until(EventLog(2, rows), t).total for t in (0.5, 1.0, 1.5, 2.0)] == [0, 1, 1, 2]
    assert [events_until(EventLog(5, rows), t).total for t in (1.5, 2.0)] == [1, 5]
    assert events_until(None, 1.0) is None
