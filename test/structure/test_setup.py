"""The script that makes the environment, with a Python that only pretends to."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PYTHON = """#!/bin/sh
# a Python whose environments hold a copy of itself as their Python, and as the command crane
case "$*" in
"-c "*) exit 0 ;;
"-m venv "*) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" && cp "$0" "$3/bin/crane" ;;
"-m pip "*) echo "WARNING: this is no weather for wheels" >&2; exit "$PIP_CODE" ;;
*) echo "crane was called with $*" ;;
esac
"""


def set_up(folder: Path, pip_code: int) -> subprocess.CompletedProcess[str]:
    """Return what the script did where installing ends with this exit code."""
    for name in ("crane", "requirements.lock", "setup.py"):
        shutil.copy(ROOT / name, folder / name)
    python = folder / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)
    env = os.environ | {"CRANE_PYTHON": str(python), "PIP_CODE": str(pip_code)}
    command = [str(folder / "crane"), "scenes"]
    return subprocess.run(command, env=env, capture_output=True, text=True, check=False, timeout=60.0)


def test_set_up_says_one_line(tmp_path: Path) -> None:
    """Where all goes well the warnings of the package client stay in its log, and the command is called."""
    done = set_up(tmp_path, 0)
    assert (done.returncode, done.stdout) == (0, "crane was called with scenes\n")
    assert len(done.stderr.splitlines()) == 1 and "making the environment" in done.stderr
    assert "no weather" in (tmp_path / ".venv" / "install.log").read_text()


def test_a_set_up_that_fails_says_why(tmp_path: Path) -> None:
    """Where installing fails the end of the package client's words is shown, and where the rest is."""
    done = set_up(tmp_path, 1)
    assert done.returncode == 2
    assert "no weather for wheels" in done.stderr
    assert "could not be installed" in done.stderr.splitlines()[-1] and "install.log" in done.stderr.splitlines()[-1]


@pytest.mark.parametrize("pip_code", [0, 1])
def test_what_was_begun_is_made_anew(tmp_path: Path, pip_code: int) -> None:
    """An environment that could not be finished is not in the way of the next attempt."""
    set_up(tmp_path, 1)
    assert set_up(tmp_path, pip_code).returncode == (2 if pip_code else 0)
