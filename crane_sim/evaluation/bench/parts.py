"""The parts of the benchmark beside its scenes: what each measures, and its results as lines of text."""

from collections.abc import Callable
from typing import Any, NamedTuple

from crane_sim.evaluation.bench import batch, groups, lockstep, memory, realtime, recording, start, stiff


class Part(NamedTuple):
    """A part of the benchmark."""

    title: str
    measure: Callable[[], dict[str, Any]]
    format: Callable[[dict[str, Any]], list[str]]


PARTS = {
    "lockstep": Part("Lockstep over Fast DDS, against a bare echo", lockstep.measure, lockstep.format_lines),
    "realtime": Part("Real time at 1 kHz, against a bare loop", realtime.measure, realtime.format_lines),
    "start": Part("From a new process to the first step", start.measure, start.format_lines),
    "memory": Part("Memory over ten minutes", memory.measure, memory.format_lines),
    "recording": Part("What a recording costs", recording.measure, recording.format_lines),
    "groups": Part("What each optional group of a scene costs", groups.measure, groups.format_lines),
    "batch": Part("Thousands of cranes at once", batch.measure, batch.format_lines),
    "stiff": Part("A cable as stiff as steel, against LSODA", stiff.measure, stiff.format_lines),
}
