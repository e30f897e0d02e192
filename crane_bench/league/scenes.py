"""The scene of a cell: the catalogue's with a trial's changes, and the law's nominal scene."""

import copy
import json
from collections.abc import Mapping
from typing import Any

from crane_bench.league.cases import Entrant, FromScene, Trial
from crane_sim.files.catalogue import config_folder
from crane_sim.files.document import get_value, read, set_value

BEST = "compromise_1"  # of what a search has chosen
# keys of a control group that other laws keep: period and measurement
COMMON = ("period", "vision")
# values that stand for an absent group; of other groups: None
ABSENT: dict[str, Any] = {"forces": []}


def trial_scene(trial: Trial, entrant: Entrant, seed: int) -> dict[str, Any]:
    """Return the scene, as a file's document, of an entrant in a trial with this seed.

    What the scene's own nominal one says, such as a point mass in place of a body, stays.
    """
    document = read(trial.scene)
    for key, value in (trial.known | entrant.changes).items():
        set_value(document, key, _trial_value(key, value))
    own = document.get("control") or {}  # no trial hides or scales a setting of it
    nominal = copy.deepcopy(own.get("nominal", {}))
    hidden = dict(trial.hidden)
    for key, factor in trial.scaled.items():
        hidden[key] = _times(factor, get_value(document, key)[1])
    for key, value in hidden.items():
        whole = _whole_key(document, key)
        original = get_value(document, whole)[1]
        if not _has_key(nominal, whole):
            set_value(
                nominal, whole, ABSENT.get(key) if original is None else copy.deepcopy(original)
            )
        set_value(document, key, _trial_value(key, value))
    for key, value in entrant.nominal.items():
        set_value(nominal, key, value)
    document["control"] = _settings(own, entrant) | {"nominal": nominal}
    if trial.seeded:
        set_value(document, trial.seeded, seed)
    return document


def _whole_key(document: Mapping[str, Any], key: str) -> str:
    """Return the dotted key, or that of the first list on its way.

    A nominal scene replaces lists as a whole.
    """
    names = key.split(".")
    keys = (".".join(names[:n]) for n in range(1, len(names)))
    return next((part for part in keys if isinstance(get_value(document, part)[1], list)), key)


def _has_key(nominal: Mapping[str, Any], key: str) -> bool:
    """Return whether a nominal scene has a value at a dotted key, or in place of its group.

    The value may be null.
    """
    group: Any = nominal
    for name in key.split("."):
        if not isinstance(group, Mapping):
            return True
        if name not in group:
            return False
        group = group[name]
    return True


def _settings(own: Mapping[str, Any], entrant: Entrant) -> dict[str, Any]:
    """Return the control group of an entrant in a scene with its own group `own`."""
    settings = (
        read(entrant.home)["control"]
        if entrant.home
        else own
        if own.get("law") == entrant.law
        else {}
    )
    law_settings = {key: value for key, value in settings.items() if key not in COMMON}
    common = {key: own[key] for key in COMMON if key in own}
    group = {
        "control": copy.deepcopy(common | law_settings | {"law": entrant.law} | entrant.settings)
    }
    for key, value in tuned_changes(entrant.tuned).items() if entrant.tuned else ():
        set_value(group, key, value)
    return group["control"]


def tuned_changes(name: str) -> dict[str, Any]:
    """Return a scene's changes by dotted key: the best compromise of a search of `crane tune`."""
    found = read_tuned_gains()[name]
    return found["changes"] | found["chosen"][BEST]["gains"]


def read_tuned_gains() -> dict[str, Any]:
    """Return the summaries of the catalogue's searches, by name."""
    return json.loads((config_folder() / "tuned_gains.json").read_text())


def _trial_value(key: str, value: Any) -> Any:
    """Return a trial's value of a key."""
    if not isinstance(value, FromScene):
        return copy.deepcopy(value)
    group = get_value(read(value.scene), key)[1]
    for inner_key, change in value.changes.items():
        set_value(group, inner_key, change)
    return group


def _times(factor: float, value: Any) -> Any:
    return [factor * x for x in value] if isinstance(value, list) else factor * value
