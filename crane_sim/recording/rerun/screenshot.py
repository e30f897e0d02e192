"""Draws a recording as its viewer shows it, without a window.

`python -m crane_sim.recording.rerun.screenshot RUN.rrd OUT.png --time 12` needs a Vulkan driver; a software one is
enough.
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
from typing import TYPE_CHECKING, TypeVar

from rerun.experimental import ViewerClient

from crane_sim.process_signals import set_parent_death_signal
from crane_sim.recording.rerun.repair import viewer_program

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rerun.experimental import ViewerState

LOAD_SECONDS = 120.0  # for each question to the viewer, on however busy a machine
END_SECONDS = 5.0  # for the viewer to end in order, before it is killed
NO_DRAWING = "the viewer cannot draw here; is there a Vulkan driver (Debian, Ubuntu: apt install mesa-vulkan-drivers)?"
_LOOK = 0.1  # s between two questions
DRAW_SECONDS = 1.0  # the viewer does not report that it has drawn a new time


Answer = TypeVar("Answer")


class PictureError(RuntimeError):
    """No picture could be made; the message is one line."""


def picture(recording: Path, output: Path, at: float | None = None) -> list[str]:
    """Save what the viewer shows at a scene time.

    Args:
        recording: a complete `.rrd` file.
        output: the PNG to write, 1920 x 1080.
        at: scene time [s]; default: the end of the run.

    Returns:
        What the views complain about, one line each; empty for a healthy recording.

    Raises:
        PictureError: there is no such recording, no viewer, or no Vulkan driver to draw with.
    """
    if not recording.is_file():
        raise PictureError(f"{recording}: no such file")
    with _viewer() as viewer:
        viewer.request(lambda client: client.open(str(recording.resolve())))
        end = _end_of_run(_load_recording(viewer, recording), recording)
        instant = end if at is None else at
        viewer.request(lambda client: client.set_time("sim_time", duration=instant, play_state="paused"))
        time.sleep(DRAW_SECONDS)
        viewer.request(lambda client: client.save_screenshot(str(output.resolve())))
        state = viewer.request(lambda client: client.get_state())
        return [f"{view.name}: {report.summary}" for view in state.views for report in view.reports]


class _Viewer:
    """A viewer that runs without a window."""

    def __init__(self, process: subprocess.Popen[bytes], port: int) -> None:
        """Expect it at a port of the loopback interface."""
        self._process, self._url = process, f"rerun+http://127.0.0.1:{port}/proxy"
        self._client: ViewerClient | None = None

    def request(self, call: Callable[[ViewerClient], Answer]) -> Answer:
        """Return the response to a request that may be sent twice.

        On a busy machine a viewer needs a while to start, and may lose a connection: the request is sent again.

        Raises:
            PictureError: it has ended, or does not answer within `LOAD_SECONDS`.
        """
        deadline = time.monotonic() + LOAD_SECONDS
        while True:
            try:
                self._client = self._client or ViewerClient.connect(self._url)
                return call(self._client)
            except (RuntimeError, OSError) as error:
                self._client = None
                if self._process.poll() is not None:
                    raise PictureError(NO_DRAWING) from error
                if time.monotonic() >= deadline:
                    raise PictureError(f"the viewer failed: {error}") from error
            time.sleep(_LOOK)


@contextlib.contextmanager
def _viewer() -> Iterator[_Viewer]:
    """Run a viewer for the length of the block; it ends with this process, however that ends."""
    port = _free_port()
    command = [viewer_program(), "--headless", "--hide-welcome-screen", "--bind", "127.0.0.1", "--port", str(port)]
    env, quiet = os.environ | {"RERUN_APP_ONLY": "true"}, subprocess.DEVNULL  # no questions about analytics
    try:
        process = subprocess.Popen(command, env=env, stdout=quiet, stderr=quiet, preexec_fn=set_parent_death_signal())
    except OSError as error:
        raise PictureError(f"no viewer: {error}") from error
    try:
        yield _Viewer(process, port)
    finally:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(END_SECONDS)
        process.kill()
        process.wait()


def _load_recording(viewer: _Viewer, recording: Path) -> ViewerState:
    deadline = time.monotonic() + LOAD_SECONDS
    while time.monotonic() < deadline:
        state = viewer.request(lambda client: client.get_state())
        if state.active_recording and not state.loading:
            return state
        time.sleep(_LOOK)
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
    parser = argparse.ArgumentParser(
        prog="python -m crane_sim.recording.rerun.screenshot", description="Draw a recording."
    )
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
