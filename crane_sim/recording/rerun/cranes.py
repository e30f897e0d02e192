"""The crane of a recording: a URDF in a posture, or an overhead crane's solids, cable and nodes.

Rails and legs of the latter are as long as the motion needs. They are static, and what is static
can be logged anew: the picture grows with a run, and is fitted to all of it in the end.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
import rerun as rr
import rerun.urdf  # noqa: F401  (makes rr.urdf available)

from crane_sim.description import overhead
from crane_sim.description.suspended import ATTITUDE_JOINT
from crane_sim.description.workspace import make_bounding_box
from crane_sim.recording.base_frame import fall_ends
from crane_sim.recording.camera import TROLLEY, of_room
from crane_sim.scenes.schema.rigging import ATTITUDE

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from crane_sim.description.solids import Shape
    from crane_sim.description.workspace import BoundingBox
    from crane_sim.recording.camera import Framing
    from crane_sim.recording.layout import Array, Layout
    from crane_sim.recording.suspension import Suspension


Vector = tuple[float, float, float]
Colors: TypeAlias = "NDArray[np.uint8]"  # red, green, blue along the last axis
LABEL_COLOR, NODE_COLOR = (226, 230, 236), (184, 191, 199)
CABLE_RADIUS_RATIO = 0.0035  # radius of a rope, of the crane's size


class EffortArrow(NamedTuple):
    """The arrow of an effort in a frame: origin, in crane sizes, and a positive unit vector."""

    frame: str
    origin: Vector
    direction: Vector


def turn_from_z(direction: Array) -> NDArray[np.float64]:
    """Return quaternions (xyzw) from the z axis to directions (n, 3); zero vectors do not turn."""
    x, y, z = direction.T
    length = np.linalg.norm(direction, axis=1)
    # half-way form of the shortest arc, (-y, x, 0, length + z); below the horizon length + z
    # cancels: r² / (length - z)
    below = z < 0.0
    scalar = np.where(below, (x * x + y * y) / np.where(below, length - z, 1.0), length + z)
    quaternion = np.column_stack([-y, x, np.zeros_like(z), scalar])
    norm = np.linalg.norm(quaternion, axis=1, keepdims=True)
    # straight down has no unique arc: the half turn about x
    still = np.where(below[:, None], (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    return np.divide(quaternion, norm, out=still, where=norm > 0.0)


def log_solids(rec: rr.RecordingStream, entity: str, frame: str, shapes: Sequence[Shape]) -> None:
    """Log a frame's boxes and cylinders, replacing the entity's; they turn about x at most."""
    for kind, length in (("boxes", 3), ("cylinders", 2)):
        chosen = [shape for shape in shapes if len(shape.size) == length]
        if not chosen:
            continue
        sizes = np.array([shape.size for shape in chosen])
        look: dict[str, Any] = {
            "centers": [shape.at for shape in chosen],
            "rotation_axis_angles": [
                rr.RotationAxisAngle((1.0, 0.0, 0.0), radians=each.rpy[0]) for each in chosen
            ],
            "colors": [_color(shape) for shape in chosen],
            "fill_mode": "solid",
        }
        if kind == "boxes":
            solids = rr.Boxes3D(half_sizes=0.5 * sizes, **look)
        else:
            solids = rr.Cylinders3D(radii=sizes[:, 0], lengths=sizes[:, 1], **look)
        rec.log(f"{entity}/{kind}", rr.CoordinateFrame(frame), solids, static=True)


def _color(shape: Shape) -> tuple[int, ...]:
    return tuple(round(255.0 * float(part)) for part in shape.color.split())


TORQUE_ARM = 0.15  # of the crane's size: distance of a torque's arrow from the axis


class RobotVisual:
    """Draws a URDF's solids at the joint coordinates, and rods between the rope's nodes."""

    def __init__(self, rec: rr.RecordingStream, layout: Layout) -> None:
        """Log the solids."""
        self._rec, self._layout = rec, layout
        tree = load_robot(layout.robot)
        self._joints = {joint.name: joint for joint in tree.joints()}
        rec.send_chunks(tree.stream(include_joint_transforms=False))
        for joint in self._joints.values():
            if joint.joint_type == "fixed" and joint.name != ATTITUDE_JOINT:
                rec.log(f"tf/{joint.name}", joint.compute_transform(0.0), static=True)
        rec.log("rope", rr.CoordinateFrame(layout.stand.frame), static=True)
        if "tip_z" in layout.joints:  # its boom is not modelled: nothing else shows what it is
            name = rr.Points3D(
                [[0.0, 0.0, 0.0]], labels="driven suspension point", colors=LABEL_COLOR, radii=0.0
            )
            rec.log("suspension_point", rr.CoordinateFrame("tip_link"), name, static=True)

    def effort_arrow(self, joint: str) -> EffortArrow:
        """Return a torque's push at the arm along the link's x axis, a force's along its axis."""
        pose = self._joints[joint]
        axis = np.array(pose.axis)
        if pose.joint_type == "prismatic":
            return EffortArrow(pose.child_link, (0.0, 0.0, 0.0), _as_vector(axis))
        return EffortArrow(
            pose.child_link, (TORQUE_ARM, 0.0, 0.0), _as_vector(np.cross(axis, (1.0, 0.0, 0.0)))
        )

    def set_size(self, size: float) -> None:
        """Log the rope's thickness."""
        rods = rr.Cylinders3D.from_fields(radii=CABLE_RADIUS_RATIO * size, fill_mode="solid")
        self._rec.log("rope", rods, static=True)

    def move(
        self, time: list[rr.TimeColumn], q: Array, nodes: Array, colors: Colors
    ) -> Framing | None:
        """Add frames: coordinates (F, nq), and nodes (F, N, 3) in the crane's standing frame.

        The colours (F, L, 3) are those of links or falls; one alone is that of all. The framing
        stays.
        """
        values = dict(zip(self._layout.joints, q.T, strict=True))
        for name, columns in joint_transforms(self._joints.values(), values):
            self._rec.send_columns(f"tf/{name}", time, columns)
        if self._layout.ropes.falls is not None:
            ends = fall_ends(self._layout.ropes.falls, values, nodes[:, self._layout.ropes.tip])
            self._draw_lines(time, *ends, colors)
        else:
            tip = self._layout.ropes.tip
            self._draw_lines(time, nodes[:, tip:-1], nodes[:, tip + 1 :], colors)

    def fit_to_motion(self) -> Framing | None:
        """Return None: a boom's reach is known from the start."""

    def _draw_lines(
        self, time: list[rr.TimeColumn], tops: Array, bottoms: Array, colors: Colors
    ) -> None:
        """Add rods between points (F, n, 3), in colours (F, n, 3), or (F, 1, 3) for all."""
        frames, count = tops.shape[:2]
        start, end = tops.reshape(-1, 3), bottoms.reshape(-1, 3)
        length = np.linalg.norm(end - start, axis=1)
        columns = rr.Cylinders3D.columns(
            lengths=length,
            centers=0.5 * (start + end),
            quaternions=turn_from_z(end - start),
            colors=np.broadcast_to(
                colors[:, : count if colors.shape[1] == count else 1], (frames, count, 3)
            ).reshape(-1, 3),
        )
        self._rec.send_columns("rope", time, columns.partition([count] * frames))


def joint_transforms(
    joints: Iterable[rr.urdf.UrdfJoint], values: Mapping[str, Array]
) -> Iterator[tuple[str, rr.ComponentColumnList]]:
    """Yield names and transforms of all joints that move, from coordinates (F,) by name."""
    for joint in joints:
        if joint.name == ATTITUDE_JOINT:
            yield joint.name, _turns(joint, np.column_stack([values[name] for name in ATTITUDE]))
        elif joint.joint_type != "fixed":
            mimic = joint.mimic
            value = (
                values[joint.name]
                if mimic is None
                else mimic.multiplier * values[mimic.joint] + mimic.offset
            )
            yield joint.name, joint.compute_transform_columns(value.tolist(), clamp=False)


def _turns(joint: rr.urdf.UrdfJoint, attitude: Array) -> rr.ComponentColumnList:
    """Return a payload's turns, from its axes to the base's, of quaternions (F, 4), w first."""
    # with the names of frames that this tree gives them
    rest, frames = joint.compute_transform(0.0), len(attitude)
    names = [
        each.as_arrow_array().to_pylist()
        for each in (rest.parent_frame, rest.child_frame)
        if each is not None
    ]
    parent, child = (name * frames for name in names)
    return rr.Transform3D.columns(
        quaternion=np.roll(attitude, -1, axis=1), parent_frame=parent, child_frame=child
    )


def _as_vector(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def load_robot(
    robot: str, entity: str | None = None, frames: str | None = None
) -> rr.urdf.UrdfTree:
    """Return a URDF's tree, its entities below `entity`, its frames' names prefixed by `frames`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "crane.urdf")
        path.write_text(robot)
        return rr.urdf.UrdfTree.from_file_path(path, entity, frame_prefix=frames)


def _cable_columns(nodes: Array, colors: Colors) -> rr.ComponentColumnList:
    """Return a strip per link for nodes (F, N+1, 3), with colours (F, N, 3) or one (F, 1, 3).

    With a single colour it is a single strip.
    """
    frames, links = len(nodes), colors.shape[1]
    if links != nodes.shape[1] - 1:
        return rr.LineStrips3D.columns(strips=nodes.astype(np.float32), colors=colors[:, 0])
    strips = np.stack([nodes[:, :-1], nodes[:, 1:]], axis=2).reshape(-1, 2, 3).astype(np.float32)
    return rr.LineStrips3D.columns(strips=strips, colors=colors.reshape(-1, 3)).partition(
        [links] * frames
    )


# fraction of the motion's extent by which a room is made larger, so that it rarely has to grow
ROOM_MARGIN = 0.3


EFFORT_ARROWS = {
    "trolley": EffortArrow("trolley", (0.0, -0.06, 0.03), (1.0, 0.0, 0.0)),
    "bridge": EffortArrow("trolley", (0.1, 0.0, 0.03), (0.0, 1.0, 0.0)),
    "hoist": EffortArrow("trolley", (0.1, -0.06, 0.03), (0.0, 0.0, -1.0)),
}


class GantryVisual:
    """Draws the cable of a `Suspension`."""

    def __init__(self, rec: rr.RecordingStream, suspension: Suspension, stand: str) -> None:
        """Log the solids in the room that is expected; all of them stand in the frame `stand`."""
        self._rec, self._suspension, self._stand = rec, suspension, stand
        self._low, self._high, self._shortest = np.full(3, np.inf), np.full(3, -np.inf), np.inf
        for entity in ("rope", "rope/nodes"):
            rec.log(entity, rr.CoordinateFrame(stand), static=True)
        self._build(suspension.room)

    def effort_arrow(self, joint: str) -> EffortArrow:
        """Return a free position beside the trolley."""
        return EFFORT_ARROWS[joint]

    def set_size(self, size: float) -> None:
        """Log the cable's thickness."""
        self._rec.log(
            "rope", rr.LineStrips3D.from_fields(radii=CABLE_RADIUS_RATIO * size), static=True
        )
        radii = np.array(self._radii(self._room))
        # others are hidden in the line
        self._beads = bool(np.any(radii > CABLE_RADIUS_RATIO * size))
        if self._beads:
            self._rec.log(
                "rope/nodes", rr.Points3D.from_fields(colors=NODE_COLOR, radii=radii), static=True
            )

    def move(
        self, time: list[rr.TimeColumn], q: Array, nodes: Array, colors: Colors
    ) -> Framing | None:
        """Add frames; the framing is a new one where the room was too small."""
        self._extend_range(nodes)
        grown = None
        if not self._room.contains(self._low, self._high):
            more = ROOM_MARGIN * (self._high - self._low)
            grown = self._build(
                make_bounding_box(
                    self._low - more, self._high + more, self._shortest, self._room.spatial
                )
            )
        if self._room.spatial:
            self._place(time, "bridge", nodes[:, 0] * (0.0, 1.0, 0.0))
        self._place(time, "trolley", nodes[:, 0])
        self._place(time, "payload", nodes[:, -1], turn_from_z(nodes[:, -2] - nodes[:, -1]))
        self._rec.send_columns("rope", time, _cable_columns(nodes, colors))
        if self._beads:
            beads = rr.Points3D.columns(positions=nodes[:, 1:-1].reshape(-1, 3))
            self._rec.send_columns(
                "rope/nodes", time, beads.partition([nodes.shape[1] - 2] * len(nodes))
            )
        return grown

    def fit_to_motion(self) -> Framing | None:
        """Make the room as large as the motion was."""
        if not np.isfinite(self._low).all():
            return None
        return self._build(
            make_bounding_box(self._low, self._high, self._shortest, self._room.spatial)
        )

    def _extend_range(self, nodes: Array) -> None:
        """Extend the range of the motion by the nodes (F, N+1, 3)."""
        self._low, self._high = (
            np.minimum(self._low, nodes.min((0, 1))),
            np.maximum(self._high, nodes.max((0, 1))),
        )
        self._shortest = min(
            self._shortest, float(np.linalg.norm(nodes[:, -1] - nodes[:, 0], axis=1).min())
        )

    def _build(self, room: BoundingBox) -> Framing:
        """Log the solids, which replace those that were logged before."""
        self._room = room
        mass = self._suspension.hang.masses[-1]
        log_solids(self._rec, "crane/base", self._stand, overhead.base(room))
        if room.spatial:
            log_solids(self._rec, "crane/bridge", "bridge", overhead.bridge(room))
        log_solids(self._rec, TROLLEY, "trolley", overhead.trolley(room))
        log_solids(self._rec, "payload/box", "payload", overhead.payload(mass, room))
        return of_room(room, self._suspension.lifts)

    def _radii(self, room: BoundingBox) -> list[float]:
        hang = self._suspension.hang
        pairs = list(zip(hang.masses, hang.lengths, strict=True))
        return [overhead.node_radius(mass, length, room) for mass, length in pairs[:-1]]

    def _place(
        self, time: list[rr.TimeColumn], frame: str, at: Array, turn: Array | None = None
    ) -> None:
        frames = len(at)
        columns = rr.Transform3D.columns(
            translation=at,
            quaternion=turn,
            parent_frame=[self._stand] * frames,
            child_frame=[frame] * frames,
        )
        self._rec.send_columns(f"tf/{frame}", time, columns)
