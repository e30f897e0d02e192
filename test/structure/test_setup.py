"""The setup script, with a fake Python."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FAKE_PYTHON = """#!/bin/sh
# a fake Python: its environments have a copy of it as their Python and as the command crane
case "$*" in
"-c "*) exit 0 ;;
"-m venv "*) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" && cp "$0" "$3/bin/crane" ;;
"-m pip "*) echo "WARNING: no matching wheel" >&2; exit "$PIP_CODE" ;;
*) echo "crane was called with $*" ;;
esac
"""


def run_setup_script(folder: Path, pip_code: int) -> subprocess.CompletedProcess[str]:
    """Return exit code and output of the script when installing ends with `pip_code`."""
    (folder / "requirements").mkdir(exist_ok=True)
    for name in ("crane", "requirements/run.lock", "setup.py"):
        shutil.copy(ROOT / name, folder / name)
    python = folder / "python"
    python.write_text(FAKE_PYTHON)
    python.chmod(0o755)
    env = os.environ | {"CRANE_PYTHON": str(python), "PIP_CODE": str(pip_code)}
    command = [str(folder / "crane"), "scenes"]
    return subprocess.run(
        command, env=env, capture_output=True, text=True, check=False, timeout=60.0
    )


def test_setup_prints_one_line(tmp_path: Path) -> None:
    """After an installation pip's warnings are only in the log, and the command is called."""
    result = run_setup_script(tmp_path, 0)
    assert (result.returncode, result.stdout) == (0, "crane was called with scenes\n")
    assert len(result.stderr.splitlines()) == 1 and "making the environment" in result.stderr
    assert "no matching wheel" in (tmp_path / ".venv" / "install.log").read_text()


def test_a_failed_setup_prints_the_reason(tmp_path: Path) -> None:
    """After a failed installation the end of pip's output is printed, with the path of the log."""
    result = run_setup_script(tmp_path, 1)
    assert result.returncode == 2
    assert "no matching wheel" in result.stderr
    assert (
        "could not be installed" in result.stderr.splitlines()[-1]
        and "install.log" in result.stderr.splitlines()[-1]
    )


@pytest.mark.parametrize("pip_code", [0, 1])
def test_an_unfinished_environment_is_recreated(tmp_path: Path, pip_code: int) -> None:
    """An unfinished environment is replaced at the next attempt."""
    run_setup_script(tmp_path, 1)
    assert run_setup_script(tmp_path, pip_code).returncode == (2 if pip_code else 0)


def test_a_tree_may_have_any_name_in_any_locale(tmp_path: Path) -> None:
    """With LC_ALL=C, or another Python's home, the command starts in a non-ASCII folder."""
    tree = tmp_path / "Kräne"
    tree.mkdir()
    run_setup_script(tree, 0)
    stamp = (tree / ".venv" / "crane.stamp").read_bytes()
    shutil.rmtree(tree / ".venv")
    subprocess.run(
        [sys.executable, "-m", "venv", "--without-pip", tree / ".venv"], check=True, timeout=60.0
    )
    (tree / ".venv" / "crane.stamp").write_bytes(stamp)
    (packages,) = (tree / ".venv" / "lib").glob("python*/site-packages")
    (packages / "tree.pth").write_text(f"{tree}\n", encoding="utf-8")
    (tree / "of_this_tree.py").write_text("print('called')\n")
    command = tree / ".venv" / "bin" / "crane"
    command.write_text(f"#!{tree}/.venv/bin/python\nimport of_this_tree\n", encoding="utf-8")
    command.chmod(0o755)
    env = os.environ | {"LC_ALL": "C", "PYTHONHOME": "/nonexistent"}
    result = subprocess.run(
        [tree / "crane"], env=env, capture_output=True, text=True, check=False, timeout=60.0
    )
    assert result.stdout == "called\n", result.stderr
