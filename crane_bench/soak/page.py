"""The page of documentation on the results of the soak tests."""

from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from crane_bench.soak import plots
from crane_bench.soak.metrics import Metric
from crane_bench.speed.measurement import describe_machine

HEAD = """# What a run survives

Written by `crane soak page --save docs` from the files in [soak](soak), one for each part, which `crane soak PART
--save docs` saves: a part that is run again replaces its former results. Every run has the scene
`knuckle_setpoint`. What is required stands beside what was measured, passed or not; a metric without a requirement is a
basis of comparison for others. What is required of a run over ROS is measured outside the plant where that is possible:
by a node that belongs to no run, the monitor, which subscribes in the same ROS domain and records instant, stamp and
efforts of every message.
"""


class Part(NamedTuple):
    """A section of the page."""

    title: str
    procedure: str
    data_keys: tuple[str, ...] = ()  # keys of the data that the plot shows
    draw: Callable[[Any, dict[str, Any]], None] | None = None  # into a matplotlib figure
    series: bool = False  # they are samples over time, which may be thinned


PARTS = {
    "kill": Part(
        "Nodes that are killed",
        "One run in real time with `--restart`. Controller and recorder are killed by SIGKILL in turn, half a second "
        "to two and a half seconds apart, drawn at random. Control is restored when the plant applies a command of the "
        "*next* controller: the monitor recognises it by the efforts, bit for bit, so that a held command of "
        "the killed one does not count. Steps are counted three times, by the plant, by the monitor and in "
        "the recording that is left at the end, which is read back. A loop beside the "
        "run that only sleeps, a millisecond at a time, measures the machine's own longest stalls: no call can "
        "be required to be shorter.",
        ("back_s",),
        plots.draw_kill,
    ),
    "signals": Part(
        "Runs that are interrupted",
        "Each run is a `crane run` of its own, in turn in real time, in lockstep, with `--restart` and with `--mcap`, "
        "and gets SIGINT or SIGTERM at a random instant: a fifth of "
        "them in the first 100 ms, a tenth with an empty cache, while the equations are being compiled; a third get "
        "a second signal. Failures are: a process that outlives its run, a traceback, any file but recording and "
        "bag, a recording that lacks a step that the monitor received, a last effort other than zero as the monitor "
        "received it, or an exit code other than 1, the signal's own apart within the first 100 ms, while the shell of "
        "the start script is still there; a run that had taken all its steps may end with 0.",
        ("at", "took", "fresh", "code"),
        plots.draw_signals,
    ),
    "memory": Part(
        "Long runs over ROS",
        "One lockstep run with plant, controller and recorder, as fast as possible, sampled once a second. The rate "
        "at constant speed of the processor, which a fixed piece of arithmetic measures with each sample, is judged "
        "after the warm-up: the run is divided into thirty segments, each represented by its median, and the "
        "change is the median slope between all pairs of them (Theil and Sen) times its length. Half its "
        "95 % interval is the part that noise of the machine can explain.",
        ("seconds", "steps_per_second", "memory_MB"),
        plots.draw_memory,
        series=True,
    ),
    "inprocess": Part(
        "Long runs without ROS",
        "The same of one process: a plant that is stepped with its law without pause, then the same run simulated "
        "again and again. Memory is counted from the first of 25 samples on, the rate is judged in the same way.",
        ("Plant.advance", "simulate"),
        plots.draw_inprocess,
        series=True,
    ),
    "determinism": Part(
        "One scene, one run",
        "600 steps in lockstep, again and again: plant and controller, or a recorder as well, each a process started "
        "by hand; the executor `events` or `single`; the machine idle or with another process that keeps a core "
        "busy, in turn. Where `CRANE_SIM_KILTED_PYTHON` names a Python with ROS 2 Kilted, plant or controller or both "
        "run there, too. `state_sha256` is a hash of every state of a run.",
    ),
    "realtime": Part(
        "Real time at 1 kHz",
        "Rounds of ten seconds, in turn: a loop that only sleeps until its next deadline, plant and controller by "
        "themselves, and plant and controller beside the monitor. The period error, which the plant measures itself, "
        "is compared with that of the bare loop in the same round, on the same machine. Rate and overruns beside the "
        "monitor are also counted by it, from when states and efforts were sent; where a machine has few cores, it "
        "takes time from the nodes that it observes.",
    ),
}


def write_findings(documents: Mapping[str, Mapping[str, Any]], drawn: Collection[str]) -> str:
    """Return the page in Markdown.

    Args:
        documents: the document of each part that was run: command, machine, metrics, data.
        drawn: the parts that have a plot.
    """
    sections = [_section(part, documents[part], part in drawn) for part in PARTS if part in documents]
    return "\n".join([HEAD, *sections])


def _section(name: str, document: Mapping[str, Any], drawn: bool) -> str:
    part = PARTS[name]
    lines = [
        f"## {part.title}",
        "",
        part.procedure,
        "",
        f"`{document['command']}` on {describe_machine(document['machine'])}.",
        "",
    ]
    if drawn:
        lines += [f"![{part.title}](soak/{name}.png)", ""]
    lines += ["| metric | measured | required | passed |", "|---|---|---|---|"]
    return "\n".join(lines + [_write_row(metric) for metric in document["metrics"]]) + "\n"


def _write_row(metric: Metric) -> str:
    verdict = ("yes" if metric.passed else "**no**") if metric.requirement else ""
    cells = metric.what, metric.format_value(), metric.requirement, verdict
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
