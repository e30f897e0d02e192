"""Loads at the lower end of a cable: a point mass, or a rigid body that hangs from one of its points."""

from typing import NamedTuple

from crane_sim.files.types import Positive
from crane_sim.models.wind_load import Windage
from crane_sim.multibody.vectors import Matrix, Vector


class PointLoad(NamedTuple):
    """The payload, a point mass."""

    mass: Positive  # kg, of the payload
    windage: Windage | None = None  # area and drag in the `wind`; left out: no wind acts on it


class RigidLoad(NamedTuple):
    """A payload that is a rigid body; vectors are in its own axes, with the origin in its centre of mass."""

    mass: float  # kg
    inertia: Matrix  # kg m², rows of the inertia tensor about the centre of mass
    inverse_inertia: Matrix  # 1/(kg m²), rows of its inverse
    attachment: Vector  # m, from the centre of mass to the point from which the body hangs
    windage: Windage | None = None  # area and drag in the wind
    pressure_centre: Vector = (0.0, 0.0, 0.0)  # m, where the wind presses
