"""The command `crane`, as a child process or in the process of the tests."""

import subprocess
import sys
from pathlib import Path

import pytest
from process_helpers import run_to_completion

from crane_sim import cli

CRANE = Path(sys.executable).with_name("crane")


def crane(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Return exit code and output of the command."""
    return run_to_completion([str(CRANE), *arguments], cwd=cwd)


def crane_here(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *arguments: str
) -> subprocess.CompletedProcess[str]:
    """Return a command's exit code and output, run in this process.

    The process is no terminal and has loaded everything.
    """
    monkeypatch.setattr("sys.argv", ["crane", *arguments])
    # pytest has its own handlers
    monkeypatch.setattr("crane_sim.process_signals.exit_on_signal", lambda end: None)
    capsys.readouterr()
    code = cli.main()
    return subprocess.CompletedProcess(list(arguments), code, *capsys.readouterr())
