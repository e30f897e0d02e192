"""How large a crane is and where its picture is taken from: what the drawing needs beside the crane's own solids."""

from __future__ import annotations

from math import cos, radians, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.description.envelope import envelope
from crane_sim.description.knuckle import pedestal_height
from crane_sim.overhead import OverheadCrane
from crane_sim.supports.trolley import trolley_mass

if TYPE_CHECKING:
    from crane_sim.model import Crane
    from crane_sim.scene import Scene

Vector = tuple[float, float, float]


class Framing(NamedTuple):
    """World coordinates in m."""

    size: float  # a typical length of the crane: sets line widths
    ground: Vector  # middle of the ground that is drawn
    ground_size: float  # from its middle to its edge
    eye: Vector
    look_at: Vector
    effort_scales: tuple[float, ...]  # the efforts (nu,) that are drawn as arrows of a seventh of `size`


def framing(scene: Scene) -> Framing:
    """Return how to draw a scene's crane."""
    if isinstance(scene.model, OverheadCrane):
        return _overhead(scene, scene.model)
    return _knuckle(scene, scene.model)


def _knuckle(scene: Scene, crane: Crane) -> Framing:
    boom, jib, load = crane.support.boom, crane.support.jib, crane.load.mass
    size = boom.length + jib.length
    heading = 0.5 * (scene.initial_q[0] + (scene.reference or scene.initial_q)[0])  # where the crane works
    aside = heading - radians(72.0)
    # a joint needs this much to carry the outstretched crane; the slew, which carries nothing, gets a fifth
    torque = crane.gravity * boom.length * (load + 0.5 * boom.mass + jib.mass)
    scales = {"N m": torque, "N": load * crane.gravity}
    slew, *others = (max(scales[unit], 1e-9) for unit in scene.effort_units)
    return Framing(
        size=size,
        ground=(0.0, 0.0, -pedestal_height(crane)),
        ground_size=1.25 * size,
        eye=(1.4 * size * cos(aside), 1.4 * size * sin(aside), 0.55 * size),
        look_at=(0.46 * size * cos(heading), 0.46 * size * sin(heading), -0.03 * size),
        effort_scales=(0.2 * slew, *others),
    )


def _overhead(scene: Scene, crane: OverheadCrane) -> Framing:
    room = envelope(scene, crane)
    hanging = float(np.sum(crane.cable.masses))
    # a trolley that brings all up to speed at 2 m/s², a hoist that carries what hangs on it
    scales = {"trolley": 2.0 * (hanging + trolley_mass(crane.trolley)), "hoist": max(crane.gravity, 1.0) * hanging}
    away, middle = max(1.7 * room.reach, 1.4 * room.span), 0.5 * room.ground
    return Framing(
        size=room.reach,
        ground=(room.middle, 0.0, room.ground),
        ground_size=0.6 * max(room.span, 1.5 * room.reach),
        eye=(room.middle + 0.3 * away, -away, middle + 0.28 * away),
        look_at=(room.middle, 0.0, middle),
        effort_scales=tuple(scales[name] for name in scene.actuated),
    )
