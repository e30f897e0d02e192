"""One run over ROS: plant, one or two laws and recorder, from start to summary; no rclpy.

Each of them is an OS process.
"""

import tempfile
import uuid
from collections.abc import Callable, Iterator
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from crane_sim.laws import outer_loop_of
from crane_sim.orchestration.desk_link import OPERATOR, Operator, desk_link
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.roles import RecorderRole, Role, RoleSpec
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain
from crane_sim.orchestration.shutdown import (
    collect_controller_summary,
    finish_recording,
    merge_summaries,
)
from crane_sim.orchestration.supervisor import READY_TIMEOUT, Callbacks, RunError, Supervisor
from crane_sim.process_signals import collect_signals

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene


class _RunSettings(NamedTuple):
    """Parameters and roles of a run."""

    namespace: str
    plant: dict[str, object]
    recorder: dict[str, object]  # empty: no recorder
    controller: bool  # ours is started
    restart: bool
    operator: Operator | None = None
    compile_time: float = 0.0


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
    command_stamps: str | None = None,
    tf: str | None = None,
    frame_prefix: str | None = None,
    namespace: str | None = None,
    beside: str | None = None,
    clock: bool = True,
    paused: bool = False,
    fifo: int | None = None,
    operator: Operator | None = None,
    compile_time: float = 0.0,
    on_progress: Callable[[int, int], object] | None = None,
    on_news: Callable[[str], object] | None = None,
    on_activated: Callable[[str, int], object] | None = None,
) -> dict[str, Any]:
    """Simulate `scene` with its nodes as OS processes and return the run's summary.

    Args:
        scene: what to simulate.
        mode: "lockstep" or "realtime".
        rate: simulated seconds per second in realtime; None: the default of the plant's parameter
            of that name.
        record: the recording to write, or None for none.
        mcap: the MCAP file to write, with the messages as they came over the wire, or None for
            none.
        live_port: serve the recording to viewers on this port of the loopback interface, too.
        domain_id: ROS domain; None picks one that is free on this machine.
        controller: the scene's own law commands; False leaves it out and waits for the user's node
            on `joint_commands`.
        wait: s without that node until the run ends; at its start at least two minutes.
        restart: replace a controller, tracker or recorder that dies, by a standby.
        on_silence: action of a plant in realtime at the time-out of commands: "zero" effort, "hold"
            the last effort, or "brake"; None: the default of the plant's parameter of that name.
        command_stamps: what stamps of commands have to be: "state", "ros" or "any"; None: the
            default of the plant's parameter of that name.
        tf: which transforms the plant publishes: "all", those of the "base", or "off"; None: the
            default of the plant's parameter `publish_tf`.
        frame_prefix: begins the names of all frames but `world`; None: no prefix.
        namespace: of the nodes; None: the kind of crane.
        beside: in lockstep, namespaces of other cranes on the same clock, with commas between them.
        clock: the plant publishes /clock; of several cranes in one domain one does.
        paused: begin paused, until resumed by a service call.
        operator: commands the crane through the node `operator`, with `controller` False, in
            realtime.
        fifo: the plant's real-time priority under SCHED_FIFO, 1 .. 99; 0 or None for none.
        compile_time: s that the caller has compiled for this run; the summary's has it, too.
        on_progress: called with (steps done, steps in all) about ten times a second.
        on_news: called with single-line messages for the terminal.
        on_activated: called with a node's name and process id when it becomes the active one of its
            role.

    Returns:
        The summary; with the key `error`, one line, when the run failed or was interrupted. No
        process is left.
    """
    progress = on_progress or _ignore
    callbacks = Callbacks(
        lambda step: progress(step, scene.steps), on_news or _ignore, on_activated or _ignore
    )
    plant: dict[str, object] = {"mode": mode, "commanded": not controller, "paused": paused}
    plant |= {"clock": clock, "commander": "controller" if controller else ""}
    optional = {"rate": rate, "fifo_priority": fifo, "on_silence": on_silence, "publish_tf": tf}
    optional |= {"command_stamps": command_stamps, "frame_prefix": frame_prefix, "beside": beside}
    plant |= {name: value for name, value in optional.items() if value is not None}
    recorder = _recorder_settings(record, mcap, live_port, operator is not None)
    is_controlled = controller and scene.sampled
    settings = _RunSettings(
        namespace or scene.crane, plant, recorder, is_controlled, restart, operator, compile_time
    )
    with (
        collect_signals() as interrupts,
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        reserve_domain(domain_id) as domain,
        ProcessGroup(node_environment(domain, Path(folder)), interrupts) as group,
    ):
        roles = _start(group, scene, Path(folder), settings)
        if not (controller or operator):
            callbacks.on_news(_describe_wait(settings.namespace, domain, wait))
        supervisor = Supervisor(group, roles, interrupts, callbacks, wait)
        return _supervise(supervisor, roles, scene, settings)


def _describe_wait(namespace: str, domain: int, wait: float) -> str:
    """Return one line on the user's node, for which a run waits `wait` [s]."""
    limit = f", {max(wait, READY_TIMEOUT):g} s at most" if isfinite(wait) else ""
    topic = f"/{namespace}/joint_commands"
    return f"the run waits for your node on {topic}, ROS domain {domain}{limit}"


def _ignore(*_: object) -> None:
    """Do nothing."""


def _recorder_settings(
    record: Path | None, mcap: Path | None, live_port: int | None, commanded: bool
) -> dict[str, object]:
    """Return the recorder's parameters, empty where nothing is recorded."""
    if record is None and mcap is None:
        return {}
    paths = {"path": record, "mcap": mcap}
    files: dict[str, object] = {
        name: str(Path(path).absolute()) if path else "" for name, path in paths.items()
    }
    return files | {
        "commanded": commanded,
        "live_port": live_port or 0,
        "recording_id": uuid.uuid4().hex[:12],
    }


def _start(group: ProcessGroup, scene: "Scene", folder: Path, settings: _RunSettings) -> list[Role]:
    scene_file = folder / "scene.yaml"
    scene.dump(scene_file)
    roles: list[Role] = []
    for name, package, parameters in _nodes(scene, str(scene_file), settings):
        spec = RoleSpec(name, f"{package}.{name}_node", settings.namespace, parameters)
        role = RecorderRole if name == "recorder" else Role
        roles.append(role(group, spec, settings.restart and name != "plant"))
    if settings.restart:
        group.preload(scene_file)
        for role in roles:
            role.start_standby()
    return roles


def _nodes(
    scene: "Scene", file: str, settings: _RunSettings
) -> Iterator[tuple[str, str, dict[str, object]]]:
    """Yield name, package and parameters of each node, the plant's first."""
    scene_only: dict[str, object] = {"scene": file}
    common = scene_only | {"expected_recorders": int(bool(settings.recorder))}
    has_tracker = settings.controller and outer_loop_of(scene.law) is not None
    yield (
        "plant",
        "crane_sim.ros",
        common | settings.plant | {"expected_trackers": int(has_tracker)},
    )
    if settings.controller:
        yield "controller", "crane_control.nodes", common | {"mode": settings.plant["mode"]}
    if settings.operator:
        yield OPERATOR, "crane_control.nodes", common | dict(settings.operator.parameters)
    if has_tracker:
        recorders = {"expected_recorders": int(bool(settings.recorder.get("mcap")))}
        yield "tracker", "crane_control.nodes", scene_only | recorders
    if settings.recorder:
        yield "recorder", "crane_sim.ros", scene_only | settings.recorder


def _supervise(
    supervisor: Supervisor, roles: list[Role], scene: "Scene", settings: _RunSettings
) -> dict[str, Any]:
    plant, error = supervisor.plant, ""
    try:
        supervisor.wait_ready()
        if settings.operator:
            settings.operator.begin(desk_link(roles))
        supervisor.run()
    except RunError as failure:
        error = str(failure)
        supervisor.stop_early()
    head: dict[str, Any] = {
        "scene": scene.name,
        "law": scene.law_name,
        "mode": settings.plant["mode"],
    }
    head |= {"seed": scene.seed}
    summary = merge_summaries(plant.summary or head, collect_controller_summary(supervisor, roles))
    summary |= {"error": error} if error else {}
    summary["compile_time"] = summary.get("compile_time", 0.0) + settings.compile_time
    if settings.restart:
        summary |= {"restarts": {role.name: role.restarts for role in roles[1:]}}
    recorder = next((role for role in roles if isinstance(role, RecorderRole)), None)
    summary = finish_recording(supervisor, recorder, summary)
    summary.setdefault("steps", plant.step)
    return summary
