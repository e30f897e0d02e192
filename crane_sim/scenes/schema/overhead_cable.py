"""Cable and initial state of an overhead scene: expanded lists, merged nodes, coordinates."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError, shorten
from crane_sim.scenes.schema.axes import start_of
from crane_sim.scenes.schema.overhead_groups import OverheadGroups

Vector = tuple[float, ...]
# payload / heaviest node above it, from which model: auto takes a rod for a straight cable
STRAIGHT_MASS_RATIO = 1e3
# deviation of a unit vector's length from 1, and of its rate from perpendicular
UNIT_TOLERANCE = 1e-6
MIN_SEPARATION = 1e-9  # of a link's ends, relative to its length; a closer pair has no direction


@dataclass(frozen=True)
class Cable:
    """Links from the top (N,); the last node is the payload."""

    lengths: Vector  # m
    masses: Vector  # kg
    turns: tuple[Any, ...]  # of the links at t = 0: angles [rad], or unit vectors (3,)
    rates: tuple[Any, ...]  # of the links: rad/s, or their unit vectors' rates of change (3,)


def fill_list(values: tuple[Any, ...], n: int, name: str) -> tuple[Any, ...]:
    """Return n values, a single one repeated.

    Raises:
        SceneError: there are neither one nor n values.
    """
    if len(values) == 1:
        return values * n
    if len(values) != n:
        raise SceneError(f"{name}: has {len(values)} values, the cable has {n} links")
    return values


def cable_of(file: "OverheadCrane") -> Cable:
    """Return the cable of a scene, links across massless nodes merged.

    Raises:
        SceneError: lists of different lengths, a massless payload, or a massless node in a bent
            cable.
    """
    group = file.cable
    n = group.links or max(len(group.lengths), len(group.node_masses))
    lengths = fill_list(group.lengths, n, "cable.lengths")
    masses = list(fill_list(group.node_masses, n, "cable.node_masses"))
    if file.payload is not None:
        masses[-1] = file.payload.mass
    if masses[-1] == 0.0:
        raise SceneError(
            "cable.node_masses: the last one is the payload and must be greater than 0"
        )
    turns, rates = _link_directions(file, n), _link_rates(file, n)
    if file.dimensions == 3:
        _check_across(turns, rates)
    return _merge_links(Cable(lengths, tuple(masses), turns, rates))


def _check_across(directions: tuple[Any, ...], rates: tuple[Any, ...]) -> None:
    """Raise SceneError when the rate of a link's direction is not perpendicular to it."""
    for k, (direction, rate) in enumerate(zip(directions, rates, strict=True)):
        along = float(np.dot(direction, rate))
        if abs(along) > UNIT_TOLERANCE * (1.0 + max(map(abs, rate))):
            across = [round(v - along * n, 6) for v, n in zip(rate, direction, strict=True)]
            raise SceneError(
                f"initial.rates[{k}] = {list(rate)}: {along:g} of it is along link {k + 1}; "
                f"the rate of a direction must be across it: {across}"
            )


def _link_directions(file: "OverheadCrane", n: int) -> tuple[Any, ...]:
    start = file.initial
    if file.dimensions == 2:
        if start.directions is not None:
            raise SceneError("initial.directions: belong to 3 dimensions; 2 take angles")
        return fill_list(start.angles or (0.0,), n, "initial.angles")
    if start.angles is not None:
        raise SceneError(
            "initial.angles: belong to 2 dimensions; 3 take directions, unit vectors down the links"
        )
    directions = fill_list(start.directions or ((0.0, 0.0, -1.0),), n, "initial.directions")
    for k, direction in enumerate(directions):
        if not abs(np.linalg.norm(direction) - 1.0) < UNIT_TOLERANCE:
            raise SceneError(f"initial.directions[{k}] = {list(direction)}: must be a unit vector")
    return tuple(tuple(map(float, np.array(d) / np.linalg.norm(d))) for d in directions)


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, list | tuple):
        for entry in value:
            yield from _leaves(entry)
    else:
        yield value


def _link_rates(file: "OverheadCrane", n: int) -> tuple[Any, ...]:
    values, flat = file.initial.rates, file.dimensions == 2
    if values is None or values in ([], ()):
        return (0.0 if flat else (0.0, 0.0, 0.0),) * n
    if any(isinstance(x, bool) or not isinstance(x, int | float) for x in _leaves(values)):
        raise SceneError(
            f"initial.rates = {shorten(values)}: must be numbers, one or three for each link"
        )
    try:
        rates = np.atleast_1d(np.array(values, dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        raise SceneError(
            f"initial.rates = {shorten(values)}: must be numbers, one or three for each link"
        ) from None
    if rates.shape not in (((1,), (n,)) if flat else ((1, 3), (n, 3))) or not np.all(
        np.isfinite(rates)
    ):
        form = f"{n} numbers" if flat else f"{n} vectors of 3"
        raise SceneError(f"initial.rates: has the shape {rates.shape}, must be {form}, all finite")
    return fill_list(tuple(rates.tolist()), n, "initial.rates")


def _merge_links(cable: Cable) -> Cable:
    kept: list[list[Any]] = []
    for length, mass, turn, rate in zip(
        cable.lengths, cable.masses, cable.turns, cable.rates, strict=True
    ):
        if kept and kept[-1][1] == 0.0:
            if kept[-1][2:] != [turn, rate]:
                raise SceneError(
                    f"cable.node_masses: node {len(kept)} has no mass, so the cable cannot be bent "
                    "there"
                )
            kept[-1][:2] = [kept[-1][0] + length, mass]
        else:
            kept.append([length, mass, turn, rate])
    return Cable(*(tuple(column) for column in zip(*kept, strict=True)))


def choose_cable_model(file: "OverheadCrane") -> str:
    """Return the cable's model; `auto`: a rod for a light straight cable in the plane, or links."""
    requested, cable = file.cable.model, file.parts
    if requested != "auto":
        return requested
    other_groups = (
        file.joints
        or file.cable.joints
        or file.cable.inertia
        or file.base_motion
        or file.pushes_nodes
    )
    plain = file.dimensions == 2 and not other_groups
    light = max(cable.masses[:-1], default=0.0) * STRAIGHT_MASS_RATIO <= cable.masses[-1]
    return (
        "straight" if plain and light and _is_straight(cable) and len(cable.masses) > 1 else "rigid"
    )


def _is_straight(cable: Cable) -> bool:
    return len(set(cable.turns)) == 1 and len(set(cable.rates)) == 1


def compute_initial_state(file: "OverheadCrane") -> tuple[Vector, Vector]:
    """Return the joint positions and velocities at t = 0.

    Raises:
        SceneError: they do not fit the cable.
    """
    start = file.initial
    positions, velocities = [start.x], [start.v]
    if file.dimensions == 3:
        positions.append(start.y)
        velocities.append(start.vy)
    for i, axis in enumerate((file.trolley, file.bridge)[: len(positions)]):
        if axis is not None and axis.motion is not None:
            positions[i], velocities[i] = start_of(axis.motion)
    if file.hoist is not None:
        length, rate = hoist_at_start(file)
        positions.append(length)
        velocities.append(rate)
    q, v = _link_states(file, positions, velocities)
    return (*map(float, positions), *q), (*map(float, velocities), *v)


def hoist_at_start(file: "OverheadCrane") -> tuple[float, float]:
    """Return length [m] and rate [m/s] of the first link of a crane with a hoist at t = 0."""
    profile = file.hoist and file.hoist.profile
    if profile is not None:
        return start_of(profile)
    return file.initial.length or file.parts.lengths[0], file.initial.length_rate


def _link_states(
    file: "OverheadCrane", top: list[float], rates: list[float]
) -> tuple[Vector, Vector]:
    cable = file.parts
    if file.cable_model == "elastic":
        return _node_states(file, top, rates)
    if file.dimensions == 3:
        return tuple(x for turn in cable.turns for x in turn), tuple(
            x for rate in cable.rates for x in rate
        )
    if file.cable_model == "straight" and not _is_straight(cable):
        raise SceneError(
            "cable.model = 'straight': the links start with different angles or rates; take model: "
            "rigid"
        )
    n = 1 if file.cable_model == "straight" else len(cable.turns)
    return tuple(map(float, cable.turns[:n])), tuple(map(float, cable.rates[:n]))


def _node_states(
    file: "OverheadCrane", top: list[float], rates: list[float]
) -> tuple[Vector, Vector]:
    """Return positions and velocities of an elastic cable's nodes, from those of the axes."""
    start, n, d = file.initial, len(file.parts.lengths), file.dimensions
    if start.positions is None:
        return _unstretched_nodes(file, top, rates)
    states = []
    for name, rows in (
        ("positions", start.positions),
        ("velocities", start.velocities or ((0.0,) * d,) * n),
    ):
        if len(rows) != n or any(len(row) != d for row in rows):
            raise SceneError(f"initial.{name}: must be {n} vectors of {d}")
        states.append(tuple(float(x) for row in rows for x in row))
    _check_apart([(*top[: d - 1], 0.0), *start.positions], file.parts.lengths)
    return states[0], states[1]


def _check_apart(points: list[tuple[float, ...]], lengths: Vector) -> None:
    """Raise SceneError when the ends of a link coincide: it has no direction."""
    for k, length in enumerate(lengths):
        if np.linalg.norm(np.subtract(points[k + 1], points[k])) < MIN_SEPARATION * length:
            upper = f"node {k}" if k else "the trolley"
            raise SceneError(
                f"initial.positions[{k}] = {list(points[k + 1])}: node {k + 1} is at the position "
                f"of {upper}; "
                "the link between them needs a direction"
            )


def _unstretched_nodes(
    file: "OverheadCrane", top: list[float], rates: list[float]
) -> tuple[Vector, Vector]:
    """Return positions and velocities of unstretched links' nodes, from angles or directions."""
    cable, flat = file.parts, file.dimensions == 2
    if file.initial.velocities is not None:
        raise SceneError(
            "initial.velocities: belong to initial.positions; angles and directions take rates"
        )
    r, v = (np.array([head[0], 0.0 if flat else head[1], 0.0]) for head in (top, rates))
    hoisted = file.hoist is not None
    lengths, length_rate = (
        (top[-1], *cable.lengths[1:]) if hoisted else cable.lengths,
        rates[-1] if hoisted else 0.0,
    )
    positions, velocities = [], []
    for length, turn, rate in zip(lengths, cable.turns, cable.rates, strict=True):
        n = np.array([np.sin(turn), 0.0, -np.cos(turn)]) if flat else np.array(turn)
        turning = rate * np.array([np.cos(turn), 0.0, np.sin(turn)]) if flat else np.array(rate)
        r, v, length_rate = r + length * n, v + length * turning + length_rate * n, 0.0
        positions += list(r[[0, 2]] if flat else r)
        velocities += list(v[[0, 2]] if flat else v)
    return tuple(map(float, positions)), tuple(map(float, velocities))


class OverheadCrane(OverheadGroups):
    """The groups of an overhead scene, and its cable, actuated joints and initial state."""

    @cached_property
    def parts(self) -> Cable:
        """Lengths and masses of the cable's links, checked, massless nodes merged."""
        return cable_of(self)

    @cached_property
    def cable_model(self) -> str:
        """The cable's model: rigid, elastic or straight."""
        return choose_cable_model(self)

    @property
    def pushes_nodes(self) -> bool:
        """Whether forces act on nodes or on the payload: given ones, wind or drag."""
        return bool(self.forces or self.is_windy or self.payload_drag or self.payload_force)

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes that carry the cable's upper end."""
        return ("trolley",) if self.dimensions == 2 else ("trolley", "bridge")

    @property
    def actuated(self) -> tuple[str, ...]:
        """Joints that take commands."""
        groups = (("trolley", self.trolley), ("bridge", self.bridge), ("hoist", self.hoist))
        return tuple(name for name, group in groups if group is not None and group.drive == "force")

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return self._start[0]

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return self._start[1]

    @cached_property
    def _start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        return compute_initial_state(self)
