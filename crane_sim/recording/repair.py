"""Makes recordings whole again that a killed recorder left as `.part` files."""

from __future__ import annotations

import logging
import subprocess
from pathlib import Path

import rerun_cli

from crane_sim.recording.leftover import free_name, held


def repair_leftovers(folder: Path) -> list[Path]:
    """Repair every `.rrd.part` file in a folder that nobody is writing, and return the recovered recordings.

    A file from which nothing can be recovered stays as it is.
    """
    if not folder.is_dir():
        return []
    found = [repair(part) for part in sorted(folder.glob("*.rrd.part"))]
    return [path for path in found if path is not None]


def repair(part: Path) -> Path | None:
    """Turn one leftover into `<name>.recovered.rrd`, or the first such name that is free.

    Returns None, and leaves the file alone, where a recorder is still writing it or nothing can be recovered.
    """
    with held(part) as ours:
        if not ours:
            return None
        target = free_name(part)
        fresh = target.with_name(target.name + ".tmp")
        command = [viewer_program(), "rrd", "optimize", str(part), "-o", str(fresh)]
        done = subprocess.run(command, capture_output=True, check=False)
        if done.returncode or not fresh.is_file():
            fresh.unlink(missing_ok=True)
            return None
        fresh.replace(target)
        part.unlink()
    logging.getLogger(__name__).warning("%s was left by a killed run: recovered as %s", part, target)
    return target


def viewer_program() -> Path:
    """Return the Rerun program itself; its Python wrapper would leave it behind when killed."""
    return Path(rerun_cli.__file__).with_name("rerun")
