"""Further metrics of a study's runs, by a function that its file names."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from crane_sim.files.errors import SceneError, join_lines, shorten
from crane_sim.files.functions import hash_source, load_function
from crane_sim.simulation.batch_metrics import Measure, MetricError
from crane_sim.simulation.flat_summary import flatten
from crane_sim.simulation.rollout import Rollout
from crane_sim.study.columns import COLUMNS
from crane_sim.study.schema import Study


class UnusableMetrics(MetricError):
    """A function of metrics returned what cannot be columns; other runs would fail, too."""


def load_metrics(study: Study) -> Measure | None:
    """Return the function of a run that has the study's own metrics, None without one.

    When called it raises `MetricError` where the function raised an error, and `UnusableMetrics`.

    Raises:
        SceneError: there is no such function.
    """
    return _load(study.metrics, hash_source(study.metrics)) if study.metrics else None


@lru_cache(maxsize=1)
def _load(name: str, _: str | None) -> Measure:
    """Load a function anew where its source has another hash."""
    try:
        function = load_function("study: metrics", name)
    except (Exception, SystemExit) as error:
        # of the user's own module: any error of it is one line
        raise (
            error
            if isinstance(error, SceneError)
            else SceneError(f"study: metrics = {name!r}: {_cause(error)}")
        ) from error

    def measure(run: Rollout) -> dict[str, float | None]:
        try:
            found = function(run)
        except (Exception, SystemExit) as error:
            raise MetricError(f"metrics = {name!r}: {_cause(error)}") from error
        try:
            return _numbers_by_name(found, run)
        except UnusableMetrics as error:
            raise UnusableMetrics(f"metrics = {name!r}: {error}") from None

    return measure


def _cause(error: BaseException) -> str:
    return f"{type(error).__name__}: {join_lines(error)}"


def _numbers_by_name(found: Any, run: Rollout) -> dict[str, float | None]:
    """Return what a function of metrics returned of a run, as numbers by name.

    Raises UnusableMetrics where it cannot.
    """
    if not isinstance(found, Mapping):
        line = (
            f"returned {shorten(found)}; must return a dict of name: number, None where a run has "
            "none"
        )
        raise UnusableMetrics(line)
    taken = {name.partition(".")[0] for name in (*COLUMNS, *flatten(run.summary))}
    for name in found:
        if not isinstance(name, str) or not name:
            raise UnusableMetrics(f"returned {shorten(name)} as a name; names are text")
        if name.partition(".")[0] in taken:
            reason = "is taken by the table's own columns"
            raise UnusableMetrics(
                f"returned {name!r}, which {reason}; take another name, such as 'own_{name}'"
            )
    return {name: _to_float(name, value) for name, value in found.items()}


def _to_float(name: str, value: Any) -> float | None:
    try:
        if isinstance(value, str | bytes):
            raise TypeError
        return None if value is None else float(value)
    except (TypeError, ValueError, OverflowError):
        line = f"returned {name} = {shorten(value)}; must be a number, or None where a run has none"
        raise UnusableMetrics(line) from None
