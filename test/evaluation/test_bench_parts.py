"""The measurements of the whole path, with settings too small to tell anything: what they return, that it adds up."""

import json
import random
import time
from typing import Any

import pytest

from crane_sim.evaluation.bench import groups, lockstep, memory, realtime, recording, start
from crane_sim.evaluation.bench.group_cases import CASES
from crane_sim.evaluation.bench.measurement import describe_spread, machine, ratio
from crane_sim.ros.common.timing import StepTiming
from crane_sim.scenes.scene import load_scene

SPREAD = {"median", "least", "most", "rounds"}


def checked(found: dict[str, Any]) -> dict[str, Any]:
    """Return what a measurement returned, after a way through JSON, with its machine left out."""
    assert found["machine"] == machine()
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    return {key: value for key, value in found.items() if key != "machine"}


def test_a_ratio_is_taken_round_by_round() -> None:
    """A drift that hits both sides of a round drops out of their ratio, which the ratio of medians would not do."""
    assert describe_spread([3.0, 1.0, 2.0]) == {"median": 2.0, "least": 1.0, "most": 3.0, "rounds": [3.0, 1.0, 2.0]}
    assert ratio([2.0, 40.0, 6.0], [1.0, 20.0, 3.0]) == describe_spread([2.0, 2.0, 2.0])


def test_lockstep_is_compared_with_both_echoes() -> None:
    """Every kind has a speed per round and a ratio to each echo, that of an echo to itself being 1."""
    found = checked(lockstep.measure(duration=0.2, rounds=1, recorder=False))
    assert found["steps_per_round"] == 20
    for key in ("steps_per_second", "ratio_to_echo", "ratio_to_packed_echo"):
        assert set(found[key]) == {"echo", "packed echo", "lockstep"}
        assert all(set(values) == SPREAD and values["least"] > 0.0 for values in found[key].values())
    speed = {kind: values["median"] for kind, values in found["steps_per_second"].items()}
    assert found["ratio_to_echo"]["echo"]["rounds"] == found["ratio_to_packed_echo"]["packed echo"]["rounds"] == [1.0]
    assert found["ratio_to_echo"]["lockstep"]["median"] == speed["lockstep"] / speed["echo"]


def test_a_recording_has_a_size_and_a_cost() -> None:
    """Files of both kinds are measured against the same run without a recorder."""
    found = checked(recording.measure(duration=0.2, rounds=1, labels=("none", "rrd and mcap")))
    assert set(found["added_us_per_step"]) == {"rrd and mcap"}
    assert found["ratio_to_unrecorded"]["none"]["rounds"] == [1.0]
    assert set(found["bytes_per_simulated_minute"]) == {"rrd", "mcap"}
    # 20 steps hold at least q and v of six joints, 8 bytes each; a minute has 300 times as many
    assert all(size["least"] > 300 * 20 * 96 for size in found["bytes_per_simulated_minute"].values())


def test_real_time_is_compared_with_a_loop_that_only_sleeps() -> None:
    """Both tell the quantiles of their period errors and lateness, in order, their rate and their overruns."""
    found = checked(realtime.measure(period=0.01, duration=0.2, rounds=1))
    for kind in ("bare", "plant"):
        for key in ("period_error_us", "lateness_us"):
            values = [found[kind][key][name]["median"] for name in ("p50", "p99", "max")]
            assert values == sorted(values) and values[0] >= 0.0
        assert len(found[kind]["overruns"]) == 1 and found[kind]["rate_Hz"]["least"] > 0.0


def test_memory_is_seen_for_every_node_until_the_end() -> None:
    """Plant and controller are looked at as long as asked, at least once a second, and the run ends in order."""
    found = checked(memory.measure(seconds=1.2, warm_up=0.5, recorder=False))
    assert set(found["resident"]) == {"plant", "controller"}
    assert found["steps"] > 0 and len(found["sample_times_s"]) >= 2
    for figures in found["resident"].values():
        assert len(figures["samples_MB"]) == len(found["sample_times_s"])
        assert figures["most_MB"] >= figures["after_warm_up_MB"] > 1.0
        assert figures["growth_MB"] == figures["end_MB"] - figures["after_warm_up_MB"]


def test_starts_are_processes_of_their_own() -> None:
    """The first step of a new process is timed warm, beside its imports and an empty program."""
    found = checked(start.measure("overhead_swing", rounds=1, cold_rounds=1))
    assert all(found[key]["least"] > 0.0 for key in start.LABELS)


@pytest.mark.slow
def test_a_group_has_a_cost_and_states() -> None:
    """A prescribed trolley: as many states; times per evaluation and step whose difference and ratio fit."""
    (case,) = (case for case in CASES if case.group == "trolley, prescribed")
    (row,) = checked(groups.measure(rounds=1, times=12, cases=[case]))["cases"]
    assert (row["states"], row["states_added"]) == (4, 1)  # place, angle, their rates; a meter of the motion imposed
    for unit in ("evaluation", "step"):
        without, having = (row[f"ns_per_{unit}_{which}"]["median"] for which in ("without", "with"))
        assert row[f"ns_per_{unit}_added"]["median"] == having - without
        assert row[f"{unit}_ratio"]["median"] == having / without


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.base.label}: {case.group}")
def test_a_case_differs_from_its_base_by_its_group(case: groups.Case) -> None:
    """Both scenes of a row are possible, are the same crane, and the group is in one of them only."""
    without, having = groups.scene_pair(case)
    assert without.crane == having.crane and without.document != having.document


def test_quantiles_of_period_errors() -> None:
    """Quantiles over bins of 1 µs are those of the errors themselves, rounded up, and a pause breaks the chain."""
    random.seed(1)
    late = [random.uniform(0.0, 2e-3) for _ in range(1001)]  # s
    punctuality = StepTiming()
    for k, by in enumerate(late):
        punctuality.note(0.001 * k, 0.001 * k + by)
    errors = sorted(1e6 * abs(b - a) for a, b in zip(late, late[1:], strict=False))
    found = punctuality.figures()["period_error_us"]
    for name, i in (("p50", 499), ("p99", 989)):
        assert errors[i] - 1e-6 <= found[name] <= errors[i] + 1.000001  # a bin, and rounding in the last digits
    assert found["max"] == pytest.approx(errors[-1], abs=1e-6)  # µs: differences of times near 1 s round at 1e-10 s
    before = punctuality.figures()["period_error_us"]["max"]
    punctuality.pause()
    punctuality.note(50.0, 50.09)
    assert punctuality.figures()["period_error_us"]["max"] == before
    assert punctuality.figures()["lateness_us"]["max"] == pytest.approx(90_000.0)


def test_a_bare_loop_keeps_its_deadlines_in_order() -> None:
    """The loop that only sleeps never comes before a deadline: its run is at least as long as its periods together."""
    began = time.monotonic()
    found = realtime.bare(0.002, 20)
    assert time.monotonic() - began >= 0.04
    assert found["lateness_us"]["p50"] > 0.0 and found["steps_per_second"] <= 500.0


def test_the_recorded_scene_is_sampled() -> None:
    """The default scene of these measurements has a law that is asked every period: there are two nodes to measure."""
    assert load_scene("knuckle_setpoint").sampled
