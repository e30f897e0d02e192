"""The curves that the nodes of an overhead crane's cable tell, whatever its coordinates are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from crane_sim.recording.channel import PALETTE, PLAIN, Channel, colors_of

if TYPE_CHECKING:
    from crane_sim.recording.layout import Numbers
    from crane_sim.recording.suspension import Suspension

BLUE_GREEN, XZ = (PALETTE[0], PALETTE[2]), (0, 2)


def cable_channels(cable: Suspension) -> list[Channel]:
    """Return them: the energies, the payload's way, swings that are no joints, the length of an elastic cable."""
    parts = ("kinetic [J]", "potential [J]")
    listed = [
        Channel("plots/energy_parts", parts, BLUE_GREEN, lambda b: np.column_stack([b.kinetic, b.potential])),
        *(_planar(cable) if cable.planar else _spatial()),
    ]
    if cable.elastic:
        listed.append(Channel("shown/cable_m", ("cable",), (PALETTE[3],), lambda b: _length(b.nodes)))
    return listed


def _planar(cable: Suspension) -> list[Channel]:
    listed = [Channel("shown/payload_m", ("x", "z"), BLUE_GREEN, lambda b: b.nodes[:, -1, XZ])]
    if cable.elastic:
        names, lower = tuple(f"link {k}" for k in cable.links), np.array(cable.links)
        colors = colors_of(range(1, 1 + len(names)))
        listed.append(Channel("shown/swing_deg", names, colors, lambda b: _lean(_links(b.nodes)[:, lower - 1], 0)))
    if len(cable.links) > 1:
        names = ("trolley to payload",)
        listed.append(Channel("shown/swing_total_deg", names, (PLAIN,), lambda b: _lean(_whole(b.nodes), 0), 2.2))
    return listed


def _spatial() -> list[Channel]:
    return [
        Channel("shown/lean_deg", ("towards x", "towards y"), PALETTE, lambda b: _leans(_whole(b.nodes))),
        Channel("shown/swing_total_deg", ("from the vertical",), (PLAIN,), lambda b: np.degrees(b.swing)),
    ]


def _links(nodes: Numbers) -> Numbers:
    """Return the vectors (K, N, 3) from node to node."""
    return np.diff(nodes, axis=1)


def _whole(nodes: Numbers) -> Numbers:
    """Return the vector (K, 3) from the trolley to the payload."""
    return nodes[:, -1] - nodes[:, 0]


def _lean(line: Numbers, axis: int) -> Numbers:
    """Return the angles [°] from the downward vertical of vectors (..., 3), seen across a horizontal axis."""
    return np.degrees(np.arctan2(line[..., axis], -line[..., 2]))


def _leans(line: Numbers) -> Numbers:
    return np.column_stack([_lean(line, 0), _lean(line, 1)])


def _length(nodes: Numbers) -> Numbers:
    return np.linalg.norm(_links(nodes), axis=2).sum(axis=1)
