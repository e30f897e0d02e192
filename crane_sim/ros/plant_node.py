"""The node `plant`: the crane in lockstep with its controller, in real time, or open loop."""

import json
import os
import sys
import time
from types import SimpleNamespace

from crane_sim import load_scene
from crane_sim.ros.common import node_host
from crane_sim.ros.common.choices import (
    COMMAND_STAMPS,
    COMMAND_TIMEOUT_ACTIONS,
    RUN_MODES,
    TRANSFORM_SCOPES,
    CommandStamps,
    CommandTimeoutAction,
    RunMode,
    TransformScope,
)
from crane_sim.ros.common.command_filter import largest_efforts
from crane_sim.ros.common.messages import LIVELINESS_LEASE
from crane_sim.ros.common.node_host import QUIT, Fault, NodeHost
from crane_sim.ros.common.nodes import ENDINGS
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.common.ros2_control import urdf_with_ros2_control
from crane_sim.ros.plant import standard_services
from crane_sim.ros.plant.braking import brake_to_rest
from crane_sim.ros.plant.command_publishers import HeldCommands
from crane_sim.ros.plant.instrument_topics import camera_topic, imu_topic
from crane_sim.ros.plant.lockstep import Lockstep
from crane_sim.ros.plant.peers import peer_names
from crane_sim.ros.plant.realtime import Realtime
from crane_sim.ros.plant.run_control import RunControl
from crane_sim.ros.plant.scheduler import Scheduler
from crane_sim.ros.plant.services import offer_faults, offer_services
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.ros.plant.state_publisher import BaseOdometry, StatePublisher
from crane_sim.ros.plant.topics import PlantTopics
from crane_sim.ros.plant.transform_topics import TransformTopics, missing_package
from crane_sim.ros.plant.warm_up import warm_up
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.hardware import is_sensed
from crane_sim.simulation.plant import Plant

PARAMETERS = {
    "scene": Option("knuckle_setpoint", "scene: a name of the catalogue or a path"),
    "mode": Option(RunMode.LOCKSTEP.value, "when steps are taken", choices=RUN_MODES),
    "rate": Option(1.0, "realtime: simulated seconds per second", 1e-3, 1e6),
    "commanded": Option(
        False, "ignore the scene's own law and inputs: another node commands every period"
    ),
    "commander": Option(
        "",
        "lockstep: node in this namespace that alone may command; empty: the first one that does",
    ),
    "expected_controllers": Option(
        1, "publishers of commands to wait for before the run begins", 0, 100
    ),
    "expected_trackers": Option(
        0, "outer loops of laws, which subscribe to the states and command nothing", 0, 100
    ),
    "expected_recorders": Option(0, "recorders to wait for before the run begins", 0, 100),
    "command_timeout": Option(
        0.5,
        "realtime: time-out of commands, s of wall time, two periods at least; 0: never",
        0.0,
        3600.0,
    ),
    "on_silence": Option(
        CommandTimeoutAction.ZERO.value,
        "realtime: action at the time-out of commands: zero effort, the last one held, or brakes",
        choices=tuple(COMMAND_TIMEOUT_ACTIONS),
    ),
    "command_lease": Option(
        0.3,
        "s without a command after which another node may command; in lockstep only a standby of "
        "the same node",
        0.01,
        60.0,
    ),
    "command_stamps": Option(
        CommandStamps.STATE.value,
        "stamps of commands: that of the state answered, ROS time, or any; with ros the clock "
        "leads lockstep",
        choices=COMMAND_STAMPS,
    ),
    "largest_effort": Option(
        0.0,
        "N m or N; a command that is larger is refused; 0: far beyond what the scene can need",
        0.0,
        1e12,
    ),
    "step_timeout": Option(
        0.5, "s without a command until lockstep sends its state again", 1e-3, 3600.0
    ),
    "beside": Option(
        "",
        "lockstep: peers, the namespaces of other cranes on the same clock, with commas between "
        "them",
    ),
    "clock": Option(True, "publish /clock; of several cranes on the same clock one does"),
    "publish_tf": Option(
        TransformScope.ALL.value,
        "transforms: of all frames; of the base alone, beside a robot_state_publisher; or none",
        choices=TRANSFORM_SCOPES,
    ),
    "tf_rate": Option(
        50.0, "transforms per second of the scene, at most one per period", 1e-3, 1e6
    ),
    "frame_prefix": Option(
        "", "begins the names of all frames but world; for several cranes in one ROS domain"
    ),
    "paused": Option(
        False, "the run begins paused, until ~/set_pause or a standard service plays it"
    ),
    "resends": Option(
        10, "of one state until lockstep reports that it waits, paused, for a command", 0, 1_000_000
    ),
    "fifo_priority": Option(
        0, "SCHED_FIFO priority of the loop over steps; 0: ordinary scheduling", 0, 99
    ),
    "step_count": Option(
        1, "steps that one call of ~/step_simulation takes", 1, 100_000_000, live=True
    ),
    "reset_positions": Option(
        (), "where ~/reset_simulation puts the joints; empty: the scene's start", live=True
    ),
    "reset_velocities": Option((), "with which velocities; empty: the scene's own", live=True),
}


# s after which the graph has all nodes that were there before: announcements are 0.1 s apart
_DISCOVERY = 0.5


class PlantNode:
    """One run of a plant with its topics, services and scheduler."""

    def __init__(self, host: NodeHost, settings: SimpleNamespace) -> None:
        """Load the scene and publish the robot description; raises ValueError for a bad scene."""
        scene = load_scene(settings.scene)
        scene = scene.with_external_commands() if settings.commanded else scene
        clock_leads = _clock_leads(scene, settings)
        self._host, self._settings = host, settings
        self._discovered = time.monotonic() + _DISCOVERY
        sensed = is_sensed(scene)
        self._topics = PlantTopics(
            host.node, scene.joint_names, scene.actuated, settings.clock, sensed, host.notify
        )
        self._topics.publish_description(urdf_with_ros2_control(scene, host.node.get_namespace()))
        plant, largest = Plant(scene), largest_efforts(scene, settings.largest_effort)
        further = self._further_publishers(scene)
        held = HeldCommands(host.node, scene) if scene.sampled else None
        self._simulation = SimulationRun(
            scene, plant, self._topics, host.pipes, largest, clock_leads, further, held, host.notify
        )
        self._remark_on_missing_packages()
        warm_up(plant, braking=settings.mode == RunMode.REALTIME)  # by time-out or fault
        self._scheduler = self._make_scheduler()
        control = RunControl(host, self._simulation, self._scheduler, settings)
        offer_services(host.node, control, settings)
        offer_faults(host.node, plant)
        standard_services.offer(host.node, control, self._simulation, settings.frame_prefix)

    def run(self) -> None:
        """Wait for the peers, simulate, report; then raise Fault if the run failed."""
        host, simulation = self._host, self._simulation
        host.manage(self._settings.autostart, self._activate)
        keep_clock = simulation.publish_clock_if_due
        host.wait(self._missing, keep_clock)
        self._refuse_duplicate()
        host.report_ready()
        host.wait(lambda: "" if host.started and host.active else "the request go", keep_clock)
        if not host.stop_reason:
            self._set_priority()
            if self._settings.paused:
                simulation.pause(True, RunControl.USER)
            self._scheduler.run()
        if host.brake_reason and simulation.running and not host.stop_reason:
            brake_to_rest(host, simulation, self._scheduler, self._wall_period)
        ended = self._simulation.finished or host.stop_reason == QUIT
        error = self._simulation.failure or ("" if ended else "interrupted")
        simulation.end()
        self._report(error)
        # after the report: a subscriber that does not acknowledge delays nothing else
        self._topics.flush()
        if host.pipes.attached:
            host.wait(lambda: "the request finish", keep_clock)
        if error and host.stop_reason not in ENDINGS:
            raise Fault(error)

    def _further_publishers(self, scene: Scene) -> list[StatePublisher]:
        """Return the publishers of base and frames of this scene whose messages are installed."""
        node, settings, publishers = self._host.node, self._settings, list[StatePublisher]()
        if getattr(scene.model, "base", None) is not None:
            publishers.append(BaseOdometry(node, settings.frame_prefix))
        if scene.instruments is not None and scene.instruments.imu is not None:
            publishers.append(imu_topic(node, settings.frame_prefix, scene.instruments.imu))
        if scene.instruments is not None and scene.instruments.camera is not None:
            publishers.append(camera_topic(node, settings.frame_prefix, scene.instruments.camera))
        if settings.publish_tf != TransformScope.OFF and not missing_package(settings.publish_tf):
            publishers.append(TransformTopics(node, scene, settings))
        return publishers

    def _remark_on_missing_packages(self) -> None:
        """Say in the diagnostics what is off and why; without a supervisor also in the log."""
        reasons = {
            "transforms": missing_package(self._settings.publish_tf),
            "standard services": standard_services.missing_package(),
        }
        for subject, reason in reasons.items():
            if reason:
                self._simulation.remarks[subject] = reason
            if reason and not self._host.pipes.attached:
                self._host.node.get_logger().info(f"{subject} are {reason}")

    def _refuse_duplicate(self) -> None:
        """Raise Fault if another plant publishes these joint states: controllers would drive both.

        Another one is in the graph some announcements after this one came. A plant that was killed
        stays there until its liveliness lease ends; that is waited for.
        """
        self._host.wait(lambda: "other nodes" if time.monotonic() < self._discovered else "")
        deadline = time.monotonic() + 2 * LIVELINESS_LEASE
        self._host.wait(
            lambda: self._topics.duplicate_publisher() if time.monotonic() < deadline else ""
        )
        if line := self._topics.duplicate_publisher():
            raise Fault(
                f"{line}; possible: one plant in a namespace and ROS domain; end the other, or use "
                "another"
            )

    def _set_priority(self) -> None:
        """Give the loop over steps the real-time priority, not the middleware's threads."""
        priority = self._settings.fifo_priority
        if not priority:
            return
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except OSError as error:
            self._host.node.get_logger().warning(
                f"fifo_priority {priority}: not permitted: {error.strerror}"
            )

    @property
    def _wall_period(self) -> float:
        realtime = self._settings.mode == RunMode.REALTIME
        return self._simulation.scene.period / self._settings.rate if realtime else 0.0

    def _activate(self, active: bool) -> None:
        """Pause the run while the node is inactive."""
        if self._simulation.stamp and self._simulation.running:
            self._simulation.pause(not active, "lifecycle")
            if not self._simulation.paused:
                self._scheduler.resume()

    def _report(self, error: str) -> None:
        summary = self._simulation.summary(self._settings.mode) | self._scheduler.metrics()
        summary |= {"error": error} if error else {}
        self._host.pipes.report("done", summary=summary)
        if not self._host.pipes.attached:
            self._host.node.get_logger().info(json.dumps(summary))

    def _missing(self) -> str:
        recorders, trackers = self._settings.expected_recorders, self._settings.expected_trackers
        controllers = self._settings.expected_controllers if self._simulation.scene.sampled else 0
        if self._scheduler.commands_have_come:  # controllers that only command receive no states
            controllers -= len(
                self._scheduler.commanding_nodes() - self._topics.subscribing_nodes()
            )
        subscribers = (
            max(controllers, 0) + trackers + recorders + len(peer_names(self._settings.beside))
        )
        return self._topics.missing(subscribers, recorders) or self._scheduler.missing()

    def _make_scheduler(self) -> Scheduler:
        if self._settings.mode == RunMode.LOCKSTEP and self._simulation.scene.sampled:
            return Lockstep(self._host, self._simulation, self._settings)
        if self._settings.mode == RunMode.REALTIME:
            return Realtime(self._host, self._simulation, self._settings)
        return Scheduler(self._host, self._simulation)


def _clock_leads(scene: Scene, settings: SimpleNamespace) -> bool:
    """Return whether /clock leads the states; raises ValueError for what contradicts the scheduler.

    The error is one line.
    """
    lockstep = settings.mode == RunMode.LOCKSTEP and scene.sampled
    leads = settings.command_stamps == CommandStamps.ROS and lockstep
    beside = f"parameter beside is {settings.beside!r}"
    if peer_names(settings.beside) and not lockstep:
        raise ValueError(f"{beside}; only a crane in lockstep can have it")
    if leads and peer_names(settings.beside):
        raise ValueError(f"{beside}; cranes on one clock need command_stamps 'state'")
    if leads and not settings.clock:
        raise ValueError(
            "parameter command_stamps is 'ros'; lockstep by ROS time needs the parameter clock"
        )
    return leads


def main() -> int:
    """Run the node; see `node_host.main` for the exit code."""
    return node_host.main(
        "plant", PARAMETERS, lambda host, settings: PlantNode(host, settings).run(), managed=True
    )


if __name__ == "__main__":
    sys.exit(main())
