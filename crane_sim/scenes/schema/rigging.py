"""Groups of a scene file for what hangs below a rope: links with nodes, and a rigid body."""

from collections.abc import Sequence
from math import cos, sin
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.models.cables.chain import Chain
from crane_sim.models.loads import PointLoad, RigidLoad
from crane_sim.models.suspended.torsion import Torsion
from crane_sim.models.wind_load import Windage
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.hardware import PayloadChange
from crane_sim.scenes.schema.motors import reflected_inertia
from crane_sim.scenes.schema.rods import ROUNDING

Vector = tuple[Real, Real, Real]
Quaternion = tuple[Real, Real, Real, Real]
ORIGIN, NO_TURN = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
UNIT_TOLERANCE = 1e-6  # how far from 1 the length of a unit vector may be


def _square(value: Any) -> Any:
    """Return three principal moments as a diagonal matrix, and a matrix as it is."""
    if (
        isinstance(value, list | tuple)
        and len(value) == 3
        and not any(isinstance(row, list | tuple) for row in value)
    ):
        return [[value[i] if i == k else 0.0 for k in range(3)] for i in range(3)]
    return value


class Link(Group):
    """A further link below the rope: a node, such as a hook block, and a rigid, massless line."""

    mass: Positive  # kg, of the node at its upper end
    length: Positive  # m, of the line


class PayloadWindage(Group):
    """Area and drag coefficient of the payload in the wind."""

    area: NonNegative  # m², that the wind sees
    drag_coefficient: NonNegative  # -, some 1.2 of a box
    centre: Vector | None = None  # m, of pressure, from the centre of mass of a body, in its axes;
    # left out: there


class Payload(Group):
    """The payload: a point mass, or with `inertia` a rigid body turning about its attachment."""

    mass: Positive  # kg, of the payload
    inertia: Annotated[tuple[Vector, Vector, Vector] | None, BeforeValidator(_square)] = (
        None  # kg m², about the
    )
    # centre of mass, in the body's axes: three principal moments, or the rows of the tensor
    windage: PayloadWindage | None = None  # area and drag in the `wind`; left out: no wind acts on
    # it
    attachment: Vector | None = None  # m, from a body's centre of mass to where it hangs, in its
    # axes; left out: there

    @property
    def pressed(self) -> Windage | None:
        """The payload's windage, None where it has none."""
        return (
            None
            if self.windage is None
            else Windage(self.windage.area, self.windage.drag_coefficient)
        )

    def load(self) -> PointLoad | RigidLoad:
        """Return the load.

        Raises:
            SceneError: no rigid body has this inertia, or `attachment` or `windage.centre` is given
                without `inertia`.
        """
        if self.inertia is None:
            if self.attachment is not None:
                raise SceneError("payload.attachment: belongs to a body; give payload.inertia, too")
            if self.windage is not None and self.windage.centre is not None:
                raise SceneError(
                    "payload.windage.centre: belongs to a body; give payload.inertia, too"
                )
            return PointLoad(self.mass, self.pressed)
        tensor = np.array(self.inertia)
        _check_inertia(tensor)
        centre = self.windage.centre or ORIGIN if self.windage is not None else ORIGIN
        matrices: list[Any] = [
            tuple(map(tuple, matrix.tolist())) for matrix in (tensor, np.linalg.inv(tensor))
        ]
        return RigidLoad(
            self.mass, matrices[0], matrices[1], self.attachment or ORIGIN, self.pressed, centre
        )


def _check_inertia(tensor: Any) -> None:
    """Raise SceneError for a tensor (3, 3) that no rigid body has."""
    # then three moments were given, or could have been
    diagonal = not (tensor - np.diag(np.diag(tensor))).any()
    shown = f"payload.inertia = {(np.diag(tensor) if diagonal else tensor).tolist()}"
    if not np.allclose(tensor, tensor.T, rtol=ROUNDING, atol=0.0):
        raise SceneError(f"{shown}: must be symmetric")
    moments = np.linalg.eigvalsh(tensor)
    if not moments[0] > 0.0:
        raise SceneError(
            f"{shown}: its principal moments {moments.round(9).tolist()} must be greater than 0"
        )
    if moments[2] > (moments[0] + moments[1]) * (1.0 + ROUNDING):
        raise SceneError(
            f"{shown}: no rigid body has a principal moment, here {moments[2]:g}, above the sum of "
            "the two others"
        )


class RiggingStart(Group):
    """Further links and attitude at t = 0; left out: in line with the rope, axes as the base's."""

    directions: tuple[Vector, ...] | None = None  # -, unit vectors down the further links, in the
    # axes of the base
    direction_rates: tuple[Vector, ...] | None = None  # 1/s, across the directions
    orientation: Quaternion = NO_TURN  # -, unit quaternion (w, x, y, z) from the body's axes to the
    # base's
    angular_velocity: Vector = (0.0, 0.0, 0.0)  # rad/s, of the body relative to the base, in the
    # body's axes

    def nearest_to(self, yaw: float) -> "RiggingStart":
        """Return the start with the quaternion of its attitude that is nearer to a yaw [rad]."""
        w, _, _, z = self.orientation
        if w * cos(0.5 * yaw) + z * sin(0.5 * yaw) >= 0.0:
            return self
        a, b, c, d = self.orientation
        return self.model_copy(update={"orientation": (-a, -b, -c, -d)})


class RopeStart(Group):
    """Joint coordinates at t = 0, in joint order."""

    rigging: RiggingStart | None = None  # further links, and the payload's attitude


def chain_of(rope_length: float, links: Sequence[Link], payload: float) -> Chain:
    """Return the cable of a rope and further links; the payload's mass [kg] is the last node's."""
    lengths, masses = (
        [rope_length, *(link.length for link in links)],
        [*(link.mass for link in links), payload],
    )
    return Chain(np.array(masses, dtype=float), np.array(lengths, dtype=float))


def twist_frequency(torsion: Torsion | None, inertias: Sequence[Any], mobility: float) -> float:
    """Return the largest frequency or decay rate [rad/s] on the rope's torsion, 0 without.

    Args:
        torsion: of the rope.
        inertias: of the payloads, each (3, 3) [kg m²].
        mobility: of the tip's yaw [1/(kg m²)].
    """
    if torsion is None:
        return 0.0
    turned = mobility + 1.0 / min(float(np.linalg.eigvalsh(inertia)[0]) for inertia in inertias)
    return max((torsion.stiffness * turned) ** 0.5, torsion.damping * turned)


def link_names(count: int, first: int = 2) -> tuple[str, ...]:
    """Return the joints of `count` links, numbered from `first` on; the rope is number 1."""
    return tuple(f"link_{k}_{axis}" for k in range(first, count + first) for axis in "xyz")


ATTITUDE = ("payload_qw", "payload_qx", "payload_qy", "payload_qz")
"""The joints of a body's attitude: the components of a unit quaternion."""


def rigging_start(
    start: RiggingStart, links: int, body: bool, rope: tuple[Any, Any]
) -> tuple[Any, Any]:
    """Return (q, v) of the joints that the rigging adds.

    Args:
        start: the group of the file.
        links: number of further links.
        body: whether the payload has an attitude.
        rope: direction of the rope and its rate, each (3,), which further links take where they are
            left out.

    Raises:
        SceneError: directions are no unit vectors, rates are not across them, or there are more
            than links.
    """
    directions = start.directions if start.directions is not None else (rope[0],) * links
    rates = start.direction_rates
    if rates is None:
        rates = (rope[1] if start.directions is None else (0.0, 0.0, 0.0),) * links
    for key, rows in (("directions", directions), ("direction_rates", rates)):
        if len(rows) != links:
            raise SceneError(
                f"initial.rigging.{key}: has {len(rows)} vectors, the cable has {links} further "
                "links"
            )
    for n, u in zip(directions, rates, strict=True):
        _check_direction(n, u)
    q, v = [x for n in directions for x in n], [x for u in rates for x in u]
    if not body and (start.orientation != NO_TURN or any(start.angular_velocity)):
        raise SceneError(
            "initial.rigging: orientation and angular_velocity belong to a body; give "
            "payload.inertia, too"
        )
    if body:
        attitude = attitude_of(start.orientation, "initial.rigging.orientation")
        return (*q, *attitude), (*v, *attitude_rate(attitude, start.angular_velocity))
    return tuple(q), tuple(v)


def _check_direction(n: Any, u: Any) -> None:
    if not abs(float(np.linalg.norm(n)) - 1.0) < UNIT_TOLERANCE:
        raise SceneError(f"initial.rigging.directions: {list(n)} must be a unit vector")
    if abs(float(np.dot(n, u))) > UNIT_TOLERANCE * (1.0 + float(np.linalg.norm(u))):
        raise SceneError(f"initial.rigging.direction_rates: {list(u)} must be across its direction")


def attitude_of(
    orientation: Any, key: str = "initial.orientation"
) -> tuple[float, float, float, float]:
    """Return a unit quaternion, (1, 0, 0, 0) for None; `key` of the file is named in errors.

    Raises:
        SceneError: it is none.
    """
    q = np.array(orientation if orientation is not None else NO_TURN)
    if not abs(float(np.linalg.norm(q)) - 1.0) < UNIT_TOLERANCE:
        raise SceneError(f"{key} = {q.tolist()}: must be a unit quaternion")
    w, x, y, z = (float(part) for part in q / np.linalg.norm(q))
    return w, x, y, z


def attitude_rate(q: Any, omega: Any) -> tuple[float, ...]:
    """Return the rates q' = ½ q ⊗ ω (4,) of a unit quaternion, ω [rad/s] in the body's axes."""
    (w, x, y, z), (a, b, c) = q, omega
    rate = (
        -(x * a + y * b + z * c),
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
    )
    return tuple(0.5 * part for part in rate)


def check_equipment(file: Any, payload: Payload, geared: Sequence[str] = ()) -> None:
    """Raise SceneError for groups of drives and faults that have no effect on these cranes.

    Motors of the joints `geared` add their inertia.
    """
    for joint in file.actuated:
        if joint not in geared and reflected_inertia(file, joint) > 0.0:
            raise SceneError(
                f"actuators.{joint}.motor.inertia: is not modelled on this crane; must be 0"
            )
    for name, fault in (file.faults or {}).items():
        if isinstance(fault, PayloadChange) and payload.inertia is not None:
            raise SceneError(
                f"faults.{name}: changes the mass of a payload, but not its inertia; leave out "
                "payload.inertia"
            )
