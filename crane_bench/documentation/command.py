"""`crane docs`: lists the pages that commands write, and runs these commands."""

import shlex
import subprocess
import sys
from collections.abc import Sequence

from rich.console import Console

from crane_bench.documentation.pages import PAGES
from crane_bench.documentation.site import source_tree
from crane_sim.cli.tables import print_table
from crane_sim.files.errors import SceneError, unknown_key

PICTURES = "pictures"
"""What is written beside the pages: pictures of runs."""
WIDE = 260  # columns of a pipe, so that each command is on one line


def docs(names: Sequence[str]) -> None:
    """List the pages, or write the named ones from the source tree.

    `pictures` and `all` are names, too.

    Raises:
        SceneError: as of `check_names`, or a command failed.
    """
    check_names(names)
    if not names:
        print_pages()
        return
    tree = source_tree()
    if {PICTURES, "all"} & {*names}:
        from crane_bench.documentation.pictures import save_pictures  # needs Rerun

        save_pictures(tree / "docs")
    for name in PAGES if "all" in names else (name for name in names if name != PICTURES):
        command = [str(tree / "crane"), *shlex.split(PAGES[name].command)]
        if subprocess.run(command, cwd=tree, check=False).returncode:
            raise SceneError(f"{name}: crane {PAGES[name].command}: failed, see above")


def check_names(names: Sequence[str]) -> None:
    """Raise SceneError where there is no page of one of these names, or this is no source tree."""
    for name in names:
        if name not in (*PAGES, PICTURES, "all"):
            raise SceneError(unknown_key(name, (*PAGES, PICTURES, "all"), "page"))
    if names:
        source_tree()


def print_pages() -> None:
    """Print each page, its command, how long that takes, and what measures the data behind it."""
    rows = [
        (f"{name}.md", f"crane {page.command}", f"{page.minutes:g}", "\n".join(page.measured))
        for name, page in PAGES.items()
    ]
    rows.append(
        ("*.png", f"crane docs {PICTURES}", "1", "runs of the catalogue, drawn by the viewer")
    )
    console = Console(width=None if sys.stdout.isatty() else WIDE)
    print_table(console, "docs", ("page", "written by", "minutes", "from what these measure"), rows)
