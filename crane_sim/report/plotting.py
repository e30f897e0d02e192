"""Figures of the pages as PNG files, drawn by matplotlib, which is optional.

Without it a page has no figure.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from crane_sim.files.installation import MissingPackage, import_optional
from crane_sim.files.output import write_whole

RED, BLUE, GREEN, GREY = "#c43d3d", "#2a78b8", "#2f9e62", "#555555"


def save_figure(draw: Callable[[Any, Any], None], data: Any, file: Path, dpi: int) -> bool:
    """Write a figure into a PNG file, and return whether there is matplotlib to draw it.

    Without it, a line on stderr says so.

    Args:
        draw: draws data into a `matplotlib.figure.Figure` without axes.
        data: what is drawn.
        file: where it goes.
        dpi: pixels per inch.
    """
    try:
        figure = import_optional("matplotlib.figure", "the figure").Figure(layout="constrained")
    except MissingPackage as error:
        print(f"no {file.name}: {error}", file=sys.stderr)
        return False
    draw(figure, data)
    write_whole(file, lambda path: figure.savefig(path, dpi=dpi))
    return True
