"""The file of a study: its scene, the parameters that vary and how, and the variants."""

import copy
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    TypeAdapter,
    ValidationError,
    model_validator,
)

from crane_sim.files.document import function_from, plain_copy, read, read_groups, with_values
from crane_sim.files.errors import RenameWarning, SceneError, no_group, one_line, shorten
from crane_sim.files.types import Name, Positive, Seed, reject_bool
from crane_sim.laws import switch_law
from crane_sim.scenes.schema.uncertain import DISTRIBUTIONS, Distribution

DEPRECATED_KEYS = {"figures": "metrics"}
"""New names of a study's keys by those of the previous release, which still work in files of this
one."""
Count = Annotated[int, BeforeValidator(reject_bool), Field(ge=1, le=10_000_000)]


class _Group(BaseModel):
    """A group of a study's file: unknown keys and non-finite numbers are errors."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True, defer_build=True)


class Values(_Group):
    """A list of values of a parameter: points of a grid, equally likely in drawn samples."""

    values: Annotated[tuple[Any, ...], Field(min_length=1)]

    def quantile(self, p: float, nominal: Any) -> Any:
        """Return the value at p in (0, 1); `nominal`, the scene's own, does not matter."""
        return self.values[int(p * len(self.values))]


_DISTRIBUTION = TypeAdapter(Distribution)


def _write_parameter(parameter: Any) -> Any:
    """Return a parameter as a file has it, without defaults: JSON has no infinite limits."""
    if isinstance(parameter, Values):
        return {"values": list(parameter.values)}
    defaults = parameter._field_defaults
    name = next(name for name, kind in DISTRIBUTIONS.items() if type(parameter) is kind)
    return {"distribution": name} | {
        key: value
        for key, value in parameter._asdict().items()
        if key not in defaults or value != defaults[key]
    }


def _read_parameter(value: Any) -> Any:
    """Return `Values` for a list or a group with `values`, else a distribution as in scenes."""
    if isinstance(value, list | tuple):
        return Values(values=tuple(value))
    if not isinstance(value, dict):
        raise ValueError(
            f"{no_group()}: values, or distribution with its numbers; or a list of values"
        )
    try:
        return (
            Values.model_validate(value)
            if "values" in value
            else _DISTRIBUTION.validate_python(value)
        )
    except ValidationError as error:
        raise ValueError(one_line(error, Values)) from None


Parameter = Annotated[Any, BeforeValidator(_read_parameter), PlainSerializer(_write_parameter)]


class Worst(_Group):
    """Runs to record because they are the worst ones by a metric."""

    metric: str  # a column of the table; the worst values are the largest, those of
    # `LARGER_IS_BETTER` the least
    count: Count = 3  # -


class Recordings(_Group):
    """Which runs are recorded: they are repeated after the study, bit for bit the same."""

    failures: bool = False  # those that failed
    every: Count | None = None  # -, every n-th case
    worst: Worst | None = None


class Gain(_Group):
    """The range in which a number of the scene is searched."""

    low: float  # in the number's unit
    high: float
    log: bool = False  # whether its logarithm is searched evenly

    @model_validator(mode="after")
    def _check_order(self) -> "Gain":
        if not self.low < self.high:
            raise ValueError(f"low = {self.low:g} must be less than high = {self.high:g}")
        if self.log and self.low <= 0.0:
            raise ValueError(f"low = {self.low:g}: log needs a number greater than 0")
        return self


class Tune(_Group):
    """What `crane tune` searches: the gains of least metrics, judged on other samples."""

    gains: Annotated[dict[str, Gain], Field(min_length=1)]  # by dotted key of the scene
    changes: dict[str, Any] = {}  # of the scene in every trial, by dotted key: another law, a list
    # that gains enter
    objectives: Annotated[tuple[str, ...], Field(min_length=1)]  # metrics whose mean over the
    # samples shall be least
    trials: Count = 100  # -
    keep: Count = 3  # -, of the Pareto-optimal gains, evaluated beside the best of each objective


BASELINE = "scene"
"""The variant of the scene as it is, where a file names no variants."""
MORRIS, SALTELLI = "morris", "saltelli"
"""Designs of sensitivity: their samples belong together, and have one seed."""


class Study(_Group):
    """A study: every sample of the parameters is run with every variant."""

    name: Name = ""  # left out: the file's
    scene: str | dict[str, Any]  # a name of the catalogue, a file, or a scene in place
    design: Literal["grid", "latin_hypercube", "sobol", "monte_carlo", "morris", "saltelli"] = (
        "grid"
    )
    samples: Count | None = None  # -, of every design but the grid, which has as many as its values
    # make; of morris: paths of one more samples than parameters, of saltelli: base samples, each
    # with two more than parameters
    seed: Seed = 0  # of the samples, and of the scenes' own random numbers
    duration: Positive | None = None  # s; left out: the scene's
    changes: dict[str, Any] = {}  # of the scene in every run, by dotted key
    parameters: Annotated[dict[str, Parameter], Field(min_length=1)]  # by dotted key of the scene
    variants: dict[str, dict[str, Any]] = {}  # name: changes by dotted key; all run on the same
    # samples
    metrics: str = ""  # FILE.py:FUNCTION or MODULE:FUNCTION, a function of a run: its further
    # metrics, numbers by name
    recordings: Recordings = Recordings()
    tune: Tune | None = None  # what `crane tune` searches; other commands refuse it

    @property
    def variant_changes(self) -> dict[str, dict[str, Any]]:
        """Changes of the scene by variant; only `BASELINE`, without changes, if there are none."""
        return self.variants or {BASELINE: {}}


def load_study(source: "Study | str | Path | Mapping[str, Any]") -> Study:
    """Return the study of a file, or of a dict of a file's shape.

    A scene's file is looked for beside the study's file, unless it is a name of the catalogue.

    Raises:
        SceneError: one line naming the key, its value and what is possible.
    """
    if isinstance(source, Study):
        return source
    document = plain_copy(source) if isinstance(source, Mapping) else _read_file(Path(source))
    for deprecated in DEPRECATED_KEYS.keys() & document.keys():
        line = f"study: {deprecated} is now called {DEPRECATED_KEYS[deprecated]}"
        warnings.warn(line, RenameWarning, stacklevel=2)
    try:
        study = Study.model_validate(rename_keys(document))
    except ValidationError as error:
        raise SceneError(f"study: {one_line(error, Study)}") from None
    _check_design(study)
    _check_changes(study)
    return study


def rename_keys(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study's document with deprecated names replaced; if it has both, both stay."""
    return {
        DEPRECATED_KEYS[key] if DEPRECATED_KEYS.get(key, key) not in document else key: value
        for key, value in document.items()
    }


def _read_file(path: Path) -> dict[str, Any]:
    """Return the document of a study's file, with absolute paths of scene and functions."""
    if not os.path.exists(path):  # unlike Path.exists, no error for a name that no file can have
        raise SceneError(f"study file {path}: there is no such file")
    document, folder = read_groups(path, "study file"), path.resolve().parent
    for key in ("metrics", *DEPRECATED_KEYS):
        if isinstance(document.get(key), str):
            document[key] = function_from(document[key], folder)
    variants, tune, parameters = (
        _group(document.get(key)) for key in ("variants", "tune", "parameters")
    )
    for changes in map(_group, (document.get("changes"), tune.get("changes"), *variants.values())):
        if "control.law" in changes:
            changes["control.law"] = _law_from(changes["control.law"], folder)
    if isinstance(laws := parameters.get("control.law"), list):
        parameters["control.law"] = [_law_from(law, folder) for law in laws]
    elif isinstance(listed := _group(laws).get("values"), list):
        parameters["control.law"]["values"] = [_law_from(law, folder) for law in listed]
    with suppress(TypeError):
        if (beside := folder / document.get("scene", "")).is_file():
            document["scene"] = str(beside)
    return document


def _group(value: Any) -> dict[str, Any]:
    """Return a group of a file, an empty one for anything else: its error is reported later."""
    return value if isinstance(value, dict) else {}


def _law_from(law: Any, folder: Path) -> Any:
    """Return a law, its file made absolute where it has one."""
    return function_from(law, folder) if isinstance(law, str) else law


def _check_design(study: Study) -> None:
    """Raise SceneError where design, samples and parameters contradict each other."""
    grid, samples = study.design == "grid", study.samples
    if grid and samples is not None:
        raise SceneError(
            f"study: samples = {samples}: a grid has as many as its values make; leave it out"
        )
    if not grid and samples is None:
        raise SceneError(f"study: samples is missing: how many a design of {study.design} draws")
    for key, parameter in study.parameters.items():
        if grid and not isinstance(parameter, Values):
            raise SceneError(
                f"study: parameters.{key}: is a distribution, and design = grid needs values; "
                "or another design: latin_hypercube, sobol, monte_carlo, morris, saltelli"
            )
    if study.design in ("sobol", SALTELLI) and samples is not None and samples & (samples - 1):
        near = 1 << (samples.bit_length() - 1)
        raise SceneError(
            f"study: samples = {samples}: a Sobol sequence is balanced at powers of two only: "
            f"{near}, {2 * near}"
        )


def _check_changes(study: Study) -> None:
    """Raise SceneError where two of a study's groups set the same of the scene.

    A run takes its parameters last: what changes set at or below a parameter's key would be
    ignored. A change of a
    whole group or list may be above it: the parameter varies one number of that.
    """
    for where, key, value in _changes_of(study):
        if key == "duration" and study.duration is not None:
            raise SceneError(
                f"study: duration = {study.duration:g}: is in {where}, too; give one of them"
            )
        others = (
            study.parameters.keys() - {key} if where == "parameters" else study.parameters.keys()
        )
        above = parameter_above(others, key)
        if above is not None and not (where == "changes" and _varies_own(study.parameters[above])):
            shown = "" if where == "parameters" else f" = {shorten(value)}"
            raise SceneError(
                f"study: {where}.{key}{shown}: sets what the parameter {above} sets, too"
            )


def _changes_of(study: Study) -> Iterator[tuple[str, str, Any]]:
    """Yield (group of the study, dotted key, value) of all that sets something of the scene."""
    groups: dict[str, Mapping[str, Any]] = {
        "parameters": study.parameters,
        "changes": study.changes,
    }
    groups |= {} if study.tune is None else {"tune.changes": study.tune.changes}
    groups |= {f"variants.{name}": changes for name, changes in study.variant_changes.items()}
    for where, changes in groups.items():
        yield from ((where, key, value) for key, value in changes.items())


def parameter_above(parameters: Iterable[str], key: str) -> str | None:
    """Return the parameter whose dotted key is a key's own, or above it; None without one."""
    return next((each for each in parameters if f"{key}.".startswith(f"{each}.")), None)


def _varies_own(parameter: Any) -> bool:
    """Return whether a parameter varies the scene's own value, which changes may set."""
    return not isinstance(parameter, Values) and (parameter.relative or None in parameter)


def varied_document(study: Study) -> dict[str, Any]:
    """Return the document that the parameters vary: the scene with the changes of every run.

    Raises:
        SceneError: there is no such scene, or a change has no place in it.
    """
    document = scene_document(study)
    try:
        return changed_document(document, study.changes)
    except SceneError as error:
        raise SceneError(f"study: changes.{error}") from None


def changed_document(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a scene's document with changes by dotted key.

    Raises SceneError where one has no place.
    """
    switched, _ = switch_law(copy.deepcopy(dict(document)), changes)
    return with_values(switched, changes)


def scene_document(study: Study) -> dict[str, Any]:
    """Return the document of the study's scene.

    Raises:
        SceneError: there is no such scene.
    """
    return read(study.scene) if isinstance(study.scene, str) else dict(study.scene)
