"""SIGKILL of controller and recorder in turn, at random instants of a real-time run.

The run is one long one; the command is `crane soak kill`.
"""

import os
import random
import signal
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from crane_bench.soak.leftovers import steps_in
from crane_bench.soak.memory import resident
from crane_bench.soak.metrics import Metric, at_most, equal, quantiles
from crane_bench.soak.monitor import Messages, Received, monitor, wait_for_discovery
from crane_bench.soak.realtime import run_sleep_process
from crane_sim import load_scene
from crane_sim.orchestration import run
from crane_sim.orchestration.ros_environment import reserve_domain
from crane_sim.scenes.scene import Scene

VICTIMS = ("controller", "recorder")
# s within which control is back behind half of the kills, and behind all of them
MEDIAN_LIMIT, MAX_LIMIT = 0.5, 1.0
_GAP = (0.5, 2.5)  # s between two kills, uniform
_POLL = 0.01  # s between two polls for a process to kill
_BEFORE, _BEHIND = 1.0, 5.0  # s of the run without kills
_MAX_GROWTH = 5.0  # MB that the plant may grow
_CALL = 20.0  # ms that a call may take
_BARE = 1e-3  # s, period of a loop beside the run that measures stalls of the machine
# ms; a plant that waited for a dead node would stand still for the lease of a commander, at least
_STALL = 100.0
_SECOND = 1e9  # ns


class Kill(NamedTuple):
    """A kill; instants in ns of the system's clock."""

    victim: str
    at: int
    filled: int  # when the role was filled again, 0: not within the run


class _Killer(threading.Thread):
    """Kills the processes that fill the roles, in turn.

    Attributes:
        plant_memory: the plant's resident memory [MB], after each kill.
    """

    def __init__(self, gaps: list[float]) -> None:
        super().__init__(daemon=True)
        self.plant_memory: list[float] = []
        self._gaps, self._pids, self._filled = gaps, dict[str, int](), list[tuple[str, int]]()
        self._all_filled, self._killed = threading.Event(), list[tuple[str, int]]()

    def on_activated(self, name: str, pid: int) -> None:
        """Record the new process of a role."""
        wait_for_discovery(name, pid)
        self._pids[name] = pid
        self._filled.append((name, time.time_ns()))
        if name == VICTIMS[-1]:
            self._all_filled.set()

    def run(self) -> None:
        self._all_filled.wait()
        time.sleep(_BEFORE)
        for i, gap in enumerate(self._gaps):
            time.sleep(gap)
            victim = VICTIMS[i % len(VICTIMS)]
            while not (pid := self._pids.pop(victim, 0)):
                time.sleep(_POLL)  # the role is not filled yet
            instant = time.time_ns()
            with suppress(ProcessLookupError):  # it has just ended by itself, with the run: no kill
                os.kill(pid, signal.SIGKILL)
                self._killed.append((victim, instant))
            if (memory := resident(self._pids["plant"])) is not None:
                self.plant_memory.append(memory)

    def kills(self) -> list[Kill]:
        """Return the kills."""
        return [
            Kill(victim, at, next((t for name, t in self._filled if name == victim and t > at), 0))
            for victim, at in self._killed
        ]


def soak_kills(
    count: int = 200, scene: str = "knuckle_setpoint", seed: int = 0
) -> tuple[list[Metric], dict[str, Any]]:
    """Kill `count` times; return (metrics, data)."""
    draw = random.Random(seed)
    gaps = [draw.uniform(*_GAP) for _ in range(count)]
    loaded = load_scene(scene, {"duration": round(_BEFORE + sum(gaps) + _BEHIND)})
    killer, shared = _Killer(gaps), set(os.listdir("/dev/shm"))
    summary, received, recorded, stall = _run_with_kills(loaded, killer)
    files = set(os.listdir("/dev/shm")) - shared
    kills = killer.kills()
    back = [back_after(kill, received) for kill in kills if kill.victim == "controller"]
    growth = _growth(killer.plant_memory)
    metrics = [
        equal("kills", len(kills), count),
        *_survival(loaded.steps, summary, received, recorded),
        *_control(back),
        *_publishing(summary, stall),
        _gap(loaded.period_ns, received["s"]),
        equal("files more in /dev/shm", len(files), 0),
        at_most("growth of the plant's memory", growth, _MAX_GROWTH, "MB"),
    ]
    return metrics, {"summary": summary, "back_s": back, "plant_MB": killer.plant_memory}


def _run_with_kills(
    scene: Scene, killer: _Killer
) -> tuple[dict[str, Any], Messages, list[int], float]:
    """Return (summary, messages, recorded steps, longest stall [ms] of a bare loop beside it)."""
    with (
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        reserve_domain() as domain,
        monitor(scene, domain) as monitored,
        ThreadPoolExecutor(1) as pool,
    ):
        bare = pool.submit(run_sleep_process, _BARE, round(scene.duration / _BARE))
        killer.start()
        options = {"mode": "realtime", "domain_id": domain, "restart": True}
        file = Path(folder, "soak.rrd")
        summary = run(scene, record=file, on_activated=killer.on_activated, **options)
        received: Messages = {}
        monitored.read_to_end(received, lambda messages: len(messages["e"]) >= scene.steps)
        recorded = steps_in(Path(summary["recording"]))
        return summary, received, recorded, bare.result()["lateness_us"]["max"] * 1e-3


def back_after(kill: Kill, received: Messages) -> float:
    """Return the time [s] until the plant applied a command of the next controller; inf: never."""
    commands = {h.effort for h in received["c"] if kill.filled and h.sent >= kill.filled}
    applied = (h.sent for h in received["e"] if h.sent >= kill.filled and h.effort in commands)
    return (next(applied, float("inf")) - kill.at) / _SECOND


def _control(back: list[float]) -> list[Metric]:
    times = quantiles(back)
    return [
        at_most("control back, median", times["p50"], MEDIAN_LIMIT, "s"),
        Metric("control back, 99 %", times["p99"], "s"),
        at_most("control back, longest", times["max"], MAX_LIMIT, "s"),
    ]


def _survival(
    steps: int, summary: dict[str, Any], received: Messages, recorded: list[int]
) -> list[Metric]:
    stamps, planned = [h.stamp for h in received["e"]], range(1, steps + 1)
    return [
        Metric(
            "error of the run",
            summary.get("error", "none"),
            requirement="none",
            passed="error" not in summary,
        ),
        equal("steps, the plant's own count", summary["steps"], steps),
        equal("steps, heard by an independent subscriber", len(set(stamps)), steps),
        equal("steps in the recording, read back", len(set(recorded) & set(planned)), steps),
        Metric("late steps", summary.get("deadline_misses")),
        Metric(
            "replaced", ", ".join(f"{name} {count}" for name, count in summary["restarts"].items())
        ),
    ]


def _publishing(summary: dict[str, Any], stall: float) -> list[Metric]:
    """Return the durations of publish calls.

    They may be as long as the longest stall [ms] of a bare loop.
    """
    *usual, (name, longest) = ((name, value / 1e3) for name, value in summary["publish_us"].items())
    requirement = f"at most {_CALL:g} ms, or that stall"
    return [
        *(Metric(f"publish call, {name}", value, "ms") for name, value in usual),
        Metric("longest stall of a loop that only sleeps, beside it", stall, "ms"),
        Metric(f"publish call, {name}", longest, "ms", requirement, longest <= max(_CALL, stall)),
    ]


def _growth(memory: list[float]) -> float:
    return memory[-1] - memory[0] if memory else float("nan")


def _gap(period: int, states: list[Received]) -> Metric:
    """Return the longest time between two states, less the period [ns]."""
    gap = max(
        (b.sent - a.sent - period for a, b in zip(states, states[1:], strict=False)), default=0
    )
    return at_most("longest gap between two states above the period", gap / 1e6, _STALL, "ms")
