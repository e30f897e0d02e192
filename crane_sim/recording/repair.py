"""Makes recordings whole again that a killed recorder left as `.part` files."""

from __future__ import annotations

import logging
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import rerun_cli

from crane_sim.interruption import tie
from crane_sim.recording.leftover import free_name, held
from crane_sim.recording.part_names import joining

if TYPE_CHECKING:
    from collections.abc import Sequence

LIMIT = 60.0  # s for making one recording of what there is


def repair_leftovers(folder: Path) -> list[Path]:
    """Repair every `.rrd.part` file in a folder that nobody is writing, and return the recovered recordings.

    A file from which nothing can be recovered stays as it is.
    """
    if not folder.is_dir():
        return []
    found = [repair(part) for part in sorted(folder.glob("*.rrd.part"))]
    return [path for path in found if path is not None]


def repair(part: Path, within: float = LIMIT) -> Path | None:
    """Turn one leftover into `<name>.recovered.rrd`, or the first such name that is free.

    Returns None, and leaves the file alone, where a recorder is still writing it, nothing can be recovered, or it would
    take longer than `within` seconds.
    """
    with held(part) as ours:
        if not ours:
            return None
        target = free_name(part)
        fresh = joining(target)
        if not optimized([part], fresh, within):
            return None
        fresh.replace(target)
        part.unlink()
    logging.getLogger(__name__).warning("%s was left by a killed run: recovered as %s", part, target)
    return target


def optimized(parts: Sequence[Path], whole: Path, within: float) -> bool:
    """Whether recordings, which may be unfinished, have become the `whole` within so many seconds; else there is none.

    The program that does it ends with this process, however that ends.
    """
    if within <= 0.0:
        return False
    command = [str(viewer_program()), "rrd", "optimize", *map(str, parts), "-o", str(whole)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=within, preexec_fn=tie(), check=False)
        if not done.returncode and whole.is_file():
            return True
    except subprocess.TimeoutExpired:
        pass
    whole.unlink(missing_ok=True)
    return False


def viewer_program() -> Path:
    """Return the Rerun program itself; its Python wrapper would leave it behind when killed."""
    return Path(rerun_cli.__file__).with_name("rerun")
