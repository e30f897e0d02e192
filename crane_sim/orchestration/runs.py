"""One run over ROS: plant, law (one or two) and recorder as OS processes, from start to summary. No rclpy here."""

import tempfile
import uuid
from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from crane_sim.laws import slow_half
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.roles import RecorderRole, Role, RoleSpec
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain
from crane_sim.orchestration.shutdown import collect_controller_summary, finish_recording
from crane_sim.orchestration.supervisor import READY, Callbacks, RunError, Supervisor
from crane_sim.process_signals import collect_signals

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene


class _RunSettings(NamedTuple):
    """What is asked of the nodes of a run."""

    plant: dict[str, object]
    recorder: dict[str, object]  # empty: nobody records
    controller: bool
    replaced: bool


def run(
    scene: "Scene",
    *,
    mode: str = "lockstep",
    rate: float | None = None,
    record: Path | None,
    mcap: Path | None = None,
    live_port: int | None = None,
    domain_id: int | None = None,
    controller: bool = True,
    wait: float = 120.0,
    restart: bool = False,
    on_silence: str | None = None,
    fifo: int | None = None,
    on_progress: Callable[[int, int], object] | None = None,
    on_news: Callable[[str], object] | None = None,
    on_filled: Callable[[str, int], object] | None = None,
) -> dict[str, Any]:
    """Simulate `scene` with its nodes as OS processes and return the run's summary.

    Args:
        scene: what to simulate.
        mode: "lockstep" or "realtime".
        rate: simulated seconds per second in realtime; None: as the plant's parameter of that name says.
        record: the recording to write, or None for none.
        mcap: the MCAP file to write, with the messages as they came over the wire, or None for none.
        live_port: serve the recording to viewers on this port of the loopback interface, too.
        domain_id: ROS domain; None picks one that is free on this machine.
        controller: the scene's own law commands; False leaves it out and waits for the user's node on `joint_commands`.
        wait: s without that node until the run ends; at its start at least two minutes.
        restart: replace a controller, tracker or recorder that dies, by one that stands by.
        on_silence: what a plant in realtime does when commands stay away: "zero" effort, "hold" the last, or "brake";
            None: as the plant's parameter of that name says.
        fifo: the plant's real-time priority under SCHED_FIFO, 1 .. 99; 0 or None for none.
        on_progress: called with (steps done, steps in all) about ten times a second.
        on_news: called with one line on whatever a person at the terminal should know.
        on_filled: called with a node's name and process id when it takes its place in the run.

    Returns:
        The summary; with the key `error`, one line, when the run failed or was interrupted. No process is left.
    """
    progress, nobody = on_progress or _ignore, _ignore
    telling = Callbacks(lambda step: progress(step, scene.steps), on_news or nobody, on_filled or nobody)
    settings: dict[str, object] = {"mode": mode, "commanded": not controller}
    chosen = {"rate": rate, "on_silence": on_silence, "fifo_priority": fifo}
    settings |= {name: value for name, value in chosen.items() if value is not None}
    wishes = _RunSettings(settings, _recorder_settings(record, mcap, live_port), controller and scene.sampled, restart)
    with (
        collect_signals() as interrupts,
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        reserve_domain(domain_id) as domain,
        ProcessGroup(node_environment(domain, Path(folder)), interrupts) as crew,
    ):
        posts = _start(crew, scene, Path(folder), wishes)
        if not controller:
            limit = f", {max(wait, READY):g} s at most" if isfinite(wait) else ""
            telling.news(f"the run waits for your node on /{scene.crane}/joint_commands, ROS domain {domain}{limit}")
        return _supervise(Supervisor(crew, posts, interrupts, telling, wait), posts, scene, wishes)


def _ignore(*_: object) -> None:
    """Take note of nothing."""


def _recorder_settings(record: Path | None, mcap: Path | None, live_port: int | None) -> dict[str, object]:
    """Return the recorder's parameters, none at all where it has nothing to do."""
    if record is None and mcap is None:
        return {}
    paths = {"path": record, "mcap": mcap}
    files: dict[str, object] = {name: str(Path(path).absolute()) if path else "" for name, path in paths.items()}
    return files | {"live_port": live_port or 0, "recording_id": uuid.uuid4().hex[:12]}


def _start(crew: ProcessGroup, scene: "Scene", folder: Path, wishes: _RunSettings) -> list[Role]:
    scene_file = folder / "scene.yaml"
    scene.dump(scene_file)
    if wishes.replaced:
        crew.prepare_forks(scene_file)
    file: dict[str, object] = {"scene": str(scene_file)}
    common = file | {"expected_recorders": int(bool(wishes.recorder))}
    split = wishes.controller and slow_half(scene.law) is not None

    def place(name: str, package: str, settings: dict[str, object]) -> RoleSpec:
        return RoleSpec(name, f"{package}.{name}_node", scene.crane, settings)

    posts = [Role(crew, place("plant", "crane_sim.ros", common | wishes.plant | {"expected_trackers": int(split)}))]
    if wishes.controller:
        answering = common | {"mode": wishes.plant["mode"]}
        posts.append(Role(crew, place("controller", "crane_control.nodes", answering), wishes.replaced))
    if split:
        heard = file | {"expected_recorders": int(bool(wishes.recorder.get("mcap")))}
        posts.append(Role(crew, place("tracker", "crane_control.nodes", heard), wishes.replaced))
    if wishes.recorder:
        recorder = place("recorder", "crane_sim.ros", file | wishes.recorder)
        posts.append(RecorderRole(crew, recorder, wishes.replaced))
    return posts


def _supervise(conductor: Supervisor, posts: list[Role], scene: "Scene", wishes: _RunSettings) -> dict[str, Any]:
    plant, error = conductor.plant, ""
    try:
        conductor.wait_ready()
        conductor.play()
    except RunError as failure:
        error = str(failure)
        conductor.stop_early()
    head: dict[str, Any] = {"scene": scene.name, "law": scene.law_name, "mode": wishes.plant["mode"]}
    head |= {"seed": scene.seed}
    summary = (
        (plant.summary or head) | collect_controller_summary(conductor, posts) | ({"error": error} if error else {})
    )
    if wishes.replaced:
        summary |= {"restarts": {post.name: post.restarts for post in posts[1:]}}
    recorder = next((post for post in posts if isinstance(post, RecorderRole)), None)
    whole = finish_recording(conductor, recorder, summary)
    whole.setdefault("steps", plant.step)
    return whole
