"""The scene of a cell: the catalogue's with a trial's changes, and the nominal one that the law believes in."""

import copy
from collections.abc import Mapping
from typing import Any

from crane_sim.evaluation.league.cases import Entrant, FromScene, Trial
from crane_sim.files.document import read, set_value

COMMON = ("period", "vision")  # keys of a control group that stay with another law: how often and how well it measures
ABSENT: dict[str, Any] = {"forces": []}  # values that stand for an absent group; of other groups: None


def trial_scene(trial: Trial, entrant: Entrant, seed: int) -> dict[str, Any]:
    """Return the scene, as a file's document, of an entrant in a trial with this seed."""
    document, believed = read(trial.scene), dict[str, Any]()
    for key, value in trial.known.items():
        set_value(document, key, _trial_value(key, value))
    hidden = dict(trial.hidden)
    for key, factor in trial.scaled.items():
        hidden[key] = _times(factor, _document_value(document, key))
    for key, value in hidden.items():
        before = _document_value(document, key)
        set_value(believed, key, ABSENT.get(key) if before is None else copy.deepcopy(before))
        set_value(document, key, _trial_value(key, value))
    for key, value in entrant.believes.items():
        set_value(believed, key, value)
    document["control"] = _settings(document["control"], entrant) | {"nominal": believed}
    if trial.seeded:
        set_value(document, trial.seeded, seed)
    return document


def _settings(own: Mapping[str, Any], entrant: Entrant) -> dict[str, Any]:
    """Return the control group of a entrant in a scene whose own it is."""
    settings = read(entrant.home)["control"] if entrant.home else own if own["law"] == entrant.law else {}
    rest = {key: value for key, value in settings.items() if key not in COMMON}
    common = {key: own[key] for key in COMMON if key in own}
    return copy.deepcopy(common | rest | {"law": entrant.law} | entrant.settings)


def _trial_value(key: str, value: Any) -> Any:
    """Return what a trial puts at a key."""
    if not isinstance(value, FromScene):
        return copy.deepcopy(value)
    group = _document_value(read(value.scene), key)
    for within, change in value.changes.items():
        set_value(group, within, change)
    return group


def _document_value(document: Mapping[str, Any], key: str) -> Any:
    """Return the value of a document at a dotted key, None where there is none."""
    value: Any = document
    for name in key.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def _times(factor: float, value: Any) -> Any:
    return [factor * x for x in value] if isinstance(value, list) else factor * value
