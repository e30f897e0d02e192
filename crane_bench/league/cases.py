"""The trials and entrants of the league, which stand in `cases.yaml`."""

from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from typing import Any, Literal, NamedTuple

from crane_sim.files.errors import SceneError, did_you_mean
from crane_sim.files.yaml_text import parse_yaml

COLUMNS = (
    "set-point", "obstacle", "resonant base", "irregular sea", "mass -20 %", "mass +20 %",
    "rope -5 %", "rope +5 %", "gust", "30 Hz vision",
)  # fmt: skip
"""The trials: columns of the figure."""
SCALED = {
    "mass -20 %": ("masses", 0.8),
    "mass +20 %": ("masses", 1.2),
    "rope -5 %": ("ropes", 0.95),
    "rope +5 %": ("ropes", 1.05),
}
"""Trials that scale keys of their crane: which, and the factor."""
SEEDS = tuple(range(100, 110))
"""Seeds of seas and camera noise that no catalogue scene uses: no law is tuned to them."""
OF_DISTURBANCE = 0.2
"""By which part at most samples vary the size of a disturbance."""


class FromScene(NamedTuple):
    """A group that a scene takes from another one of the catalogue."""

    scene: str
    changes: dict[str, Any] = {}  # by dotted key, within the group


class Trial(NamedTuple):
    """The task of all laws of a crane in one column."""

    column: str
    scene: str  # of the catalogue
    known: dict[str, Any] = {}  # changes of the scene by dotted key that are part of the laws'
    # nominal scene
    hidden: dict[str, Any] = {}  # changes that are not
    scaled: dict[str, float] = {}  # hidden factors of the scene's numbers, by dotted key
    seeded: str = ""  # the dotted key that takes SEEDS


class Entrant(NamedTuple):
    """A law with its settings."""

    name: str
    law: str
    home: str = ""  # scene of its settings; "": the trial's scene, if it has this law
    settings: dict[str, Any] = {}  # in addition
    nominal: dict[str, Any] = {}  # changes of the law's nominal scene, by dotted key
    tuned: str = ""  # the search of `crane tune` whose best compromise it takes
    changes: dict[str, Any] = {}  # of the scene by dotted key: drives that the law commands, and
    # what it believes


class Group(NamedTuple):
    """The entrants on a crane, their trials, and the payload's goal: the path, or the target."""

    name: str
    goal: Literal["path", "target"]
    entrants: tuple[Entrant, ...]
    trials: tuple[Trial, ...]
    uncertain: dict[str, float] = {}  # what samples vary, unknown to the laws: largest part of the
    # number, by key


def _read_groups() -> Iterator[Group]:
    text = files("crane_bench.league").joinpath("cases.yaml").read_text(encoding="utf-8")
    for name, crane in parse_yaml(text)["cranes"].items():
        crane = _with_scenes(crane)
        entrants = [
            Entrant(key, **({"law": key} | (own or {}))) for key, own in crane["entrants"].items()
        ]
        entrants += _speed_entrants(**crane["by_speed"]) if "by_speed" in crane else []
        trials = (_trial(column, crane, own or {}) for column, own in crane["trials"].items())
        yield Group(name, crane["goal"], tuple(entrants), tuple(trials), crane["uncertain"])


def _with_scenes(value: Any) -> Any:
    """Return a value with `FromScene` in place of what names one, at any depth."""
    if isinstance(value, dict) and "from_scene" in value:
        return FromScene(value["from_scene"], value.get("changes", {}))
    return (
        {key: _with_scenes(part) for key, part in value.items()}
        if isinstance(value, dict)
        else value
    )


def _trial(column: str, crane: Mapping[str, Any], own: Mapping[str, Any]) -> Trial:
    keys, factor = SCALED.get(column, ("", 1.0))
    return Trial(
        column,
        own.get("scene", crane["scene"]),
        own.get("known", crane.get("known", {})),
        own.get("still", crane["still"]) | own.get("hidden", {}),
        dict.fromkeys(crane[keys], factor) if keys else {},
        own.get("seeded", ""),
    )


def _speed_entrants(
    drives: dict[str, Any], path: dict[str, Any], swing_feedback: bool
) -> list[Entrant]:
    """Return the entrants that command drives by speed.

    The law with feedback of the swing needs angles, and believes in the scene's point mass on a
    rope, the others know hook and sling.
    """
    path = path | {"of": "joints", "kind": "point_to_point"}
    shaped = path | {"shaping": {"kind": "zv"}}
    known = drives | {"control.nominal": {}}  # the law believes in hook, sling and body
    entrants = [
        Entrant("speeds", "joint_trajectory", nominal={"reference.path": path}, changes=known),
        Entrant(
            "speeds, ZV", "joint_trajectory", nominal={"reference.path": shaped}, changes=known
        ),
    ]
    return (
        [*entrants, Entrant("anti-swing", "anti_swing", changes=drives)]
        if swing_feedback
        else entrants
    )


GROUPS = tuple(_read_groups())


def groups_named(cranes: Sequence[str]) -> list[Group]:
    """Return the groups of these cranes in order, all groups where none is named.

    Raises:
        SceneError: there is no such crane.
    """
    known = [group.name for group in GROUPS]
    for crane in cranes:
        if crane not in known:
            near = did_you_mean(crane, known)
            # names have commas
            raise SceneError(f"unknown crane {crane!r}{near} (known: {'; '.join(known)})")
    return [group for group in GROUPS if not cranes or group.name in cranes]


def names(groups: Sequence[Group] = GROUPS) -> list[tuple[str, str, str]]:
    """Return crane, law and trial of every cell, in order, without running any."""
    return [
        (g.name, c.name, trial.column) for g in groups for c in g.entrants for trial in g.trials
    ]
