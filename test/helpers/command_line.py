"""The command `crane` as a child process."""

import subprocess
import sys
from pathlib import Path

from process_helpers import run_to_completion

CRANE = Path(sys.executable).with_name("crane")


def crane(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Return exit code and output of the command."""
    return run_to_completion([str(CRANE), *arguments], cwd=cwd)
