"""The node `plant`: simulates the crane in lockstep with its controller, in real time, or open loop."""

import json
import sys
from types import SimpleNamespace

from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.plant import Plant
from crane_sim.ros import process
from crane_sim.ros.lockstep import Lockstep
from crane_sim.ros.pacing import OpenLoop, Pace
from crane_sim.ros.plant_services import PlantServices
from crane_sim.ros.plant_topics import PlantTopics
from crane_sim.ros.process import Fault, Host
from crane_sim.ros.realtime import Realtime
from crane_sim.ros.stepper import Stepper

PARAMETERS = {
    "scene": "knuckle_setpoint",  # catalogue name or path
    "mode": "lockstep",  # lockstep | realtime
    "rate": 1.0,  # realtime: simulated seconds per second
    "commanded": False,  # leave the scene's own law and inputs out: another node commands every period
    "expected_controllers": 1,
    "expected_trackers": 0,  # slow halves of laws, which hear the states and command nothing
    "expected_recorders": 0,
    "command_timeout": 0.5,  # s without a command until realtime applies zero effort; 0: never
    "step_timeout": 0.5,  # s without a command until lockstep sends its state again
    "resends": 10,  # of one state before the run ends with a fault
}


class PlantNode:
    """Puts plant, topics and pace together and takes them through one run."""

    def __init__(self, host: Host, settings: SimpleNamespace) -> None:
        """Load the scene and publish the robot description; raises ValueError for bad settings."""
        check(settings)
        scene = load_scene(settings.scene)
        scene = scene.commanded() if settings.commanded else scene
        self._host, self._settings = host, settings
        self._topics = PlantTopics(host.node, scene.joint_names, scene.actuated)
        self._topics.publish_description(urdf(scene))
        self._stepper = Stepper(scene, Plant(scene), self._topics, host.pipes)
        self._stepper.warm_up()
        self._pace = self._chosen_pace()
        self._services = PlantServices(host.node, self._stepper, self._pace)

    def run(self) -> None:
        """Wait for the peers, simulate, report; raises Fault after the report when the run failed."""
        host = self._host
        host.wait(self._missing)
        host.pipes.report("ready")
        host.wait(lambda: "" if host.started else "the word to go")
        if not host.stopping:
            self._pace.run()
        error = self._stepper.fault or ("" if self._stepper.finished else "interrupted")
        self._stepper.end()
        self._report(error)
        if host.pipes.attached:
            host.wait(lambda: "the word to finish")
        if error:
            raise Fault(error)

    def _report(self, error: str) -> None:
        summary = self._stepper.summary(self._settings.mode) | self._pace.figures()
        summary |= {"error": error} if error else {}
        self._host.pipes.report("done", summary=summary)
        if not self._host.pipes.attached:
            self._host.node.get_logger().info(json.dumps(summary))

    def _missing(self) -> str:
        recorders, trackers = self._settings.expected_recorders, self._settings.expected_trackers
        controllers = self._settings.expected_controllers if self._stepper.scene.sampled else 0
        return self._topics.missing(controllers + trackers + recorders, recorders) or self._pace.missing()

    def _chosen_pace(self) -> Pace:
        if self._settings.mode == "realtime":
            return Realtime(self._host, self._stepper, self._settings)
        if self._stepper.scene.sampled:
            return Lockstep(self._host, self._stepper, self._settings)
        return OpenLoop(self._host, self._stepper)


def check(settings: SimpleNamespace) -> None:
    """Raise ValueError, one line, for a parameter value that makes no sense."""
    if settings.mode not in ("lockstep", "realtime"):
        raise ValueError(f"parameter mode is {settings.mode!r}; it must be lockstep or realtime")
    for name, bound in (("rate", 0.0), ("step_timeout", 0.0)):
        if not getattr(settings, name) > bound:
            raise ValueError(f"parameter {name} is {getattr(settings, name)}; it must be positive")
    for name in ("expected_controllers", "expected_trackers", "expected_recorders", "command_timeout", "resends"):
        if not getattr(settings, name) >= 0:
            raise ValueError(f"parameter {name} is {getattr(settings, name)}; it must not be negative")


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    return process.main("plant", PARAMETERS, lambda host, settings: PlantNode(host, settings).run())


if __name__ == "__main__":
    sys.exit(main())
