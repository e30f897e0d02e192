"""The documentation site: the pages of `docs` and two of the tree's own, built by Zensical without a network."""

import re
import shutil
import subprocess
import sys
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from crane_sim.files.errors import SceneError

CONFIG = "zensical.toml"
OWN = {"ARCHITECTURE.md": "architecture.md", "CHANGELOG.md": "changelog.md"}
"""Pages of the tree's root, and their names in the site."""
ADDRESS = ("127.0.0.1", 8000)
LINK = re.compile(r"(\]\()(?:\.\./)?([^)#:\s]+)(#[^)\s]*)?\)")
"""A link to a file: [text](file#heading)."""


def build_site(tree: Path, folder: Path) -> Path:
    """Build the site of a source tree into a folder; one that an earlier build made is replaced. Returns the folder.

    Raises:
        SceneError: a link leads nowhere or a page is missing, the folder is another's, or Zensical is not installed.
    """
    if find_spec("zensical") is None:
        raise SceneError("crane docs --build: needs the Python package zensical (pip install crane_sim[docs])")
    if folder.exists() and not (folder.is_dir() and (not any(folder.iterdir()) or (folder / "search.json").is_file())):
        raise SceneError(f"{folder}: exists and is no site of this command's making; name another with --output")
    with TemporaryDirectory() as temporary:
        stage_pages(tree, Path(temporary))
        command = [sys.executable, "-m", "zensical", "build", "--strict"]
        done = subprocess.run(command, cwd=temporary, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SceneError(f"crane docs --build: {' '.join((done.stdout + done.stderr).split())}")
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(Path(temporary, "site"), folder)
    return folder


def stage_pages(tree: Path, folder: Path) -> None:
    """Copy what the site is built from into a folder; links between `docs` and the tree's root lead to its pages."""
    shutil.copy(tree / CONFIG, folder)
    shutil.copytree(tree / "docs", folder / "docs")
    pages = {page: tree / source for source, page in OWN.items()}
    for name, file in (pages | {file.name: file for file in (tree / "docs").glob("*.md")}).items():
        Path(folder, "docs", name).write_text(LINK.sub(_link_in_site, file.read_text()))


def _link_in_site(link: re.Match[str]) -> str:
    return f"{link[1]}{OWN.get(link[2], link[2].removeprefix('docs/'))}{link[3] or ''})"


def serve_site(folder: Path) -> None:
    """Serve a folder on the loopback interface until Ctrl-C; prints the address."""
    handler = partial(SimpleHTTPRequestHandler, directory=str(folder))
    with ThreadingHTTPServer(ADDRESS, handler) as server:
        print(f"http://{ADDRESS[0]}:{ADDRESS[1]}/ until Ctrl-C", flush=True)
        server.serve_forever()
