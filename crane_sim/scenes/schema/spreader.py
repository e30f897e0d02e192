"""The group `events` of a gantry crane: loads that its spreader takes or lets go, and contact."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Real
from crane_sim.models.contact.surface import PointChanges
from crane_sim.models.loads import RigidLoad
from crane_sim.scenes.schema.contact import ContactGroup, Points, check_points
from crane_sim.scenes.schema.exchange import ExchangeEvent, LoadChange, at_rest, order_of
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.rigging import Payload, Vector

DECIMALS = 12  # [m/s] of the deck's velocity, which then has the same bits on every machine


class ContactChange(Group):
    """What may touch from an event on, such as spreader corners on a container that it let go."""

    points: Points  # m, of the new payload, as many as those of `contact`, from the spreader's
    # origin, in its axes
    height: Real | None = None  # m, of what they touch above the base's origin; left out: that of
    # `contact`


class SpreaderChange(LoadChange):
    """Change of an event."""

    contact: ContactChange | None = None  # what may touch from then on, where the scene has a
    # `contact`


class SpreaderEvent(ExchangeEvent):
    """An exchange of the payload at a time: the spreader lets a load go, or takes one up."""

    set: SpreaderChange  # what is new from then on

    @property
    def payload(self) -> Payload:
        """All that hangs from then on."""
        return self.set.payload


def ground_velocity(contact: ContactGroup | None) -> Callable[[float], Vector]:
    """Return the velocity (3,) [m/s] of the deck, on which waiting loads stand, over time."""
    motion = contact.motion.motion() if contact is not None and contact.motion is not None else None
    if motion is None:
        return at_rest

    def velocity(at: float) -> Vector:
        x, y, z = (
            motion.amplitudes * motion.frequencies * np.cos(motion.frequencies * at + motion.phases)
        ).sum(1)[:3]
        return round(float(x), DECIMALS), round(float(y), DECIMALS), round(float(z), DECIMALS)

    return velocity


def contact_of(
    contact: ContactGroup | None, events: Sequence[SpreaderEvent], load: RigidLoad, q: Any
) -> Any:
    """Return the contact of all loads of a run; the first begins at the pose q (7,).

    Raises:
        SceneError: a key contradicts another one.
    """
    for i, event in enumerate(events):
        _check_change(f"events[{i}].set.contact", event.set.contact, contact)
    model = contact.model(load, q) if contact is not None else None
    if contact is None or model is None or not events:
        return model
    changes = [change for i in order_of(events) if (change := events[i].set.contact) is not None]
    points = [contact.points, *(change.points for change in changes)]
    heights = [
        contact.height,
        *(contact.height if change.height is None else change.height for change in changes),
    ]
    shifted = np.array(points, dtype=float) + np.array(load.attachment)
    return model._replace(changes=PointChanges(shifted, np.array(heights, dtype=float)))


def _check_change(key: str, change: ContactChange | None, contact: ContactGroup | None) -> None:
    """Raise SceneError for a change that does not fit the contact."""
    if change is None:
        if contact is not None:
            raise SceneError(
                f"{key}: is missing; with contact, say which points of the new payload may touch"
            )
        return
    if contact is None:
        raise SceneError(f"{key}: needs contact, the surface that they may touch")
    if len(change.points) != len(contact.points):
        raise SceneError(
            f"{key}.points: has {len(change.points)} points, contact.points has "
            f"{len(contact.points)}"
        )
    check_points(f"{key}.points", np.array(change.points, dtype=float))
