"""Groups of a scene file that are common to all cranes."""

from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from crane_sim.files.errors import about_keys, missing_key, no_group, one_line, shorten, unknown_key
from crane_sim.files.types import Real, type_adapter
from crane_sim.integrators.dop853 import DOP853, RK8
from crane_sim.integrators.dopri5 import DOPRI5
from crane_sim.integrators.gauss import Gauss
from crane_sim.integrators.gauss16 import Gauss16
from crane_sim.integrators.leapfrog import Leapfrog
from crane_sim.integrators.rk4 import RK4
from crane_sim.integrators.rodas import Rodas
from crane_sim.models.effects import LinearFriction, PaperFriction, PayloadForce, QuadraticFriction
from crane_sim.scenes.schema.integrator import Auto
from crane_sim.trajectories.inputs import Constant, Polynomial, Sine, Table
from crane_sim.trajectories.profiles import PolynomialMotion, SineMotion, SmoothMotion, SplineMotion


class Group(BaseModel):
    """A group of a scene file: unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, defer_build=True)


WORDS = {"from": "begin", "to": "end"}
"""Reserved words of Python as keys of a file, and the fields of NamedTuples in their place."""


def explain_acceleration(remedy: str) -> BeforeValidator:
    """Return a validator that refuses an acceleration drive and says what to do instead."""

    def check(drive: Any) -> Any:
        if drive == "acceleration":
            raise ValueError(f"is not possible; {remedy}")
        return drive

    return BeforeValidator(check)


BY_SPEED = explain_acceleration(
    "its integral, the speed over time, is: actuators.JOINT: {drive: velocity, servo: {gain: .inf, "
    "max_acceleration: ...}}, which the joint follows exactly, and inputs.JOINT"
)
BY_RATE = explain_acceleration("drive: rate takes the length's acceleration")


def _words_of(fields: tuple[str, ...]) -> dict[str, str]:
    """Return the words of a file for the fields of a NamedTuple, with the fields."""
    words = {field: word for word, field in WORDS.items()}
    return {words.get(field, field): field for field in fields}


def _read_group(kind: Any, values: dict[str, Any]) -> Any:
    """Return the NamedTuple with these values; an error in a field names it by the file's word."""
    try:
        return type_adapter(kind).validate_python(values)
    except ValidationError as error:
        line = one_line(error, kind)
        for word, field in WORDS.items():
            if line.startswith((f"{field} ", f"{field}:", f"{field}[")):
                raise ValueError(word + line.removeprefix(field)) from None
        if about_keys(error):
            raise ValueError(line) from None
        raise


class TaggedUnion:
    """A tagged union: reads `{key: name, ...}` as the NamedTuple `choices[name]`.

    Attributes:
        choice: (the key, the NamedTuples by name).
    """

    def __init__(self, key: str, choices: dict[str, Any], optional: bool) -> None:
        """Take the key and its choices; `optional`: null is possible, too."""
        self.choice, self._optional = (key, choices), optional

    def __call__(self, value: Any) -> Any:
        """Return the NamedTuple.

        Raises:
            ValueError: there is no such choice, or it has other keys or values.
        """
        key, choices = self.choice
        if value is None and self._optional:
            return None
        if not isinstance(value, dict):
            raise ValueError(f"{no_group()}, with {key}: {' | '.join(choices)}")
        name = value.get(key)
        if name is None:
            raise ValueError(missing_key(key, value, choices))
        if not isinstance(name, str) or name not in choices:
            raise ValueError(f"{key} {shorten(name)} is unknown; possible: {', '.join(choices)}")
        rest, known = {k: v for k, v in value.items() if k != key}, _words_of(choices[name]._fields)
        for unknown in (k for k in rest if k not in known):
            raise ValueError(unknown_key(str(unknown), (key, *known)))
        group = _read_group(choices[name], {known[k]: v for k, v in rest.items()})
        error = group.find_error() if hasattr(group, "find_error") else ""
        if error:
            raise ValueError(error)
        return group


def tagged_union_validator(
    key: str, choices: dict[str, Any], optional: bool = False
) -> BeforeValidator:
    """Return a validator that reads `{key: name, ...}` as the NamedTuple `choices[name]`."""
    return BeforeValidator(TaggedUnion(key, choices, optional))


_FRICTION = {"quadratic": QuadraticFriction, "linear": LinearFriction, "paper": PaperFriction}
Friction = Annotated[Any, tagged_union_validator("model", _FRICTION, optional=True)]
_METHODS = {
    "auto": Auto,
    "dop853": DOP853,
    "dopri5": DOPRI5,
    "rk4": RK4,
    "rk8": RK8,
    "gauss": Gauss,
}
_METHODS |= {"gauss16": Gauss16, "rodas": Rodas, "leapfrog": Leapfrog}
Method = Annotated[Any, tagged_union_validator("method", _METHODS)]
Channel = Annotated[
    Any,
    tagged_union_validator(
        "kind", {"constant": Constant, "sine": Sine, "table": Table, "polynomial": Polynomial}
    ),
]
"""An open-loop input, of a joint or a component of a force: a function of time of one of these
kinds."""


class InlineUnion(NamedTuple):
    """Marks a field of a tagged union whose keys are inlined into the group."""

    choice: tuple[str, dict[str, Any]]


class PayloadForceGroup(Group):
    """A given force on the payload [N], along the axes of the world; absent axes are zero.

    It acts at the centre of mass of a payload that is a body, and so has no moment about it.
    """

    x: Channel = Constant(0.0)  # N, over time
    y: Channel = Constant(0.0)  # N, over time
    z: Channel = Constant(0.0)  # N, over time

    def force(self) -> PayloadForce:
        """Return the force."""
        return PayloadForce(self.x, self.y, self.z)


_Period = Annotated[Real, Field(ge=1e-6)]


def _period(value: Any) -> Any:
    if value == "continuous":
        return value
    try:
        return type_adapter(_Period).validate_python(value)
    except ValidationError:
        raise ValueError(
            "a period is a number of seconds, at least 1e-6, or 'continuous'"
        ) from None


Profile = Annotated[
    Any,
    tagged_union_validator(
        "kind",
        {
            "smooth": SmoothMotion,
            "sine": SineMotion,
            "polynomial": PolynomialMotion,
            "table": SplineMotion,
        },
        optional=True,
    ),
]


class Control(Group):
    """The law, its period and its nominal model; further keys are the law's, see section Laws."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False, frozen=True, defer_build=True)
    law: str  # its name: one of those below, or one that another package has installed
    period: Annotated[Any, BeforeValidator(_period)] = 0.01  # s, between commands; or `continuous`:
    # the law is evaluated inside the equations
    nominal: dict[str, Any] = {}  # the law's nominal model, as groups of a scene file that are
    # merged over the scene
