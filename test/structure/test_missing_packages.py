"""Without optional packages, as after `pip install .`, what needs one names it and its extra."""

import json
import os
import re
import sys
from importlib.metadata import metadata, version
from pathlib import Path
from typing import Any

import pytest
from process_helpers import run_to_completion

import crane_sim
from crane_sim.files.installation import PACKAGES

TREE = Path(__file__).parents[2]
PROGRAM = TREE / "test" / "programs" / "without_packages.py"
COMMANDS = {
    "run overhead_energy": "a run over ROS needs the Python package rclpy, .*crane_sim[ros]",
    "drive overhead_energy": "a run over ROS needs the Python package rclpy, .*crane_sim[ros]",
    "simulate overhead_energy --record run.rrd": "--record: needs the Python package rerun-sdk, "
    ".*crane_sim[rerun]",
    "view --web run.rrd": "a recording needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "view --live": "a recording needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "shot run.rrd": "a recording needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "clip run.rrd": "a recording needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "plot run.rrd": "a recording needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "replay run.rrd": "a recording needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "docs pictures": "a recording needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "docs --build": "crane docs --build needs the Python package zensical, .*crane_sim[docs]",
    "report study": "the table of a study needs the Python package pyarrow, .*crane_sim[study]",
    "soak kill": "needs the Python package rerun-sdk, .*crane_sim[rerun]",
    "shot nothing.rrd": "RUN = 'nothing.rrd': no such file",
    "report nothing": "RUN = 'nothing': no such file",
    "report .": "folder .: holds no study",
}
"""Command lines, and what the line on stderr has."""
NODES = ("crane_sim.ros.plant_node", "crane_sim.ros.recorder_node") + tuple(
    f"crane_control.nodes.{name}_node" for name in ("controller", "tracker", "operator")
)
EXPRESSIONS = {
    "run.record('run.rrd')": "MissingPackage: a recording needs the Python package rerun-sdk, "
    ".*crane_sim[rerun]",
    "run.plot()": "MissingPackage: a figure needs the Python package matplotlib, "
    ".*crane_sim[plots]",
    "crane_sim.read_recording('run.rrd')": "UnreadableRecording: run.rrd: a recording needs "
    ".*crane_sim[rerun]",
    "crane_sim.read_recording('run.mcap')": "UnreadableRecording: run.mcap: a .* needs "
    ".*crane_sim[",
    "__import__('crane_sim.gym')": "MissingPackage: an environment needs .* gymnasium, "
    ".*crane_sim[gym]",
}
"""Expressions in Python, and their errors."""


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return what commands, nodes and expressions do without optional packages.

    All are in one process.
    """
    folder = tmp_path_factory.mktemp("without_packages")
    for name in ("run.rrd", "run.mcap", "study/study.json", "study/table.parquet"):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("{}")
    commands = [words.split() for words in COMMANDS]
    wanted = {"commands": commands, "nodes": NODES, "expressions": list(EXPRESSIONS)}
    display = {"DISPLAY": ":0", "CRANE_SIM_INTERPRETED": "1"}
    done = run_to_completion(
        [sys.executable, str(PROGRAM), json.dumps(wanted)], cwd=folder, env=os.environ | display
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def as_pattern(text: str) -> str:
    """Return the pattern of a text in which only .* is special."""
    return ".*".join(map(re.escape, text.split(".*")))


def test_a_command_names_the_extra_that_it_needs(found: dict[str, Any]) -> None:
    """Each command ends with exit code 2 and a line: a package to install, or bad input.

    The line has the package and the command that installs it.
    """
    for (words, line), (code, errors) in zip(COMMANDS.items(), found["commands"], strict=True):
        assert code == 2 and len(errors) == 1, (words, errors)
        assert re.match(f"crane: .*{as_pattern(line)}", errors[0]), (words, errors)


def test_a_node_names_the_extra_that_it_needs(found: dict[str, Any]) -> None:
    """A node without ROS exits with code 1 and one line.

    The line has the package and the command that installs it.
    """
    line = (
        "crane: a node needs the Python package rclpy, which is not installed (pip install "
        "'crane_sim[ros]')"
    )
    assert found["nodes"] == [line] * len(NODES)


def test_python_names_the_extra_that_it_needs(found: dict[str, Any]) -> None:
    """An error in Python is one line with the package and the command that installs it."""
    for (expression, line), (kind, message) in zip(
        EXPRESSIONS.items(), found["expressions"], strict=True
    ):
        assert re.fullmatch(f"{as_pattern(line)}.*", f"{kind}: {message}"), expression


def test_every_optional_package_is_an_extra() -> None:
    """Each optional package names an extra of this package.

    The extra `ros` has the pins of ./crane's environment.
    """
    extras = set(metadata("crane_sim").get_all("Provides-Extra") or ())
    assert {package.extra for package in PACKAGES.values()} <= extras
    required = metadata("crane_sim").get_all("Requires-Dist") or ()
    pins = {line.partition(";")[0].strip() for line in required if 'extra == "ros"' in line}
    run = (TREE / "requirements" / "run.in").read_text().splitlines()
    assert pins == {line for line in run if line.startswith("ros-")}


def test_the_package_has_its_version() -> None:
    """`crane_sim.__version__` is the version that pip knows."""
    assert crane_sim.__version__ == version("crane_sim")
