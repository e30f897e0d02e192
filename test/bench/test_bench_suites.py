"""The benchmark's suites with tiny settings: keys and consistency of their results."""

import json
import random
from typing import Any

import pytest

from crane_bench.speed import groups, lockstep, reeving, start
from crane_bench.speed.group_cases import CASES
from crane_bench.speed.measurement import describe_spread, machine, ratio
from crane_sim.ros.common.timing import StepTiming
from crane_sim.scenes.registry import SCHEMAS
from crane_sim.scenes.scene import load_scene

SPREAD = {"median", "least", "most", "rounds"}


def without_machine(results: dict[str, Any]) -> dict[str, Any]:
    """Return results without their machine, after a check that JSON can carry them."""
    assert results["machine"] == machine()
    assert json.loads(json.dumps(results, allow_nan=False)) == results
    return {key: value for key, value in results.items() if key != "machine"}


def test_a_ratio_is_taken_round_by_round() -> None:
    """A drift of both sides of a round cancels in their ratio, unlike in the ratio of medians."""
    assert describe_spread([3.0, 1.0, 2.0]) == {
        "median": 2.0,
        "least": 1.0,
        "most": 3.0,
        "rounds": [3.0, 1.0, 2.0],
    }
    assert ratio([2.0, 40.0, 6.0], [1.0, 20.0, 3.0]) == describe_spread([2.0, 2.0, 2.0])


@pytest.mark.long
def test_lockstep_is_compared_with_an_echo() -> None:
    """Every kind has a speed per round and a ratio to the echo; the echo's own is 1."""
    results = without_machine(lockstep.measure_lockstep(duration=0.2, rounds=1, recorder=False))
    assert results["steps_per_round"] == 20
    for key in ("steps_per_second", "ratio_to_echo"):
        assert set(results[key]) == {"echo", "lockstep"}
        assert all(
            set(values) == SPREAD and values["least"] > 0.0 for values in results[key].values()
        )
    speed = {kind: values["median"] for kind, values in results["steps_per_second"].items()}
    assert results["ratio_to_echo"]["echo"]["rounds"] == [1.0]
    assert results["ratio_to_echo"]["lockstep"]["median"] == speed["lockstep"] / speed["echo"]


@pytest.mark.long
def test_starts_are_separate_processes() -> None:
    """The first step of a new process is timed warm, beside its imports and an empty program."""
    results = without_machine(start.measure_start("overhead_swing", rounds=1, cold_rounds=1))
    assert all(results[key]["least"] > 0.0 for key in start.LABELS)


@pytest.mark.slow
def test_a_group_has_a_cost_and_states() -> None:
    """A prescribed trolley has its number of states, and times that fit together.

    These are times per evaluation and step, their difference and their ratio.
    """
    (case,) = (case for case in CASES if case.group == "trolley, prescribed")
    (row,) = without_machine(groups.measure_groups(rounds=1, repetitions=12, cases=[case]))["cases"]
    assert (row["states"], row["states_added"]) == (
        4,
        1,
    )  # position, angle, their rates; the energy of the imposed motion
    for unit in ("evaluation", "step"):
        without, with_group = (
            row[f"ns_per_{unit}_{which}"]["median"] for which in ("without", "with")
        )
        assert row[f"ns_per_{unit}_added"]["median"] == with_group - without
        assert row[f"{unit}_ratio"]["median"] == with_group / without


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.baseline.label}: {case.group}")
def test_a_case_differs_from_its_baseline_by_its_group(case: groups.GroupCase) -> None:
    """Both scenes of a row are possible, are the same crane, and only one has the group."""
    without, with_group = groups.scene_pair(case)
    assert without.crane == with_group.crane and without.document != with_group.document


@pytest.mark.long
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.baseline.label}: {case.group}")
def test_every_row_runs(case: groups.GroupCase) -> None:
    """Both scenes of each row evaluate and step without an end of the run, and have times."""
    row = groups.measure_cost(case, rounds=1, repetitions=12)
    assert row["ns_per_step_without"]["median"] > 0.0 and row["ns_per_step_with"]["median"] > 0.0


def test_every_group_of_the_equations_has_a_row() -> None:
    """Each optional group that enters the equations has a cost.

    The scenes have a cable or falls below their support.
    """
    # of the plant, a law or the file; the load on falls and the ways of the inputs are in the
    # baselines
    outside = {
        "name",
        "description",
        "seed",
        "control",
        "integrator",
        "reference",
        "brake",
        "sensors",
        "faults",
    }
    outside |= {"uncertain", "imu", "camera", "legs"}
    measured = {key.split(".")[0] for case in CASES for key in case.changes}
    for schema in ("tower", "mobile", "bridge", "gantry", "knuckle", "pendulum"):
        fields = {
            name for name, field in SCHEMAS[schema].model_fields.items() if not field.is_required()
        }
        assert fields - outside - {"gravity"} <= measured, schema
    assert {SCHEMAS[load_scene(case.baseline.scene).crane] for case in CASES} == set(
        SCHEMAS.values()
    )


def test_all_groups_of_a_crane_are_measured_at_once() -> None:
    """The case of all groups has the changes and the model of each part.

    What is absent alone is present together.
    """
    for case in (case for case in CASES if case.parts):
        without, together = groups.scene_pair(case)
        own = [row for row in CASES if row.baseline is case.baseline and row.group in case.parts]
        assert len(own) == len(case.parts) > 1
        for row in own:
            for key, value in row.changes.items():
                assert case.changes[key] == (
                    case.changes[key] | value if isinstance(value, dict) else value
                ), key
            _, alone = groups.scene_pair(row)
            for name, value in alone.model._asdict().items():
                if value is not None and getattr(without.model, name) is None:
                    assert type(getattr(together.model, name)) is type(value), name


@pytest.mark.long
def test_twelve_falls_are_measured_against_real_time() -> None:
    """Every setting has an error, smaller for finer tolerances, and a rate.

    The fastest one within 1e-4 m counts.
    """
    results = without_machine(reeving.measure_reeving(rounds=1, duration=2.0))
    rows = results["rows"]
    assert all(row["times_real_time"]["least"] > 0.0 for row in rows)
    for first in (0, 3):
        assert rows[first]["error"] > rows[first + 1]["error"] > rows[first + 2]["error"] > 0.0
    assert (
        rows[-1]["error"] < reeving.LIMIT
        and "within 1e-04 m" in reeving.format_reeving(results)[-1]
    )


def test_rows_of_other_cranes_stay() -> None:
    """Groups of one crane measured again replace its rows, others keep theirs.

    Rows keep the processor that they are from.
    """

    def result(processor: str, *labels: str) -> dict[str, Any]:
        costs = {
            key: describe_spread([1.0])
            for key in (
                f"ns_per_{unit}_{which}"
                for unit in ("evaluation", "step")
                for which in ("with", "without", "added")
            )
        }
        costs |= {"evaluation_ratio": describe_spread([1.0]), "step_ratio": describe_spread([1.0])}
        cases = [case for case in CASES if case.baseline.label in labels and not case.parts]
        rows = [
            {"crane": c.baseline.label, "group": c.group, "states": 1, "states_added": 0} | costs
            for c in cases
        ]
        return {"cases": rows, "machine": {"processor": processor}}

    new = result("new", "tower")
    new["cases"] = [row | {"processor": "new"} for row in new["cases"]]
    joined = groups.join(result("old", "tower", "mobile", "knuckle"), new)
    assert {(row["crane"], row["processor"]) for row in joined["cases"]} == {
        ("knuckle", "old"),
        ("mobile", "old"),
        ("tower", "new"),
    }
    assert groups.format_groups(joined)[-2:] == ["on old: knuckle, mobile", "on new: tower"]


def test_quantiles_of_period_errors() -> None:
    """Quantiles in bins of 1 µs are those of the errors, rounded up; a pause breaks the chain."""
    random.seed(1)
    lateness = [random.uniform(0.0, 2e-3) for _ in range(1001)]  # s
    timing = StepTiming()
    for k, delay in enumerate(lateness):
        timing.note(0.001 * k, 0.001 * k + delay)
    errors = sorted(1e6 * abs(b - a) for a, b in zip(lateness, lateness[1:], strict=False))
    results = timing.metrics()["period_error_us"]
    for name, i in (("p50", 499), ("p99", 989)):
        # a bin, and rounding in the last digits
        assert errors[i] - 1e-6 <= results[name] <= errors[i] + 1.000001
    # µs: differences of times near 1 s round at 1e-10 s
    assert results["max"] == pytest.approx(errors[-1], abs=1e-6)
    before = timing.metrics()["period_error_us"]["max"]
    timing.pause()
    timing.note(50.0, 50.09)
    assert timing.metrics()["period_error_us"]["max"] == before
    assert timing.metrics()["lateness_us"]["max"] == pytest.approx(90_000.0)
