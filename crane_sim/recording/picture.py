"""Draws a recording as its viewer shows it, without a window.

`python -m crane_sim.recording.picture RUN.rrd OUT.png --time 12` needs a Vulkan driver; a software one is enough.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from rerun.experimental import ViewerClient

from crane_sim.recording.repair import viewer_program

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rerun.experimental import ViewerState

LOAD_SECONDS = 30.0
NO_DRAWING = "the viewer cannot draw here; is there a Vulkan driver (Debian, Ubuntu: apt install mesa-vulkan-drivers)?"
DRAW_SECONDS = 1.0  # the viewer does not say when it has drawn a new time


class PictureError(RuntimeError):
    """No picture could be made; the message is one line."""


def picture(recording: Path, output: Path, at: float | None = None) -> list[str]:
    """Save what the viewer shows at a scene time.

    Args:
        recording: a complete `.rrd` file.
        output: the PNG to write, 1920 x 1080.
        at: scene time [s]; the end of the run when not given.

    Returns:
        What the views complain about, one line each; empty for a healthy recording.

    Raises:
        PictureError: there is no such recording, no viewer, or no Vulkan driver to draw with.
    """
    if not recording.is_file():
        raise PictureError(f"{recording}: no such file")
    with _viewer() as viewer:
        viewer.open(str(recording.resolve()))
        end = _end_of_run(_loaded(viewer, recording), recording)
        viewer.set_time("sim_time", duration=end if at is None else at, play_state="paused")
        time.sleep(DRAW_SECONDS)
        viewer.save_screenshot(str(output.resolve()))
        return [f"{view.name}: {report.summary}" for view in viewer.get_state().views for report in view.reports]


@contextlib.contextmanager
def _viewer() -> Iterator[ViewerClient]:
    """Run a viewer without a window for the length of the block."""
    port = _free_port()
    command = [viewer_program(), "--headless", "--hide-welcome-screen", "--bind", "127.0.0.1", "--port", str(port)]
    quiet = os.environ | {"RERUN_APP_ONLY": "true"}  # no questions about analytics
    try:
        process = subprocess.Popen(command, env=quiet, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except OSError as error:
        raise PictureError(f"no viewer: {error}") from error
    try:
        yield _connected(process, port)
    except PictureError:
        raise
    except (RuntimeError, ConnectionError) as error:
        raise PictureError(NO_DRAWING if process.poll() is not None else f"the viewer failed: {error}") from error
    finally:
        process.terminate()
        process.wait()


def _connected(process: subprocess.Popen[bytes], port: int) -> ViewerClient:
    deadline = time.monotonic() + LOAD_SECONDS
    while time.monotonic() < deadline and process.poll() is None:
        try:
            viewer = ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
            viewer.get_state()
            return viewer
        except (RuntimeError, ConnectionError):
            time.sleep(0.1)
    raise PictureError(NO_DRAWING)


def _loaded(viewer: ViewerClient, recording: Path) -> ViewerState:
    deadline = time.monotonic() + LOAD_SECONDS
    while time.monotonic() < deadline:
        state = viewer.get_state()
        if state.active_recording and not state.loading:
            return state
        time.sleep(0.1)
    raise PictureError(f"{recording}: the viewer did not load it within {LOAD_SECONDS:g} s")


def _end_of_run(state: ViewerState, recording: Path) -> float:
    ends = [line.end for each in state.recordings for line in each.timelines if line.name == "sim_time"]
    if not ends or ends[0] is None:
        raise PictureError(f"{recording}: has no timeline sim_time")
    return ends[0] * 1e-9


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="python -m crane_sim.recording.picture", description="Draw a recording.")
    parser.add_argument("recording", type=Path, help="a complete .rrd file")
    parser.add_argument("output", type=Path, help="the PNG to write")
    parser.add_argument("--time", type=float, default=None, help="scene time in s (default: the end of the run)")
    options = parser.parse_args()
    try:
        complaints = picture(options.recording, options.output, options.time)
    except PictureError as error:
        print(f"picture: {error}", file=sys.stderr)
        return 1
    for line in complaints:
        print(f"picture: {line}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
