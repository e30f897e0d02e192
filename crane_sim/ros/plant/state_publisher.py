"""The interface of what publishes more than a plant's joint states: frames, the base, sensors."""

from collections.abc import Iterable
from typing import Any, Protocol

from geometry_msgs.msg import Point, Quaternion, Vector3

from crane_sim.simulation.plant import Plant


class StatePublisher(Protocol):
    """Publishes something of every state that has just been published as `joint_states`."""

    def update_subscribers(self) -> bool:
        """Update whether there are subscribers; return whether there are more than before."""
        ...

    def publish(self, stamp: int, plant: Plant) -> None:
        """Publish what belongs to the present state, stamped `stamp` [ns], where there are subscribers."""
        ...


class SubscriberCount:
    """The number of subscribers of publishers at the last update.

    Attributes:
        number: of all of them together.
    """

    def __init__(self, *publishers: Any) -> None:
        """Count those of the publishers."""
        self._publishers, self.number = publishers, 0

    def update(self) -> bool:
        """Count anew; return whether there are more than before."""
        before, self.number = self.number, sum(each.get_subscription_count() for each in self._publishers)
        return self.number > before


def set_vector(vector: Vector3 | Point, values: Iterable[float]) -> None:
    """Write (3,) into a vector or point."""
    vector.x, vector.y, vector.z = map(float, values)


def set_quaternion(quaternion: Quaternion, values: Iterable[float]) -> None:
    """Write x, y, z, w into a quaternion."""
    quaternion.x, quaternion.y, quaternion.z, quaternion.w = map(float, values)
