"""Metrics of a run: settling times and the energy balance, independent of the blocks."""

from typing import Any

import numpy as np
import pytest
from metric_rows import metrics_of

from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.energy_balance import (
    add_energies,
    add_work,
    empty_balance,
    relative_errors,
)
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate
from crane_sim.simulation.settling import RESOLUTION, STAY
from crane_sim.simulation.status import SimulationError, list_kinds
from crane_sim.simulation.totals import watched_of

PERIOD = 0.01
PUSHED: dict[str, Any] = {
    "crane": "overhead",
    "duration": 1.0,
    "trolley": {"drive": "force", "mass": 20.0, "limits": [-1.0, 1.0]},
    "cable": {"lengths": [3.0], "node_masses": [10.0]},
    "initial": {"angles": ["10 deg"]},
    "inputs": {"trolley": {"kind": "constant", "value": 100.0}},
}
"""A trolley that is pushed against the end of its travel, where the run ends."""
T = np.arange(1000) * PERIOD


def settling_time(error: np.ndarray, initial: float, cuts: tuple[int, ...] = ()) -> float | None:
    """Return when a joint settled from errors (1000,) over 10 s, its initial one, and blocks.

    Its target is 0.
    """
    still = {
        "inputs": None,
        "trolley.limits": None,
        "duration": 10.0,
        "reference.q": [0.0],
        "initial.x": initial,
    }
    q = np.column_stack([np.append(error, error[-1]), np.zeros(1001)])
    return metrics_of(load_scene(PUSHED, still), q, cuts)["settling_time"]["trolley"]


def test_a_joint_that_begins_at_its_target_settles() -> None:
    """A joint that is pushed off its target and comes back settles, though 2 % of 0 is 0."""
    pushed = np.where((T > 1.0) & (T < 2.5), 0.1, 0.5 * RESOLUTION)
    assert settling_time(pushed, 0.0) == pytest.approx(2.5)
    assert settling_time(0.0 * T, 0.0) == 0.0
    assert settling_time(np.full(1000, 2.0 * RESOLUTION), 0.0) is None


def test_a_joint_must_stay_at_its_target() -> None:
    """A joint within 2 % only in the last tenth of the run has not settled, one before has."""
    late, early = (np.where(T < at, 0.021, 0.019) for at in (9.96, 10.0 * (1.0 - STAY)))
    assert settling_time(late, 1.0) is None
    assert settling_time(early, 1.0) == pytest.approx(9.0)
    assert settling_time(np.full(1000, 0.021), 1.0) is None


def test_a_manoeuvre_settles_within_its_part_of_the_way() -> None:
    """Errors are measured by 2 % of the first one where that is more than the resolution."""
    assert settling_time(np.exp(-T), 1.0) == pytest.approx(np.log(50.0), abs=PERIOD)


def test_metrics_know_no_blocks() -> None:
    """However many instants come at once, sums, largest values and the hash are the same bits."""
    q, scene = (
        np.random.default_rng(1).normal(0.0, 1.0, (1001, 2)),
        load_scene(PUSHED, {"reference.q": [0.0]}),
    )
    assert (
        metrics_of(scene, q)
        == metrics_of(scene, q, (1, 2, 3, 514, 900))
        == metrics_of(scene, q, tuple(range(1000)))
    )


def test_the_largest_error_of_the_balance_is_kept() -> None:
    """Energy that comes and goes again is in the largest error, and not in the one at the end."""
    balance, watched = empty_balance(0), watched_of(load_scene("pendulum_free"), metered=True)
    balance.start[0], none = 1.0, np.zeros(0)
    for supplied, kinetic in ((0.0, 1.0), (0.5, 2.0), (0.5, 1.5)):
        add_work(balance, watched._replace(driven=none), none, none, supplied)
        add_energies(balance, kinetic, 0.0)
    relative_errors(balance, watched._replace(driven=none), none, 1.5, 0.5)
    assert balance.errors.tolist() == [0.0, 0.5 / 2.0]  # J, of the 2 J that were in play


def test_looking_at_a_run_does_not_change_its_metrics() -> None:
    """A plant whose summary is read midway ends with the metrics of `simulate`, to the last bit."""
    scene = load_scene("knuckle_setpoint", {"duration": 1.0})
    law, plant = scene.law, Plant(scene)
    assert law is not None
    for k in range(scene.steps):
        plant.advance(tuple(law(plant.t, plant.q, plant.v)))
        if k % 7 == 0:
            plant.summary()
    actual, expected = plant.summary(), simulate(scene).summary
    assert {key: actual[key] for key in actual} == {key: expected[key] for key in actual}
    # 1e-9 a step, and some rounding
    assert 0.0 < actual["energy_audit_error"] <= actual["energy_audit_max"] < 1e-11


def test_efforts_are_any_numbers() -> None:
    """Integers, a list, an array, NumPy's numbers are efforts, as floats are, compiled, too."""
    plant, hashes = Plant(load_scene("knuckle_setpoint")), set()
    for efforts in (
        (1.0, 0.0, 2.0, 9.5),
        (1, 0, 2, 9.5),
        [1, 0.0, np.int64(2), 9.5],
        np.array([1.0, 0.0, 2.0, 9.5]),
    ):
        plant.reset()
        plant.advance(efforts)
        hashes.add(plant.summary()["state_sha256"])
    assert len(hashes) == 1


def test_many_events_are_listed_by_kind() -> None:
    """Of many events the summary has each kind once, by first time, with number and times."""
    events = [(0.1 * k, ("sticks", "slips")[k % 2]) for k in range(5)]
    kinds = list_kinds(events)
    assert [(kind["what"], kind["count"]) for kind in kinds] == [("sticks", 3), ("slips", 2)]
    assert (kinds[0]["first"], kinds[0]["last"]) == (events[0][0], events[4][0])


@pytest.mark.parametrize("instants", [None, [0.1, 0.2]])
def test_a_payload_that_changes_as_the_run_ends_is_in_the_audit(
    instants: list[float] | None,
) -> None:
    """A payload taken up in the period in which the run fails counts in the energy audit.

    It counts as it does of a `Plant`.
    """
    scene = load_scene(
        PUSHED | {"faults": {"heavy": {"kind": "payload", "mass": 40.0, "at": 0.60}}}
    )
    with pytest.raises(
        SimulationError, match="t = 0.605.* s: the trolley reached its travel limit"
    ) as caught:
        simulate(scene, sample_times=instants)
    run, plant = caught.value.run, Plant(scene)
    for _ in range(60):
        plant.advance()
    with pytest.raises(SimulationError):
        plant.advance()
    # rounding
    assert run.summary["energy_audit_error"] == plant.summary()["energy_audit_error"] < 1e-12
    assert len(run.t) == (61 if instants is None else 2)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_run_that_fails_within_a_period_ends_with_the_energy_of_its_start(
    dimensions: int,
) -> None:
    """The audit of a crane without a meter compares energy and work of the same instant."""
    document = {
        "crane": "overhead",
        "dimensions": dimensions,
        "duration": 5.0,
        "trolley": {"mass": 20.0, "limits": [-1.0, 1.0]},
        "cable": {"lengths": [3.0], "node_masses": [10.0]},
        "control": {"law": "lqr", "period": 0.05},
        "reference": {"q": [1.0, 0.5][: dimensions - 1]},
    }
    bridge = {"bridge": {"mass": 10.0}} if dimensions == 3 else {}
    with pytest.raises(SimulationError, match="the trolley reached its travel limit") as caught:
        simulate(document | bridge)
    # rounding; the period is one of 2e-3
    assert caught.value.run.summary["energy_audit_error"] < 1e-12


def test_a_plant_goes_on_from_the_start_of_its_period() -> None:
    """Efforts in place of open-loop inputs act from then on.

    They do beside sensors, too, and after a failure with a load.
    """
    sensed = {"sensors": {"all": {"noise": [0.01, 0.01]}}}
    bare, beside = (Plant(load_scene(PUSHED | group)) for group in ({}, sensed))
    for plant in (bare, beside):
        for _ in range(10):
            plant.advance()
        plant.advance((-5000.0,))
    assert beside.q == pytest.approx(bare.q, rel=1e-9) and beside.v == pytest.approx(
        bare.v, rel=1e-9
    )
    plant = Plant(
        load_scene(PUSHED | {"faults": {"heavy": {"kind": "payload", "mass": 40.0, "at": 0.60}}})
    )
    for _ in range(60):
        plant.advance()
    with pytest.raises(SimulationError):
        plant.advance()
    plant.advance((-2e4,))  # N: turns the trolley in time
    assert plant.k == 61 and plant.summary()["energy_audit_error"] < 1e-12  # rounding


def test_events_beyond_the_end_are_not_of_the_run() -> None:
    """A run that ends before the trolley reaches its limit at 0.605 s lists no event.

    It does not however far its last step went.

    Nor does the summary of a `Plant` under way.
    """
    for duration in (
        0.56,
        0.60,
    ):  # from 0.55 s on the step that follows the solution reaches the limit
        run, plant = simulate(PUSHED, duration=duration), Plant(load_scene(PUSHED))
        for _ in range(run.scene.steps):
            plant.advance()
        assert run.events == run.summary["events"] == plant.summary()["events"] == []
        assert run.summary["event_count"] == plant.summary()["event_count"] == 0


def test_a_plant_lists_the_event_that_ended_its_run() -> None:
    """The summary of a `Plant` that fails has the events of `simulate`.

    They stay until other efforts let it go on.
    """
    with pytest.raises(SimulationError) as caught:
        simulate(PUSHED)
    expected, plant = caught.value.run, Plant(load_scene(PUSHED))
    led = Plant(plant.scene.with_external_commands())
    for _ in range(60):
        plant.advance()
        led.advance((100.0,))
    for each, efforts in ((plant, None), (led, (100.0,))):
        assert each.summary()["events"] == []
        with pytest.raises(SimulationError):
            each.advance(efforts)
        assert each.summary()["event_count"] == 1
    assert plant.summary()["events"] == expected.summary["events"] != []
    led.advance((-1e4,))  # N: turns the trolley in time
    assert led.summary()["events"] == []


def test_brakes_do_not_change_what_counts_as_near() -> None:
    """A joint reset to 10 m away settles within 0.2 m of its target, with brakes or without.

    The brakes act on the way.

    2 % of the scene's own start would be 0.01 m, where the joint does not arrive.
    """
    scene = load_scene(
        PUSHED
        | {"inputs": None, "reference": {"q": [0.0]}, "initial": {"x": 0.5}, "duration": 10.0}
    )
    scene, times = (
        load_scene(scene, {"trolley.limits": None, "control": {"law": "lqr", "period": 0.05}}),
        [],
    )
    for braked in (False, True):
        plant = Plant(scene)
        plant.reset([10.0, 0.0], [0.0, 0.0])
        for k in range(280):
            plant.braking = braked and k == 250
            plant.advance((-8.0 * plant.q[0] - 18.0 * plant.v[0],))
        times.append(plant.summary()["settling_time"]["trolley"])
        assert 0.01 < abs(plant.q[0]) < 0.2
    assert times[0] == times[1] and 0.0 < times[0] < 12.5  # s, before the brakes
