"""Clips of a recording: pictures of the viewer at equal distances of scene time, as GIF or MP4."""

from __future__ import annotations

import io
import shutil
import subprocess
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_output
from crane_sim.process_signals import set_parent_death_signal
from crane_sim.recording.rerun.screenshot import Shown, ViewCamera, camera
from crane_sim.recording.rerun.viewer import PictureError

KINDS = (".gif", ".mp4")
# pictures per second at most: a GIF counts in 1/100 s, and viewers show 1/100 s as 1/10 s
_GIF_RATE = 50.0
_COLORS = 128  # of a GIF: the solids of a crane and the curves need fewer


class Cut(NamedTuple):
    """Which part of a run a clip shows, and how."""

    begin: float = 0.0  # s, scene time
    end: float | None = None  # s, scene time; None: the end of the run
    frames_per_second: float = 10.0  # of the clip
    speed: float = 1.0  # scene time per time of the clip
    width: int = 960  # pixels; of an MP4 the next smaller even number


def write_clip(
    recording: Path,
    output: Path,
    cut: Cut,
    shown: Shown,
    on_progress: Callable[[int, int], None] = lambda *_: None,
) -> int:
    """Write a clip; return its number of frames.

    Args:
        recording: a complete `.rrd` file.
        output: ends in `.gif` or `.mp4`; the latter needs the program ffmpeg.
        cut: which part of the run.
        shown: what is drawn.
        on_progress: called with the frames done and all frames.

    Raises:
        SceneError: as of `screenshot.picture`; the part of the run is empty, the file of another
            kind, or a GIF has more than 50 pictures a second.
        PictureError: as of `screenshot.picture`; no ffmpeg, or it failed.
    """
    _check_output(output, cut.frames_per_second)
    with camera(recording, shown) as viewer:
        instants = _instants(cut, viewer.end)
        is_video = output.suffix == ".mp4"  # video encoders want even sizes
        frames = _frames(
            viewer, instants, cut.width - cut.width % 2 if is_video else cut.width, on_progress
        )
        write = partial(_write_mp4, output) if is_video else _write_gif
        write_output("--output", output, lambda path: write(path, frames, cut.frames_per_second))
        return len(instants)


def _check_output(output: Path, frames_per_second: float) -> None:
    if output.suffix not in KINDS:
        raise SceneError(f"{output}: must end in {' or '.join(KINDS)}")
    if output.suffix == ".gif" and frames_per_second > _GIF_RATE:
        line = (
            f"a GIF shows {_GIF_RATE:g} pictures a second at most, not {frames_per_second:g}; an "
            ".mp4 shows more"
        )
        raise SceneError(f"{output}: {line}")
    if output.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise PictureError(
            f"{output}: needs the program ffmpeg, which is not installed; a .gif needs nothing more"
        )


def _instants(cut: Cut, end_of_run: float) -> list[float]:
    end = end_of_run if cut.end is None else min(cut.end, end_of_run)
    if not 0.0 <= cut.begin < end:
        raise SceneError(f"from {cut.begin:g} to {end:g} s: no part of a run of {end_of_run:g} s")
    return np.arange(cut.begin, end, cut.speed / cut.frames_per_second).tolist()


def _frames(
    viewer: ViewCamera, instants: list[float], width: int, on_progress: Callable[[int, int], None]
) -> Iterator[Image.Image]:
    for done, instant in enumerate(instants, 1):
        frame = Image.open(io.BytesIO(viewer.at(instant))).convert("RGB")
        height = round(frame.height * width / frame.width / 2) * 2  # even, too
        yield frame.resize((width, height), Image.Resampling.LANCZOS)
        on_progress(done, len(instants))


def _write_gif(output: Path, frames: Iterator[Image.Image], frames_per_second: float) -> None:
    first, *others = (frame.quantize(_COLORS, dither=Image.Dither.NONE) for frame in frames)
    durations = _gif_durations(1 + len(others), frames_per_second)
    first.save(output, save_all=True, append_images=others, duration=durations, loop=0)


def _gif_durations(count: int, frames_per_second: float) -> list[int]:
    """Return how long each picture is shown [ms], without drift of the total.

    GIFs count in hundredths of a second.
    """
    ends = [round(100.0 * k / frames_per_second) for k in range(count + 1)]
    return [10 * (end - begin) for begin, end in pairwise(ends)]


def _write_mp4(
    output: Path, path: Path, frames: Iterator[Image.Image], frames_per_second: float
) -> None:
    """Write a clip to a path; errors name the output that it becomes."""
    first = next(frames)
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", f"{first.width}x{first.height}", "-r", f"{frames_per_second:g}", "-i", "-"]
    command += ["-pix_fmt", "yuv420p", str(path.resolve())]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=set_parent_death_signal()
    ) as program:
        data = b"".join(frame.tobytes() for frame in (first, *frames))
        _, errors = program.communicate(data)
    if program.returncode:
        text = errors.decode(errors="replace").replace(str(path.resolve()), str(output))
        last_line = text.strip().rpartition("\n")[2].strip()
        raise PictureError(f"{output}: ffmpeg failed: {last_line or 'no message'}")
