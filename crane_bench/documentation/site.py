"""The documentation site: pages of `docs` and two of the tree's own, built by Zensical offline."""

import re
import shutil
import subprocess
import sys
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from tempfile import TemporaryDirectory

from crane_sim.files.catalogue import config_folder
from crane_sim.files.errors import SceneError
from crane_sim.files.installation import require

CONFIG = "zensical.toml"
OWN = {"ARCHITECTURE.md": "architecture.md", "CHANGELOG.md": "changelog.md"}
"""Pages of the tree's root, and their names in the site."""
BUILD_SECONDS = 600.0  # for Zensical, on however busy a machine
ADDRESS = ("127.0.0.1", 8000)
LINK = re.compile(r"\[([^]\n]*)\]\((?:\.\./)?([^)#:\s]+)(#[^)\s]*)?\)")
"""A link to a file: [text](file#heading)."""
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_FAULT = re.compile(r"^\w+: (.*)\n.*\[ (\S+:\d+):\d+ \]", re.MULTILINE)


def source_tree() -> Path:
    """Return the source tree; raise SceneError where this is an installation without one."""
    tree = config_folder().parent
    if not (tree / "docs").is_dir():
        raise SceneError(f"{tree}: has no docs; run this in the source tree")
    return tree


def build_site(tree: Path, folder: Path) -> Path:
    """Build the site of a source tree into a folder, which is returned.

    A site of an earlier build in the folder is replaced.

    Raises:
        SceneError: a link leads nowhere or a page is missing, the folder is another's, or Zensical
            is not installed or does not end within `BUILD_SECONDS`.
    """
    require("zensical", "crane docs --build")
    if folder.exists() and not (
        folder.is_dir() and (not any(folder.iterdir()) or (folder / "search.json").is_file())
    ):
        raise SceneError(
            f"{folder}: exists and is no site of this command's making; name another with --output"
        )
    with TemporaryDirectory() as temporary:
        stage_pages(tree, Path(temporary))
        _run_zensical(temporary)
        _replace(folder.resolve(), Path(temporary, "site"))
    return folder


def _run_zensical(folder: str) -> None:
    command = [sys.executable, "-m", "zensical", "build", "--strict"]
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False, timeout=BUILD_SECONDS
        )
    except subprocess.TimeoutExpired:
        raise SceneError(
            f"crane docs --build: Zensical did not end within {BUILD_SECONDS:g} s"
        ) from None
    if done.returncode:
        raise SceneError(f"crane docs --build: {_faults(done.stdout + done.stderr)}")


def _replace(folder: Path, site: Path) -> None:
    """Put a site in the place of a folder.

    The folder stays whole until the site has been copied to the same disk.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(prefix=f".{folder.name}.", dir=folder.parent) as beside:
        copy = Path(shutil.copytree(site, Path(beside, "new")))
        former = folder.rename(Path(beside, "former")) if folder.exists() else None
        try:
            copy.rename(folder)
        except BaseException:
            if former is not None:
                former.rename(folder)
            raise


def _faults(text: str) -> str:
    """Return in one line what Zensical complains about and where, else its last line."""
    found = _FAULT.findall(_COLOUR.sub("", text))
    return (
        "; ".join(f"{where}: {what}" for what, where in found) or text.strip().rpartition("\n")[2]
    )


def stage_pages(tree: Path, folder: Path) -> None:
    """Copy the sources of the site into a folder.

    Links between `docs` and the tree's root lead to the site's pages.
    """
    shutil.copy(tree / CONFIG, folder)
    shutil.copytree(tree / "docs", folder / "docs")
    sources = {file.name: file for file in (tree / "docs").glob("*.md")}
    sources |= {page: tree / source for source, page in OWN.items()}
    texts = {page: file.read_text() for page, file in sources.items()}
    titles = {page: text.partition("\n")[0].removeprefix("# ") for page, text in texts.items()}
    for page, text in texts.items():
        Path(folder, "docs", page).write_text(LINK.sub(partial(_link_in_site, titles), text))


def _link_in_site(titles: dict[str, str], link: re.Match[str]) -> str:
    """Return a link with its page's name in the site, and its title in place of a file's name."""
    text, target, heading = link.groups(default="")
    page = OWN.get(target, target.removeprefix("docs/"))
    shown = titles.get(page, text) if text.removeprefix("docs/") in (page, target) else text
    return f"[{shown}]({page}{heading})"


def serve_site(folder: Path) -> None:
    """Serve a folder on the loopback interface until Ctrl-C; prints the address."""
    handler = partial(SimpleHTTPRequestHandler, directory=str(folder))
    with ThreadingHTTPServer(ADDRESS, handler) as server:
        print(f"http://{ADDRESS[0]}:{ADDRESS[1]}/ until Ctrl-C", flush=True)
        server.serve_forever()
