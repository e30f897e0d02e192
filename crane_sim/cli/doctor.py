"""The command `crane doctor`."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import click

from crane_sim.environment import Unusual, find_kept_from_nodes, find_unusual

_NODE = "import rclpy; rclpy.init(); rclpy.create_node('doctor').destroy_node()"
_START_TIMEOUT = 60.0  # s; a node starts in less than one


@click.command()
def doctor() -> None:
    """List what is unusual in the environment, and may be why a run does not start."""
    found = [*find_unusual(), *_failures(), *find_kept_from_nodes()]
    for unusual in found:
        print(f"{unusual.name}: {unusual.description}")
    if not found:
        print("nothing unusual: variables, limits, memory, caches; a ROS node starts")


def _failures() -> Iterator[Unusual]:
    """Yield what of a run fails: compiled code that is not kept, the start of a node, or all."""
    try:
        yield from _unusual_cache()
        yield from _failed_node()
    except RuntimeError as error:  # a profile of Fast DDS that does not exist
        yield Unusual("runs", f"do not start: {error}")


def _failed_node() -> Iterator[Unusual]:
    """Yield why a node does not start."""
    # here: slow to import
    from crane_sim.orchestration.ros_environment import node_environment, reserve_domain

    with tempfile.TemporaryDirectory(prefix="crane_sim-") as folder, reserve_domain() as domain:
        environment = node_environment(domain, Path(folder))
        try:
            node = subprocess.run(
                [sys.executable, "-c", _NODE],
                env=environment,
                capture_output=True,
                text=True,
                timeout=_START_TIMEOUT,
            )
        except subprocess.TimeoutExpired:
            yield Unusual("ROS", f"a node did not start within {_START_TIMEOUT:g} s")
            return
    if node.returncode:
        last_line = (node.stderr.strip().splitlines() or [f"exit code {node.returncode}"])[-1]
        yield Unusual("ROS", f"a node does not start: {last_line}")


def _unusual_cache() -> Iterator[Unusual]:
    """Yield why compiled code is not kept where it should be."""
    from crane_sim.tracing.cache import cache_folder, cache_root  # here, too

    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as file:
            file.write(bytes(1 << 20))
    except OSError as error:
        yield Unusual(
            "compiled code", f"is not kept, every process compiles: {folder}: {error.strerror}"
        )
        return
    if not folder.is_relative_to(cache_root()):
        yield Unusual(
            "compiled code", f"is kept in {folder}, since {cache_root()} cannot be written"
        )
