"""The group `reference` of a scene file: target of the actuated joints, and the path to it."""

from math import sqrt
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, TypeAdapter, model_validator

from crane_sim.files.errors import SceneError, no_group, shorten
from crane_sim.files.types import Real
from crane_sim.scenes.schema.groups import Group, InlineUnion, tagged_union_validator
from crane_sim.trajectories.joint_trajectory import Waypoints, read_trajectory
from crane_sim.trajectories.line_arc import Arc, Line
from crane_sim.trajectories.minimum_jerk import MinimumJerk
from crane_sim.trajectories.obstacle import ObstacleDetour
from crane_sim.trajectories.point_to_point import PointToPoint
from crane_sim.trajectories.polynomials import PiecewisePolynomial, reorder
from crane_sim.trajectories.replanning import to_piecewise_polynomial
from crane_sim.trajectories.shaping import Shaping, apply_input_shaper
from crane_sim.trajectories.trajectory import Trajectory, compile_trajectory

KINDS: dict[str, Any] = {
    "line": Line,
    "arc": Arc,
    "point_to_point": PointToPoint,
    "minimum_jerk": MinimumJerk,
    "obstacle": ObstacleDetour,
    "trajectory": Waypoints,
}
"""The kinds of path, and their keys."""
_PROFILE: TypeAdapter[Any] = TypeAdapter(Annotated[Any, tagged_union_validator("kind", KINDS)])
_COMMON_KEYS = ("of", "shaping")  # keys of a path of any kind, beside the kind's own
# m, rad, relative to large ones: of a path's end from the target of the joints
TARGET_TOLERANCE = 1e-6
COORDINATES = ("x", "y", "z")  # of the payload, in the base frame


class PathGroup(Group):
    """Path of the payload or of the actuated joints: the keys that all kinds of path have."""

    of: Literal["payload", "joints"] = "payload"  # whether the coordinates are the payload's (x, y,
    # z in the axes of the base) or the actuated joints'
    profile: Annotated[Any, InlineUnion(("kind", KINDS))]  # which path; its own keys stand beside
    # `kind`
    shaping: Shaping | None = None  # input shaping against swing; left out: the path as it is


def _path(value: Any) -> Any:
    """Return the group read from a file."""
    if value is None:
        return value
    if not isinstance(value, dict):
        raise ValueError(f"{no_group()}, with kind: {' | '.join(KINDS)}")
    own = {key: entry for key, entry in value.items() if key not in _COMMON_KEYS}
    if own.get("kind") == "trajectory" and "file" in own:
        duplicates = [key for key in ("joint_names", "points") if key in own]
        if duplicates:
            raise ValueError(f"file gives {duplicates[0]}, too; leave out one of the two")
        if not isinstance(own["file"], str):
            raise ValueError(f"file = {shorten(own['file'])}: must be text")
        own |= read_trajectory(own.pop("file"))
    return {key: value[key] for key in _COMMON_KEYS if key in value} | {
        "profile": _PROFILE.validate_python(own)
    }


class ReferenceGroup(Group):
    """Target of the actuated joints, and path of joints or payload; at least one of them."""

    q: tuple[Real, ...] | None = None  # joint's unit, target of the actuated joints, in their
    # order; left out: the end of a path of the joints
    path: Annotated[PathGroup | None, BeforeValidator(_path)] = None  # of the actuated joints or
    # the payload

    @model_validator(mode="after")
    def _check_not_empty(self) -> Self:
        if self.q is None and self.path is None:
            raise ValueError("needs q, path or both")
        return self


def target_of(
    reference: ReferenceGroup | None, actuated: tuple[str, ...]
) -> tuple[float, ...] | None:
    """Return the target of the actuated joints, None without `reference.q`.

    Raises:
        SceneError: it has another number of values than joints are actuated.
    """
    if reference is None or reference.q is None:
        return None
    if len(reference.q) != len(actuated):
        raise SceneError(f"reference.q: has {len(reference.q)} values, actuated are {actuated}")
    return reference.q


def resolve_target(
    target: tuple[float, ...] | None, path: Trajectory | None
) -> tuple[float, ...] | None:
    """Return the target of the actuated joints: the scene's, or the end of their path.

    Raises:
        SceneError: the path ends elsewhere.
    """
    if path is None or not path.of_joints:
        return target
    end = tuple(float(x) for x in to_piecewise_polynomial(path).coefficients[-1, :, 0])
    if target is None:
        return end
    if any(
        abs(x - y) > TARGET_TOLERANCE * max(1.0, abs(x)) for x, y in zip(target, end, strict=True)
    ):
        raise SceneError(
            f"reference.q = {list(target)}: the path of the joints ends at {list(end)}; leave out q"
        )
    return target


def compile_path(reference: ReferenceGroup | None, file: Any) -> Trajectory | None:
    """Return the compiled path of a scene's file, None where it has none.

    Raises:
        SceneError: the path's coordinates do not match the crane's, or there is no such motion.
    """
    group = reference.path if reference is not None else None
    if group is None:
        return None
    try:
        with np.errstate(all="ignore"):  # non-finite results are rejected below
            pieces = _pieces(group, file)
    except (ValueError, OverflowError) as error:
        raise SceneError(f"reference.path: {error}") from None
    if not all(np.all(np.isfinite(part)) for part in pieces):
        raise SceneError("reference.path: is not finite: its numbers are too large or too small")
    if np.any(np.diff(pieces.starts) <= 0.0):
        raise SceneError(
            f"reference.path.start = {group.profile.start:g}: so large that the motion takes no "
            "time there"
        )
    return compile_trajectory(pieces, group.of == "joints")


def _pieces(group: PathGroup, file: Any) -> PiecewisePolynomial:
    """Return the motion, with input shaping if there is some."""
    pieces = _reordered_pieces(group, file.actuated if group.of == "joints" else COORDINATES)
    if group.shaping is None:
        return pieces
    return apply_input_shaper(
        pieces, group.shaping.kind, _frequency(group.shaping, file), group.shaping.damping
    )


def _reordered_pieces(group: PathGroup, names: tuple[str, ...]) -> PiecewisePolynomial:
    """Return the motion with its coordinates in the order of `names`.

    A path of joints has all of the names, one of the payload the first ones.
    """
    pieces = group.profile.to_polynomials()
    n = pieces.coefficients.shape[1]
    if n > len(names) or (group.of == "joints" and n < len(names)):
        raise ValueError(f"has {n} coordinates, {group.of} of this crane: {', '.join(names)}")
    order = getattr(group.profile, "joint_names", names[:n])
    if sorted(order) != sorted(names[:n]):
        raise ValueError(
            f"joint_names = {', '.join(order)}: must be {', '.join(names[:n])}, in any order"
        )
    return reorder(pieces, [order.index(name) for name in names[:n]])


def _frequency(shaping: Shaping, file: Any) -> float:
    """Return the frequency of the swing [rad/s]; `auto`: of a point load on the whole rope."""
    if shaping.frequency != "auto":
        return shaping.frequency
    if not file.gravity > 0.0:
        raise ValueError(
            f"shaping.frequency = 'auto': nothing swings at gravity = {file.gravity:g}"
        )
    return sqrt(file.gravity / file.rope_length)
