"""The suites of the benchmark beside its scenes: measurement, and results as lines of text."""

from collections.abc import Callable
from typing import Any, NamedTuple

from crane_bench.speed import (
    batch,
    bodies,
    groups,
    lockstep,
    recording,
    reeving,
    start,
    studies,
)


class Suite(NamedTuple):
    """A suite of the benchmark."""

    title: str
    measure: Callable[[], dict[str, Any]]
    format: Callable[[dict[str, Any]], list[str]]


SUITES = {
    "lockstep": Suite(
        "Lockstep over Fast DDS, against a bare echo",
        lockstep.measure_lockstep,
        lockstep.format_lockstep,
    ),
    "start": Suite("From a new process to the first step", start.measure_start, start.format_start),
    "recording": Suite(
        "What a recording costs", recording.measure_recording, recording.format_recording
    ),
    "groups": Suite(
        "What each optional group of a scene costs", groups.measure_groups, groups.format_groups
    ),
    "reeving": Suite(
        "Twelve falls with friction against real time",
        reeving.measure_reeving,
        reeving.format_reeving,
    ),
    "bodies": Suite("A rigid load, beside MuJoCo", bodies.measure_bodies, bodies.format_bodies),
    "batch": Suite("Thousands of cranes at once", batch.measure_batch, batch.format_batch),
    "studies": Suite(
        "A study, beside the runs it is made of", studies.measure_studies, studies.format_studies
    ),
}
