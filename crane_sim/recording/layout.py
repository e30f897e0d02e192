"""What a recording holds: the fixed facts of a run, and the arrays of one block of its steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import yaml

from crane_sim import system
from crane_sim.description import urdf
from crane_sim.description.room import form_of
from crane_sim.recording.aboard import BASE, base_of
from crane_sim.recording.cast import WORLD
from crane_sim.recording.framing import Framing, knuckle_scales, of_knuckle, of_pendulum, of_room
from crane_sim.recording.provenance import provenance
from crane_sim.recording.suspension import COORDINATES, Suspension, effort_scales, suspension, tension_name

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from crane_sim.scene import Scene

    Numbers = NDArray[np.float64]


class Way(NamedTuple):
    """A plot of joints in metres."""

    entity: str
    title: str
    joints: tuple[str, ...]


ROPE = Way("shown/rope_m", "Rope length [m]", ("rope",))
TIP = "shown/tip_m", "Position of the suspension point [m]"
HOIST = Way("shown/hoist_m", "Length of the first link [m]", ("hoist",))


class Layout(NamedTuple):
    """Everything about a run that stays fixed while it is recorded."""

    run_id: str
    name: str  # shown as the recording's name
    joints: tuple[str, ...]  # nq coordinates, in the order of q
    units: tuple[str, ...]  # of the coordinates: "rad", "m" or, of components of unit vectors, "1"
    actuated: tuple[str, ...]  # nu of the joints
    effort_units: tuple[str, ...]
    effort_scales: tuple[float, ...]  # (nu,) the efforts that are drawn as arrows of a seventh of the crane's size
    ways: tuple[Way, ...]
    swings: tuple[str, ...]  # joints with the angles of the cable that are plotted
    suspension: Suspension | None  # an overhead crane's
    stand: str  # the frame that the crane stands in: the world, or a base that moves in it
    tip: int  # which of the nodes is the upper end of the cable
    tension: str  # what the recorded tension is
    provenance: str  # what derived curves are computed from, empty where that is the truth
    period_ns: int
    robot: str  # URDF
    framing: Framing
    commanded: bool  # somebody commands efforts every period
    aimed: bool  # the actuated joints have targets
    silent: bool  # nothing drives the actuated joints
    lyapunov: bool  # the law comes with a Lyapunov function
    properties: Mapping[str, Any]  # run properties that are known at the start

    @property
    def driven(self) -> list[int]:
        """Return the indices of the actuated joints among the coordinates."""
        return [self.joints.index(name) for name in self.actuated]

    @property
    def moving(self) -> list[int]:
        """Return the indices of the coordinates that are plotted: of the cable's only those in `swings`."""
        return [i for i, joint in enumerate(self.joints) if joint in self.swings or not joint.startswith(COORDINATES)]

    @property
    def crowded(self) -> bool:
        """Return whether there are too many coordinates to plot them all."""
        return len(self.moving) < len(self.joints)


class Block(NamedTuple):
    """K consecutive control steps: the state at the start of each and the effort held over it (SI, radians)."""

    step: NDArray[np.int64]  # (K,) 1 for the first step
    q: Numbers  # (K, nq)
    v: Numbers  # (K, nq)
    effort: Numbers  # (K, nu) applied, after limits
    demanded: Numbers  # (K, nu) commanded; NaN where no command was heard
    reference: Numbers | None  # (K, nu) target of the actuated joints
    nodes: Numbers  # (K, N, 3) base .. tip .. payload; the cable is what follows the tip
    base: Numbers | None  # (K, 6) m and rad, of a base that moves
    target: Numbers | None  # (K, N, 3) the nodes at rest in the reference pose
    kinetic: Numbers  # (K,) J
    potential: Numbers  # (K,) J
    energy: Numbers  # (K,) J, their sum
    tension: Numbers  # (K,) N
    swing: Numbers  # (K,) angle from the vertical of the line from the tip to the payload
    lyapunov: Numbers | None  # (K, 2) V [J] and its rate [W]


def of_scene(scene: Scene, run_id: str) -> Layout:
    """Return the layout of a scene's recording."""
    found, origin = suspension(scene), provenance(scene)
    return Layout(
        run_id=run_id,
        name=scene.name,
        joints=scene.joint_names,
        units=scene.joint_units,
        actuated=scene.actuated,
        effort_units=scene.effort_units,
        effort_scales=_effort_scales(scene, found),
        ways=_ways(scene),
        swings=_swings(scene, found),
        suspension=found,
        stand=WORLD if base_of(scene) is None else BASE,
        tip=system.tip_index(scene.model),
        tension=tension_name(found),
        provenance=origin,
        period_ns=scene.period_ns,
        robot=urdf(scene),
        framing=_framing(scene, found),
        commanded=scene.sampled,
        aimed=scene.sampled or scene.reference is not None,
        silent=not (scene.law_name or scene.sampled or scene.document.get("inputs")),
        lyapunov=hasattr(scene.law, "lyapunov"),
        properties=_properties(scene, origin),
    )


def label(name: str) -> str:
    """Turn a joint name into words for a legend."""
    return name.replace("_", " ")


def _framing(scene: Scene, found: Suspension | None) -> Framing:
    if found:
        return of_room(found.room)
    return of_pendulum(scene) if scene.crane == "pendulum" else of_knuckle(scene)


def _effort_scales(scene: Scene, found: Suspension | None) -> tuple[float, ...]:
    if scene.crane == "pendulum":
        return (1.0,) * len(scene.actuated)  # m/s², or m
    return effort_scales(scene, found.hang) if found else knuckle_scales(scene)


def _ways(scene: Scene) -> tuple[Way, ...]:
    """Return the plots of what moves in metres, the cable left out."""
    if scene.crane == "pendulum":
        return (Way(*TIP, scene.actuated),)
    if scene.crane != "overhead":
        return (ROPE,) if "rope" in scene.actuated else ()
    form = form_of(scene)
    axes = tuple(name for name in form.axes if (group := getattr(form, name)) and group.drive != "fixed")
    ways = [Way("shown/trolley_m", f"{' and '.join(axes).capitalize()} position [m]", axes)] if axes else []
    return (*ways, HOIST) if form.hoist else tuple(ways)


def _swings(scene: Scene, found: Suspension | None) -> tuple[str, ...]:
    names = [name for name in scene.joint_names if name.startswith("swing_")]
    return tuple(names) if found is None else tuple(f"swing_{k}" for k in found.links if f"swing_{k}" in names)


def _properties(scene: Scene, origin: str) -> dict[str, Any]:
    return {
        "scene": scene.name,
        "law": scene.law_name or "none",
        "seed": scene.seed,
        "period": scene.period,
        "duration": scene.duration,
        "derived": origin or "from the true state",
        "scene_file": yaml.safe_dump(scene.to_dict(), sort_keys=False, allow_unicode=True),
    }
