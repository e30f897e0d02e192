"""The environment of a run: what nodes get of it, what is unusual in it, and what is said then."""

import os
import resource
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import CRANE, crane_here
from process_helpers import run_to_completion

from crane_sim import environment, load_scene, simulate
from crane_sim.orchestration.ros_environment import node_environment

HOSTILE = {
    "FASTDDS_BUILTIN_TRANSPORTS": "LARGE_DATA",
    "PYTHONIOENCODING": "ascii",
    "PYTHONWARNINGS": "error",
    "RCUTILS_LOGGING_USE_STDOUT": "7",
    "RMW_FASTRTPS_USE_QOS_FROM_XML": "1",
    "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp",
    "ROS_DISCOVERY_SERVER": "127.0.0.1:11811",
    "ROS_LOCALHOST_ONLY": "1",
    "ROS_SUPER_CLIENT": "1",
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
}


@pytest.mark.parametrize(
    "name", [*HOSTILE, "FASTDDS_OF_TOMORROW", "LD_PRELOAD", "PYTHONINSPECT", "ROS_OF_TOMORROW"]
)
def test_nodes_do_not_get_what_would_make_them_others(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the variables that libraries read, nodes get those of a list, or fixed values.

    These libraries are ROS, Fast DDS, Python and the loader.
    """
    monkeypatch.setenv(name, "unusual")
    assert node_environment(7, Path("/tmp")).get(name) != "unusual"


@pytest.mark.parametrize(
    "name", ["MY_GAIN", "HOME", "ROS_SECURITY_KEYSTORE", "ROS_LOG_DIR", "PYTHONUNBUFFERED"]
)
def test_nodes_get_what_is_the_user_s(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A law finds the variables of its author, ROS those of security and logs."""
    monkeypatch.setenv(name, "mine")
    assert node_environment(7, Path("/tmp"))[name] == "mine"


def other_ros(folder: Path) -> dict[str, str]:
    """Return the variables of a terminal that has sourced another ROS, which fails when used."""
    (packages := folder / "site-packages" / "rclpy").mkdir(parents=True)
    (packages / "__init__.py").write_text("raise ImportError('another distribution')\n")
    (folder / "lib").mkdir()
    for name in ("librcl.so", "librcutils.so", "librmw_fastrtps_cpp.so"):
        (folder / "lib" / name).write_bytes(
            Path(sys.prefix, "lib", "libtracetools_status.so").read_bytes()
        )
    return {
        "PYTHONPATH": str(packages.parent),
        "LD_LIBRARY_PATH": str(folder / "lib"),
        "AMENT_PREFIX_PATH": str(folder),
    }


def test_a_run_in_a_hostile_environment_is_the_same(tmp_path: Path) -> None:
    """With variables for another discovery, transport, middleware or ROS, states are the same.

    Another encoding is set, too.
    """
    scene = load_scene("overhead_energy", {"duration": 0.5})
    scene.dump(tmp_path / "scene.yaml")
    before = set(os.listdir("/dev/shm"))
    command = [
        Path(__file__).parents[2] / "crane",
        "run",
        tmp_path / "scene.yaml",
        "--no-record",
        "--json",
    ]
    result = run_to_completion(command, env=os.environ | HOSTILE | other_ros(tmp_path))
    assert result.returncode == 0, result.stderr
    assert simulate(scene).summary["state_sha256"] in result.stdout
    assert not {name for name in os.listdir("/dev/shm") if name.startswith("fast")} - before


def test_what_is_unusual_is_listed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`crane doctor` names variables, another ROS, a full /dev/shm and an unwritable folder."""
    variables = other_ros(tmp_path) | {
        "CRANE_SIM_INTERPRETED": "1",
        "ROS_DISCOVERY_SERVER": "there",
        "CRANE_SIM_CACHE": "/proc",
    }
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    full = SimpleNamespace(f_bavail=0, f_frsize=4096, f_flag=0)
    monkeypatch.setattr(environment.os, "statvfs", lambda _: full)
    result = crane_here(monkeypatch, capsys, "doctor")
    assert result.returncode == 0
    lines = result.stdout.splitlines()
    expected = (
        "CRANE_SIM_INTERPRETED: is 1",
        "another ROS on LD_LIBRARY_PATH: ",
        "another ROS on PYTHONPATH: ",
        "a full /dev/shm: ",
        "compiled code: is kept in ",
        "ROS_DISCOVERY_SERVER: is there, which nodes do not get",
    )
    for begin in expected:
        assert any(line.startswith(begin) for line in lines), begin
    names = (
        "CRANE_SIM_INTERPRETED, another ROS on LD_LIBRARY_PATH, another ROS on PYTHONPATH, a full "
        "/dev/shm"
    )
    assert environment.describe_unusual() == f"; unusual here: {names} (crane doctor)"


def test_what_no_run_starts_with_is_listed_as_well() -> None:
    """`crane doctor` lists everything where a profile fails; an empty variable is one line, too."""
    variables = {"ROS_DOMAIN_ID": "", "CRANE_SIM_DDS": "/none.xml", "CRANE_SIM_INTERPRETED": ""}
    result = run_to_completion([CRANE, "doctor"], env=os.environ | variables)
    assert result.returncode == 0 and not result.stderr
    begins = (
        "CRANE_SIM_INTERPRETED: is empty",
        "CRANE_SIM_DDS: is /none.xml",
        "runs: do not start: CRANE_SIM_DDS = /none.xml",
        "ROS_DOMAIN_ID: is empty, which nodes do not get",
    )
    for begin in begins:
        assert any(line.startswith(begin) for line in result.stdout.splitlines()), begin


def test_too_little_memory_is_one_line() -> None:
    """A command that may lack the memory for its libraries says so before they fail or hang."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (600_000 << 10, 600_000 << 10))

    command = [CRANE, "simulate", "overhead_energy"]
    result = subprocess.run(
        command, preexec_fn=limit, capture_output=True, text=True, timeout=60.0, check=False
    )
    assert result.returncode == 1 and len(result.stderr.splitlines()) == 1
    assert (
        "is limited to 585 MiB (ulimit -" in result.stderr
        and "2048 MiB are needed" in result.stderr
    )
