"""Workspace of an overhead crane: a box that holds its rails and its cable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crane_sim.files.document import present
from crane_sim.numerics.jit import entry
from crane_sim.scenes.schema.overhead import OverheadFile
from crane_sim.simulation.metrics import polyline
from crane_sim.trajectories.profiles import Motion, evaluate_motion

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.scenes.scene import Scene

    Numbers = NDArray[np.float64]

SAMPLES = 200  # of a prescribed motion
SPARE = 0.25  # of the depth: rail beyond the last node


@entry
def positions(motion, times):
    """Return the positions (n,) of a motion at times (n,) [s]."""
    out = np.empty(len(times))
    for i in range(len(times)):
        out[i] = evaluate_motion(motion, times[i])[0]
    return out


class Room(NamedTuple):
    """A box in the world [m] that holds the trolley and all nodes of the cable."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    shortest: float  # distance from trolley to payload
    spatial: bool  # there is a bridge, which moves along y

    @property
    def depth(self) -> float:
        """Return how far the box reaches below the rail: the measure of everything that is drawn."""
        return max(-self.low[2], 1e-3)

    @property
    def unit(self) -> float:
        """Return the measure of trolley and rail, which must not hide a load that is drawn up to them."""
        return max(min(self.depth / 6.0, self.shortest), self.depth / 15.0)

    @property
    def floor(self) -> float:
        """Return z of the ground, which is drawn only: the model has none."""
        return -1.2 * self.depth

    def rail(self, axis: int) -> tuple[float, float]:
        """Return the ends of what the trolley (axis 0) or the bridge (axis 1) runs on, which are drawn only."""
        spare = SPARE * self.depth
        return self.low[axis] - spare, self.high[axis] + spare

    def holds(self, low: Numbers, high: Numbers) -> bool:
        """Whether a box lies in the room, the spare ends of its rails included."""
        spare = SPARE * self.depth
        return bool(np.all(low > np.array(self.low) - spare) and np.all(high < np.array(self.high) + spare))


def room_of(low: Numbers, high: Numbers, shortest: float, spatial: bool) -> Room:
    """Return the room of a box with corners (3,)."""
    return Room(_vector(low), _vector(high), shortest, spatial)


def form_of(scene: Scene) -> OverheadFile:
    """Return the checked file of a scene with an overhead crane, defaults included."""
    return OverheadFile.model_validate(present(scene.document))


def estimate_room(scene: Scene) -> Room:
    """Return the room for a run that has not begun: where it starts, is to go, and swings to from there."""
    form = form_of(scene)
    nodes, tip = polyline(_at_rest(scene.model), 0.0, np.array(scene.initial_q), np.array(scene.initial_v))
    links = np.linalg.norm(np.diff(nodes[tip:], axis=0), axis=1)
    hoist = form.hoist.profile if form.hoist else None
    first = [float(links[0]), *_target_of(scene, "hoist"), *_way(scene, hoist.motion() if hoist else None)]
    rest = float(links[1:].sum())
    hang = nodes - nodes[tip]
    hang = np.vstack([hang, hang * (-1.0, -1.0, 1.0), (0.0, 0.0, -max(first) - rest)])
    places = [nodes[tip]]
    for axis, (joint, group) in enumerate((("trolley", form.trolley), ("bridge", form.bridge))):
        motion = group.motion.motion() if group and group.motion else None
        for place in (*_target_of(scene, joint), *_way(scene, motion)):
            places.append(np.where(np.arange(3) == axis, place, nodes[tip]))
    low, high = np.min(places, axis=0) + hang.min(axis=0), np.max(places, axis=0) + hang.max(axis=0)
    return room_of(low, high, min(first) + rest, is_spatial(scene))


def _at_rest(model: Any) -> Any:
    """Return the model on a base that rests: its points are where they are aboard."""
    return model._replace(base=None) if getattr(model, "base", None) is not None else model


def is_spatial(scene: Scene) -> bool:
    """Return whether the crane has a bridge."""
    return "bridge" in scene.joint_names


def _target_of(scene: Scene, joint: str) -> list[float]:
    if scene.reference is None or joint not in scene.actuated:
        return []
    return [scene.reference[scene.actuated.index(joint)]]


def _way(scene: Scene, motion: Motion | None) -> list[float]:
    """Return where a prescribed motion goes; nothing for a part that has none."""
    if motion is None:
        return []
    return [float(place) for place in positions(motion, np.linspace(0.0, scene.duration, SAMPLES))]


def _vector(values: Numbers) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z
