"""Physical quantities as annotated types, which convert units and check ranges of parameters."""

import re
from collections.abc import Callable
from functools import cache
from math import inf
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter


@cache
def type_adapter(kind: Any) -> TypeAdapter[Any]:
    """Return the validator of a type, cached: building one takes a millisecond."""
    return TypeAdapter(kind)


_ANGLE = re.compile(r"\s*([-+0-9.eE]+)\s*(deg|rad)?\s*")
RADIANS = {"deg": 0.017453292519943295, "rad": 1.0, None: 1.0}


def to_radians(value: Any) -> Any:
    """Return radians for a number, for "45 deg" and for "0.5 rad".

    Raises:
        ValueError: the text is not an angle.
    """
    if not isinstance(value, str):
        return value
    match = _ANGLE.fullmatch(value)
    if not match:
        raise ValueError("an angle is a number of radians, or text such as '45 deg' or '0.5 rad'")
    return float(match[1]) * RADIANS[match[2]]


def check_unitless_angle(largest: float, turn: str) -> Callable[[Any], Any]:
    """Return a validator of angles: at most `largest` [rad] without a unit, `turn` in errors.

    A larger one is probably in degrees; text with a unit may be any angle.
    """

    def check(value: Any) -> Any:
        match = _ANGLE.fullmatch(value) if isinstance(value, str) else None
        bare = to_radians(value) if match and not match[2] else value
        if isinstance(bare, int | float) and largest < abs(bare) < inf:
            meant = f"{bare:g}" if abs(bare) < 1e9 else "45"
            raise ValueError(
                f"as radians more than {turn}; did you mean '{meant} deg'? (or '{meant} rad')"
            )
        return value

    return check


def reject_bool(value: Any) -> Any:
    """Return the value unless it is a bool, which Python counts as 1 or 0.

    Raises:
        ValueError: it is a bool.
    """
    if isinstance(value, bool):
        raise ValueError("must be a number")
    return value


def as_list(value: Any) -> Any:
    """Return a list or tuple as it is, one value as a tuple."""
    return value if isinstance(value, list | tuple) else (value,)


def check_single_line(text: str) -> str:
    """Return the text if it fits in one line and in a file's name.

    Raises:
        ValueError: it does not.
    """
    if len(text) > 100 or not text.isprintable() or "/" in text:
        raise ValueError("must be at most 100 characters of one line, without '/'")
    return text


def check_increasing(value: tuple[float, float]) -> tuple[float, float]:
    """Return (low, high) if low is less than high.

    Raises:
        ValueError: low is not less than high.
    """
    if not value[0] < value[1]:
        raise ValueError("must be [low, high] with low < high")
    return value


Name = Annotated[str, AfterValidator(check_single_line)]
Real = Annotated[float, BeforeValidator(reject_bool), Field(allow_inf_nan=False)]
Positive = Annotated[float, BeforeValidator(reject_bool), Field(gt=0.0, allow_inf_nan=False)]
NonNegative = Annotated[float, BeforeValidator(reject_bool), Field(ge=0.0, allow_inf_nan=False)]
Fraction = Annotated[
    float, BeforeValidator(reject_bool), Field(ge=0.0, le=1.0, allow_inf_nan=False)
]
Seed = Annotated[int, BeforeValidator(reject_bool), Field(ge=0, le=2**63 - 1)]
Coordinate = Annotated[
    float, BeforeValidator(to_radians), BeforeValidator(reject_bool), Field(allow_inf_nan=False)
]
"""A position of a joint or a point: metres, or an angle as radians or text."""
TURN, HALF_TURN, EIGHTH_TURN = 6.29, 3.15, 0.79  # rad, with room for rounding
Angle = Annotated[Coordinate, BeforeValidator(check_unitless_angle(TURN, "a turn"))]
Tilt = Annotated[Coordinate, BeforeValidator(check_unitless_angle(HALF_TURN, "half a turn"))]
"""An angle from the vertical or the horizontal."""
Heel = Annotated[
    Coordinate, BeforeValidator(check_unitless_angle(EIGHTH_TURN, "an eighth of a turn"))
]
"""An angle by which a vessel leans."""
Range = Annotated[tuple[Real, Real], AfterValidator(check_increasing)]
AngleRange = Annotated[tuple[Angle, Angle], AfterValidator(check_increasing)]
LengthRange = Annotated[tuple[NonNegative, Positive], AfterValidator(check_increasing)]
