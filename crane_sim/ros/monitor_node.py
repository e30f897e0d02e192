"""The node `witness`: a subscriber that is no part of any run, and writes down what it hears; for soaks and tests.

A line of its file is a letter (s: joint_states, e: applied_effort, c: joint_commands), the instant at which the message
was sent [ns of the system's clock], its stamp [ns], and the efforts.
"""

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import TextIO

from crane_sim import load_scene
from crane_sim.ros.common import node_host
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.recorder.subscriptions import PolledSubscription

PARAMETERS = {
    "scene": Option("knuckle_setpoint", "scene whose runs are heard: a name of the catalogue or a path"),
    "file": Option("witness.txt", "what is written"),
}
_TOPICS = {"s": "joint_states", "e": "applied_effort", "c": "joint_commands"}
_PERIOD = 0.01  # s between two looks at what has come


class Monitor:
    """Writes down the messages of three topics."""

    def __init__(self, host: NodeHost, settings: SimpleNamespace) -> None:
        """Listen."""
        scene = load_scene(settings.scene)
        wires = {
            letter: JointWire(scene.joint_names if letter == "s" else scene.actuated, effort=letter != "s")
            for letter in _TOPICS
        }
        self._ears = [
            (letter, wires[letter], PolledSubscription(host.node, name, _nobody)) for letter, name in _TOPICS.items()
        ]

    def write(self, file: TextIO) -> None:
        """Write down what has come."""
        for letter, wire, ear in self._ears:
            for sent, _, data in ear.take_all():
                heard = wire.decode(data)
                print(letter, sent, heard.stamp, *heard.effort, file=file)
        file.flush()


def _nobody(_: bytes) -> None:
    """Take no message: they are drained."""


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Write until told to finish."""
    witness = Monitor(host, settings)
    with Path(settings.file).open("w") as file:
        host.pipes.report("ready")
        while not host.stopping:
            host.spin(_PERIOD)
            witness.write(file)
    host.pipes.report("done", summary={})


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    return node_host.main("witness", PARAMETERS, serve)


if __name__ == "__main__":
    sys.exit(main())
