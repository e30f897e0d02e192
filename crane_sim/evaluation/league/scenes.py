"""The scene of a cell: a trial's changes put into the catalogue's scene, and what the law believes instead."""

import copy
from collections.abc import Mapping
from typing import Any

from crane_sim.evaluation.league.cases import Entrant, FromScene, Task
from crane_sim.files.document import put, read

COMMON = ("period", "vision")  # of a control group: how often and how well the state is seen, whatever the law
ABSENT: dict[str, Any] = {"forces": []}  # what stands for a group that a scene does not have; others: nothing


def task_scene(trial: Task, contender: Entrant, seed: int) -> dict[str, Any]:
    """Return the scene, as a file's document, in which a contender is tried with this seed."""
    document, believed = read(trial.scene), dict[str, Any]()
    for key, value in trial.told.items():
        put(document, key, _task_value(key, value))
    untold = dict(trial.untold)
    for key, part in trial.scaled.items():
        untold[key] = _times(part, _document_value(document, key))
    for key, value in untold.items():
        before = _document_value(document, key)
        put(believed, key, ABSENT.get(key) if before is None else copy.deepcopy(before))
        put(document, key, _task_value(key, value))
    for key, value in contender.believes.items():
        put(believed, key, value)
    document["control"] = _settings(document["control"], contender) | {"nominal": believed}
    if trial.seeded:
        put(document, trial.seeded, seed)
    return document


def _settings(own: Mapping[str, Any], contender: Entrant) -> dict[str, Any]:
    """Return the control group of a contender in a scene whose own it is."""
    settings = read(contender.home)["control"] if contender.home else own if own["law"] == contender.law else {}
    rest = {key: value for key, value in settings.items() if key not in COMMON}
    common = {key: own[key] for key in COMMON if key in own}
    return copy.deepcopy(common | rest | {"law": contender.law} | contender.settings)


def _task_value(key: str, value: Any) -> Any:
    """Return what a trial puts at a key."""
    if not isinstance(value, FromScene):
        return copy.deepcopy(value)
    group = _document_value(read(value.scene), key)
    for within, change in value.changes.items():
        put(group, within, change)
    return group


def _document_value(document: Mapping[str, Any], key: str) -> Any:
    """Return what a document has at a dotted key, None where it has nothing."""
    found: Any = document
    for name in key.split("."):
        found = found.get(name) if isinstance(found, Mapping) else None
    return found


def _times(part: float, value: Any) -> Any:
    return [part * x for x in value] if isinstance(value, list) else part * value
