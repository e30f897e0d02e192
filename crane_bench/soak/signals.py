"""SIGINT and SIGTERM at random instants of `crane run`, from its start: `crane soak signals`."""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from pathlib import Path
from typing import Any, NamedTuple

from crane_bench.soak.leftovers import MARK, RECORDING, of_run, orphans
from crane_bench.soak.metrics import Metric, at_most, equal, quantiles
from crane_bench.soak.monitor import Messages, MonitorFile, monitor
from crane_sim import load_scene
from crane_sim.files.catalogue import config_folder
from crane_sim.orchestration.ros_environment import reserve_domain
from crane_sim.process_signals import set_parent_death_signal

SCENE, DURATION = "knuckle_setpoint", 2.0  # s, in real time
LIMIT = 3.0  # s from the signal to the end
_EARLY = 0.1  # s, of which every fifth instant is one
_POLL = 0.02  # s between two polls of received messages
_EXIT_TIMEOUT = 30.0  # s until a run that does not end is killed, only so that the soak goes on
_START_TIMEOUT = 300.0  # s for a run to begin, only so that the soak goes on
_ENDLESS = 1e5  # simulated s, far more than a run has until its signal


class RunKind(NamedTuple):
    """A kind of run."""

    duration: float  # simulated s: each takes about 2 s of wall time
    options: tuple[str, ...]  # of the command


RUN_KINDS = {
    "realtime": RunKind(DURATION, ("--mode", "realtime")),
    "lockstep": RunKind(100.0 * DURATION, ()),
    "restart": RunKind(DURATION, ("--mode", "realtime", "--restart")),
    "mcap": RunKind(DURATION, ("--mode", "realtime", "--mcap", "run.mcap")),
}


class Interruption(NamedTuple):
    """The signals to one run."""

    number: signal.Signals
    at: float  # s after its start
    again: float | None  # s from the first signal to a second one; None: there is one signal
    fresh: bool  # with an empty cache of compiled code: the signal comes while it is compiled
    way: str = "realtime"  # kind of the run, a key of RUN_KINDS
    begun: bool = False  # `at` counts from the first state that the monitor receives, and the run
    # does not end before


class End(NamedTuple):
    """The end of that run."""

    took: float  # s from the first signal, 0 where it had ended before
    code: int
    failures: tuple[str, ...]  # deviations from the requirements


def plan(count: int, seed: int, usual: float) -> list[Interruption]:
    """Return `count` interruptions of runs that usually take `usual` seconds."""
    draw, kinds = random.Random(seed), list(RUN_KINDS)
    interruptions = []
    for i in range(count):
        fresh = i % 10 == 3
        span = _EARLY if i % 5 == 0 else 8.0 if fresh else usual + 0.3
        again = draw.uniform(0.0, 0.6) if i % 3 == 0 else None
        number = draw.choice((signal.SIGINT, signal.SIGTERM))
        interruptions.append(
            Interruption(
                number, draw.uniform(0.0, span), again, fresh, kinds[(i + i // 10) % len(kinds)]
            )
        )
    return interruptions


def soak_signals(count: int = 50, seed: int = 0) -> tuple[list[Metric], dict[str, Any]]:
    """Interrupt `count` runs; return (metrics, data)."""
    scene = load_scene(SCENE, {"duration": DURATION})
    with reserve_domain() as domain, monitor(scene, domain) as monitored:
        start, shared = time.monotonic(), set(os.listdir("/dev/shm"))
        undisturbed = interrupt_run(None, domain, monitored)
        if undisturbed.failures:
            raise RuntimeError(f"the undisturbed run: {'; '.join(undisturbed.failures)}")
        planned = plan(count, seed, time.monotonic() - start)
        ends = [interrupt_run(interruption, domain, monitored) for interruption in planned]
        files = set(os.listdir("/dev/shm")) - shared
    pairs = zip(planned, ends, strict=True)
    failures = [
        f"{event.way}, {event.at:.3f} s: {why}" for event, end in pairs for why in end.failures
    ]
    data = {name: [getattr(event, name) for event in planned] for name in Interruption._fields}
    data |= {name: [getattr(end, name) for end in ends] for name in End._fields}
    return _compute_metrics(ends, failures, len(files)), data


def _compute_metrics(ends: list[End], failures: list[str], files: int) -> list[Metric]:
    took = quantiles([end.took for end in ends if end.took] or [0.0])
    uncut = sum(end.took > 0.0 and not end.code for end in ends)
    return [
        Metric("runs interrupted", len(ends)),
        Metric("of them after their end", sum(not end.took for end in ends)),
        Metric("of them too late to be cut short", uncut),
        Metric("until the end, median", took["p50"], "s"),
        at_most("until the end, longest", took["max"], LIMIT, "s"),
        equal("files more in /dev/shm", files, 0),
        equal("failures", len(failures), 0),
        *(Metric("failure", why) for why in failures),
    ]


def interrupt_run(interruption: Interruption | None, domain: int, monitored: MonitorFile) -> End:
    """Start a run, interrupt it, and check what remains."""
    mark, way = str(uuid.uuid4()), _kind_of(interruption)
    monitored.read()
    received: Messages = {"s": [], "e": []}
    with (
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        tempfile.TemporaryDirectory(prefix="crane_sim-") as cache,
    ):
        fresh = {"CRANE_SIM_CACHE": cache} if interruption and interruption.fresh else {}
        env = os.environ | {MARK: mark} | fresh
        command = [_crane(), "run", SCENE, "--duration", str(way.duration), *way.options]
        command += ["--domain-id", str(domain), "--record", str(Path(folder, RECORDING)), "--json"]
        pipes: dict[str, Any] = {"stderr": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        with subprocess.Popen(
            command, env=env, cwd=folder, preexec_fn=set_parent_death_signal(), **pipes
        ) as process:
            took = _send_signals(process, interruption, monitored, received)
            timeout = _EXIT_TIMEOUT if interruption else _START_TIMEOUT
            printed, outliving = _wait_for_pipes(process, mark, timeout)
        steps = load_scene(SCENE, {"duration": way.duration}).steps
        monitored.read_to_end(received, lambda messages: not _last_effort(messages, steps))
        count = _count_steps(received, steps)
        failures = [*outliving, *orphans(mark), *of_run(Path(folder), count)]
    failures += [*_last_effort(received, steps), *_exception(printed)]
    failures += _exit_code(interruption, process.returncode, took > 0.0 and count < steps)
    return End(took, process.returncode, tuple(failures))


def _exception(printed: str) -> list[str]:
    """Return the last line that a run wrote to stderr, where that has an exception."""
    if "Traceback" in printed or "Exception" in printed:
        return [printed.strip().splitlines()[-1]]
    return []


def _kind_of(interruption: Interruption | None) -> RunKind:
    """Return the kind of run; it is endless if the signal counts from its first state."""
    kind = RUN_KINDS[interruption.way if interruption else "realtime"]
    return kind._replace(duration=_ENDLESS) if interruption and interruption.begun else kind


def _wait_for_pipes(
    process: subprocess.Popen[str], mark: str, timeout: float
) -> tuple[str, list[str]]:
    """Return what a run wrote to stderr, once it and all that write to its pipes have ended.

    After `timeout` [s] those that outlive it are killed, and returned as failures.
    """
    try:
        return process.communicate(timeout=timeout)[1], []
    except subprocess.TimeoutExpired:
        outliving = orphans(mark)
        process.kill()
        return process.communicate()[1], outliving


def _exit_code(interruption: Interruption | None, code: int, cut: bool) -> list[str]:
    """Return a failure about an exit code that does not match whether the run was cut short."""
    # the start script's own end
    in_shell = (
        interruption is not None and interruption.at < _EARLY and code == -interruption.number
    )
    right = code == 1 if cut else code in ((0,) if interruption is None else (0, 1))
    return [] if right or in_shell else [f"exit code {code}"]


def _count_steps(received: Messages, steps: int) -> int:
    """Return the number of received steps.

    The last effort of a run that is cut short belongs to none.
    """
    stamps = len({effort.stamp for effort in received["e"]})
    return stamps if stamps == steps else max(stamps - 1, 0)


def _crane() -> str:
    """Return the start script of the source tree, or the installed command where there is none."""
    script = config_folder().parent / "crane"
    return str(script if script.is_file() else Path(sys.executable).with_name("crane"))


def _send_signals(
    process: subprocess.Popen[str],
    interruption: Interruption | None,
    monitored: MonitorFile,
    received: Messages,
) -> float:
    """Send the signals and wait for the end; return the time it took [s]."""
    if interruption is None:
        return 0.0
    if interruption.begun:
        _wait_for_state(process, monitored, received)
    try:
        process.wait(interruption.at)
        return 0.0
    except subprocess.TimeoutExpired:
        process.send_signal(interruption.number)
    start = time.monotonic()
    if interruption.again is not None:
        try:
            process.wait(interruption.again)
        except subprocess.TimeoutExpired:
            process.send_signal(interruption.number)
    try:
        process.wait(_EXIT_TIMEOUT)
    except subprocess.TimeoutExpired:
        process.kill()
    return time.monotonic() - start


def _wait_for_state(
    process: subprocess.Popen[str], monitored: MonitorFile, received: Messages
) -> None:
    """Wait for a run's first state, or its end."""
    limit = time.monotonic() + _START_TIMEOUT
    while process.poll() is None and not received["s"] and time.monotonic() < limit:
        time.sleep(_POLL)
        monitored.read_into(received)


def _last_effort(received: Messages, steps: int) -> list[str]:
    """Return a failure where the last effort received of a run that was cut short is not zero.

    A run that never began has none.
    """
    efforts = received["e"]
    if not received["s"] or len(efforts) == steps:
        return []
    last = efforts[-1].effort if efforts else ("none",)
    return [] if efforts and not any(map(float, last)) else [f"last effort {', '.join(last)}"]
