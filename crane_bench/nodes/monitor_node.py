"""The node `monitor`: an independent subscriber that logs messages to a file.

It is part of no run; soaks and tests use it.

A line of its file is a letter (s: joint_states, e: applied_effort, c: joint_commands), the instant
at which the message was sent [ns of the system's clock], its stamp [ns], and the numbers: efforts,
or commands.
"""

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import TextIO

from crane_sim import load_scene
from crane_sim.ros.common import node_host
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec
from crane_sim.ros.recorder.subscriptions import PolledSubscription

PARAMETERS = {
    "scene": Option(
        "knuckle_setpoint", "scene whose runs are logged: a name of the catalogue or a path"
    ),
    "file": Option("monitor.txt", "the log"),
}
_TOPICS = {"s": "joint_states", "e": "applied_effort", "c": "joint_commands"}
_PERIOD = 0.01  # s between two polls


class Monitor:
    """Logger of the messages of three topics."""

    def __init__(self, host: NodeHost, settings: SimpleNamespace) -> None:
        """Subscribe."""
        scene = load_scene(settings.scene)
        self._commands = CommandCodec(scene)
        states, efforts = (
            JointStateCodec(scene.joint_names, STATE),
            JointStateCodec(scene.actuated, EFFORT),
        )
        codecs: dict[str, JointStateCodec | CommandCodec] = {
            "s": states,
            "e": efforts,
            "c": self._commands,
        }
        self._subscriptions = [
            (letter, codecs[letter], PolledSubscription(host.node, name, _ignore))
            for letter, name in _TOPICS.items()
        ]

    def write(self, file: TextIO) -> None:
        """Write the received messages."""
        for letter, codec, subscription in self._subscriptions:
            for message in subscription.take_all():
                decoded = codec.decode(message.data)
                numbers = (
                    self._commands.values(decoded) if codec is self._commands else decoded.effort
                )
                print(letter, message.sent, decoded.stamp, *numbers, file=file)
        file.flush()


def _ignore(_: bytes) -> None:
    """Ignore a message: `write` takes them itself."""


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Write until the request to finish."""
    monitor = Monitor(host, settings)
    with Path(settings.file).open("w") as file:
        host.report_ready()
        while not host.stop_reason:
            host.spin(_PERIOD)
            monitor.write(file)
    host.pipes.report("done", summary={})


def main() -> int:
    """Run the node; see `node_host.main` for the exit code."""
    return node_host.main("monitor", PARAMETERS, serve)


if __name__ == "__main__":
    sys.exit(main())
