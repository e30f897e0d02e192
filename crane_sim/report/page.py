"""The page of a run: one HTML file that plays it, without a server, a network or any other file."""

from __future__ import annotations

import json
import re
from html import escape
from typing import TYPE_CHECKING, Any

from crane_sim.files.output import write_output
from crane_sim.recording.read import as_recorded
from crane_sim.report.assets import read_asset
from crane_sim.report.comparison_page import comparison_data
from crane_sim.report.page_data import page_data

if TYPE_CHECKING:
    from pathlib import Path

    from crane_sim.recording.comparison import Comparison
    from crane_sim.recording.run import RecordedRun
    from crane_sim.simulation.rollout import Rollout

SCRIPTS = ("three.min.js", "frames.js", "body.js", "crane.js", "charts.js", "page.js")


def save_page(run: RecordedRun, file: Path) -> None:
    """Write the page of a run.

    Raises:
        SceneError: the file cannot be written.
    """
    _write(page(run), file)


def save_comparison(comparison: Comparison, file: Path) -> None:
    """Write the page of a comparison.

    Raises:
        SceneError: the file cannot be written.
    """
    _write(_document(" / ".join(comparison.names), comparison_data(comparison)), file)


def page(run: RecordedRun) -> str:
    """Return the HTML document of a run."""
    return _document(f"{run.name} · {run.crane.kind} crane", page_data(run))


def _write(document: str, file: Path) -> None:
    write_output("-o", file, lambda path: path.write_text(document, encoding="utf-8"))


def _document(title: str, values: dict[str, Any]) -> str:
    data = json.dumps(values, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    parts = {
        "@title@": escape(title),
        "@style@": read_asset("page.css"),
        "@scripts@": "\n".join(f"<script>\n{read_asset(name)}</script>" for name in SCRIPTS),
        "@licence@": escape(read_asset("three.LICENSE.txt")),
        "@run@": data,
    }
    return re.sub("|".join(parts), lambda mark: parts[mark.group()], read_asset("page.html"))


def show(run: RecordedRun | Rollout, height: int = 900) -> Frame:
    """Return the page of a run for a notebook, what its method `show` returns."""
    return Frame(as_recorded(run), height)


class Frame:
    """The page of a run in a notebook: a frame of its own, `height` pixels high."""

    def __init__(self, run: RecordedRun, height: int) -> None:
        self._run, self._height = run, height

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{self._height}px;border:0"
        return (
            f'<iframe srcdoc="{escape(page(self._run))}" style="{style}" '
            'sandbox="allow-scripts"></iframe>'
        )
