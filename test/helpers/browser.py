"""Pages in a headless Chromium without a network: what scripts report, and what goes wrong."""

import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
NO_CHROMIUM = "there is no chromium on this machine"
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-gpu-sandbox",
)
OFFLINE = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"
BUDGET = 20_000  # ms of the browser's virtual time, which passes as fast as the pages are ready
FAULTS = """<script>
const faults = [];
for (const name of ["error", "warn"]) console[name] = (...words) => faults.push(words.join(" "));
addEventListener("error", (event) => faults.push(event.message));
document.addEventListener("securitypolicyviolation", (event) => faults.push(`request to ${event.blockedURI}`));
</script>"""  # noqa: E501
ANSWER = """<script>
addEventListener("load", () => setTimeout(() => {
  const requests = performance.getEntriesByType("resource").map((each) => each.name);
  parent.postMessage({ name: "@name@", faults, requests, answer: (@script@)() }, "*");
}, 50));
</script>"""
LISTENER = """<pre id="answers"></pre><script>
const answers = {};
addEventListener("message", ({ data }) => {
  answers[data.name] = data;
  document.getElementById("answers").textContent = JSON.stringify(answers);
});
</script>"""


def evaluate_in_pages(
    pages: dict[str, str], script: str, folder: Path, time_limit: float = 240.0, address: str = ""
) -> dict[str, Any]:
    """Return by page's name a JavaScript function's `answer`, the `faults` and the `requests`.

    All pages are opened at once, by one browser, 900 pixels wide: from files, or from the address
    on the loopback interface at which the folder is served.
    """
    frames = LISTENER
    for name, page in pages.items():
        watched = page.replace("<head>", f"<head>{FAULTS}", 1)
        asking = ANSWER.replace("@name@", name).replace("@script@", script)
        Path(folder, f"{name}.html").write_text(watched.replace("</body>", f"{asking}</body>", 1))
        frames += f'<iframe src="{name}.html" width="900" height="700"></iframe>'
    outer = Path(folder, "outer.html")
    outer.write_text(f"<!doctype html><meta charset='utf-8'>{frames}")
    profile = f"--user-data-dir={Path(folder, 'profile')}"
    command = [
        CHROMIUM or "",
        *OPTIONS,
        OFFLINE,
        profile,
        f"--virtual-time-budget={BUDGET}",
        "--dump-dom",
        f"{address}/{outer.name}" if address else outer.as_uri(),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=time_limit, check=True)
    found = re.search(r'<pre id="answers">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found and found[1], done.stderr[-2000:]
    return json.loads(unescape(found[1]))
