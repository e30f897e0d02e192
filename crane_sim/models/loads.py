"""A payload that is a point mass."""

from typing import NamedTuple

from crane_sim.files.types import Positive


class PointLoad(NamedTuple):
    """The payload, a point mass."""

    mass: Positive  # kg, of the payload
