"""The group `flexibility` of a scene file: bending of a jib, a mast or a mobile crane's boom."""

from math import cos, sin, sqrt
from typing import Any, Self

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, NonNegative, Positive
from crane_sim.models.supports.flexible import Compliance, FlexibleSupport
from crane_sim.models.supports.telescopic_boom import (
    BaseSection,
    Superstructure,
    TelescopedSection,
    TelescopicBoom,
)
from crane_sim.models.supports.tower_crane import LockedSlew, TowerCrane
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.mast import LARGEST, swaying_tower

DEFLECTION = "_deflection"  # last part of the name of a mode's joint
MAST_JOINTS = "mast_x" + DEFLECTION, "mast_y" + DEFLECTION  # angles about the axes of the base
ROUNDING = 1e-15  # rad, of a deflection


class Bending(Group):
    """A first mode of bending: the structure turns about its root on a spring."""

    stiffness: Positive  # N m/rad, about the root: of a beam with the tip's stiffness K the length
    # squared times K
    damping_ratio: NonNegative = 0.0  # -, of the mode at the start, without payload and with drives
    # that hold
    rest: Angle = 0.0  # rad, where nothing bends the structure: its camber
    deflection: Angle | None = None  # rad, at t = 0; left out: at rest under the structure's weight
    # and the payload's


class BoomFlexibility(Group):
    """Bending of the boom about its foot; the base section does not bend."""

    lateral: Bending | None = None  # about the slewing axis, positive to where a positive slew
    # goes; left out: rigid
    vertical: Bending | None = None  # in the plane of jib or boom, positive upwards; left out:
    # rigid

    @property
    def modes(self) -> dict[str, Bending]:
        """The modes by the name of their joint, in the order of the joints."""
        modes = {"lateral": self.lateral, "vertical": self.vertical}
        return {name + DEFLECTION: mode for name, mode in modes.items() if mode is not None}

    def left_to_rest(self) -> Self:
        """Return the group without deflections at t = 0."""
        modes = {"lateral": self.lateral, "vertical": self.vertical}
        left = {
            key: mode.model_copy(update={"deflection": None})
            for key, mode in modes.items()
            if mode is not None
        }
        return self.model_copy(update=left)


class MastBending(Group):
    """First bending modes of a mast, alike in all directions, about a point below the jib."""

    height: Positive  # m, h: of a cantilever loaded at its head about 0.85 of its length (Howell,
    # 2001)
    stiffness: Positive  # N m/rad, about that point: the head's stiffness K times h²
    damping_ratio: NonNegative = 0.0  # -, of the mode in the jib's plane at the start, without
    # payload
    mass: NonNegative = 0.0  # kg, of the mast that moves with its head: 0.24 of a uniform one's
    # (Rayleigh)


class JibBody(Group):
    """The jib as a thin rod."""

    mass: Positive  # kg, without the trolley
    centre: Positive  # m, of its mass from the tower's axis
    inertia: NonNegative  # kg m², about a transverse axis through the centre of mass

    @property
    def about_axis(self) -> float:
        """Inertia [kg m²] about the tower's axis."""
        return self.inertia + self.mass * self.centre**2


class JibFlexibility(BoomFlexibility):
    """Bending of the jib about the tower's head, or of the mast; the counter-jib is rigid."""

    jib: JibBody  # what bends; all else of slew.inertia turns with the drive
    mast: MastBending | None = None  # of a rigid jib: the tower that sways below it; left out:
    # rigid

    @property
    def modes(self) -> dict[str, Any]:
        """The modes by the name of their joint, in the order of the joints."""
        return super().modes if self.mast is None else dict.fromkeys(MAST_JOINTS, self.mast)


def outer_inertias(outer: TelescopicBoom, elevation: float, length: float) -> tuple[float, float]:
    """Return the inertia [kg m²] of what bends about the slewing and the root's transverse axes."""
    (ahead, _), first, second, c = (
        outer.superstructure.foot,
        outer.base_section,
        outer.telescope,
        cos(elevation),
    )
    parts = (
        (first.mass, first.centre, first.inertia),
        (second.mass, length - second.centre, second.inertia),
    )
    about_z = sum(m * (ahead + s * c) ** 2 + inertia * c * c for m, s, inertia in parts)
    return about_z, sum(m * s * s + inertia for m, s, inertia in parts)


def _bend(
    rigid: Any, bodies: tuple[TelescopicBoom, TelescopicBoom], flexibility: Any, place: Any
) -> Any:
    """Return a bending support: (what drives turn, what bends) at a start (elevation, length)."""
    if not flexibility.modes:
        raise SceneError(
            "flexibility: needs `lateral`, `vertical` or both; a rigid structure has no such group"
        )
    inertias, compliances = outer_inertias(bodies[1], *place), list[Compliance | None]()
    for mode, inertia in zip((flexibility.lateral, flexibility.vertical), inertias, strict=True):
        damping = (
            2.0 * mode.damping_ratio * sqrt(mode.stiffness * inertia) if mode is not None else 0.0
        )
        compliances.append(None if mode is None else Compliance(mode.stiffness, mode.rest, damping))
    return FlexibleSupport(rigid, *bodies, *compliances)


def flexible_boom(rigid: TelescopicBoom, flexibility: BoomFlexibility | None, q: Any) -> Any:
    """Return a mobile crane's support, rigid without the group; q: positions at t = 0.

    Raises:
        SceneError: nothing bends.
    """
    if flexibility is None:
        return rigid
    parts, first, second = rigid.superstructure, rigid.base_section, rigid.telescope
    inner = TelescopicBoom(parts, first._replace(windage=None), TelescopedSection(0.0, 0.0, 0.0))
    # the wind presses on the boom's outer half the most
    bare = BaseSection(0.0, 0.0, 0.0, windage=first.windage)
    outer = TelescopicBoom(Superstructure(0.0, parts.foot), bare, second)
    return _bend(rigid, (inner, outer), flexibility, (q[1], q[2]))


def balance(slew_inertia: float, jib: JibBody) -> tuple[float, float]:
    """Return (mass [kg], position [m]) of a point that balances the jib.

    It has the rest of the slew inertia.

    Raises:
        SceneError: the slew inertia is less than the jib's.
    """
    moment, rest = jib.mass * jib.centre, slew_inertia - jib.about_axis
    if not rest > 0.0:
        raise SceneError(
            f"slew.inertia = {slew_inertia:g}: must be greater than that of flexibility.jib, "
            f"{slew_inertia - rest:g}"
        )
    return moment**2 / rest, -rest / moment


def flexible_jib(rigid: TowerCrane, flexibility: JibFlexibility | None, q: Any) -> Any:
    """Return a tower crane's support, rigid without the group; q: positions at t = 0.

    What turns with the drive is a point mass that balances the jib and has the rest of the slew
    inertia.

    Raises:
        SceneError: nothing bends, the slew is locked, or its inertia is less than the jib's.
    """
    if flexibility is None:
        return rigid
    if isinstance(rigid.slew, LockedSlew):
        raise SceneError("flexibility: belongs to a jib that a drive slews, slew.drive is 'locked'")
    if flexibility.mast is not None:
        return swaying_tower(rigid, flexibility, balance(rigid.slew.inertia, flexibility.jib), q[1])
    (mass, centre, inertia), slew = (
        (getattr(flexibility.jib, key) for key in ("mass", "centre", "inertia")),
        rigid.slew,
    )
    ballast, at = balance(slew.inertia, flexibility.jib)
    behind: Any = BaseSection(ballast, at, 0.0)._replace(windage=slew.counter_jib_windage)
    ahead: Any = BaseSection(mass, centre, inertia)._replace(windage=slew.jib_windage)
    inner = TelescopicBoom(Superstructure(0.0), behind, TelescopedSection(0.0, 0.0, 0.0))
    outer = TelescopicBoom(
        Superstructure(0.0), ahead, TelescopedSection(rigid.trolley.mass, 0.0, 0.0)
    )
    return _bend(rigid, (inner, outer), flexibility, (0.0, q[1]))


def deflections(
    support: Any, flexibility: BoomFlexibility | None, place: Any, gravity: float, hung: float
) -> Any:
    """Return the angles [rad] of the modes at t = 0.

    Args:
        support: of `flexible_boom` or `flexible_jib`.
        flexibility: the group.
        place: (elevation, length) of the structure at t = 0.
        gravity: m/s².
        hung: mass [kg] of all that hangs on it.

    Raises:
        SceneError: it bends too far.
    """
    angles = []
    for name, mode in (flexibility.modes if flexibility is not None else {}).items():
        angle = mode.deflection
        if angle is None:
            angle = (
                _angle_at_rest(support.outer, mode, place, gravity, hung)
                if name[0] == "v"
                else mode.rest
            )
        angles.append(angle)
    return tuple(angles)


def _angle_at_rest(
    outer: TelescopicBoom, mode: Bending, place: Any, gravity: float, hung: float
) -> float:
    """Return δ [rad] of k (δ - δ₀) + g S cos(β + δ) = 0.

    S is the first moment of all masses along the structure.
    """
    (elevation, length), first, second = place, outer.base_section, outer.telescope
    moment = first.mass * first.centre + second.mass * (length - second.centre) + hung * length
    angle, step, load = mode.rest, 1.0, gravity * moment / mode.stiffness
    for _ in range(50):  # Newton's method
        step = (angle - mode.rest + load * cos(elevation + angle)) / (
            1.0 - load * sin(elevation + angle)
        )
        angle -= step
        if abs(step) <= ROUNDING:
            break
    stable = 1.0 - load * sin(elevation + angle) > 0.0
    if not (stable and abs(angle) <= LARGEST and abs(step) <= 1e-12):
        raise SceneError(
            f"flexibility.vertical.stiffness = {mode.stiffness:g}: bends by more than {LARGEST:g} "
            "rad at rest; "
            "take more, or give flexibility.vertical.deflection"
        )
    return angle
