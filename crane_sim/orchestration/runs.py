"""One run over ROS: plant, law (one or two) and recorder as OS processes, from start to summary. No rclpy here."""

import json
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crane_sim.laws import slow_half
from crane_sim.orchestration.children import Child, Crew, environment, reserved_domain

if TYPE_CHECKING:
    from crane_sim.scene import Scene

_READY = 120.0  # s of silence allowed while the nodes compile and meet
_SILENCE = 60.0  # s; a running plant reports ten times a second
_WIND_UP = 10.0  # s for the plant to report after an early end
_WRITE = 120.0  # s of silence allowed to the recorder while it finishes the file


class _RunError(RuntimeError):
    """The run cannot go on; one line."""


class _Watch:
    """Waits for the crew to get somewhere, and gives up when a child fails, is silent, or the user interrupts."""

    def __init__(self, crew: Crew, interrupts: list[int], on_heard: Callable[[], None]) -> None:
        self._crew, self._interrupts, self._on_heard = crew, interrupts, on_heard

    def until(self, done: Callable[[], bool], silence: float, what: str) -> None:
        deadline = time.monotonic() + silence
        while not done():
            if self._interrupts:
                raise _RunError("interrupted")
            if self._crew.listen(0.1):
                self._on_heard()
                deadline = time.monotonic() + silence
            if not done():
                self._look_for_faults()
            if time.monotonic() > deadline:
                raise _RunError(f"{what}: nothing heard for {silence:g} s")

    def _look_for_faults(self) -> None:
        for child in self._crew.children:
            if child.fault:
                raise _RunError(f"{child.name}: {child.fault}")


def run(
    scene: "Scene",
    *,
    mode: str = "lockstep",
    rate: float = 1.0,
    record: Path | None,
    mcap: Path | None = None,
    live_port: int | None = None,
    domain_id: int | None = None,
    controller: bool = True,
    on_progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Simulate `scene` with its nodes as OS processes and return the run's summary.

    Args:
        scene: what to simulate.
        mode: "lockstep" or "realtime".
        rate: simulated seconds per second in realtime.
        record: the recording to write, or None for none.
        mcap: the MCAP file to write, with the messages as they came over the wire, or None for none.
        live_port: serve the recording to viewers on this port of the loopback interface, too.
        domain_id: ROS domain; None picks one that is free on this machine.
        controller: the scene's own law commands; False leaves it out and waits for the user's node on `joint_commands`.
        on_progress: called with (steps done, steps in all) about ten times a second.

    Returns:
        The summary; with the key `error`, one line, when the run failed or was interrupted. No process is left.
    """
    with (
        _caught_signals() as interrupts,
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        reserved_domain(domain_id) as domain,
        Crew(environment(domain, Path(folder))) as crew,
    ):
        scene_file = Path(folder, "scene.yaml")
        scene.dump(scene_file)
        settings = {"mode": mode, "rate": rate, "commanded": not controller}
        wanted = _recorder_settings(record, mcap, live_port)
        _start(crew, scene, scene_file, settings, wanted, controller and scene.sampled)
        return _conduct(crew, scene, mode, wanted, interrupts, on_progress)


def _recorder_settings(record: Path | None, mcap: Path | None, live_port: int | None) -> dict[str, object]:
    """Return the recorder's parameters, none at all where it has nothing to do."""
    if record is None and mcap is None:
        return {}
    paths = {"path": record, "mcap": mcap}
    files: dict[str, object] = {name: str(Path(path).absolute()) if path else "" for name, path in paths.items()}
    return files | {"live_port": live_port or 0}


def _start(
    crew: Crew,
    scene: "Scene",
    scene_file: Path,
    settings: dict[str, object],
    wanted: dict[str, object],
    controller: bool,
) -> None:
    file = {"scene": str(scene_file)}
    common = file | {"expected_recorders": int(bool(wanted))}
    split = controller and slow_half(scene.law) is not None
    crew.start("plant", "crane_sim.ros.plant_node", scene.crane, common | settings | {"expected_trackers": int(split)})
    if controller:
        crew.start("controller", "crane_control.controller_node", scene.crane, common | {"mode": settings["mode"]})
    if split:
        heard = file | {"expected_recorders": int(bool(wanted.get("mcap")))}
        crew.start("tracker", "crane_control.tracker_node", scene.crane, heard)
    if wanted:
        crew.start("recorder", "crane_sim.ros.recorder_node", scene.crane, file | wanted)


def _conduct(
    crew: Crew,
    scene: "Scene",
    mode: str,
    wanted: dict[str, object],
    interrupts: list[int],
    on_progress: Callable[[int, int], None] | None,
) -> dict[str, Any]:
    plant = crew.children[0]
    watch = _Watch(crew, interrupts, lambda: on_progress(plant.step, scene.steps) if on_progress else None)
    error = ""
    try:
        watch.until(lambda: all(child.ready for child in crew.children), _READY, "waiting for the nodes to meet")
        plant.order("go")
        watch.until(lambda: plant.summary is not None, _SILENCE, "waiting for the plant")
    except _RunError as failure:
        error = str(failure)
        plant.order("finish")
        _hear_out(crew, plant, _WIND_UP)
    head = {"scene": scene.name, "law": scene.law_name, "mode": mode, "seed": scene.seed, "steps": plant.step}
    summary = (plant.summary or head) | _told(crew) | ({"error": error} if error else {})
    return _recorded(crew, summary, wanted)


def _told(crew: Crew) -> dict[str, Any]:
    """Let the law's processes come to their end; return what they add to the summary."""
    told: dict[str, Any] = {}
    for child in [child for child in crew.children if child.name in ("controller", "tracker")]:
        child.order("finish")
        _hear_out(crew, child, _WIND_UP)
        told |= child.summary or {}
    return told


def _recorded(crew: Crew, summary: dict[str, Any], wanted: dict[str, object]) -> dict[str, Any]:
    """Let the recorder finish its files with the summary, and add what it says to the summary."""
    nothing = {"recording": None, "recorded_steps": 0, "lost_steps": 0}
    if not wanted:
        return summary | nothing
    recorder = crew.children[-1]
    recorder.order(f"finish {json.dumps(summary)}")
    _hear_out(crew, recorder, _WRITE)
    merged = summary | nothing | (recorder.summary or {})
    if error := summary.get("error", merged.get("error")):  # what the plant says comes first
        return merged | {"error": error}
    if recorder.summary is None:
        return merged | {"error": f"recorder: {recorder.fault or 'it did not finish the recording'}"}
    if wanted["path"] and (merged["lost_steps"] or merged["recorded_steps"] != merged["steps"]):
        counts = f"{merged['recorded_steps']} of {merged['steps']} steps"
        return merged | {"error": f"recorder: the recording is incomplete, it has {counts}"}
    return merged


def _hear_out(crew: Crew, child: Child, silence: float) -> None:
    """Listen until the child is done or gone, whatever the others do."""
    deadline = time.monotonic() + silence
    while child.summary is None and not child.gone and time.monotonic() < deadline:
        crew.listen(0.1)


@contextmanager
def _caught_signals() -> Iterator[list[int]]:
    """Yield a list that SIGINT and SIGTERM are put into while the block runs."""
    caught: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield caught  # only the main thread may have handlers
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda n, _: caught.append(n)) for number in numbers]
    try:
        yield caught
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
