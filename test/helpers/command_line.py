"""The command `crane` as a child process."""

import subprocess
import sys
from pathlib import Path

from process_helpers import completed

CRANE = Path(sys.executable).with_name("crane")


def crane(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Return what the command did."""
    return completed([str(CRANE), *arguments], cwd=cwd)
