"""The documentation site: built offline, without a broken link, and without any request."""

import re
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest
from browser import CHROMIUM, NO_CHROMIUM, evaluate_in_pages

from crane_bench.documentation import site as site_module
from crane_bench.documentation.site import OWN, build_site, stage_pages
from crane_sim.files.errors import SceneError

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *(file.stem for file in (ROOT / "docs").glob("*.md")),
        *(Path(name).stem for name in OWN.values()),
    ]
)
OPENED = ("index", "first_controller", "api", "scene_format", "ros", "scenes", "performance")
OTHERS = tuple(name for name in PAGES if name not in OPENED)
SCRIPT = """() => ({
  wide: document.documentElement.scrollWidth,
  height: document.body.scrollHeight,
  broken: [...document.images].filter((image) => image.complete && !image.naturalWidth).map((image) => image.src),
})"""  # noqa: E501


class Page(HTMLParser):
    """What a page refers to, and what of it can be referred to."""

    def __init__(self, file: Path) -> None:
        """Read a file."""
        super().__init__()
        self.links: list[str] = []
        self.resources: list[str] = []
        self.names: set[str] = set()
        self.feed(file.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note references and names."""
        found = {name: value for name, value in attrs if value}
        self.names |= {found[key] for key in ("id", "name") if key in found}
        if "href" in found:
            (self.links if tag == "a" else self.resources).append(found["href"])
        self.resources += [
            found[key] for key in ("src", "srcset", "data", "poster") if key in found
        ]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site."""
    return build_site(ROOT, tmp_path_factory.mktemp("site"))


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[str, Page]:
    """Read all pages."""
    return {file.stem: Page(file) for file in site.glob("*.html") if file.stem != "404"}


def test_every_page_is_in_the_navigation(pages: dict[str, Page]) -> None:
    """The site has all pages of the tree, and the first page's navigation leads to each."""
    assert sorted(pages) == PAGES
    assert {f"./{name}.html" for name in PAGES if name != "index"} <= {*pages["index"].links}


def test_every_link_leads_somewhere(site: Path, pages: dict[str, Page]) -> None:
    """Each link to a page or a file of the site has its target, and its heading if any."""
    for name, page in pages.items():
        for link in page.links:
            target, heading = urlsplit(link).path, unquote(urlsplit(link).fragment)
            if urlsplit(link).scheme:
                continue
            file = site / (target or f"{name}.html")
            assert file.exists(), f"{name}: {link}"
            if heading and file.suffix == ".html" and heading != "__skip":
                assert heading in pages[file.stem].names, f"{name}: {link}: no such heading"


def test_nothing_comes_from_elsewhere(site: Path, pages: dict[str, Page]) -> None:
    """Scripts, styles, fonts and pictures of all pages and their styles are files of the site."""
    pattern = re.compile(r"""(?:url\(|@import\s)\s*["']?([^"')\s]+)""")
    assert pattern.findall("@import 'a.css'; b { background: url( \"c.png\" ) }") == [
        "a.css",
        "c.png",
    ]
    styles = [url for file in site.rglob("*.css") for url in pattern.findall(file.read_text())]
    assert styles and not [url for url in styles if url.startswith(("http", "//"))]
    for name, page in pages.items():
        for resource in page.resources:
            assert not urlsplit(resource).netloc, f"{name}: {resource}"
            assert (site / unquote(urlsplit(resource).path)).exists(), f"{name}: {resource}"


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on the loopback interface; yields the address."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: Any) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}"
        finally:
            server.shutdown()
            thread.join()


@pytest.mark.long(cases=["others"])
@pytest.mark.parametrize(
    "names", [pytest.param(OPENED, id="some"), pytest.param(OTHERS, id="others")]
)
@pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
def test_pages_open_without_errors(site: Path, names: tuple[str, ...]) -> None:
    """In a browser no page logs an error or asks another address; none is wider than its window."""
    texts = {f"asked_{name}": (site / f"{name}.html").read_text() for name in names}
    with served(site) as address:
        answers = evaluate_in_pages(texts, SCRIPT, site, address=address)
    assert set(answers) == set(texts)
    for name, answer in answers.items():
        assert answer["faults"] == [] and answer["answer"]["broken"] == [], name
        assert answer["requests"] and all(url.startswith(address) for url in answer["requests"]), (
            name
        )
        assert answer["answer"]["wide"] <= 900 and answer["answer"]["height"] > 700, name


def test_search_knows_every_page(site: Path) -> None:
    """The index that the search reads, a file of the site, has every page."""
    index = (site / "search.json").read_text()
    assert all(f'"{name}.html' in index for name in PAGES if name != "index")


def test_a_build_that_does_not_end_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The program that makes the site has a time limit, and one line says so."""
    monkeypatch.setattr(site_module, "BUILD_SECONDS", 1e-3)
    with pytest.raises(
        SceneError, match=r"^crane docs --build: Zensical did not end within 0\.001 s$"
    ):
        build_site(ROOT, tmp_path / "out")


def test_an_interrupted_build_keeps_the_former_site(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while the site is copied leaves the former one whole; the next build replaces it."""
    folder, copytree = tmp_path / "out", shutil.copytree

    def build(*_: object, cwd: str, **__: object) -> SimpleNamespace:
        Path(cwd, "site").mkdir()
        Path(cwd, "site", "search.json").write_text("new")
        return SimpleNamespace(returncode=0)

    def interrupted(source: Path, target: Path, *rest: Any) -> Path:
        if source.name == "site":
            target.mkdir(exist_ok=True)
            (target / "index.html").write_text("half of it")
            raise KeyboardInterrupt
        return copytree(source, target, *rest)

    monkeypatch.setattr(site_module.subprocess, "run", build)
    folder.mkdir()
    (folder / "search.json").write_text("former")
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(shutil, "copytree", interrupted)
        build_site(ROOT, folder)
    assert (folder / "search.json").read_text() == "former"
    assert build_site(ROOT, folder) == folder and (folder / "search.json").read_text() == "new"
    assert [file.name for file in tmp_path.iterdir()] == ["out"]


def test_a_broken_link_is_refused(tmp_path: Path) -> None:
    """A link to a missing page ends the build with its name.

    A folder of other files is not replaced.
    """
    tree, folder = tmp_path / "tree", tmp_path / "theirs"
    stage_pages(ROOT, tmp_path)
    (tmp_path / "docs").rename(tmp_path / "tree-docs")
    tree.mkdir()
    (tmp_path / "tree-docs").rename(tree / "docs")
    (tmp_path / "zensical.toml").rename(tree / "zensical.toml")
    for name in OWN:
        (tree / name).write_text("# Page\n")
    (tree / "docs" / "wind.md").write_text("# Wind\n\n[a page](that_is_not_there.md)\n")
    with pytest.raises(SceneError, match=r"wind.md:3: page does not exist"):
        build_site(tree, tmp_path / "out")
    folder.mkdir()
    (folder / "thesis.txt").write_text("mine")
    with pytest.raises(SceneError, match="no site of this command's making"):
        build_site(ROOT, folder)
    assert (folder / "thesis.txt").read_text() == "mine"
