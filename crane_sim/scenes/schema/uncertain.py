"""Uncertain parameters of a scene: distributions, from which its seed draws the values.

A value is the quantile of its distribution at a number in (0, 1) that depends on seed and key
alone: what else is uncertain does not change it.
"""

import hashlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from itertools import permutations
from math import exp, inf, log, sqrt
from statistics import NormalDist
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator, TypeAdapter, ValidationError

from crane_sim.files.document import get_value, with_values
from crane_sim.files.errors import SceneError, one_line, shorten
from crane_sim.files.types import NonNegative, Positive, Real, Seed, to_radians
from crane_sim.scenes.schema.groups import tagged_union_validator

_STANDARD = NormalDist()
_NOT_PARAMETERS = ("crane", "name", "description", "seed", "uncertain", "control")


def _to_radians(value: Any) -> Any:
    """Return radians for text that is an angle, any other value as it is."""
    if isinstance(value, str):
        with suppress(ValueError):
            return to_radians(value)
    return value


Value = Annotated[Real, BeforeValidator(_to_radians)]
Deviation = Annotated[Positive, BeforeValidator(_to_radians)]


def complain_of_order(low: float, high: float) -> str:
    """Return what is wrong with these limits, in one line; empty where nothing is."""
    return "" if low < high else f"low = {low:g} must be less than high = {high:g}"


class Uniform(NamedTuple):
    """A uniform distribution."""

    low: Value  # parameter's unit, least value
    high: Value  # parameter's unit, greatest value
    relative: bool = False  # whether the numbers are factors of the file's own value

    def find_error(self) -> str:
        """Return what contradicts, in one line; empty where nothing does."""
        return complain_of_order(self.low, self.high)

    def quantile(self, p: float, nominal: float) -> float:
        """Return the quantile at p in (0, 1); `nominal`: the file's own value, 1 for factors."""
        return self.low + p * (self.high - self.low)


class Triangular(NamedTuple):
    """A triangular distribution."""

    low: Value  # parameter's unit, least value
    high: Value  # parameter's unit, greatest value
    mode: Value | None = None  # parameter's unit, most likely value; left out: the file's own
    relative: bool = False  # whether the numbers are factors of the file's own value

    def find_error(self) -> str:
        """Return what contradicts, in one line; empty where nothing does."""
        outside = self.mode is not None and not self.low <= self.mode <= self.high
        what = f"mode = {self.mode:g} must be within low .. high" if outside else ""
        return complain_of_order(self.low, self.high) or what

    def quantile(self, p: float, nominal: float) -> float:
        """Return the quantile at p in (0, 1); `nominal`: the file's own value, 1 for factors."""
        mode = nominal if self.mode is None else self.mode
        if not self.low <= mode <= self.high:
            raise ValueError(f"the mode, the scene's own {mode:g}, must be within low .. high")
        width, below = self.high - self.low, mode - self.low
        if p * width <= below:
            return self.low + sqrt(p * width * below)
        return self.high - sqrt((1.0 - p) * width * (self.high - mode))


class Normal(NamedTuple):
    """A normal distribution, truncated where it has limits."""

    deviation: Deviation  # parameter's unit, standard deviation without the limits
    mean: Value | None = None  # parameter's unit, without the limits; left out: the file's own
    # value
    low: Value = -inf  # parameter's unit, lower limit
    high: Value = inf  # parameter's unit, upper limit
    relative: bool = False  # whether the numbers are factors of the file's own value

    def find_error(self) -> str:
        """Return what contradicts, in one line; empty where nothing does."""
        return complain_of_order(self.low, self.high)

    def quantile(self, p: float, nominal: float) -> float:
        """Return the quantile at p in (0, 1); `nominal`: the file's own value, 1 for factors."""
        mean = nominal if self.mean is None else self.mean
        return _truncated_normal(p, mean, self.deviation, self.low, self.high)


class LogNormal(NamedTuple):
    """A lognormal distribution: the logarithm of the value is normally distributed."""

    deviation: Positive  # -, standard deviation of the natural logarithm
    median: Positive | None = None  # parameter's unit; left out: the file's own value
    low: NonNegative = 0.0  # parameter's unit, lower limit
    high: Positive = inf  # parameter's unit, upper limit
    relative: bool = False  # whether the numbers are factors of the file's own value

    def find_error(self) -> str:
        """Return what contradicts, in one line; empty where nothing does."""
        return complain_of_order(self.low, self.high)

    def quantile(self, p: float, nominal: float) -> float:
        """Return the quantile at p in (0, 1); `nominal`: the file's own value, 1 for factors."""
        median = nominal if self.median is None else self.median
        if not median > 0.0:
            raise ValueError(f"the median, the scene's own {median:g}, must be greater than 0")
        low = log(self.low) if self.low > 0.0 else -inf
        try:
            return exp(_truncated_normal(p, log(median), self.deviation, low, log(self.high)))
        except OverflowError:
            raise ValueError(
                f"deviation = {self.deviation:g}: draws a value beyond the largest number; take a "
                "smaller one, or give "
                "high"
            ) from None
        except ValueError:
            raise ValueError(
                f"low .. high is out of reach of a median of {median:g} and a deviation of "
                f"{self.deviation:g} "
                "of the logarithm"
            ) from None


def _truncated_normal(p: float, mean: float, deviation: float, low: float, high: float) -> float:
    """Return the quantile at p of a normal distribution between limits."""
    below, above = (_STANDARD.cdf((limit - mean) / deviation) for limit in (low, high))
    inside = below + p * (above - below)
    if not 0.0 < inside < 1.0 or above - below < 1e-12:
        raise ValueError(
            f"low .. high is out of reach of a mean of {mean:g} and a deviation of {deviation:g}"
        )
    return min(max(mean + deviation * _STANDARD.inv_cdf(inside), low), high)


DISTRIBUTIONS = {
    "uniform": Uniform,
    "normal": Normal,
    "lognormal": LogNormal,
    "triangular": Triangular,
}
Distribution = Annotated[Any, tagged_union_validator("distribution", DISTRIBUTIONS)]
_DISTRIBUTIONS, _SEED = TypeAdapter(dict[str, Distribution]), TypeAdapter(Seed)


def probability_of(seed: int, key: str) -> float:
    """Return the number in (0, 1) of a seed and a key: 53 bits of a hash, plus half a bit."""
    word = int.from_bytes(hashlib.sha256(f"{seed}/{key}".encode()).digest()[:8], "big")
    return ((word >> 11) + 0.5) * 2.0**-53


def draw_parameters(document: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (a scene's document with the values that `uncertain` draws, these by key).

    Raises:
        SceneError: the group is wrong, or names what the scene does not have.
    """
    if document.get("uncertain") is None:
        return dict(document), {}
    try:
        distributions = _DISTRIBUTIONS.validate_python(document["uncertain"])
    except ValidationError as error:
        raise SceneError(one_line(error, dict, ("uncertain",))) from None
    try:
        seed = _SEED.validate_python(document.get("seed", 0))
    except ValidationError:
        return dict(document), {}  # the whole file is refused for it
    _check_overlap(distributions)
    drawn = {key: _drawn_value(document, key, each, seed) for key, each in distributions.items()}
    return with_values(dict(document), drawn), drawn


def _check_overlap(keys: Iterable[str]) -> None:
    """Raise SceneError where one key is what another one draws, or a part of it."""
    parts = [
        (tuple(int(name) if name.isdecimal() else name for name in key.split(".")), key)
        for key in keys
    ]
    for (whole, key), (path, other) in permutations(parts, 2):
        if path[: len(whole)] == whole:
            raise SceneError(
                f"uncertain.{other}: is a part of uncertain.{key}; leave out one of the two"
            )


def _drawn_value(document: Mapping[str, Any], key: str, distribution: Any, seed: int) -> Any:
    """Return the value that a parameter draws."""
    if key.split(".")[0] in _NOT_PARAMETERS:
        raise SceneError(f"uncertain.{key}: is no parameter of the crane")
    found, value = get_value(document, key)
    if not found:
        raise SceneError(
            f"uncertain.{key}: the scene has no {key} of its own; give it a value, the law's "
            "nominal one"
        )
    try:
        return value_at(distribution, key, value, probability_of(seed, key))
    except ValueError as error:
        raise SceneError(f"uncertain.{key}: {error}") from None


def value_at(distribution: Any, key: str, value: Any, p: float) -> Any:
    """Return the quantile at p of the distribution of a parameter, whose own value is `value`.

    A list has one factor for all its numbers.

    Raises:
        ValueError: the own value does not fit the distribution.
    """
    if isinstance(value, list):
        if not distribution.relative:
            raise ValueError(
                f"has {len(value)} values: relative: true scales them all, {key}.0 is the first one"
            )
        return _scale(value, distribution.quantile(p, 1.0))
    number = _number(value)
    return (
        number * distribution.quantile(p, 1.0)
        if distribution.relative
        else distribution.quantile(p, number)
    )


def _number(value: Any) -> float:
    """Return a number, or an angle given as text, in radians."""
    number = _to_radians(value)
    if isinstance(number, int | float) and not isinstance(number, bool):
        return float(number)
    raise ValueError(f"is {shorten(value)} in the scene, not a number")


def _scale(value: Any, factor: float) -> Any:
    """Return numbers, in lists of any depth, times a factor."""
    return (
        [_scale(part, factor) for part in value]
        if isinstance(value, list)
        else factor * _number(value)
    )
