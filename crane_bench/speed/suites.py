"""The suites of the benchmark beside its scenes: measurement, and results as lines of text."""

from collections.abc import Callable
from typing import Any, NamedTuple

from crane_bench.speed import (
    batch,
    bodies,
    campaign,
    groups,
    lockstep,
    memory,
    realtime,
    recording,
    reeving,
    start,
    stiff,
    studies,
)


class Suite(NamedTuple):
    """A suite of the benchmark."""

    title: str
    measure: Callable[[], dict[str, Any]]
    format: Callable[[dict[str, Any]], list[str]]


SUITES = {
    "lockstep": Suite("Lockstep over Fast DDS, against a bare echo", lockstep.measure, lockstep.format_lines),
    "realtime": Suite("Real time at 1 kHz, against a bare loop", realtime.measure, realtime.format_lines),
    "start": Suite("From a new process to the first step", start.measure, start.format_lines),
    "memory": Suite("Memory over ten minutes", memory.measure, memory.format_lines),
    "recording": Suite("What a recording costs", recording.measure, recording.format_lines),
    "groups": Suite("What each optional group of a scene costs", groups.measure, groups.format_lines),
    "reeving": Suite("Twelve falls with friction against real time", reeving.measure, reeving.format_lines),
    "bodies": Suite("A rigid load, beside MuJoCo and Exudyn", bodies.measure, bodies.format_lines),
    "batch": Suite("Thousands of cranes at once", batch.measure, batch.format_lines),
    "studies": Suite("A study, beside the runs it is made of", studies.measure, studies.format_lines),
    "campaign": Suite("The campaigns of cranebench, beside its own runs", campaign.measure, campaign.format_lines),
    "stiff": Suite("A cable as stiff as steel, against LSODA", stiff.measure, stiff.format_lines),
}
