"""Figures of the pages as PNG files, drawn by matplotlib, an optional package: without it a page has no figure."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from crane_sim.files.installation import how_to_install
from crane_sim.files.output import write_whole

RED, BLUE, GREEN, GREY = "#c43d3d", "#2a78b8", "#2f9e62", "#555555"


def save_figure(draw: Callable[[Any, Any], None], data: Any, file: Path, dpi: int) -> bool:
    """Write a figure into a PNG file and return True; without matplotlib a line on stderr, and False.

    Args:
        draw: draws data into a `matplotlib.figure.Figure` without axes.
        data: what is drawn.
        file: where it goes.
        dpi: pixels per inch.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        print(f"no {file.name}: the figure needs matplotlib ({how_to_install('plots')})", file=sys.stderr)
        return False
    figure = Figure(layout="constrained")
    draw(figure, data)
    write_whole(file, lambda path: figure.savefig(path, dpi=dpi))
    return True
