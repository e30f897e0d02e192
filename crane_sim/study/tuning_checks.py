"""Checks of a search of gains: of its file before the first trial, of objectives in a row."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene
from crane_sim.study.cases import CaseList, cases
from crane_sim.study.columns import FIRST_COLUMNS, PARAMETER, is_better_larger
from crane_sim.study.execution import check_cases
from crane_sim.study.recordings import check_recorder
from crane_sim.study.result import columns_of
from crane_sim.study.schema import (
    MORRIS,
    Study,
    Tune,
    changed_document,
    parameter_above,
    scene_document,
)

_NO_METRICS = (*FIRST_COLUMNS, "versions", "wall_time")


def check_search(study: Study, settings: Tune) -> CaseList:
    """Return the cases of a search; raises SceneError where it is not possible."""
    check_recorder(study)
    _check_design(study, settings)
    listed = check_cases(study)
    _check_gains(study, settings)
    return listed


def _check_design(study: Study, settings: Tune) -> None:
    """Raise SceneError where a study can judge no search.

    Its held-out samples would be those of the search, an objective is better when larger, or a
    variant has the name of a result.
    """
    if study.design in ("grid", MORRIS):
        line = f"study: design = {study.design}: its held-out samples would be those of the search"
        raise SceneError(f"{line}; for tune: latin_hypercube, sobol, monte_carlo, saltelli")
    for name in filter(is_better_larger, settings.objectives):
        line = (
            f"study: tune.objectives: {name}: is better when it is larger, and a search looks for "
            "the least"
        )
        raise SceneError(f"{line}; for its negative, name a function under metrics")
    least = {f"least_{name}" for name in settings.objectives}
    for name in study.variants:
        if name in least or re.fullmatch(r"compromise_\d+", name):
            raise SceneError(
                f"study: variants.{name}: is a name that tune gives to gains it finds; take "
                "another name"
            )


def base_changes(study: Study, settings: Tune) -> dict[str, Any]:
    """Return the changes of the scene for all trials: those of the first variant, and tune's."""
    return next(iter(study.variant_changes.values())) | settings.changes


def trial_document(study: Study, settings: Tune) -> dict[str, Any]:
    """Return the document of the scene with the changes of every trial."""
    return changed_document(scene_document(study), study.changes | base_changes(study, settings))


def _check_gains(study: Study, settings: Tune) -> None:
    """Raise SceneError where a gain is no number of the scene, or its limits are not possible."""
    base = base_changes(study, settings)
    for key, gain in settings.gains.items():
        if (above := parameter_above(study.parameters, key)) is not None:
            raise SceneError(f"study: tune.gains.{key}: sets what the parameter {above} sets, too")
        for value in (gain.low, gain.high):
            error = _error_with(study, base | {key: value})
            if error is None:
                continue
            if settings.changes and (without_gain := _error_with(study, base)):
                raise SceneError(f"study: tune.changes: {without_gain}")
            raise SceneError(f"study: tune.gains.{key} = {value:g}: {error}")


def _error_with(study: Study, changes: Mapping[str, Any]) -> str | None:
    """Return why the first sample is not possible with changes of the scene, None where it is."""
    trial = study.model_copy(update={"variants": {"trial": dict(changes)}})
    try:
        load_scene(scene_document(study), cases(trial)[0].changes)
    except SceneError as error:
        return str(error)
    return None


def find_objectives(row: Mapping[str, Any], objectives: Sequence[str]) -> list[list[Any]]:
    """Return the values of each objective in a run's row; None or NaN where there is none.

    A metric by joint has several values.

    Raises:
        SceneError: there is no such metric, or it is text.
    """
    metrics = [
        name
        for name, value in row.items()
        if name not in _NO_METRICS and not name.startswith(PARAMETER) and not isinstance(value, str)
    ]
    try:
        return [
            [row[column] for column in columns_of(objective, metrics)] for objective in objectives
        ]
    except SceneError as error:
        raise SceneError(f"study: tune.objectives: {error}") from None
