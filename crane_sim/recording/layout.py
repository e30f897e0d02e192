"""Contents of a recording: the constants of a run, and the arrays of one block of its steps.

What the derived curves of a recording are computed from, where that is not the truth.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from crane_sim import system
from crane_sim.description import urdf
from crane_sim.description.transforms import BASE, WORLD
from crane_sim.description.workspace import validated_scene_file
from crane_sim.models.falls.crane import Falls
from crane_sim.recording import provenance
from crane_sim.recording.base_frame import base_of, fall_ends, to_base
from crane_sim.recording.camera import Framing, of_room, pictures_of
from crane_sim.recording.path_units import path_unit_of_scene
from crane_sim.recording.states import TimelineInputs, make_timeline_inputs
from crane_sim.recording.suspension import COORDINATES, Suspension, effort_scales, suspension
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.hardware import is_sensed, sensed_coordinates
from crane_sim.trajectories.waves import SineSum

if TYPE_CHECKING:
    from crane_sim.simulation.rollout import Rollout

Array = NDArray[np.float64]
FRAME_NS = 33_000_000  # of scene time between two frames of the 3D scene


def source_note(scene: Scene, truth: bool) -> str:
    """Return a phrase on the source of energies, tension and swing, empty if it is the truth.

    A recorder computes them from the published states, true or measured, and the scene's payload.
    """
    parts = () if truth or not is_sensed(scene) else ("from what the sensors show",)
    changes = scene.hardware is not None and scene.hardware.payload_fault is not None
    return " and ".join((*parts, *(("for the payload of the start",) if changes else ())))


MAX_TENSIONS = 12  # in a recording; with more links or falls it has only that of the first


def select_tensions(tensions: Array) -> Array:
    """Return those of the tensions (K, L) of all links or falls that are recorded."""
    return tensions if tensions.shape[1] <= MAX_TENSIONS else tensions[:, :1]


def tension_names(count: int, falls: bool) -> tuple[str, ...]:
    """Return the names of the recorded tensions of `count` falls, or of as many links."""
    kind = "fall" if falls else "link"
    if 1 < count <= MAX_TENSIONS:
        return tuple(f"{kind} {k}" for k in range(1, 1 + count))
    if falls:
        return ("tension of fall 1",)
    return ("tension of the top link",) if count > 1 else ("rope tension",)


class LengthPlot(NamedTuple):
    """A plot of joints in metres."""

    entity: str
    title: str
    joints: tuple[str, ...]


ROPE_PLOT = LengthPlot("shown/rope_m", "Rope length [m]", ("rope",))
POSITION_TITLES = {
    "bridge": "Position of the bridge",
    "trolley": "Position of the trolley",
    "telescope": "Length of the boom",
}
"""Titles of joints that move in metres."""
TIP_PLOT = "shown/tip_m", "Position of the suspension point [m]"
FALLS_PLOT = LengthPlot("shown/hoist_m", "Length of the falls [m]", ("hoist",))
LINK_PLOT = LengthPlot("shown/hoist_m", "Length of the first link [m]", ("hoist",))


class Ropes(NamedTuple):
    """The lines from support to load."""

    tip: int  # which of the nodes is the upper end of the cable
    falls: Falls | None  # the ropes of a load that hangs on several
    tensions: tuple[str, ...]  # names of the recorded tensions
    reeved: tuple[str, ...]  # names of those of lead line and falls of a rope over sheaves, none
    # without


class Stand(NamedTuple):
    """The frame in which the crane stands, and the sea below it."""

    frame: str  # the world, or a base that moves in it
    sea: SineSum | None  # the elevation of the water at the origin, of a base in a sea


class Span(NamedTuple):
    """Least and largest value of the curves of an entity."""

    low: float
    high: float


class Layout(NamedTuple):
    """Everything about a run that stays fixed while it is recorded."""

    run_id: str
    name: str  # shown as the recording's name
    joints: tuple[str, ...]  # nq coordinates, in the order of q
    units: tuple[str, ...]  # of the coordinates: "rad", "m" or, of components of unit vectors, "1"
    actuated: tuple[str, ...]  # nu of the joints
    effort_units: tuple[str, ...]
    command_units: tuple[str, ...]  # the same, but of joints whose drives take a speed or a
    # position
    effort_scales: tuple[float, ...]  # (nu,) the efforts that are drawn as arrows of a seventh of
    # the crane's size
    length_plots: tuple[LengthPlot, ...]
    swings: tuple[str, ...]  # joints with the angles of the cable that are plotted
    suspension: Suspension | None  # an overhead crane's
    stand: Stand
    ropes: Ropes
    provenance: str  # what derived curves are computed from, empty where that is the truth
    period_ns: int
    framing: Framing
    commanded: bool  # efforts are commanded every period
    has_targets: bool  # the actuated joints have targets
    undriven: bool  # nothing drives the actuated joints
    lyapunov: bool  # the law comes with a Lyapunov function
    timeline_inputs: TimelineInputs  # what timelines of states follow from, beside the steps
    properties: Mapping[str, Any]  # run properties that are known at the start
    sensed: tuple[int, ...] = ()  # coordinates, and nq + i for rates, whose measured values are
    # known beside true ones
    path_unit: str = "m"  # of the coordinates of the scene's path, empty where they have different
    # ones
    paced: bool = True  # the run has a real-time factor: it is one over ROS
    spans: Mapping[str, Span] = MappingProxyType({})  # of the curves that are written, by entity;
    # none before the run

    @property
    def robot(self) -> str:
        """Return the URDF document of the crane."""
        return self.properties["urdf"]

    @property
    def frame_stride(self) -> int:
        """Return the number of steps from one frame of the 3D scene to the next."""
        return max(1, FRAME_NS // self.period_ns)

    @property
    def tension(self) -> str:
        """Return what the recorded tensions are."""
        if len(self.ropes.tensions) == 1:
            return self.ropes.tensions[0]
        return f"tension of each {'link' if self.ropes.falls is None else 'fall'}"

    def fall_ends(self, block: Block) -> Array | None:
        """Return falls' ends (K, n, 2, 3) [m], upper and lower, in the base's frame, or None."""
        if self.ropes.falls is None:
            return None
        tip = to_base(block.nodes, block.base)[:, self.ropes.tip]
        ends = fall_ends(self.ropes.falls, dict(zip(self.joints, block.q.T, strict=True)), tip)
        return np.stack(ends, axis=2)

    @property
    def driven(self) -> list[int]:
        """Return the indices of the actuated joints among the coordinates."""
        return [self.joints.index(name) for name in self.actuated]

    @property
    def moving(self) -> list[int]:
        """Return the indices of the plotted coordinates: of the cable's only those in `swings`."""
        return [
            i
            for i, joint in enumerate(self.joints)
            if joint in self.swings or not joint.startswith(COORDINATES)
        ]


class Block(NamedTuple):
    """K consecutive control steps: initial states and the efforts held (SI, radians)."""

    step: NDArray[np.int64]  # (K,) 1 for the first step
    q: Array  # (K, nq)
    v: Array  # (K, nq)
    effort: Array  # (K, nu) applied, after limits
    demanded: Array  # (K, nu) commanded; NaN without a command
    braked: NDArray[np.bool_]  # (K,) the brakes of all actuated joints act
    reference: Array | None  # (K, nu) target of the actuated joints
    nodes: Array  # (K, N, 3) base .. tip .. payload; the cable is what follows the tip
    base: Array | None  # (K, 6) m and rad, of a base that moves
    target: Array | None  # (K, N, 3) the nodes at rest in the reference pose
    kinetic: Array  # (K,) J
    potential: Array  # (K,) J
    energy: Array  # (K,) J, their sum
    raised: Array  # (K,) J, potential energy since the start of the run
    tensions: Array  # (K, T) N, those of `select_tensions`
    reeved: Array | None  # (K, 1 + n) N, lead line and falls of a rope that is reeved over sheaves
    swing: Array  # (K,) angle from the vertical of the line from the tip to the payload
    measured: Array | None  # (K, 2 nq) measured q and v, where q and v are the true ones
    contact: Array | None  # (K,) N, normal force of a surface on the load, of a load that may touch
    # one
    lyapunov: Array | None  # (K, 2) V [J] and its rate [W]

    def part(self, rows: Any) -> Block:
        """Return the steps of some rows."""
        return self._replace(
            **{name: each[rows] for name, each in self._asdict().items() if each is not None}
        )


def layout_of_scene(scene: Scene, run_id: str, truth: bool = True) -> Layout:
    """Return the layout of a scene's recording; without `truth` it has measured states."""
    sensed = sensed_coordinates(scene.hardware, len(scene.joint_names)) if truth else ()
    return _make_layout(scene, run_id, truth, suspension(scene))._replace(
        sensed=sensed, path_unit=path_unit_of_scene(scene)
    )


def _make_layout(scene: Scene, run_id: str, truth: bool, cable: Suspension | None) -> Layout:
    framing, scales = _pictures(scene, cable)
    return Layout(
        run_id=run_id,
        name=scene.name,
        joints=scene.joint_names,
        units=scene.joint_units,
        actuated=scene.actuated,
        effort_units=scene.effort_units,
        command_units=scene.command_units,
        effort_scales=scales,
        length_plots=_length_plots(scene),
        swings=_swings(scene, cable),
        suspension=cable,
        stand=Stand(WORLD if base_of(scene) is None else BASE, _sea(scene)),
        ropes=_ropes(scene),
        provenance=source_note(scene, truth),
        period_ns=scene.period_ns,
        framing=framing,
        commanded=scene.sampled,
        has_targets=scene.sampled or scene.reference is not None,
        undriven=not (scene.sampled or scene.law_name or scene.document.get("inputs")),
        lyapunov=hasattr(scene.law, "lyapunov"),
        timeline_inputs=make_timeline_inputs(scene.hardware),
        properties=_properties(scene, truth, framing),
    )


def _properties(scene: Scene, truth: bool, framing: Framing) -> dict[str, Any]:
    facts = {"urdf": urdf(scene), "crane": _crane_facts(scene, framing)}
    return _scene_properties(scene, truth) | facts


def _pictures(scene: Scene, cable: Suspension | None) -> tuple[Framing, tuple[float, ...]]:
    """Return how to draw a crane, and the scales (nu,) of its efforts' arrows."""
    if cable is None:
        return pictures_of(scene)
    return of_room(cable.room, cable.lifts), effort_scales(scene, cable.hang)


def of_rollout(rollout: Rollout, run_id: str) -> Layout:
    """Return the layout of a run without ROS, all of it derived from the true state."""
    layout = layout_of_scene(rollout.scene, run_id)
    properties = {**layout.properties, "derived": "from the true state"}
    return layout._replace(provenance="", paced=False, properties=properties)


def text_properties(layout: Layout) -> dict[str, str]:
    """Return the properties of a run as text, numbers as in JSON."""
    return {
        key: value if isinstance(value, str) else json.dumps(value)
        for key, value in layout.properties.items()
    }


def label(name: str) -> str:
    """Turn a joint name into words for a legend."""
    return name.replace("_", " ")


def _ropes(scene: Scene) -> Ropes:
    falls, count = getattr(scene.model, "falls", None), system.link_count(scene.model)
    parts = system.fall_count(scene.model)  # of a rope over sheaves
    reeved = ("lead line", *(f"fall {k}" for k in range(1, 1 + parts))) if parts else ()
    return Ropes(
        system.tip_index(scene.model), falls, tension_names(count, falls is not None), reeved
    )


def _sea(scene: Scene) -> SineSum | None:
    motion = getattr(scene.file, "base_motion", None)
    return None if motion is None or motion.sea is None else motion.sea.waves(scene.seed)


def _length_plots(scene: Scene) -> tuple[LengthPlot, ...]:
    """Return the plots of what moves in metres, the cable left out."""
    if scene.crane == "pendulum":
        return (LengthPlot(*TIP_PLOT, scene.actuated),)
    if scene.crane != "overhead":
        moved = [name for name in POSITION_TITLES if name in scene.actuated]
        plots = [
            LengthPlot(f"shown/{name}_m", f"{POSITION_TITLES[name]} [m]", (name,)) for name in moved
        ]
        winch = [plot for plot in (ROPE_PLOT, FALLS_PLOT) if plot.joints[0] in scene.actuated]
        return (*plots, *winch)
    file = validated_scene_file(scene)
    axes = tuple(
        name for name in file.axes if (group := getattr(file, name)) and group.drive != "fixed"
    )
    title = f"{' and '.join(axes).capitalize()} position [m]"
    length_plots = [LengthPlot("shown/trolley_m", title, axes)] if axes else []
    return (*length_plots, LINK_PLOT) if file.hoist else tuple(length_plots)


def _swings(scene: Scene, cable: Suspension | None) -> tuple[str, ...]:
    names = [name for name in scene.joint_names if name.startswith("swing_")]
    return (
        tuple(names)
        if cable is None
        else tuple(f"swing_{k}" for k in cable.links if f"swing_{k}" in names)
    )


def _scene_properties(scene: Scene, truth: bool) -> dict[str, Any]:
    return {
        "scene": scene.name,
        "law": scene.law_name or ("external" if scene.sampled else "none"),
        "seed": scene.seed,
        "period": scene.period,
        "duration": scene.duration,
        "derived": source_note(scene, truth) or "from the true state",
        "scene_file": yaml.safe_dump(scene.to_dict(), sort_keys=False, allow_unicode=True),
        "provenance": json.dumps(provenance.of_this_process()),
    } | (
        {"drawn": yaml.safe_dump(scene.notes["drawn"], sort_keys=False)}
        if "drawn" in scene.notes
        else {}
    )


def _crane_facts(scene: Scene, framing: Framing) -> str:
    """Return the properties of the crane that reading the curves needs, as JSON."""
    facts = {
        "kind": scene.crane,
        "joint_names": scene.joint_names,
        "joint_units": scene.joint_units,
        "actuated": scene.actuated,
        "effort_units": scene.effort_units,
        "command_units": scene.command_units,
        "tip_index": int(system.tip_index(scene.model)),
    }
    return json.dumps(facts | {"framing": framing._asdict()})
