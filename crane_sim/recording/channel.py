"""What a curve of a recording is: its entity, its name and colour, and how a block yields its values."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from crane_sim.recording.layout import Block, Numbers

Color = tuple[int, int, int]
PALETTE: tuple[Color, ...] = (
    (86, 156, 236),
    (245, 166, 60),
    (94, 201, 118),
    (205, 128, 224),
    (70, 204, 205),
    (240, 100, 96),
)
PLAIN: Color = (226, 230, 236)


class Channel(NamedTuple):
    """The curves of one entity; `values` returns (K,) or (K, curves), or None where the run has no such quantity."""

    entity: str
    names: tuple[str, ...]
    colors: tuple[Color, ...]
    values: Callable[[Block], Numbers | None]
    width: float = 1.6


def colors_of(which: Sequence[int]) -> tuple[Color, ...]:
    """Return the colours of curves by their numbers."""
    return tuple(PALETTE[i % len(PALETTE)] for i in which)


def soften(color: Color) -> Color:
    """Return the darker tone that marks a target beside the curve that is to reach it."""
    red, green, blue = color
    return (6 * red // 10, 6 * green // 10, 6 * blue // 10)
