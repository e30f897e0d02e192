"""What an independent subscriber hears of the runs in its ROS domain."""

import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.ros_environment import node_environment
from crane_sim.scenes.scene import Scene

_LIMIT = 60.0  # s for it to start
_MEETING = 1.0  # s, several times what nodes on one machine take to find each other


def wait_for_discovery(place: str, _pid: int) -> None:
    """Give a witness time to find the plant before it takes its first step: for `on_filled` of a run."""
    if place == "plant":
        time.sleep(_MEETING)


class Heard(NamedTuple):
    """A message."""

    sent: int  # ns of the system's clock
    stamp: int  # ns
    effort: tuple[str, ...]  # as they were written, bit for bit


class Account:
    """The file that a witness writes, read on from where it was last read."""

    def __init__(self, file: Path) -> None:
        """Begin at its start."""
        self._file, self._at = file, 0

    def read(self) -> dict[str, list[Heard]]:
        """Return what was written since the last time, by topic: s(tates), e(fforts), c(ommands)."""
        found: dict[str, list[Heard]] = {"s": [], "e": [], "c": []}
        with self._file.open() as file:
            file.seek(self._at)
            text = file.read()
        whole = text[: text.rfind("\n") + 1]
        self._at += len(whole)
        for line in whole.splitlines():
            letter, sent, stamp, *effort = line.split()
            found[letter].append(Heard(int(sent), int(stamp), tuple(effort)))
        return found


@contextmanager
def monitor(scene: Scene, domain: int) -> Iterator[Account]:
    """Yield what a witness of this scene's runs in a ROS domain writes while the block runs.

    Raises:
        RuntimeError: it did not start; one line.
    """
    with (
        tempfile.TemporaryDirectory(prefix="crane_sim-") as folder,
        ProcessGroup(node_environment(domain, Path(folder))) as crew,
    ):
        file, scene_file = Path(folder, "witness.txt"), Path(folder, "scene.yaml")
        scene.dump(scene_file)
        settings = {"scene": str(scene_file), "file": str(file)}
        child = crew.start("witness", "crane_sim.ros.monitor_node", scene.crane, settings)
        while not child.ready:
            if not crew.listen(_LIMIT) or child.fault:
                raise RuntimeError(f"witness: {child.fault or 'it did not start'}")
        yield Account(file)
