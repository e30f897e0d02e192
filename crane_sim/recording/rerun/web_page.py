"""The viewer as a page on the loopback interface, which makes no request to any other machine.

Rerun's own page asks for fonts, examples and updates on the Internet, and sends telemetry. This one
is the same without links to fonts, under a policy by which a browser refuses every request but to
this machine.
"""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
import threading
import time
from collections.abc import Iterator
from functools import partial
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import quote

from crane_sim.process_signals import end_process, set_parent_death_signal
from crane_sim.recording.rerun.live import ADDRESS, live_address
from crane_sim.recording.rerun.repair import rerun_executable
from crane_sim.recording.rerun.viewer import END_SECONDS, ENVIRONMENT, free_ports

START_SECONDS = 60.0  # for the viewer to serve its page, on however busy a machine
POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; connect-src 'self' data: "
    f"http://{ADDRESS}:*"
)
"""Content-Security-Policy of the page: its scripts are in it, compile code, and read data of this
machine."""
# headers of the viewer's answers; the latter is for its progress bar
_KEPT = ("Content-Type", "rerun-final-length")
_ELSEWHERE = re.compile(rb"<link[^>]*https?://[^>]*>")  # links of the page to other machines
_POLL = 0.05  # s between two questions whether the viewer has started


@contextlib.contextmanager
def web_page(source: str) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """Serve the page of a recording, or of what a live server serves, during the block.

    Yields the process of the viewer, which serves the data until it ends, and the address of the
    page.

    Raises:
        RuntimeError: the viewer does not start; it has said why on stderr.
    """
    page_port, data_port = free_ports(2)
    served = source if "://" in source else live_address(data_port)
    command = [str(rerun_executable()), "--serve-web", "--bind", ADDRESS]
    command += ["--port", str(data_port), "--web-viewer-port", str(page_port), source]
    viewer = subprocess.Popen(
        command, env=os.environ | ENVIRONMENT, preexec_fn=set_parent_death_signal()
    )
    try:
        _wait_for_start(viewer, page_port)
        with ThreadingHTTPServer((ADDRESS, 0), partial(_Page, page_port)) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            try:
                query = f"url={quote(served, safe='')}&hide_welcome_screen"
                yield viewer, f"http://{ADDRESS}:{server.server_port}/?{query}"
            finally:
                server.shutdown()
    finally:
        end_process(viewer, END_SECONDS)


def _wait_for_start(viewer: subprocess.Popen[bytes], port: int) -> None:
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline and viewer.poll() is None:
        with contextlib.suppress(OSError):
            HTTPConnection(ADDRESS, port, timeout=START_SECONDS).connect()
            return
        time.sleep(_POLL)
    raise RuntimeError("the viewer did not start")


class _Page(BaseHTTPRequestHandler):
    """Answers with what the viewer's own page has at a path, under `POLICY`."""

    def __init__(self, port: int, *args: object) -> None:
        self._port = port
        super().__init__(*args)  # pyright: ignore[reportArgumentType]

    def do_GET(self) -> None:  # noqa: N802  (the name that the server looks for)
        """Answer a request."""
        with contextlib.suppress(OSError):  # of a browser that has gone, or a viewer that ends
            self._pass_on()

    def _pass_on(self) -> None:
        connection = HTTPConnection(ADDRESS, self._port)
        connection.request("GET", self.path)
        answer = connection.getresponse()
        body = (
            _ELSEWHERE.sub(b"", content)
            if b"<html" in (content := answer.read())[:1000]
            else content
        )
        self.send_response(answer.status)
        for name in _KEPT:
            if value := answer.getheader(name):
                self.send_header(name, value)
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""
