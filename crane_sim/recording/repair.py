"""Makes recordings whole again that a killed recorder left as `.part` files."""

from __future__ import annotations

import logging
import subprocess
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import rerun_cli

from crane_sim.interruption import tie
from crane_sim.recording.leftover import free_name, held
from crane_sim.recording.part_names import joining

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

LIMIT = 60.0  # s for making one recording of what there is
_LOOK = 0.05  # s between two looks at what time is left


def repair_leftovers(folder: Path) -> list[Path]:
    """Repair every `.rrd.part` file in a folder that nobody is writing, and return the recovered recordings.

    A file from which nothing can be recovered stays as it is.
    """
    if not folder.is_dir():
        return []
    found = [repair(part) for part in sorted(folder.glob("*.rrd.part"))]
    return [path for path in found if path is not None]


def repair(part: Path, left: Callable[[], float] | None = None) -> Path | None:
    """Turn one leftover into `<name>.recovered.rrd`, or the first such name that is free.

    Returns None, and leaves the file alone, where a recorder is still writing it, nothing can be recovered, or there
    are no seconds `left`; without that, `LIMIT`.
    """
    with held(part) as ours:
        if not ours:
            return None
        target = free_name(part)
        fresh = joining(target)
        if not optimized([part], fresh, left or countdown(LIMIT)):
            return None
        fresh.replace(target)
        part.unlink()
    logging.getLogger(__name__).warning("%s was left by a killed run: recovered as %s", part, target)
    return target


def countdown(seconds: float) -> Callable[[], float]:
    """Return what tells how many of so many seconds are left."""
    until = time.monotonic() + seconds
    return lambda: until - time.monotonic()


def optimized(parts: Sequence[Path], whole: Path, left: Callable[[], float]) -> bool:
    """Whether recordings, which may be unfinished, have become the `whole`; else there is none.

    That is given up as soon as there are no seconds `left`, which is asked again and again: they may become fewer. The
    program that does it ends with this process, however that ends.
    """
    if left() <= 0.0:
        return False
    command = [str(viewer_program()), "rrd", "optimize", *map(str, parts), "-o", str(whole)]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, preexec_fn=tie()) as program:
        while program.poll() is None and left() > 0.0:
            with suppress(subprocess.TimeoutExpired):
                program.wait(_LOOK)
        program.kill()  # if it still runs
    if not program.returncode and whole.is_file():
        return True
    whole.unlink(missing_ok=True)
    return False


def viewer_program() -> Path:
    """Return the Rerun program itself; its Python wrapper would leave it behind when killed."""
    return Path(rerun_cli.__file__).with_name("rerun")
