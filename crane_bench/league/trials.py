"""The parts of which the league's cases are made: trials and entrants, and changes that several cranes share."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

SEEDS = tuple(range(100, 110))
"""Seeds of seas and camera noise that no catalogue scene uses: no law is tuned to them."""
SEA = "base_motion.sea.seed"
LOWER_MASS, HIGHER_MASS, SHORTER_ROPE, LONGER_ROPE = 0.8, 1.2, 0.95, 1.05
OF_MASS, OF_LENGTH, OF_DISTURBANCE = 0.1, 0.02, 0.2
"""By which part at most samples vary masses, ropes, and the size of a disturbance."""


class FromScene(NamedTuple):
    """A group that a scene takes from another one of the catalogue."""

    scene: str
    changes: dict[str, Any] = {}  # by dotted key, within the group


class Trial(NamedTuple):
    """The task of all laws of a crane in one column."""

    column: str
    scene: str  # of the catalogue
    known: dict[str, Any] = {}  # changes of the scene by dotted key that are part of the laws' nominal scene
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
    changes: dict[str, Any] = {}  # of the scene by dotted key: drives that the law commands, and what it believes


class Group(NamedTuple):
    """The entrants on a crane, their trials, and where the payload should be: on the path, or at the target."""

    name: str
    goal: Literal["path", "target"]
    entrants: tuple[Entrant, ...]
    trials: tuple[Trial, ...]
    uncertain: dict[str, float] = {}  # what samples vary, unknown to the laws: largest part of the number, by key


def gust(force: float) -> dict[str, Any]:
    """Return a wind that rises to this force [N] within a second, holds for three, and falls again."""
    return {"kind": "table", "times": [12.0, 13.0, 16.0, 17.0], "values": [0.0, force, force, 0.0]}


def wind(force: float) -> dict[str, Any]:
    """Return a gust [N] along x, of cranes whose payload takes a force."""
    return {"payload_force": {"x": gust(force)}}


def set_point_trials(
    scene: str,
    known: dict[str, Any],
    still: dict[str, Any],
    others: Mapping[str, dict[str, Any]],
    masses: Sequence[str],
) -> list[Trial]:
    """Return the trials of a crane with a target.

    Args:
        scene: of the catalogue.
        known: changes of it that the laws know, by dotted key.
        still: changes that disturb nothing, and give all trials the compiled type of those that do.
        others: changes of the scene in further columns.
        masses: keys of what another mass scales.
    """
    return [
        Trial("set-point", scene, known, still),
        Trial("mass -20 %", scene, known, still, dict.fromkeys(masses, LOWER_MASS)),
        Trial("mass +20 %", scene, known, still, dict.fromkeys(masses, HIGHER_MASS)),
        *(
            Trial(name, scene, known, still | changes, seeded=SEA if "sea" in name else "")
            for name, changes in others.items()
        ),
    ]
