"""Size of a crane and position of the camera for drawing."""

from __future__ import annotations

from math import atan2, cos, degrees, hypot, radians, sin, tan
from typing import Any, NamedTuple

import numpy as np

from crane_sim.description.falls import portal_of
from crane_sim.description.knuckle import pedestal_height
from crane_sim.description.pendulum import cable_length
from crane_sim.description.rotations import rotations_about_z
from crane_sim.description.suspended import bridge_reach, contact_height, crane_size, ground_height
from crane_sim.description.workspace import BoundingBox, axis_positions
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.supports.flexible import rigid_support
from crane_sim.models.supports.support import structure_of
from crane_sim.models.supports.telescopic_boom import TelescopicBoom
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.trajectory import sample_trajectory

Vector = tuple[float, float, float]
FIELD_OF_VIEW = 55.0  # degrees, the viewer's field of view from top to bottom
FIELD_SLOPE = tan(radians(0.5 * FIELD_OF_VIEW))
ASPECT = 0.84  # width over height of the view, a little less than on a screen of 16:9
PATH_SAMPLES = 50  # instants of a path whose positions have to be in the picture
MAX_RAIL_RATIO = 10.0  # longest rail that is shown whole, by the depth of the cable
# height of the longest arrow of a hoist above the trolley, by the crane's size
HOIST_ARROW_RATIO = 0.33
TROLLEY = "crane/trolley"
# of the crane's size, around the nodes of a motion: in a new picture, and in any
MARGIN, MIN_MARGIN = 0.08, 0.03
MAX_REACH = 20.0  # by the crane's size: a camera does not look for what is farther away
# degrees: heading and elevation of the eye, overhead cranes
PLANAR_VIEW, SPATIAL_VIEW = (-70.0, 14.0), (-78.0, 24.0)


class Framing(NamedTuple):
    """World coordinates in m."""

    size: float  # a typical length of the crane: sets line widths
    ground: Vector  # middle of the ground that is drawn
    ground_size: float  # from its middle to its edge
    eye: Vector
    look_at: Vector
    deck: tuple[float, float] = (0.9, 0.6)  # half length and half width of a vessel's deck, of
    # `ground_size`
    follows: str = ""  # the entity that the eye follows at a constant distance


def of_knuckle(scene: Scene) -> Framing:
    """Return how to draw a scene's knuckle-boom crane."""
    support = structure_of(scene.model.support)
    size = support.boom.length + support.jib.length
    # where the crane works
    heading = 0.5 * (scene.initial_q[0] + (scene.reference or scene.initial_q)[0])
    aside = heading - radians(72.0)
    return Framing(
        size=size,
        ground=(
            0.0,
            0.0,
            -pedestal_height(support) if (surface := contact_height(scene)) is None else surface,
        ),
        ground_size=1.25 * size,
        eye=(1.4 * size * cos(aside), 1.4 * size * sin(aside), 0.55 * size),
        look_at=(0.46 * size * cos(heading), 0.46 * size * sin(heading), -0.03 * size),
        deck=(0.6, 0.25),
    )


def of_suspended(scene: Scene) -> Framing:
    """Return how to draw all of a tower, mobile or bridge crane, to both ends of its slewing."""
    size, ground = crane_size(scene), ground_height(scene)
    if "slew" not in scene.joint_names:
        return _beside_bridge(scene, size, ground)
    ends = scene.initial_q[0], (scene.reference or scene.initial_q)[0]
    heading, spread = 0.5 * sum(ends), 0.5 * abs(ends[1] - ends[0])
    if "trolley" in scene.joint_names:
        behind, reach, top = 0.35 * size, 1.05 * size, 0.17 * size
    else:
        behind, (reach, top) = 0.2 * size, _boom_extent(scene, size)
    aside = max(0.2 * size, reach * sin(min(spread, radians(90.0))))
    (turn,) = rotations_about_z(np.array([heading]))
    corners = _corners((-behind, reach), (-aside, aside), (ground, top)) @ turn.T
    eye, look_at = _look(corners, degrees(heading) - 70.0, 17.0)
    return Framing(
        size=size,
        ground=(0.0, 0.0, ground),
        ground_size=1.25 * size,
        eye=eye,
        look_at=look_at,
        deck=(0.6, 0.25),
    )


def _boom_extent(scene: Scene, size: float) -> tuple[float, float]:
    """Return a telescopic boom's reach and height [m]: the greatest ones without a target."""
    if scene.reference is None:
        return 0.8 * size, 1.05 * size
    (low, high), (_, length) = _span_of(scene, 1), _span_of(scene, 2)
    return max(0.2 * size, 1.1 * length * cos(low)), 0.05 * size + 1.1 * length * sin(high)


def _beside_bridge(scene: Scene, size: float, ground: float) -> Framing:
    """Return how to draw a bridge crane, from the ends of its girder to those of its way."""
    along, across = bridge_reach(scene, size), _span_of(scene, 1)
    sides = along, (across[0] - 0.25 * size, across[1] + 0.25 * size), (ground, 0.15 * size)
    eye, look_at = _look(_corners(*sides), -74.0, 14.0)
    x, y = 0.5 * sum(along), 0.5 * sum(across)
    half = 0.6 * max(along[1] - along[0], across[1] - across[0] + 0.5 * size)
    return Framing(size=size, ground=(x, y, ground), ground_size=half, eye=eye, look_at=look_at)


def of_gantry(scene: Scene) -> Framing:
    """Return how to draw a gantry crane, from the ends of its rail to those of its way."""
    portal, across = portal_of(scene), _span_of(scene, 1)
    along, depth, aside = portal.ends, portal.depth, max(0.2 * portal.depth, portal.half_span)
    sides = along, (across[0] - aside, across[1] + aside), (-depth, max(0.1 * depth, portal.top))
    eye, look_at = _look(_corners(*sides), -60.0, 14.0)
    return Framing(
        size=0.5 * depth,
        ground=(0.5 * sum(along), 0.5 * sum(across), -depth),
        ground_size=max(1.2 * depth, 0.6 * (along[1] - along[0])),
        eye=eye,
        look_at=look_at,
    )


def _span_of(scene: Scene, i: int) -> tuple[float, float]:
    """Return the least and largest of coordinate i's start, target and prescribed positions."""
    places = axis_positions(scene, scene.joint_names[i])
    return min(places), max(places)


def heaviest_load(crane: Any) -> float:
    """Return the mass [kg] of a crane's load, of the heaviest one where loads are exchanged."""
    return crane.load.mass if crane.exchange is None else float(crane.exchange.masses.max())


def hung_mass(crane: Any) -> float:
    """Return the mass [kg] on a crane's rope: links and load, the heaviest of exchanged ones."""
    if not isinstance(crane, SuspendedCrane):
        return heaviest_load(crane) if isinstance(crane, FallsCrane) else crane.load.mass
    return heaviest_load(crane) + float(crane.cable.masses[:-1].sum())


def gantry_scales(scene: Scene) -> tuple[float, ...]:
    """Return the efforts (nu,) drawn as arrows of a seventh of a gantry crane's size."""
    crane = scene.model
    weight, portal = crane.gravity * heaviest_load(crane), crane.support.structure.bridge.mass
    scales = {"trolley": 0.1 * weight, "bridge": max(0.05 * portal, 1e-9)}
    units = zip(scene.actuated, scene.effort_units, strict=True)
    return tuple(scales.get(name, weight if unit == "N" else 1.0) for name, unit in units)


def suspended_scales(scene: Scene) -> tuple[float, ...]:
    """Return the efforts (nu,) drawn as arrows of a seventh of a tower or mobile crane's size.

    A joint needs this much to carry the load at the initial radius, boom and telescope the
    telescoped section with it, a slew or a trolley a tenth of it.
    """
    radius = max(1.0, abs(scene.initial_q[2 if "telescope" in scene.joint_names else 1]))
    crane, support = scene.model, rigid_support(structure_of(scene.model.support))
    load = hung_mass(crane)
    section = support.telescope.mass if isinstance(support, TelescopicBoom) else 0.0
    masses: dict[str, float] = dict.fromkeys(("slew", "trolley", "bridge"), 0.1 * load)
    masses |= dict.fromkeys(("boom", "telescope"), load + section)
    arms = {"N m": radius, "N": 1.0}
    return tuple(
        max(crane.gravity * masses.get(name, load) * arms[unit], 1e-9) if unit in arms else 1.0
        for name, unit in zip(scene.actuated, scene.effort_units, strict=True)
    )


def of_pendulum(scene: Scene) -> Framing:
    """Return how to draw a suspension point and its payload, from start to target, and its path."""
    (x, y, z), length = scene.initial_q[:3], cable_length(scene)
    places = np.array([(x, y), (scene.reference or (x, y))[:2]])
    if scene.trajectory is not None:
        times = np.linspace(0.0, scene.duration, PATH_SAMPLES)
        places = np.vstack([places, sample_trajectory(scene.trajectory, times)[:, 0, :2]])
    low, high = places.min(axis=0), places.max(axis=0)
    (x, y), span = 0.5 * (low + high), float((high - low).max())
    far = 1.8 * max(length, 0.7 * span)
    return Framing(
        size=length,
        ground=(float(x), float(y), z - 1.5 * length),
        ground_size=max(1.5 * length, 0.8 * span),
        eye=(float(x) + 0.5 * far, float(y) - 1.5 * far, z + 0.5 * far),
        look_at=(float(x), float(y), z - 0.6 * length),
    )


def knuckle_scales(scene: Scene) -> tuple[float, ...]:
    """Return the efforts (nu,) drawn as arrows of a seventh of a knuckle-boom crane's size.

    A joint needs this much to carry the outstretched crane; the slew, which carries nothing, gets a
    fifth. A winch that takes its acceleration or its rate gets one of its unit.
    """
    crane = scene.model
    support, load = structure_of(crane.support), hung_mass(crane)
    boom, jib = support.boom, support.jib
    scales = {
        "N m": crane.gravity * boom.length * (load + 0.5 * boom.mass + jib.mass),
        "N": load * crane.gravity,
    }
    scales |= {"m/s²": 1.0, "m/s": 1.0}
    slew, *others = (max(scales[unit], 1e-9) for unit in scene.effort_units)
    return (0.2 * slew, *others)


def pictures_of(scene: Scene) -> tuple[Framing, tuple[float, ...]]:
    """Return how to draw a crane that is not overhead, and its effort arrows' scales (nu,)."""
    framing, scales = {
        "knuckle": (of_knuckle, knuckle_scales),
        "gantry": (of_gantry, gantry_scales),
        "pendulum": (of_pendulum, lambda scene: (1.0,) * len(scene.actuated)),  # m/s², or m
    }.get(scene.crane, (of_suspended, suspended_scales))
    return framing(scene), scales(scene)


def of_room(room: BoundingBox, lifts: bool) -> Framing:
    """Return how to draw an overhead crane whose motion fills a room.

    It `lifts` if its hoist's force is an arrow.

    All of it is in the picture, unless the rail is so long that the crane would be too small: then
    the eye follows the trolley.
    """
    depth, floor = room.depth, room.floor
    sides = np.array(
        [
            room.rail(0),
            room.rail(1) if room.spatial else (-0.25 * depth, 0.25 * depth),
            (floor, 0.0),
        ]
    )
    span = float(np.ptp(sides[:2], axis=1).max())
    half = 0.6 * max(span, 1.5 * depth)
    far = span > MAX_RAIL_RATIO * depth
    size = depth if far else max(depth, 0.3 * span)
    sides[2, 1] = max(room.high[2], 0.15 * depth, HOIST_ARROW_RATIO * size if lifts else 0.0)
    x, y, z = (float(value) for value in sides.mean(axis=1))
    if far:
        sides[:2] = np.array([[x], [y]]) + np.array([-1.2, 1.2]) * depth
    eye, look_at = _look(_corners(*sides), *(SPATIAL_VIEW if room.spatial else PLANAR_VIEW))
    return Framing(
        size=size,
        ground=(x, y, floor),
        ground_size=half,
        eye=eye,
        look_at=look_at,
        follows=f"{TROLLEY}/boxes" if far else "",
    )


class MotionRange:
    """Range of a motion that a framing shows all of, or not."""

    def __init__(self, framing: Framing) -> None:
        """Begin with nothing."""
        self._framing, self._is_shown = framing, True
        self._low, self._high = np.full(3, np.inf), np.full(3, -np.inf)

    def add(self, nodes: np.ndarray) -> None:
        """Add the places (..., 3) of nodes, but for those of a load that was lost."""
        away = np.linalg.norm(nodes - np.array(self._framing.ground), axis=-1)
        points = nodes[away < MAX_REACH * self._framing.size]
        if not points.size:
            return
        self._low, self._high = (
            np.minimum(self._low, points.min(axis=0)),
            np.maximum(self._high, points.max(axis=0)),
        )
        self._is_shown &= bool(self._framing.follows) or _shows(self._framing, points)

    def fit(self) -> Framing | None:
        """Return the view of all motion from the same side of the crane; None if unchanged."""
        if self._is_shown:
            return None
        framing, margin = self._framing, MARGIN * self._framing.size
        low, high = self._low - margin, self._high + margin
        low[2] = min(low[2], framing.ground[2])
        corners = _corners(*zip(low.tolist(), high.tolist(), strict=True))
        x, y, z = np.subtract(framing.eye, framing.look_at).tolist()
        turn = _working_heading(framing, 0.5 * (low + high)) - _working_heading(
            framing, framing.look_at
        )
        eye, look_at = _look(corners, degrees(atan2(y, x) + turn), degrees(atan2(z, hypot(x, y))))
        return framing._replace(eye=eye, look_at=look_at)


def _working_heading(framing: Framing, place: Any) -> float:
    """Return the heading [rad] of a place from the middle of the ground; 0 above the middle."""
    x, y, _ = np.subtract(place, framing.ground)
    return atan2(y, x) if hypot(x, y) > MARGIN * framing.size else 0.0


def _shows(framing: Framing, points: np.ndarray) -> bool:
    """Whether points (n, 3), and what is around them, are in the picture."""
    middle = np.array(framing.look_at)
    towards = np.subtract(framing.eye, middle)
    distance = float(np.linalg.norm(towards))
    return (
        _distance(points - middle, towards / distance) + MIN_MARGIN * framing.size / FIELD_SLOPE
        <= distance
    )


def _outwards(heading: float, height: float) -> np.ndarray:
    """Return the unit vector (3,) from the crane to the eye, both angles in degrees."""
    around, up = radians(heading), radians(height)
    return np.array([cos(up) * cos(around), cos(up) * sin(around), sin(up)])


def _corners(*sides: tuple[float, float]) -> np.ndarray:
    """Return the corners (8, 3) of a box with sides along x, y and z."""
    return np.array(np.meshgrid(*sides)).reshape(3, -1).T


def _look(corners: np.ndarray, heading: float, height: float) -> tuple[Vector, Vector]:
    """Return (eye, look_at) at a heading and an elevation [degrees], with all corners in view.

    The corners are (n, 3).
    """
    middle, towards = 0.5 * (corners.min(axis=0) + corners.max(axis=0)), _outwards(heading, height)
    eye = middle + _distance(corners - middle, towards) * towards
    (a, b, c), (x, y, z) = eye.tolist(), middle.tolist()
    return (a, b, c), (x, y, z)


def _distance(corners: np.ndarray, towards: np.ndarray) -> float:
    """Return the distance of the eye from the origin at which all corners (n, 3) are in view."""
    right = np.cross((0.0, 0.0, 1.0), towards)
    right /= np.linalg.norm(right)
    up = np.cross(towards, right)
    wide, high = (
        np.abs(corners @ right) / (ASPECT * FIELD_SLOPE),
        np.abs(corners @ up) / FIELD_SLOPE,
    )
    return 1.05 * float(np.max(np.maximum(wide, high) + corners @ towards))
