"""The pages in `docs` that commands write: each one's command, its duration, and names of rows.

A page's rows come from the tables of cases, so that a page can be compared with its command without
running it: a case that is missing on the page fails a test.
"""

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import crane_sim
from crane_bench.documentation.scene_format import scene_format
from crane_bench.documentation.scenes_page import PORTS_AND_SITES
from crane_bench.league.cases import names as trials
from crane_bench.league.sampled_table import command_of
from crane_bench.reproduce import NAMES
from crane_bench.soak.page import PARTS as SOAKS
from crane_bench.speed import suites as bench
from crane_bench.speed.cases import CASES

HAND_WRITTEN = (
    *(
        "adding",
        "bench_top",
        "commands",
        "contact",
        "dependencies",
        "drives",
        "equations",
        "first_controller",
    ),
    *(
        "gymnasium",
        "identification",
        "index",
        "interfaces",
        "layers",
        "looking",
        "machines",
        "operator",
        "profiling",
    ),
    *(
        "reeving",
        "ros",
        "ros2_control",
        "studies",
        "summary",
        "tracing",
        "two_machines",
        "uncertain",
        "wind",
    ),
    *("your_crane", "your_effect", "your_law", "your_path"),
)
"""Pages written by hand."""


class Page(NamedTuple):
    """A page, `docs/NAME.md`."""

    command: str  # that writes it, without `crane`
    minutes: float  # that it takes on two idle cores whose cache of compiled code is empty
    expected_rows: Callable[[], list[str]]  # names of the rows or sections that it should have
    read_rows: Callable[[str], list[str]]  # names of those in its text
    measured: tuple[str, ...] = ()  # commands that measure what it is written from, where it does
    # not measure itself


def first_cells(count: int, text: str) -> list[str]:
    """Return the first cells of each row of a page's tables, heads left out."""
    lines = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]
    heads = {line.strip("| ").split(" | ")[0] for line in _heads(text)}
    return [", ".join(cells[:count]) for cells in lines if cells[0] not in heads]


def _heads(text: str) -> Iterator[str]:
    lines = text.splitlines()
    for line, below in zip(lines, lines[1:], strict=False):
        if below.startswith("|---"):
            yield line


def headings(text: str) -> list[str]:
    """Return the headings of a page's sections."""
    return re.findall(r"^## (.*)$", text, re.MULTILINE)


def trials_in(text: str) -> list[str]:
    """Return crane, law and trial of each cell of the league's page.

    Cells are rows, and laws that do not apply.
    """
    crane, cells = "", list[str]()
    text, _, _ = text.partition("## Tuned gains")
    refused = text[text.index("## Does not apply") :]
    for line in text.splitlines():
        if line.startswith("## "):
            crane = line.removeprefix("## ")
        elif line.startswith("| ") and not line.startswith("| law |"):
            law, trial = line.strip("| ").split(" | ")[:2]
            cells.append(f"{crane.lower()}, {law}, {trial.removesuffix(': not controlled')}")
    return [
        *cells,
        *(line[2:].partition(": ")[0] for line in refused.splitlines() if line.startswith("- ")),
    ]


def scenes_in(text: str) -> list[str]:
    """Return scenes and suites of the benchmark's page."""
    table = text[text.index("## The cheapest") : text.index("## Targets")]
    titles = [suite.title for suite in bench.SUITES.values()]
    return [
        *dict.fromkeys(first_cells(1, table)),
        *(title for title in headings(text) if title in titles),
    ]


def _reproduction_page(item: str, minutes: float, cells: int = 1) -> Page:
    def list_rows() -> list[str]:
        return [name.replace("|", "/") for name in NAMES[item]()]

    return Page(f"reproduce {item} --save docs", minutes, list_rows, partial(first_cells, cells))


PAGES = {
    "scene_format": Page("describe --save docs", 0.1, lambda: headings(scene_format()), headings),
    "api": Page("describe --python --save docs", 0.1, lambda: list(crane_sim.__all__), headings),
    "scenes": Page("describe --sites --save docs", 8.0, lambda: list(PORTS_AND_SITES), headings),
    "overhead": _reproduction_page("overhead", 0.1),
    "hardcases": _reproduction_page("hardcases", 10.0),
    "knuckle": _reproduction_page("knuckle", 2.0),
    "offshore": _reproduction_page("offshore", 5.0),
    "observer": _reproduction_page("observer", 8.0, cells=2),
    "league": Page(
        "league --save docs", 10.0, lambda: [", ".join(names) for names in trials()], trials_in
    ),
    "league_samples": Page(
        command_of(12), 20.0, lambda: [", ".join(names) for names in trials()], trials_in
    ),
    "performance": Page(
        "bench page --save docs",
        0.1,
        lambda: [*(case.id for case in CASES), *(suite.title for suite in bench.SUITES.values())],
        scenes_in,
        ("bench --peers --save docs", *(f"bench {suite} --save docs" for suite in bench.SUITES)),
    ),
    "soak": Page(
        "soak page --save docs",
        0.1,
        lambda: [part.title for part in SOAKS.values()],
        headings,
        tuple(f"soak {part} --save docs" for part in SOAKS),
    ),
}
"""Every page that a command writes, by name."""
