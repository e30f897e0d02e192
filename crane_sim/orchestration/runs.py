"""One run over ROS: plant, law (one or two) and recorder as OS processes, from start to summary. No rclpy here."""

import tempfile
import uuid
from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from crane_sim.laws import slow_half
from crane_sim.orchestration.desk_link import OPERATOR, Operator, desk_link
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.roles import RecorderRole, Role, RoleSpec
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain
from crane_sim.orchestration.shutdown import collect_controller_summary, finish_recording
from crane_sim.orchestration.supervisor import READY, Callbacks, RunError, Supervisor
from crane_sim.process_signals import collect_signals

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene


class _RunSettings(NamedTuple):
    """Parameters and roles of a run."""

    plant: dict[str, object]
    recorder: dict[str, object]  # empty: no recorder
    controller: bool  # ours is started
    restart: bool
    operator: Operator | None = None


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
    fifo: int | None = None,
    operator: Operator | None = None,
    on_progress: Callable[[int, int], object] | None = None,
    on_news: Callable[[str], object] | None = None,
    on_activated: Callable[[str, int], object] | None = None,
) -> dict[str, Any]:
    """Simulate `scene` with its nodes as OS processes and return the run's summary.

    Args:
        scene: what to simulate.
        mode: "lockstep" or "realtime".
        rate: simulated seconds per second in realtime; None: the default of the plant's parameter of that name.
        record: the recording to write, or None for none.
        mcap: the MCAP file to write, with the messages as they came over the wire, or None for none.
        live_port: serve the recording to viewers on this port of the loopback interface, too.
        domain_id: ROS domain; None picks one that is free on this machine.
        controller: the scene's own law commands; False leaves it out and waits for the user's node on `joint_commands`.
        wait: s without that node until the run ends; at its start at least two minutes.
        restart: replace a controller, tracker or recorder that dies, by a standby.
        on_silence: action of a plant in realtime at the time-out of commands: "zero" effort, "hold" the last effort, or
            "brake"; None: the default of the plant's parameter of that name.
        command_stamps: what stamps of commands have to be: "state", "ros" or "any"; None: the default of the plant's
            parameter of that name.
        tf: which transforms the plant publishes: "all", those of the "base", or "off"; None: the default of the plant's
            parameter `publish_tf`.
        operator: commands the crane through the node `operator`, with `controller` False, in realtime.
        fifo: the plant's real-time priority under SCHED_FIFO, 1 .. 99; 0 or None for none.
        on_progress: called with (steps done, steps in all) about ten times a second.
        on_news: called with single-line messages for the terminal.
        on_activated: called with a node's name and process id when it becomes the active one of its role.

    Returns:
        The summary; with the key `error`, one line, when the run failed or was interrupted. No process is left.
    """
    progress = on_progress or _ignore
    callbacks = Callbacks(lambda step: progress(step, scene.steps), on_news or _ignore, on_activated or _ignore)
    plant: dict[str, object] = {"mode": mode, "commanded": not controller}
    optional = {"rate": rate, "on_silence": on_silence, "command_stamps": command_stamps, "fifo_priority": fifo}
    optional |= {"publish_tf": tf}
    plant |= {name: value for name, value in optional.items() if value is not None}
    recorder = _recorder_settings(record, mcap, live_port)
    if operator and recorder:
        recorder["commanded"] = True
    settings = _RunSettings(plant, recorder, controller and scene.sampled, restart, operator)
    with (
        collect_signals() as interrupts,
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        reserve_domain(domain_id) as domain,
        ProcessGroup(node_environment(domain, Path(folder)), interrupts) as group,
    ):
        roles = _start(group, scene, Path(folder), settings)
        if not (controller or operator):
            limit = f", {max(wait, READY):g} s at most" if isfinite(wait) else ""
            callbacks.on_news(
                f"the run waits for your node on /{scene.crane}/joint_commands, ROS domain {domain}{limit}"
            )
        return _supervise(Supervisor(group, roles, interrupts, callbacks, wait), roles, scene, settings)


def _ignore(*_: object) -> None:
    """Do nothing."""


def _recorder_settings(record: Path | None, mcap: Path | None, live_port: int | None) -> dict[str, object]:
    """Return the recorder's parameters, empty where nothing is recorded."""
    if record is None and mcap is None:
        return {}
    paths = {"path": record, "mcap": mcap}
    files: dict[str, object] = {name: str(Path(path).absolute()) if path else "" for name, path in paths.items()}
    return files | {"live_port": live_port or 0, "recording_id": uuid.uuid4().hex[:12]}


def _start(group: ProcessGroup, scene: "Scene", folder: Path, settings: _RunSettings) -> list[Role]:
    scene_file = folder / "scene.yaml"
    scene.dump(scene_file)
    scene_only: dict[str, object] = {"scene": str(scene_file)}
    common = scene_only | {"expected_recorders": int(bool(settings.recorder))}
    has_tracker = settings.controller and slow_half(scene.law) is not None

    def spec(name: str, package: str, parameters: dict[str, object]) -> RoleSpec:
        return RoleSpec(name, f"{package}.{name}_node", scene.crane, parameters)

    plant = common | settings.plant | {"expected_trackers": int(has_tracker)}
    roles = [Role(group, spec("plant", "crane_sim.ros", plant))]
    if settings.controller:
        controller = common | {"mode": settings.plant["mode"]}
        roles.append(Role(group, spec("controller", "crane_control.nodes", controller), settings.restart))
    if settings.operator:
        operator = common | dict(settings.operator.parameters)
        roles.append(Role(group, spec(OPERATOR, "crane_control.nodes", operator), settings.restart))
    if has_tracker:
        tracker = scene_only | {"expected_recorders": int(bool(settings.recorder.get("mcap")))}
        roles.append(Role(group, spec("tracker", "crane_control.nodes", tracker), settings.restart))
    if settings.recorder:
        recorder = scene_only | settings.recorder
        roles.append(RecorderRole(group, spec("recorder", "crane_sim.ros", recorder), settings.restart))
    if settings.restart:
        group.preload(scene_file)
        for role in roles:
            role.start_standby()
    return roles


def _supervise(supervisor: Supervisor, roles: list[Role], scene: "Scene", settings: _RunSettings) -> dict[str, Any]:
    plant, error = supervisor.plant, ""
    try:
        supervisor.wait_ready()
        if settings.operator:
            settings.operator.begin(desk_link(roles))
        supervisor.run()
    except RunError as failure:
        error = str(failure)
        supervisor.stop_early()
    head: dict[str, Any] = {"scene": scene.name, "law": scene.law_name, "mode": settings.plant["mode"]}
    head |= {"seed": scene.seed}
    summary = (
        (plant.summary or head) | collect_controller_summary(supervisor, roles) | ({"error": error} if error else {})
    )
    if settings.restart:
        summary |= {"restarts": {role.name: role.restarts for role in roles[1:]}}
    recorder = next((role for role in roles if isinstance(role, RecorderRole)), None)
    summary = finish_recording(supervisor, recorder, summary)
    summary.setdefault("steps", plant.step)
    return summary
