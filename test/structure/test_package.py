"""The tree as a ROS package: colcon builds it, and what it installs runs from there."""

import os
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from process_helpers import run_to_completion

ROOT = Path(__file__).parents[2]
NODES = ("plant_node", "controller_node", "tracker_node", "recorder_node", "crane")


def test_the_manifest_is_an_ament_python_package() -> None:
    """package.xml is format 3 with build type ament_python and the name of the resource marker."""
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    assert manifest.get("format") == "3"
    assert manifest.findtext("export/build_type") == "ament_python"
    assert (ROOT / "resource" / str(manifest.findtext("name"))).is_file()


def test_colcon_builds_an_installable_tree(tmp_path: Path) -> None:
    """`colcon build` installs package, scenes, profile, marker and programs, and the package works from there."""
    bases = ["--build-base", str(tmp_path / "build"), "--install-base", str(tmp_path / "install")]
    command = [sys.executable, "-m", "colcon", "--log-base", str(tmp_path / "log"), "build", *bases]
    command += ["--base-paths", str(ROOT), "--packages-select", "crane_sim", "--event-handlers", "console_direct+"]
    built = run_to_completion(command, cwd=tmp_path)
    assert built.returncode == 0, built.stdout + built.stderr
    tree = tmp_path / "install" / "crane_sim"
    share = tree / "share" / "crane_sim"
    assert (share / "package.xml").is_file() and (share / "config" / "fastdds_loopback.xml").is_file()
    assert (share / "config" / "scenes" / "knuckle_setpoint.yaml").is_file()
    assert (tree / "share" / "ament_index" / "resource_index" / "packages" / "crane_sim").is_file()
    assert all((tree / "lib" / "crane_sim" / name).is_file() for name in NODES)
    modules = next(tree.glob("lib/python3*/site-packages"))
    environment = os.environ | {"PYTHONPATH": str(modules)}
    code = "import crane_sim.files.catalogue as c; print(c.__file__, c.scene_files()['knuckle_setpoint'])"
    run = [sys.executable, "-c", code]
    where = run_to_completion(run, env=environment, cwd=tmp_path, check=True)
    assert all(path.startswith(str(tree)) for path in where.stdout.split())
    assert not any((ROOT / name).exists() for name in ("build", "install", "log"))
