"""The figure of an identification: measured positions, the fit, and the residuals."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from crane_sim.files.output import write_whole
from crane_sim.report.plotting import BLUE, GREY, RED

if TYPE_CHECKING:
    from crane_sim.identification import Identification


def save_identification_figure(found: Identification, units: dict[str, str], file: Path) -> None:
    """Draw measured joints (angles in degrees) and residuals into a file.

    OSError: it cannot be written.
    """
    joints = found.data.joints
    figure: Any = Figure(figsize=(10.0, 1.0 + 2.5 * len(joints)), layout="constrained")
    axes = figure.subplots(len(joints), 2, sharex=True, squeeze=False)
    for i, (name, row) in enumerate(zip(joints, axes, strict=True)):
        angle = units[name] == "rad"
        _draw_joint(row, found, i, degrees(1.0) if angle else 1.0)
        row[0].set_ylabel(f"{name.replace('_', ' ')} [{'deg' if angle else units[name]}]")
    axes[0, 0].legend(loc="best")
    axes[0, 0].set_title("data and fit")
    axes[0, 1].set_title("data less fit")
    for axis in axes[-1]:
        axis.set_xlabel("t [s]")
    write_whole(file, lambda path: figure.savefig(path, dpi=110))


def _draw_joint(row: Any, found: Identification, i: int, factor: float) -> None:
    """Draw positions and residuals of joint i; lines of the fit end with their segments."""
    t, q, fit = found.data.t, factor * found.data.q[:, i], factor * found.fit[:, i]
    row[0].plot(t, q, ".", color=GREY, markersize=2.0, label="data")
    ends = [*found.segments[1:], len(t)]
    for k, (first, end) in enumerate(zip(found.segments, ends, strict=True)):
        row[0].plot(
            t[first:end], fit[first:end], color=RED, linewidth=1.0, label="fit" if k == 0 else None
        )
    row[1].plot(t, q - fit, ".", color=BLUE, markersize=1.5)
    for first in found.segments[1:]:
        row[1].axvline(t[first], color=GREY, linewidth=0.5)
    largest = np.max(np.abs(q - fit), initial=0.0)
    if largest > 0.0:
        row[1].set_ylim(-1.1 * largest, 1.1 * largest)
