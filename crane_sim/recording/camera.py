"""Size of a crane and position of the camera: needed for drawing beside the crane's own solids."""

from __future__ import annotations

from math import cos, radians, sin, tan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crane_sim.description.falls import depth_of
from crane_sim.description.knuckle import pedestal_height
from crane_sim.description.pendulum import cable_length
from crane_sim.description.suspended import contact_height, crane_size, ground_height
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.supports.actuated_support import bare_support
from crane_sim.models.suspended.crane import SuspendedCrane

if TYPE_CHECKING:
    from crane_sim.description.workspace import BoundingBox
    from crane_sim.scenes.scene import Scene

Vector = tuple[float, float, float]
VIEW = 55.0  # degrees, the viewer's field of view from top to bottom
ASPECT = 0.84  # width over height of the view, a little less than on a screen of 16:9
FAR = 10.0  # depths of the cable: the longest rail that is shown whole
TROLLEY = "crane/trolley"
PLANE, SPACE = (-70.0, 14.0), (-78.0, 24.0)  # degrees: heading and height from where an overhead crane is looked at


class Framing(NamedTuple):
    """World coordinates in m."""

    size: float  # a typical length of the crane: sets line widths
    ground: Vector  # middle of the ground that is drawn
    ground_size: float  # from its middle to its edge
    eye: Vector
    look_at: Vector
    deck: tuple[float, float] = (0.9, 0.6)  # half length and half width of a vessel's deck, of `ground_size`
    follows: str = ""  # the entity that the eye goes along with, keeping its distance


def of_knuckle(scene: Scene) -> Framing:
    """Return how to draw a scene's knuckle-boom crane."""
    support = bare_support(scene.model.support)
    size = support.boom.length + support.jib.length
    heading = 0.5 * (scene.initial_q[0] + (scene.reference or scene.initial_q)[0])  # where the crane works
    aside = heading - radians(72.0)
    return Framing(
        size=size,
        ground=(0.0, 0.0, -pedestal_height(support) if (surface := contact_height(scene)) is None else surface),
        ground_size=1.25 * size,
        eye=(1.4 * size * cos(aside), 1.4 * size * sin(aside), 0.55 * size),
        look_at=(0.46 * size * cos(heading), 0.46 * size * sin(heading), -0.03 * size),
        deck=(0.6, 0.25),
    )


def of_suspended(scene: Scene) -> Framing:
    """Return how to draw a tower, mobile or bridge crane."""
    size, ground = crane_size(scene), ground_height(scene)
    if "slew" not in scene.joint_names:
        return _beside_bridge(scene, size, ground)
    heading = 0.5 * (scene.initial_q[0] + (scene.reference or scene.initial_q)[0])
    aside, middle = heading - radians(70.0), 0.5 * ground if ground < -0.5 * size else 0.35 * size
    far = 1.9 * max(size, -ground)
    return Framing(
        size=size,
        ground=(0.0, 0.0, ground),
        ground_size=1.25 * size,
        eye=(far * cos(aside), far * sin(aside), middle + 0.35 * far),
        look_at=(0.4 * size * cos(heading), 0.4 * size * sin(heading), middle),
        deck=(0.6, 0.25),
    )


def _beside_bridge(scene: Scene, size: float, ground: float) -> Framing:
    """Return how to draw a bridge crane."""
    ends = np.array([scene.initial_q[:2], (scene.reference or scene.initial_q)[:2]])
    (x, y), span = ends.mean(axis=0).tolist(), float(np.ptp(ends, axis=0).max())
    far = 1.3 * max(size, span)
    return Framing(
        size=size,
        ground=(x, y, ground),
        ground_size=max(size, span),
        eye=(x + 0.4 * far, y - 1.4 * far, 0.35 * far),
        look_at=(x, y, 0.5 * ground),
    )


def of_gantry(scene: Scene) -> Framing:
    """Return how to draw a gantry crane."""
    depth, ends = depth_of(scene), [scene.initial_q[0], *(scene.reference or ())[:1]]
    x, y, span = 0.5 * (min(ends) + max(ends)), scene.initial_q[1], max(ends) - min(ends)
    far = 1.5 * max(depth, 0.8 * span)
    return Framing(
        size=0.5 * depth,
        ground=(x, y, -depth),
        ground_size=max(1.2 * depth, 0.8 * span),
        eye=(x + 0.75 * far, y - far, 0.15 * far),
        look_at=(x, y, -0.55 * depth),
    )


def heaviest_load(crane: Any) -> float:
    """Return the mass [kg] of a crane's load, of the heaviest one where loads are exchanged."""
    return crane.load.mass if crane.exchange is None else float(crane.exchange.masses.max())


def hung_mass(crane: Any) -> float:
    """Return the mass [kg] that hangs on a crane's rope: of links and load, the heaviest one where it is exchanged."""
    if not isinstance(crane, SuspendedCrane):
        return heaviest_load(crane) if isinstance(crane, FallsCrane) else crane.load.mass
    return heaviest_load(crane) + float(crane.cable.masses[:-1].sum())


def gantry_scales(scene: Scene) -> tuple[float, ...]:
    """Return the efforts (nu,) of a gantry crane that are drawn as arrows of a seventh of its size."""
    crane = scene.model
    weight, portal = crane.gravity * heaviest_load(crane), bare_support(crane.support).bridge.mass
    hoist = weight if scene.effort_units[2] == "N" else 1.0
    return 0.1 * weight, 0.05 * portal, hoist


def suspended_scales(scene: Scene) -> tuple[float, ...]:
    """Return the efforts (nu,) that are drawn as arrows of a seventh of a tower or mobile crane's size.

    A joint needs this much to carry the load at the initial radius, a slew or a trolley a tenth of it.
    """
    radius = max(1.0, abs(scene.initial_q[2 if "telescope" in scene.joint_names else 1]))
    crane = scene.model
    weight = crane.gravity * hung_mass(crane)
    scales = {"N m": radius * weight, "N": weight, "m/s²": 1.0, "m/s": 1.0}
    shares = [0.1 if name in ("slew", "trolley", "bridge") else 1.0 for name in scene.actuated]
    return tuple(max(share * scales[unit], 1e-9) for share, unit in zip(shares, scene.effort_units, strict=True))


def of_pendulum(scene: Scene) -> Framing:
    """Return how to draw a suspension point and its payload."""
    (x, y, z), length = scene.initial_q[:3], cable_length(scene)
    ends = [(x, y), (scene.reference or (x, y))[:2]]
    (x, y), span = np.mean(ends, axis=0), float(np.ptp(ends, axis=0).max())
    far = 1.8 * max(length, 0.7 * span)
    return Framing(
        size=length,
        ground=(float(x), float(y), z - 1.5 * length),
        ground_size=max(1.5 * length, 0.8 * span),
        eye=(float(x) + 0.5 * far, float(y) - 1.5 * far, z + 0.5 * far),
        look_at=(float(x), float(y), z - 0.6 * length),
    )


def knuckle_scales(scene: Scene) -> tuple[float, ...]:
    """Return the efforts (nu,) that are drawn as arrows of a seventh of a knuckle-boom crane's size.

    A joint needs this much to carry the outstretched crane; the slew, which carries nothing, gets a fifth. A winch that
    takes its acceleration or its rate gets one of its unit.
    """
    crane = scene.model
    support, load = bare_support(crane.support), hung_mass(crane)
    boom, jib = support.boom, support.jib
    scales = {"N m": crane.gravity * boom.length * (load + 0.5 * boom.mass + jib.mass), "N": load * crane.gravity}
    scales |= {"m/s²": 1.0, "m/s": 1.0}
    slew, *others = (max(scales[unit], 1e-9) for unit in scene.effort_units)
    return (0.2 * slew, *others)


def of_room(room: BoundingBox) -> Framing:
    """Return how to draw an overhead crane whose motion fills a room.

    All of it is in the picture, unless the trolley goes so far that nothing would be seen: then the eye goes along.
    """
    depth, floor = room.depth, room.floor
    sides = np.array([room.rail(0), room.rail(1) if room.spatial else (-0.25 * depth, 0.25 * depth), (floor, 0.0)])
    sides[2, 1] = max(room.high[2], 0.15 * depth)
    x, y, z = (float(value) for value in sides.mean(axis=1))
    span = float(np.ptp(sides[:2], axis=1).max())
    half = 0.6 * max(span, 1.5 * depth)
    far = span > FAR * depth
    if far:
        sides[:2] = np.array([[x], [y]]) + np.array([-1.2, 1.2]) * depth
    towards = _outwards(*(SPACE if room.spatial else PLANE))
    eye = np.array([x, y, z]) + _distance(sides, towards) * towards
    return Framing(
        size=depth if far else max(depth, 0.3 * span),
        ground=(x, y, floor),
        ground_size=half,
        eye=(float(eye[0]), float(eye[1]), float(eye[2])),
        look_at=(x, y, z),
        follows=f"{TROLLEY}/boxes" if far else "",
    )


def _outwards(heading: float, height: float) -> np.ndarray:
    """Return the unit vector (3,) from the crane to the eye."""
    around, up = radians(heading), radians(height)
    return np.array([cos(up) * cos(around), cos(up) * sin(around), sin(up)])


def _distance(sides: np.ndarray, towards: np.ndarray) -> float:
    """Return how far the eye must stand from the middle of a box with sides (3, 2) to see all its corners."""
    right = np.cross((0.0, 0.0, 1.0), towards)
    right /= np.linalg.norm(right)
    up = np.cross(towards, right)
    corners = np.array(np.meshgrid(*sides)).reshape(3, -1).T - sides.mean(axis=1)
    slope = tan(radians(0.5 * VIEW))
    wide, high = np.abs(corners @ right) / (ASPECT * slope), np.abs(corners @ up) / slope
    return 1.05 * float(np.max(np.maximum(wide, high) + corners @ towards))
