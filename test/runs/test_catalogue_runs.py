"""Every scene of the catalogue over ROS, with real processes and a recorder."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from graph_messages import check_payload, messages_of

from crane_sim import load_scene
from crane_sim.files.catalogue import scene_files

NAMES = sorted(scene_files())
SHARES = 4
LIMIT = 300.0  # s for a share, which takes less than one minute


@pytest.mark.long
@pytest.mark.parametrize("share", range(SHARES))
def test_every_scene_runs_and_is_recorded(share: int, tmp_path: Path) -> None:
    """Every scene of the catalogue runs to the bits of `simulate`, with all steps on the disk; its messages agree."""
    check_runs(NAMES[share::SHARES], tmp_path)


def test_a_scene_of_every_crane_runs_and_is_recorded(tmp_path: Path) -> None:
    """The same of the first scene of every kind of crane."""
    first = {load_scene(name).crane: name for name in reversed(NAMES)}
    check_runs(sorted(first.values()), tmp_path)


def check_runs(names: list[str], tmp_path: Path) -> None:
    """Run scenes over ROS and check what they leave."""
    command = [sys.executable, str(Path(__file__).parents[1] / "programs" / "catalogue_runs.py"), str(tmp_path), *names]
    env = os.environ | {"NUMBA_DISABLE_JIT": "1", "TMPDIR": str(tmp_path)}
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=LIMIT, check=False)
    runs = [json.loads(line) for line in done.stdout.splitlines()]
    assert [run["scene"] for run in runs] == names, done.stderr
    failed = [run for run in runs if "error" in run or not run["due"] == run["steps"] == run["recorded_steps"]]
    assert not failed, done.stderr
    assert [run["state_sha256"] for run in runs] == [run["simulated_sha256"] for run in runs]
    assert all(Path(run["recording"]).stat().st_size for run in runs)
    for name in names:
        check_payload(load_scene(name), messages_of(tmp_path / f"{name}.mcap"))
