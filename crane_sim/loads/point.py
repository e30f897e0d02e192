"""A payload that is a point mass."""

from typing import NamedTuple

from crane_sim.quantities import Positive


class PointLoad(NamedTuple):
    """Parameters of the load."""

    mass: Positive  # kg
