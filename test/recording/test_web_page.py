"""The viewer's page in a browser is served whole, and asks for nothing elsewhere."""

import re
import socket
import time
from http.client import HTTPResponse
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
from browser import CHROMIUM, NO_CHROMIUM, OPTIONS
from process_helpers import LIMIT, started_program

from crane_sim.recording.rerun.web_page import POLICY, web_page

ELSEWHERE = ("rerun.io", "github.com", "fonts.googleapis.com", "fonts.gstatic.com")
"""Whom Rerun's own page asks; a browser asks others for itself."""
SETTLING_SECONDS = 5.0  # from the first request for data, after which the page has made all others


def fetch(address: str) -> HTTPResponse:
    """Return the answer at an address."""
    return urlopen(address, timeout=LIMIT)


def test_the_page_has_no_link_to_another_machine() -> None:
    """Page and program come from this machine, with a policy against others, and no link to any."""
    with web_page("rerun+http://127.0.0.1:9/proxy") as (viewer, address):
        page = fetch(address)
        assert (
            page.headers["Content-Security-Policy"] == POLICY
            and "127.0.0.1" in POLICY
            and "https:" not in POLICY
        )
        text = page.read().decode()
        assert 'src="re_viewer.js"' in text and not re.search(
            r"<(link|script|img)[^>]*https?://", text
        )
        parts = urlsplit(address)
        program = fetch(f"{parts.scheme}://{parts.netloc}/re_viewer_bg.wasm")
        assert program.headers["Content-Type"] == "application/wasm" and program.read(4) == b"\0asm"
        assert viewer.poll() is None
    assert viewer.poll() is not None


@pytest.mark.long
@pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
def test_a_browser_asks_no_other_machine(tmp_path: Path) -> None:
    """A browser's network log has no request for fonts, examples, updates or telemetry."""
    log = tmp_path / "net.json"
    with socket.create_server(("127.0.0.1", 0)) as data:
        data.settimeout(LIMIT)
        with web_page(f"rerun+http://127.0.0.1:{data.getsockname()[1]}/proxy") as (_, address):
            options = (*OPTIONS, f"--user-data-dir={tmp_path / 'profile'}", f"--log-net-log={log}")
            command = [str(CHROMIUM), *options, "--remote-debugging-port=0", address]
            with started_program(command) as browser:
                data.accept()  # the page has started, and asks for the recording
                time.sleep(SETTLING_SECONDS)
                browser.terminate()
                browser.wait()
    hosts = set(re.findall(r'"host":"([^"]+)"', log.read_text()))
    assert "127.0.0.1" in hosts and not [host for host in hosts if host.endswith(ELSEWHERE)]
