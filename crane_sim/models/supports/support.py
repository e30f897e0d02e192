"""A support, which carries the upper end of a rope: a tree of joints and bodies, and drives.

A structure (`knuckle_boom`, `telescopic_boom`, `tower_crane`, `bridge`, `flexible`,
`swaying_tower`, `driven_point`) is a NamedTuple of parameters whose method `mechanism` declares its
joints and bodies; all equations follow from that. Coordinates are those of the drives, the
structure's first ones, then what bends; drives with play have theirs behind.

Friction and motors act on coordinates. The reflected inertia of a motor, ratio² times that of its
rotor, stands on the diagonal of the mass matrix: a motor turns relative to the support, a base's
motion does not accelerate what it reflects. A coordinate that dry friction holds does not
accelerate and leaves the equations of the others.

Vectors are in the tree's axes (`multibody.tree`): the base's, turned by the slew.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.models.supports.backlash import Drive, DriveState, drives_of
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.wind_load import BoomWindage, JibWindage, RodWindage
from crane_sim.multibody.tree import (
    Kinematics,
    Point,
    Tree,
    compute_kinematics,
    point_acceleration,
    point_position,
    point_velocity,
    to_base_axes,
    velocity_at_rates,
)
from crane_sim.multibody.vectors import Vector
from crane_sim.numerics.elementary import sincos


class Spring(NamedTuple):
    """A spring and a damper on a combination of coordinates."""

    lever: tuple[Any, ...]  # (n,) of its deflection, by the coordinates
    stiffness: Any  # N/m or N m/rad
    rest: Any = 0  # m or rad, where it is relaxed
    damping: Any = 0  # N s/m or N m s/rad


class Pressed(NamedTuple):
    """A slender part along the x axis of a joint's link, on which the wind presses."""

    joint: int
    windage: RodWindage | JibWindage | BoomWindage
    reach: Any = 0  # m, of the centre of pressure from the link's origin; a `BoomWindage` has it
    # halfway up
    length: int = 0  # of a `BoomWindage`: the coordinate that is its length


class Mechanism(NamedTuple):
    """What a structure is made of; n coordinates."""

    tree: Tree
    limits: tuple[Any, ...]  # (n,) each (low, high) [m or rad] or None; a run ends where one is
    # reached
    actuated: tuple[int, ...]  # coordinates that take a command each
    springs: tuple[Spring, ...] = ()
    yaw: tuple[int, ...] = (0,)  # coordinates whose sum is the angle about the vertical of what
    # hangs at the tip
    outline: tuple[Point, ...] = ()  # points of its polyline before the tip
    pressed: tuple[Pressed, ...] = ()
    prescribed: tuple[bool, ...] = ()  # (n,): it moves as its drive says, whatever it carries;
    # empty: none does
    bending: int = 0  # number of the coordinates that bend: the last ones

    def by_coordinate(self, command: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return commands, one for each of `actuated`, by coordinate (n,), 0 for the others."""
        actuated = self.actuated
        return tuple(
            command[actuated.index(i)] if i in actuated else 0 for i in range(len(self.limits))
        )


class Support(NamedTuple):
    """A structure with friction, motors and play of its drives; what is None is not modelled."""

    structure: Any
    motors: tuple[float, ...] | None = None  # (n,) kg or kg m², reflected to the coordinates
    frictions: tuple[Friction | LuGre | None, ...] | None = None  # (n,)
    drives: tuple[tuple[Drive, ...], ...] | None = None  # (n,) with play

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return self.structure.coordinate(i)


def structure_of(support: Any) -> Any:
    """Return the structure of a support; the support of a `single_rope` is one itself."""
    return support.structure if isinstance(support, Support) else support


class SupportState(NamedTuple):
    """State of a support with n coordinates."""

    q: tuple[Any, ...]  # (n,) m or rad
    v: tuple[Any, ...]  # (n,)
    drives: tuple[DriveState, ...]  # of drives with play
    friction: tuple[Any, ...]  # modes, or deflections of bristles, of the coordinates that have
    # friction


class Posture(NamedTuple):
    """A support in a state: its kinematics."""

    state: SupportState
    mechanism: Mechanism
    kinematics: Kinematics
    tip: Vector  # m, from the base's origin
    tip_velocity: Vector  # m/s, relative to the base
    heading: tuple[Any, Any]  # sine and cosine of the yaw
    yaw_rate: Any  # rad/s


def own_count(support: Support) -> int:
    """Return the number n of coordinates of the structure."""
    return len(support.structure.mechanism().limits)


def coordinate_count(support: Support) -> int:
    """Return the number of coordinates, those of drives with play included."""
    return own_count(support) + drive_count(support)


def drive_count(support: Support) -> int:
    """Return the number of drives with play."""
    return len(drives_of(support.drives))


def trailing_count(support: Support) -> int:
    """Return the number of trailing coordinates in joint order: bending and drives with play."""
    return support.structure.mechanism().bending + drive_count(support)


def frictions_of(support: Support) -> tuple[tuple[int, Friction | LuGre], ...]:
    """Return (coordinate, friction) of all coordinates that have friction."""
    if support.frictions is None:
        return ()
    return tuple((i, part) for i, part in enumerate(support.frictions) if part is not None)


def friction_state_count(support: Support) -> int:
    """Return the number of the friction states, which end the crane's state."""
    return len(frictions_of(support))


def first_friction_state(support: Support, x: Any) -> Any:
    """Return the index of the first friction state in a crane's state x."""
    return len(x) - friction_state_count(support)


def read_state(support: Support, x: Any, nq: Any) -> SupportState:
    """Return the support's state from a crane's state x with nq coordinates."""
    n, drives, last = own_count(support), drive_count(support), first_friction_state(support, x)
    states = tuple(DriveState(x[n + i], x[nq + n + i], x[last - drives + i]) for i in range(drives))
    frictions = tuple(x[last + i] for i in range(friction_state_count(support)))
    return SupportState(
        tuple(x[i] for i in range(n)), tuple(x[nq + i] for i in range(n)), states, frictions
    )


def to_joint_order(support: Support, row: Any) -> Any:
    """Return a row of coordinates or their rates in the order of joints, trailing ones last."""
    n, count, out = trailing_count(support), len(row), row.copy()
    own = coordinate_count(support) - n
    for i in range(own, count - n):
        out[i] = row[i + n]
    for i in range(n):
        out[count - n + i] = row[own + i]
    return out


def to_coordinate_order(support: Support, row: Any) -> Any:
    """Return a row of joints or their rates in the order of coordinates.

    This is the inverse of `to_joint_order`.
    """
    n, count, out = trailing_count(support), len(row), np.empty(len(row))
    own = coordinate_count(support) - n
    for i in range(own):
        out[i] = row[i]
    for i in range(own, count - n):
        out[i + n] = row[i]
    for i in range(n):
        out[own + i] = row[count - n + i]
    return out


def takes_energy(support: Support) -> bool:
    """Return whether drives with play, a structure that bends or friction take energy."""
    bends = support.structure.mechanism().bending > 0
    return bends or support.drives is not None or support.frictions is not None


def compute_posture(support: Support, state: SupportState) -> Posture:
    """Return the posture of a support in a state."""
    mechanism = support.structure.mechanism()
    tree = mechanism.tree
    kinematics = compute_kinematics(tree, state.q, state.v)
    return Posture(
        state,
        mechanism,
        kinematics,
        point_position(kinematics, tree.tip),
        point_velocity(kinematics, tree.tip),
        _heading(mechanism, kinematics, state.q),
        sum(state.v[i] for i in mechanism.yaw),
    )


def yaw(support: Support, q: tuple[Any, ...]) -> Any:
    """Return the angle [rad] about the vertical of what hangs at the tip, at coordinates q."""
    return sum(q[i] for i in support.structure.mechanism().yaw)


def _heading(mechanism: Mechanism, kinematics: Kinematics, q: tuple[Any, ...]) -> tuple[Any, Any]:
    if len(mechanism.yaw) == 1 and not isinstance(kinematics.turn[0], int):
        return kinematics.turn
    return sincos(sum(q[i] for i in mechanism.yaw)) if mechanism.yaw else (0, 1)


def tip_acceleration(posture: Posture, qdd: tuple[Any, ...]) -> Vector:
    """Return the tip's acceleration [m/s²] relative to the base, in its axes, at qdd (n,)."""
    tree = posture.mechanism.tree
    return to_base_axes(
        posture.kinematics.turn, point_acceleration(tree, posture.kinematics, tree.tip, qdd)
    )


def tip_rate(posture: Posture, rates: tuple[Any, ...]) -> Vector:
    """Return the tip's velocity [m/s] relative to the base, in its axes, at rates (n,).

    Jumps of the rates give the jump of the velocity.
    """
    tree = posture.mechanism.tree
    return to_base_axes(
        posture.kinematics.turn, velocity_at_rates(tree, posture.kinematics, tree.tip, rates)
    )


def polyline(posture: Posture) -> tuple[Vector, ...]:
    """Return the structure's polyline [m], base to tip, in the base's axes."""
    kinematics = posture.kinematics
    places = [
        *(point_position(kinematics, point) for point in posture.mechanism.outline),
        posture.tip,
    ]
    return tuple(to_base_axes(kinematics.turn, place) for place in places)


def polyline_size(support: Support) -> int:
    """Return the number of points of the structure's polyline."""
    return len(support.structure.mechanism().outline) + 1


def bare_tip(posture: Posture) -> tuple[Vector, Vector]:
    """Return (position [m], velocity [m/s]) of the tip relative to the base, in its axes."""
    turn = posture.kinematics.turn
    return to_base_axes(turn, posture.tip), to_base_axes(turn, posture.tip_velocity)


def arm_of(posture: Posture, arm: Vector) -> Vector:
    """Return a vector (3,) that turns with the yaw, in the base's axes."""
    return to_base_axes(posture.heading, arm)
