"""The group `events` of cranes with a body or point mass as payload: loads exchanged in a run."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative
from crane_sim.models.carrier.exchange import COLUMNS, Exchange
from crane_sim.models.loads import PointLoad, RigidLoad
from crane_sim.models.wind_load import AnyWindage, Windage
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.rigging import Payload, Vector

REST = (0.0, 0.0, 0.0)
ROUNDING = 1e-9  # relative, of differences of masses and moments
NO_WINDAGE = Windage(0.0, 0.0)
Velocity = Literal["hook"] | Vector


class LoadChange(Group):
    """Change of an event."""

    payload: Payload  # all that hangs from then on, in the axes of the payload before


class ExchangeEvent(Group):
    """Time of a pick-up or release, and how what is picked up moves before."""

    at: NonNegative  # s, when it happens
    velocity: Velocity | None = None  # m/s, of what is taken up just before, relative to the base
    # and in its axes, without turning; `hook`: it moves with the payload, and nothing jumps; left
    # out: it rests

    @property
    @abstractmethod
    def payload(self) -> Payload:
        """All that hangs from then on."""


class LoadEvent(ExchangeEvent):
    """Pick-up or release of a load at a given time: the payload becomes heavier or lighter."""

    set: LoadChange  # what is new from then on

    @property
    def payload(self) -> Payload:
        """All that hangs from then on."""
        return self.set.payload


def windages_of(payload: Payload, events: Sequence[ExchangeEvent]) -> dict[str, AnyWindage | None]:
    """Return the windages of all payloads of a run, by key of the file."""
    windages: dict[str, AnyWindage | None] = {"payload.windage": payload.pressed}
    for i, event in enumerate(events):
        windages[f"events[{i}].set.payload.windage"] = event.payload.pressed
    return windages


def at_rest(at: float) -> Vector:
    """Return the velocity (3,) [m/s] at a time of what rests on the base."""
    return REST


def exchange_of(
    payload: Payload, events: Sequence[ExchangeEvent], ground: Callable[[float], Vector] = at_rest
) -> tuple[PointLoad | RigidLoad, Exchange | None]:
    """Return the load at t = 0 and the schedule of its exchanges, None without events.

    Args:
        payload, events: groups of the file.
        ground: velocity (3,) [m/s] at a time of what waits to be taken up, where an event does not
            say it.

    Raises:
        SceneError: there is no such load, no body is the difference of two, or a key contradicts
            another one.
    """
    first, order = payload.load(), order_of(events)
    if not events:
        return first, None
    loads = [first]
    for i in order:
        loads.append(_load_after(f"events[{i}]", events[i], loads[-1]))
    windages = [load.windage or NO_WINDAGE for load in loads]
    if any(load.windage is not None for load in loads):
        first = first._replace(windage=windages[0])
    moves = [
        _velocity(f"events[{i}]", events[i], a, b, ground)
        for i, a, b in zip(order, loads, loads[1:], strict=False)
    ]
    exchange = Exchange(
        times=np.array([events[i].at for i in order]),
        velocities=np.array([velocity or REST for velocity in moves], dtype=float),
        carried=np.array([float(velocity is None) for velocity in moves]),
        masses=np.array([load.mass for load in loads]),
        bodies=np.array([_columns(load) for load in loads]),
        windages=np.array(windages),
    )
    return first, exchange


def order_of(events: Sequence[Any]) -> list[int]:
    """Return the numbers of the events in the order of their times."""
    return sorted(range(len(events)), key=lambda i: events[i].at)


def _columns(load: PointLoad | RigidLoad) -> Any:
    if isinstance(load, PointLoad):
        return np.zeros(COLUMNS)
    return np.concatenate([np.ravel(part) for part in (*load[1:4], load.pressure_centre)])


def _load_after(
    key: str, event: ExchangeEvent, before: PointLoad | RigidLoad
) -> PointLoad | RigidLoad:
    """Return the load after an event, checked against the one before."""
    try:
        after = event.payload.load()
    except SceneError as error:
        raise SceneError(f"{key}.set.{error}") from None
    if type(after) is not type(before):
        word = "is missing" if isinstance(before, RigidLoad) else "is given"
        raise SceneError(
            f"{key}.set.payload.inertia: {word}; the payloads of a run are all point masses, or "
            "all bodies with inertia"
        )
    if abs(after.mass - before.mass) <= ROUNDING * before.mass:
        raise SceneError(
            f"{key}.set.payload.mass = {after.mass:g}: must be another one; a payload in place of "
            "another one is two "
            "events: let go, taken up"
        )
    if isinstance(after, RigidLoad) and isinstance(before, RigidLoad):
        _check_difference(
            f"{key}.set.payload.inertia", *sorted((before, after), key=lambda load: load.mass)
        )
    return after


def _check_difference(key: str, less: RigidLoad, more: RigidLoad) -> None:
    """Raise SceneError where the heavier load minus the lighter one is not a possible body."""
    mass, moments, tensors = more.mass - less.mass, [], []
    for load in (less, more):
        r = -np.array(load.attachment)
        moments.append(load.mass * r)
        tensors.append(np.array(load.inertia) + load.mass * (r @ r * np.eye(3) - np.outer(r, r)))
    centre, scale = (moments[1] - moments[0]) / mass, float(np.trace(tensors[1]))
    tensor = (
        tensors[1] - tensors[0] - mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    )
    low, middle, high = np.linalg.eigvalsh(tensor)
    if low < -ROUNDING * scale or high > low + middle + ROUNDING * scale:
        raise SceneError(
            f"{key}: the {mass:g} kg by which the payload changes would have the principal moments "
            f"{[round(float(moment), 6) for moment in (low, middle, high)]}, which no body has"
        )


def _velocity(
    key: str, event: ExchangeEvent, before: Any, after: Any, ground: Any
) -> Vector | None:
    """Return the velocity of what is taken up, None where nothing jumps."""
    if after.mass < before.mass:
        if event.velocity is not None:
            raise SceneError(
                f"{key}.velocity: belongs to what is taken up; what is let go keeps its velocity"
            )
        return None
    return None if event.velocity == "hook" else event.velocity or ground(event.at)
