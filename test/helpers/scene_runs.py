"""Runs of several scenes over ROS, by the program that runs them interpreted."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

PROGRAM = Path(__file__).parents[1] / "programs" / "catalogue_runs.py"
LIMIT = 300.0  # s for all scenes, which take less than one minute


def run_scenes(scenes: list[str], folder: Path) -> None:
    """Run scenes of the catalogue or of files, with recordings and bags, and check the output.

    Every one ends without an error, has all steps on the disk, and the bits of `simulate`.
    """
    env = os.environ | {"CRANE_SIM_INTERPRETED": "1", "TMPDIR": str(folder)}
    command = [sys.executable, str(PROGRAM), str(folder), *scenes]
    done = subprocess.run(
        command, env=env, capture_output=True, text=True, timeout=LIMIT, check=False
    )
    runs: list[dict[str, Any]] = [json.loads(line) for line in done.stdout.splitlines()]
    assert [run["scene"] for run in runs] == scenes, done.stderr
    failed = [
        run
        for run in runs
        if "error" in run or not run["due"] == run["steps"] == run["recorded_steps"]
    ]
    assert not failed, done.stderr
    assert [run["state_sha256"] for run in runs] == [run["simulated_sha256"] for run in runs]
    assert all(Path(run["recording"]).stat().st_size for run in runs)
