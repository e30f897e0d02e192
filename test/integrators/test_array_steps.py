"""Steps of array states, in one piece as one by one, and the leapfrog method.

Of the latter: its order, its price, its independence of samples.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest

from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.integrators import (
    Integration,
    Status,
    advance,
    dense_output,
    integrate_to,
    make_event_log,
    scratch,
    start,
)
from crane_sim.integrators.array_steps import take_single_steps
from crane_sim.integrators.dop853 import DOP853, RK8
from crane_sim.integrators.dopri5 import DOPRI5
from crane_sim.integrators.events import BETWEEN, StepEnds, guard_between, may_switch
from crane_sim.integrators.leapfrog import Leapfrog
from crane_sim.integrators.rk4 import RK4
from crane_sim.integrators.rodas import Rodas
from crane_sim.scenes.scene import load_scene


class Whirl(NamedTuple):
    """x'' = -4 x + 0.3 v^2 + sin(3 t), and the integral of x v: an array [x, v, integral]."""

    unused: float = 0.0


@system.rhs_into.register(Whirl)
def _whirl_rhs_into(p, t, x, u, out, work):
    out[0], out[1], out[2] = x[1], -4.0 * x[0] + 0.3 * x[1] * x[1] + np.sin(3.0 * t), x[0] * x[1]


@system.workspace.register(Whirl)
def _whirl_workspace(p):
    return np.zeros(1)


@system.position_count.register(Whirl)
def _whirl_position_count(p):
    return 1


START = np.array([0.5, 0.0, 0.0])


def integrate(method: Any, end: float, samples: Any = ()) -> Integration:
    """Return the integration to `end`, with states at samples on the way.

    Steps may go beyond the samples.
    """
    integration = start(Whirl(), 0.0, START, None)
    for t in samples:
        integration = integrate_to(method, Whirl(), (), integration, t, end)
        dense_output(method, Whirl(), (), integration, t)
    return integrate_to(method, Whirl(), (), integration, end, end)


@pytest.mark.parametrize(
    "method", [RK4(0.1), RK8(0.1), DOP853(1e-6, 1e-8), DOPRI5(1e-6, 1e-8)], ids=repr
)
def test_steps_in_one_piece_are_those_one_by_one(method: Any) -> None:
    """One loop over steps of an array state has the bits of a loop over `advance`.

    Counters and the last step are the same, too.
    """
    single = start(Whirl(), 0.0, START, None)
    while single.t < 2.0:
        single = advance(method, Whirl(), (), single, 2.0)
    whole = integrate(method, 2.0)
    assert np.array_equal(whole.x, single.x) and np.array_equal(whole.x0, single.x0)
    assert whole._replace(x=0, x0=0, scratch=0) == single._replace(x=0, x0=0, scratch=0)
    assert np.array_equal(START, [0.5, 0.0, 0.0])


class SwitchingWhirl(NamedTuple):
    """The same, whose velocity turns around where the position falls below a floor."""

    floor: float = -0.2
    rank: int = 0  # of what the guards depend on; 0: on all of the state


@system.rhs_into.register(SwitchingWhirl)
def _switching_whirl_rhs_into(p, t, x, u, out, work):
    system.rhs_into(Whirl(), t, x, u, out, work)


@system.workspace.register(SwitchingWhirl)
def _switching_whirl_workspace(p):
    return np.zeros(1)


@system.switching.register(SwitchingWhirl)
def _switching_of_whirl(p):
    return system.Switching(10, p.rank)


@system.guard.register(SwitchingWhirl)
def _switching_whirl_guard(p, t, x, u, work):
    return (x[0] - p.floor if x[1] < 0.0 else 1.0), 0, 1 - p.rank


@system.apply_reset_map.register(SwitchingWhirl)
def _switching_whirl_apply_reset_map(p, t, x, u, which):
    return np.array([x[0], -0.9 * x[1], x[2]]), which, True


@pytest.mark.parametrize("rank", [0, 1])
@pytest.mark.parametrize(
    "method", [RK4(0.1), RK8(0.1), DOP853(1e-6, 1e-8), Rodas(1e-4, 1e-6)], ids=repr
)
def test_steps_with_events_in_one_piece_are_those_one_by_one(method: Any, rank: int) -> None:
    """Events, bits, counters and the last step are those of a loop that checks every step.

    It looks for an event after each one.
    """
    p = SwitchingWhirl(rank=rank)
    switches = system.switching(p)
    single, whole = (start(p, 0.0, START, make_event_log(switches)) for _ in range(2))
    for t in (0.7, 9.0):
        single = take_single_steps(switches, method, p, (), single, t, 9.0)
        whole = integrate_to(method, p, (), whole, t, 9.0)
    assert whole.event_log.total > 2 and np.array_equal(whole.event_log.rows, single.event_log.rows)
    assert np.array_equal(whole.x, single.x) and np.array_equal(whole.x0, single.x0)
    nothing = {"x": 0, "x0": 0, "scratch": 0, "event_log": 0}
    assert whole._replace(**nothing) == single._replace(**nothing)


@pytest.mark.parametrize("method", [RK4(1.0), RK8(1.0), DOP853(), DOPRI5()], ids=repr)
def test_the_cubic_through_first_and_last_stage_is_of_order_four(method: Any) -> None:
    """The interpolation of guards errs by h⁴: halving the step divides its error by 16.

    This is measured in the middle of a step.
    """
    p, errors = SwitchingWhirl(), list[float]()
    for h in (0.1, 0.05):
        x, space, middle = np.empty(3), scratch(START, p), np.empty(3)
        method.take_step(p, 0.0, START, (), h, space, x)
        may_switch(system.switching(p), method, space, p, (), StepEnds(0.0, START, h, x))
        guard_between(x, p, (), StepEnds(0.0, START, h, x), space.rows, 0.5, space.work)
        RK8(1.0).take_step(p, 0.0, START, (), 0.5 * h, scratch(START, p), middle)
        errors.append(float(np.linalg.norm(space.rows[BETWEEN] - middle)))
    # the next term is h times as large
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)


def test_steps_in_one_piece_end_where_a_state_is_not_finite() -> None:
    """A fixed step to a state that is not a number is the last one, and has been counted."""
    integration = start(Whirl(), 0.0, np.array([1e200, 1e200, 0.0]), None)
    integration = integrate_to(RK4(0.1), Whirl(), (), integration, 1.0, 1.0)
    assert (integration.status, integration.steps, integration.evaluations) == (
        Status.NOT_FINITE,
        1,
        4,
    )


def test_leapfrog_is_of_order_two() -> None:
    """Halving the step divides the errors by 4, with forces by squared velocity and by time."""
    exact = integrate(RK8(0.01), 3.0).x
    errors = [np.linalg.norm(integrate(Leapfrog(h), 3.0).x - exact) for h in (0.02, 0.01)]
    assert errors[1] < 1e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize(
    "method", [RK4(0.1), RK8(0.1), DOP853(1e-6, 1e-8), DOPRI5(1e-6, 1e-8)], ids=repr
)
def test_samples_change_no_step(method: Any) -> None:
    """States that are wanted within steps leave the next steps as they are, to the last bit."""
    samples = (0.07, 0.31, 0.32, 0.77)
    assert np.array_equal(integrate(method, 1.0).x, integrate(method, 1.0, samples).x)


def test_leapfrog_evaluates_once_a_step_wherever_it_is_sampled() -> None:
    """A period takes an evaluation a step and one at its start; samples in it change no bit."""
    whole, sampled = (
        integrate(Leapfrog(0.1), 1.0),
        integrate(Leapfrog(0.1), 1.0, samples=(0.07, 0.31, 0.32, 0.77)),
    )
    assert (whole.steps, whole.evaluations) == (sampled.steps, sampled.evaluations) == (10, 11)
    assert np.array_equal(whole.x, sampled.x)


def test_leapfrog_takes_overhead_cranes_of_several_links_alone() -> None:
    """A crane whose state is no array of positions and velocities is refused with one line."""
    with pytest.raises(
        SceneError, match="'leapfrog': takes overhead cranes of several links; this one dop853"
    ):
        load_scene("knuckle_springs", {"integrator": {"method": "leapfrog", "step": 1e-3}})
    assert load_scene(
        "overhead_chain", {"integrator": {"method": "leapfrog", "step": 1e-3}}
    ).method == Leapfrog(1e-3)
