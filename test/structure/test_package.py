"""The tree as a ROS package: colcon builds it, and what it installs runs from there."""

import ast
import os
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import yaml
from process_helpers import run_to_completion

from crane_control.nodes import controller_node
from crane_sim.ros import plant_node, recorder_node
from crane_sim.ros.common.nodes import MANAGED

ROOT = Path(__file__).parents[2]
NODES = ("plant_node", "controller_node", "tracker_node", "recorder_node", "operator_node", "crane")


def test_the_manifest_is_an_ament_python_package() -> None:
    """package.xml is format 3 with build type ament_python and the name of the resource marker."""
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    assert manifest.get("format") == "3"
    assert manifest.findtext("export/build_type") == "ament_python"
    assert (ROOT / "resource" / str(manifest.findtext("name"))).is_file()


def test_colcon_builds_an_installable_tree(tmp_path: Path) -> None:
    """`colcon build` installs a working package with scenes, profile, marker and programs."""
    bases = ["--build-base", str(tmp_path / "build"), "--install-base", str(tmp_path / "install")]
    command = [sys.executable, "-m", "colcon", "--log-base", str(tmp_path / "log"), "build", *bases]
    command += [
        "--base-paths",
        str(ROOT),
        "--packages-select",
        "crane_sim",
        "--event-handlers",
        "console_direct+",
    ]
    built = run_to_completion(command, cwd=tmp_path)
    assert built.returncode == 0, built.stdout + built.stderr
    tree = tmp_path / "install" / "crane_sim"
    share = tree / "share" / "crane_sim"
    assert (share / "package.xml").is_file() and (
        share / "config" / "fastdds_loopback.xml"
    ).is_file()
    assert (share / "config" / "scenes" / "knuckle_setpoint.yaml").is_file()
    assert (share / "launch" / "crane.launch.py").is_file() and (
        share / "config" / "parameters.yaml"
    ).is_file()
    assert (tree / "share" / "ament_index" / "resource_index" / "packages" / "crane_sim").is_file()
    assert all((tree / "lib" / "crane_sim" / name).is_file() for name in NODES)
    modules = next(tree.glob("lib/python3*/site-packages"))
    assert (modules / "crane_sim" / "report" / "assets" / "study.html").is_file()
    assert (modules / "crane_bench" / "pages" / "league.md").is_file()
    environment = os.environ | {"PYTHONPATH": str(modules)}
    code = (
        "import crane_sim.files.catalogue as c; print(c.__file__, "
        "c.scene_files()['knuckle_setpoint'])"
    )
    run = [sys.executable, "-c", code]
    where = run_to_completion(run, env=environment, cwd=tmp_path, check=True)
    assert all(path.startswith(str(tree)) for path in where.stdout.split())
    assert not any((ROOT / name).exists() for name in ("build", "install", "log"))


def test_the_launch_file_names_parameters_of_the_nodes() -> None:
    """What launch and parameter files set, the nodes declare.

    What the launch file starts, the package installs.
    """
    declared = {
        *MANAGED,
        *plant_node.PARAMETERS,
        *controller_node.PARAMETERS,
        *recorder_node.PARAMETERS,
    }
    tree = ast.parse((ROOT / "launch" / "crane.launch.py").read_text())
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    words = {
        (k.arg, k.value.value)
        for call in calls
        for k in call.keywords
        if isinstance(k.value, ast.Constant)
    }
    assert {value for name, value in words if name == "executable"} - {
        "robot_state_publisher"
    } < set(NODES)
    body = next(
        node
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and node.name == "crane_nodes"
    )
    # behind options of launch itself
    groups = [node for node in ast.walk(body) if isinstance(node, ast.Dict)][2:]
    keys = {key.value for group in groups for key in group.keys if isinstance(key, ast.Constant)}
    assert (
        {"scene", "mode", "autostart", "expected_recorders", "publish_tf", "path"}
        <= keys
        <= declared
    )
    assert "frame_prefix" in keys
    document = yaml.safe_load((ROOT / "config" / "parameters.yaml").read_text())
    assert set(document["/**/plant"]["ros__parameters"]) <= set(plant_node.PARAMETERS)
