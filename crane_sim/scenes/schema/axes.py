"""The groups of a trolley or bridge on rails: its drive, its prescribed motion and its mass."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Real
from crane_sim.scenes.schema.groups import BY_SPEED, Group, Profile
from crane_sim.trajectories.profiles import Shape

# of masses, lengths, stiffness: products of several stay numbers of the machine
SMALLEST, LARGEST = 1e-12, 1e12


def _check_size(value: float) -> float:
    if value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(f"must be 0 or of a size of {SMALLEST:g} to {LARGEST:g}")
    return value


Size = Annotated[Positive, AfterValidator(_check_size)]
SizeOrZero = Annotated[NonNegative, AfterValidator(_check_size)]
AxisDrive = Annotated[Literal["force", "prescribed", "fixed"], BY_SPEED]


class AxisGroup(Group):
    """Motion of the trolley (along x) or the bridge (along y)."""

    drive: AxisDrive = "force"  # by a force, which needs a `mass`; by a given `motion`;
    # or not at all
    mass: SizeOrZero | None = None  # kg, of a drive by force; of a bridge: without its trolley; 0
    # in all, above rigid links, is taken as 1e-10 of the payload's mass (`rounded`): what hangs
    # below a massless trolley falls freely until it is below it, and bounces
    motion: Profile = None  # m, position over time, of a prescribed drive
    limits: tuple[Real, Real] | None = None  # m, ends of the rail; a run ends where one is reached;
    # left out: none


def start_of(shape: Shape) -> tuple[float, float]:
    """Return position and velocity of a motion at t = 0."""
    motion = shape.motion()
    piece = max(0, int(np.searchsorted(motion.starts, 0.0, side="right")) - 1)
    polynomial, s = np.polynomial.Polynomial(motion.coefficients[piece]), -motion.starts[piece]
    rate = motion.amplitude * motion.frequency * np.cos(motion.phase)
    return float(polynomial(s) + motion.amplitude * np.sin(motion.phase)), float(
        polynomial.deriv()(s) + rate
    )


def check_shape(name: str, shape: Shape | None, drive: str) -> None:
    """Raise SceneError when a prescribed drive has no motion over time, or another one has one."""
    if shape is None and drive == "prescribed":
        raise SceneError(f"{name}: is missing, a prescribed drive needs one")
    if shape is not None and drive != "prescribed":
        raise SceneError(f"{name}: belongs to a prescribed drive, here it is {drive!r}")


def check_mass(name: str, group: AxisGroup, carried: bool) -> None:
    """Raise SceneError when nothing moves an axis's mass; carried: a force moves it across."""
    if group.mass is not None and group.drive != "force" and not carried:
        drive = group.drive
        raise SceneError(
            f"{name}.mass = {group.mass}: nothing moves it; it belongs to a drive by force, not "
            f"{drive!r}"
        )


def check_finite(name: str, shape: Any) -> None:
    """Raise SceneError when a motion's values are too large."""
    if shape is None:
        return
    with np.errstate(all="ignore"):
        finite = np.all(np.isfinite(shape.motion().coefficients))
    if not finite:
        raise SceneError(f"{name}: its values are too large for numbers of the machine")
