"""Solids of a description as static entities of a recording: one for boxes, one for cylinders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import rerun as rr

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.description.solids import Shape


def log_solids(rec: rr.RecordingStream, entity: str, frame: str, shapes: Sequence[Shape]) -> None:
    """Log boxes and cylinders that stand in a frame, in place of those that this entity had before."""
    for kind, solids in (("boxes", _boxes(shapes)), ("cylinders", _cylinders(shapes))):
        if solids is not None:
            rec.log(f"{entity}/{kind}", rr.CoordinateFrame(frame), solids, static=True)


def _boxes(shapes: Sequence[Shape]) -> rr.Boxes3D | None:
    chosen = [shape for shape in shapes if len(shape.size) == 3]
    if not chosen:
        return None
    return rr.Boxes3D(
        half_sizes=[[0.5 * edge for edge in shape.size] for shape in chosen],
        centers=[shape.at for shape in chosen],
        rotation_axis_angles=[_lean(shape) for shape in chosen],
        colors=[_color(shape) for shape in chosen],
        fill_mode="solid",
    )


def _cylinders(shapes: Sequence[Shape]) -> rr.Cylinders3D | None:
    chosen = [shape for shape in shapes if len(shape.size) == 2]
    if not chosen:
        return None
    return rr.Cylinders3D(
        radii=[shape.size[0] for shape in chosen],
        lengths=[shape.size[1] for shape in chosen],
        centers=[shape.at for shape in chosen],
        rotation_axis_angles=[_lean(shape) for shape in chosen],
        colors=[_color(shape) for shape in chosen],
        fill_mode="solid",
    )


def _lean(shape: Shape) -> rr.RotationAxisAngle:
    """Return a shape's turn about x, the only one that an overhead crane's solids have."""
    return rr.RotationAxisAngle((1.0, 0.0, 0.0), radians=shape.rpy[0])


def _color(shape: Shape) -> tuple[int, ...]:
    return tuple(round(255.0 * float(part)) for part in shape.color.split())
