"""Rerun's viewer: in a window, and without one."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import socket
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TypeVar
from urllib.parse import quote

from rerun.experimental import ViewerClient, ViewerState

from crane_sim.files.errors import SceneError
from crane_sim.process_signals import end_process, set_parent_death_signal
from crane_sim.recording.rerun.live import ADDRESS, live_address
from crane_sim.recording.rerun.repair import rerun_executable
from crane_sim.recording.rerun.rrd_file import open_viewable

LOAD_SECONDS = 120.0  # for each question to the viewer, on however busy a machine
END_SECONDS = 5.0  # for the viewer to end in order, before it is killed
NO_DRAWING = (
    "the viewer cannot draw here; is there a Vulkan driver (Debian, Ubuntu: apt install "
    "mesa-vulkan-drivers)?"
)
_BEGINNINGS = b"RRF", b"\x89MCAP"  # of Rerun's files, in any version of their format, and of bags
_PANIC = "panicked at"  # what a viewer without a driver ends with, above a page of stack
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_POLL = 0.1  # s between two questions

_OFFLINE = {
    "ALL_PROXY": f"http://{ADDRESS}:9",
    "NO_PROXY": ADDRESS,
}  # port 9 discards what it gets, or no program listens
ENVIRONMENT = {"RERUN_APP_ONLY": "true", "RUST_LOG": "warn"} | {
    name: value for upper, value in _OFFLINE.items() for name in (upper, upper.lower())
}
"""Of the viewer: no question about analytics, no line for what goes well, and no telemetry or
request for updates."""

Answer = TypeVar("Answer")


class PictureError(RuntimeError):
    """No picture could be made; the message is one line."""


def check_viewable(recording: Path) -> None:
    """Raise SceneError for a file that is no recording and no bag: the viewer would wait."""
    if recording.name.endswith(".mcap.part") and recording.exists():
        return  # an unfinished bag, by older versions a folder
    try:
        with recording.open("rb") as file:
            beginning = file.read(5)
    except OSError as error:
        raise SceneError(f"{recording}: {error.strerror}") from None
    if not beginning.startswith(_BEGINNINGS):
        raise SceneError(f"{recording}: is no recording: its first bytes are not those of one")


def window_command(source: str) -> list[str]:
    """Return the command that shows a recording, or a live server's address, in a window."""
    return [
        str(rerun_executable()),
        "--hide-welcome-screen",
        "--bind",
        ADDRESS,
        "--port",
        "auto",
        source,
    ]


def free_ports(count: int) -> list[int]:
    """Return ports of the loopback interface that no program uses."""
    with contextlib.ExitStack() as stack:
        probes = [stack.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind((ADDRESS, 0))
        return [probe.getsockname()[1] for probe in probes]


class HeadlessViewer:
    """A viewer that runs without a window."""

    def __init__(self, process: subprocess.Popen[bytes], port: int, log: Path) -> None:
        """Expect it at a port of the loopback interface, and its output in a file."""
        self._process, self._url, self._log = process, live_address(port), log
        self._client: ViewerClient | None = None

    def request(self, call: Callable[[ViewerClient], Answer]) -> Answer:
        """Return the response to a request that may be sent twice.

        On a busy machine a viewer needs a while to start, and may lose a connection: the request is
        sent again.

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
                    raise PictureError(
                        _describe_end(self._log.read_text(errors="replace"))
                    ) from error
                if time.monotonic() >= deadline:
                    raise PictureError(f"the viewer failed: {error}") from error
            time.sleep(_POLL)

    def load(self, recording: Path) -> ViewerState:
        """Open a recording; return what the viewer shows when it has loaded all of it.

        Of a file that it opens itself it would load, while it draws, only what it draws just then.

        Raises:
            PictureError: it cannot read it, or does not load it within `LOAD_SECONDS`.
        """
        with _served(recording) as address:
            opened = self.request(lambda client: client.open(address))
            if not (opened.store_ids or opened.loading):
                raise PictureError(f"{recording}: the viewer cannot read it")
            deadline = time.monotonic() + LOAD_SECONDS
            while time.monotonic() < deadline:
                state = self.request(lambda client: client.get_state())
                if state.active_recording and not state.loading:
                    return state
                time.sleep(_POLL)
        raise PictureError(f"{recording}: the viewer did not load it within {LOAD_SECONDS:g} s")


@contextlib.contextmanager
def headless_viewer() -> Iterator[HeadlessViewer]:
    """Run a viewer for the length of the block; it ends with this process, however that ends."""
    (port,) = free_ports(1)
    command = [
        str(rerun_executable()),
        "--headless",
        "--hide-welcome-screen",
        "--bind",
        ADDRESS,
        "--port",
        str(port),
    ]
    with tempfile.TemporaryDirectory(
        prefix="crane_sim-"
    ) as folder:  # a viewer that is ended leaves one of its own
        env, log = os.environ | ENVIRONMENT | {"TMPDIR": folder}, Path(folder, "viewer.log")
        try:
            with log.open("wb") as output:
                process = subprocess.Popen(
                    command,
                    env=env,
                    stdout=output,
                    stderr=output,
                    preexec_fn=set_parent_death_signal(),
                )
        except OSError as error:
            raise PictureError(f"no viewer: {error}") from error
        try:
            yield HeadlessViewer(process, port, log)
        finally:
            end_process(process, END_SECONDS)


@contextlib.contextmanager
def _served(recording: Path) -> Iterator[str]:
    """Serve a recording on the loopback interface during the block; yield its secret address.

    Of one that is cut it is what is whole.
    """
    path = f"/{secrets.token_hex(16)}/{quote(recording.name.removesuffix('.part'))}"
    whole = open_viewable(recording) or recording.open("rb")
    again = f"/proc/self/fd/{whole.fileno()}"  # opened anew, it is read from its beginning

    class _Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:  # noqa: N802  (the name that the server looks for)
            if self.path != path:
                self.send_error(HTTPStatus.NOT_FOUND)
                return
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Length", str(os.fstat(whole.fileno()).st_size))
            self.end_headers()
            with open(again, "rb") as file:
                shutil.copyfileobj(file, self.wfile)

        def log_message(self, format: str, *args: object) -> None:
            pass

    with whole, ThreadingHTTPServer((ADDRESS, 0), _Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://{ADDRESS}:{server.server_port}{path}"
        finally:
            server.shutdown()


def _describe_end(output: str) -> str:
    """Return one line on why a viewer has ended, from its output."""
    text = _COLOUR.sub("", output).strip()
    return (
        f"the viewer ended: {text.splitlines()[-1].strip()}"
        if text and _PANIC not in output
        else NO_DRAWING
    )
