"""Messages that the monitor node, an independent subscriber, receives in its ROS domain."""

import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.ros_environment import node_environment
from crane_sim.scenes.scene import Scene

_START_TIMEOUT = 60.0  # s for it to start
_WRITE_TIMEOUT = 60.0  # s for it to write what it has received
_WRITE_INTERVAL = 0.1  # s, ten times the interval at which it writes
_DISCOVERY_TIME = 1.0  # s, several times what nodes on one machine take to find each other


def wait_for_discovery(role: str, _pid: int) -> None:
    """Let a monitor discover the plant before its first step: for `on_activated` of a run."""
    if role == "plant":
        time.sleep(_DISCOVERY_TIME)


class Received(NamedTuple):
    """A message that the monitor received."""

    sent: int  # ns of the system's clock
    stamp: int  # ns
    effort: tuple[str, ...]  # unparsed texts, bit for bit


Messages = dict[str, list[Received]]
"""Messages by topic: s(tates), e(fforts), c(ommands)."""


class MonitorFile:
    """The file that a monitor writes, read incrementally."""

    def __init__(self, file: Path) -> None:
        """Begin at its start."""
        self._file, self._at = file, 0

    def read(self) -> Messages:
        """Return the messages since the last call."""
        messages: Messages = {"s": [], "e": [], "c": []}
        with self._file.open() as file:
            file.seek(self._at)
            text = file.read()
        complete_lines = text[: text.rfind("\n") + 1]
        self._at += len(complete_lines)
        for line in complete_lines.splitlines():
            letter, sent, stamp, *effort = line.split()
            messages[letter].append(Received(int(sent), int(stamp), tuple(effort)))
        return messages

    def read_to_end(self, received: Messages, is_complete: Callable[[Messages], bool]) -> None:
        """Add what the monitor still writes to `received`, until that is complete.

        A busy machine may delay it.
        """
        deadline = time.monotonic() + _WRITE_TIMEOUT
        while True:
            time.sleep(_WRITE_INTERVAL)
            self.read_into(received)
            if is_complete(received) or time.monotonic() > deadline:
                return

    def read_into(self, received: Messages) -> None:
        """Add the messages since the last call to `received`."""
        for letter, messages in self.read().items():
            received.setdefault(letter, []).extend(messages)


@contextmanager
def monitor(scene: Scene, domain: int) -> Iterator[MonitorFile]:
    """Yield the file that a monitor of a scene's runs in a ROS domain writes in the block.

    Raises:
        RuntimeError: it did not start; the message is one line.
    """
    with (
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        ProcessGroup(node_environment(domain, Path(folder))) as group,
    ):
        file, scene_file = Path(folder, "monitor.txt"), Path(folder, "scene.yaml")
        scene.dump(scene_file)
        settings = {"scene": str(scene_file), "file": str(file)}
        child = group.start("monitor", "crane_bench.nodes.monitor_node", scene.crane, settings)
        while not child.ready:
            if not group.listen(_START_TIMEOUT) or child.fault:
                raise RuntimeError(f"monitor: {child.fault or 'it did not start'}")
        yield MonitorFile(file)
