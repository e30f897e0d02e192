"""The form of a scene file: which groups there are, what they may hold, and how a mistake is told in one line."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, ValidationError

from crane_sim.effects import (
    BoomSpring,
    JibSpring,
    LinearFriction,
    PaperFriction,
    PayloadDrag,
    QuadraticFriction,
    RopeSpring,
)
from crane_sim.explain import unknown_key
from crane_sim.integrators.dop853 import DOP853, RK8
from crane_sim.integrators.rk4 import RK4
from crane_sim.loads.point import PointLoad
from crane_sim.quantities import Angle, NonNegative, Positive, Real
from crane_sim.sources import Constant, Polynomial, Sine, Table
from crane_sim.supports.knuckle import Rod, Tower


class Group(BaseModel):
    """A group of a scene file: unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


def _chosen(key: str, choices: dict[str, Any], what: str) -> BeforeValidator:
    """Return a validator that reads `{key: name, ...}` as the NamedTuple that `choices` has under that name."""

    def pick(value: Any) -> Any:
        if not isinstance(value, dict):
            raise ValueError(f"a {what} is a group of keys, with {key}: {' | '.join(choices)}")
        name = value.get(key)
        if not isinstance(name, str) or name not in choices:
            raise ValueError(f"{key} {name!r} is unknown; possible: {', '.join(choices)}")
        rest = {k: v for k, v in value.items() if k != key}
        for unknown in rest.keys() - set(choices[name]._fields):
            raise ValueError(unknown_key(str(unknown), (key, *choices[name]._fields)))
        return TypeAdapter(choices[name]).validate_python(rest)

    return BeforeValidator(pick)


Friction = Annotated[
    Any,
    _chosen(
        "model", {"quadratic": QuadraticFriction, "linear": LinearFriction, "paper": PaperFriction}, "swing friction"
    ),
]
Method = Annotated[Any, _chosen("method", {"dop853": DOP853, "rk4": RK4, "rk8": RK8}, "integrator")]
Channel = Annotated[
    Any, _chosen("kind", {"constant": Constant, "sine": Sine, "table": Table, "polynomial": Polynomial}, "input")
]


class Rope(Group):
    """How the winch moves the rope."""

    drive: Literal["force", "rate", "locked"] = "force"
    time_constant: Positive | None = None  # s, of a rate drive


class Springs(Group):
    """Springs on joints."""

    boom: BoomSpring | None = None
    jib: JibSpring | None = None
    rope: RopeSpring | None = None


class Initial(Group):
    """Joint coordinates at t = 0, in joint order."""

    q: tuple[Angle, Angle, Angle, Positive, Angle, Angle]
    v: tuple[Real, Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Reference(Group):
    """Where the actuated joints should go."""

    q: tuple[Angle, Angle, Angle, Positive]


def _period(value: Any) -> Any:
    if value == "continuous":
        return value
    try:
        return TypeAdapter(Annotated[float, Field(ge=1e-6, allow_inf_nan=False)]).validate_python(value)
    except ValidationError:
        raise ValueError("a period is a number of seconds, at least 1e-6, or 'continuous'") from None


class Control(Group):
    """The law, how often it is evaluated, and what it is to believe; further keys are the law's own settings."""

    model_config = ConfigDict(extra="allow", allow_inf_nan=False, frozen=True)
    law: str
    period: Annotated[Any, BeforeValidator(_period)] = 0.01  # s, or "continuous"
    nominal: dict[str, Any] = {}


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; silent ones are zero."""

    slew: Channel = Constant(0.0)
    boom: Channel = Constant(0.0)
    jib: Channel = Constant(0.0)
    rope: Channel = Constant(0.0)


class KnuckleFile(Group):
    """A scene with a knuckle-boom crane."""

    crane: Literal["knuckle"]
    name: str = ""
    description: str = ""
    duration: Positive  # s
    gravity: NonNegative = 9.81  # m/s²
    seed: int = 0
    boom: Rod
    jib: Rod
    tower: Tower
    rope: Rope = Rope()
    payload: PointLoad
    initial: Initial
    springs: Springs = Springs()
    swing_friction: Friction = None
    payload_drag: PayloadDrag | None = None
    reference: Reference | None = None
    control: Control | None = None
    inputs: InputGroup | None = None
    integrator: Method = DOP853()
