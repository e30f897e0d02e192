"""The node `plant`: simulates the crane in lockstep with its controller, in real time, or open loop."""

import json
import os
import sys
from types import SimpleNamespace

from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.ros.common import node_host
from crane_sim.ros.common.command_filter import largest_efforts
from crane_sim.ros.common.lifecycle import ENDINGS
from crane_sim.ros.common.node_host import Fault, NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.plant.braking import brake_to_rest
from crane_sim.ros.plant.lockstep import Lockstep
from crane_sim.ros.plant.realtime import Realtime
from crane_sim.ros.plant.scheduler import OpenLoop, StepScheduler
from crane_sim.ros.plant.services import FaultServices, PlantServices
from crane_sim.ros.plant.simulation_run import SimulationRun
from crane_sim.ros.plant.topics import PlantTopics
from crane_sim.ros.plant.warm_up import warm_up
from crane_sim.ros.plant.watchdog import COMMAND_TIMEOUT_ACTIONS
from crane_sim.simulation.plant import Plant

PARAMETERS = {
    "scene": Option("knuckle_setpoint", "scene: a name of the catalogue or a path"),
    "mode": Option("lockstep", "when steps are taken", choices=("lockstep", "realtime")),
    "rate": Option(1.0, "realtime: simulated seconds per second", 1e-3, 1e6),
    "commanded": Option(False, "leave the scene's own law and inputs out: another node commands every period"),
    "expected_controllers": Option(1, "publishers of commands to wait for before the run begins", 0, 100),
    "expected_trackers": Option(0, "slow halves of laws, which hear the states and command nothing", 0, 100),
    "expected_recorders": Option(0, "recorders to wait for before the run begins", 0, 100),
    "command_timeout": Option(
        0.5,
        "s of wall time, two periods at least, without a command until realtime does as on_silence says; 0: never",
        0.0,
        3600.0,
    ),
    "on_silence": Option(
        "zero",
        "realtime, nobody commands: zero effort, the last one held, or brakes",
        choices=tuple(COMMAND_TIMEOUT_ACTIONS),
    ),
    "command_lease": Option(
        0.3, "s of silence after which somebody else may command; in lockstep only if somebody seems dead", 0.01, 60.0
    ),
    "largest_effort": Option(
        0.0, "N m or N; a command that is larger is refused; 0: far beyond what the scene can need", 0.0, 1e12
    ),
    "step_timeout": Option(0.5, "s without a command until lockstep sends its state again", 1e-3, 3600.0),
    "beside": Option("", "lockstep: namespaces of cranes on the same clock, with commas between them"),
    "clock": Option(True, "publish /clock; of several cranes on the same clock one does"),
    "resends": Option(10, "of one state until lockstep says that it waits, paused, for a command", 0, 1_000_000),
    "fifo_priority": Option(0, "SCHED_FIFO priority of the loop over steps; 0: ordinary scheduling", 0, 99),
    "step_count": Option(1, "steps that one call of ~/step_simulation takes", 1, 100_000_000, live=True),
    "reset_positions": Option((), "where ~/reset_simulation puts the joints; empty: the scene's start", live=True),
    "reset_velocities": Option((), "with which velocities; empty: the scene's own", live=True),
}


class PlantNode:
    """Puts plant, topics and pace together and takes them through one run."""

    def __init__(self, host: NodeHost, settings: SimpleNamespace) -> None:
        """Load the scene and publish the robot description; raises ValueError for a bad scene."""
        scene = load_scene(settings.scene)
        scene = scene.commanded() if settings.commanded else scene
        self._host, self._settings = host, settings
        self._topics = PlantTopics(host.node, scene.joint_names, scene.actuated, settings.clock)
        self._topics.publish_description(urdf(scene))
        plant, largest = Plant(scene), largest_efforts(scene, settings.largest_effort)
        self._stepper = SimulationRun(scene, plant, self._topics, host.pipes, largest)
        warm_up(plant, braking=settings.mode == "realtime")  # on silence, or when nobody will command any more
        self._pace = self._chosen_pace()
        self._services = PlantServices(host, self._stepper, self._pace, settings)
        self._faults = FaultServices(host.node, self._stepper.plant)

    def run(self) -> None:
        """Wait for the peers, simulate, report; raises Fault after the report when the run failed."""
        host, stepper = self._host, self._stepper
        host.manage(self._settings.autostart, self._activate)
        host.wait(self._missing, stepper.publish_clock_if_due)
        host.pipes.report("ready")
        host.wait(lambda: "" if host.started and host.active else "the word to go", stepper.publish_clock_if_due)
        if not host.stopping:
            self._prioritise()
            self._pace.run()
        if host.brake and stepper.running and not host.stopping:
            brake_to_rest(host, stepper, self._pace, self._wall_period)
        error = self._stepper.fault or ("" if self._stepper.finished else "interrupted")
        stepper.end()
        self._report(error)
        self._topics.flush()  # behind the report: a subscriber that stands still delays nobody else
        if host.pipes.attached:
            host.wait(lambda: "the word to finish", stepper.publish_clock_if_due)
        if error and host.stopping not in ENDINGS:
            raise Fault(error)

    def _prioritise(self) -> None:
        """Let the loop over steps, not the middleware's threads, go before all ordinary processes if that is wished."""
        priority = self._settings.fifo_priority
        if not priority:
            return
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except OSError as error:
            self._host.node.get_logger().warning(f"fifo_priority {priority}: not permitted: {error.strerror}")

    @property
    def _wall_period(self) -> float:
        realtime = self._settings.mode == "realtime"
        return self._stepper.scene.period / self._settings.rate if realtime else 0.0

    def _activate(self, active: bool) -> None:
        """Pause the run while the node is inactive."""
        if self._stepper.stamp and self._stepper.running:
            self._stepper.pause(not active, "lifecycle")
            if not self._stepper.paused:
                self._pace.go_on()

    def _report(self, error: str) -> None:
        summary = self._stepper.summary(self._settings.mode) | self._pace.figures()
        summary |= {"error": error} if error else {}
        self._host.pipes.report("done", summary=summary)
        if not self._host.pipes.attached:
            self._host.node.get_logger().info(json.dumps(summary))

    def _missing(self) -> str:
        recorders, trackers = self._settings.expected_recorders, self._settings.expected_trackers
        controllers = self._settings.expected_controllers if self._stepper.scene.sampled else 0
        beside = self._settings.beside.count(",") + 1 if self._settings.beside else 0
        return self._topics.missing(controllers + trackers + recorders + beside, recorders) or self._pace.missing()

    def _chosen_pace(self) -> StepScheduler:
        if self._settings.mode == "lockstep" and self._stepper.scene.sampled:
            return Lockstep(self._host, self._stepper, self._settings)
        if self._settings.beside:
            raise ValueError(f"parameter beside is {self._settings.beside!r}; only a crane in lockstep can have it")
        if self._settings.mode == "realtime":
            return Realtime(self._host, self._stepper, self._settings)
        return OpenLoop(self._host, self._stepper)


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    return node_host.main("plant", PARAMETERS, lambda host, settings: PlantNode(host, settings).run(), managed=True)


if __name__ == "__main__":
    sys.exit(main())
