"""The trials of the league as studies: samples of what the laws do not know, the same for all laws.

Around the numbers of a trial samples vary masses, ropes and the size of its disturbance; each has
its own sea or noise.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from crane_bench.league.cases import OF_DISTURBANCE, SEEDS, Entrant, Group, Trial
from crane_bench.league.cells import metrics_at_target, metrics_on_path, reason_of
from crane_bench.league.scenes import trial_scene
from crane_sim.files.document import get_value
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene
from crane_sim.study.schema import Study, load_study

DISTURBANCES = (
    "payload_force.x.values",
    "forces.0.force.values",
    "base_motion.sway.amplitude",
    "base_motion.surge.amplitude",
    "base_motion.sea.significant_height",
    "wind.speed",
)
"""Keys of the size of disturbances."""
_SIGNS = {"-": "minus", "+": "plus"}


class TrialStudy(NamedTuple):
    """A trial of a crane with samples."""

    crane: str
    trial: str
    study: Study | None  # its variants are the laws that apply; None: none does
    refused: dict[str, str]  # why the others do not, by law

    @property
    def folder(self) -> Path:
        """Where its rows are within the league's folder.

        The name has no blanks, no commas, and no signs of numbers.
        """
        words = re.sub(r"[,%]", "", f"{self.crane} {self.trial}").split()
        return Path(re.sub(r"(?<![^_])[-+](?=\d)", lambda sign: _SIGNS[sign[0]], "_".join(words)))


def study_of(group: Group, trial: Trial, samples: int) -> TrialStudy:
    """Return the study of all laws of a crane in a trial."""
    documents, refused = dict[str, dict[str, Any]](), dict[str, str]()
    for entrant in group.entrants:
        document = uncertain_scene(group, trial, entrant)
        try:
            load_scene(document)
            documents[entrant.name] = document
        except SceneError as error:
            refused[entrant.name] = reason_of(error, entrant)
    if not documents:
        return TrialStudy(group.name, trial.column, None, refused)
    base = next(iter(documents.values()))
    measure = metrics_on_path if group.goal == "path" else metrics_at_target
    study: dict[str, Any] = {
        "name": f"{group.name}, {trial.column}",
        "scene": base,
        "design": "latin_hypercube",
        "samples": samples,
        "seed": SEEDS[0],
        "parameters": parameters_of(group, trial, base, samples),
        "variants": {name: _changed_groups(base, document) for name, document in documents.items()},
        "metrics": f"{measure.__module__}:{measure.__name__}",
    }
    return TrialStudy(group.name, trial.column, load_study(study), refused)


def uncertain_scene(group: Group, trial: Trial, entrant: Entrant) -> dict[str, Any]:
    """Return the scene of an entrant in a trial.

    Its nominal scene has its own numbers of what samples vary.
    """
    unknown = dict.fromkeys(group.uncertain, 1.0) | trial.scaled
    return trial_scene(trial._replace(scaled=unknown), entrant, SEEDS[0])


def parameters_of(
    group: Group, trial: Trial, document: Mapping[str, Any], samples: int
) -> dict[str, Any]:
    """Return what samples vary of a trial's scene, as a study has it."""
    parts = group.uncertain | {
        key: OF_DISTURBANCE for key in DISTURBANCES if _has_size(document, key)
    }
    seeds = {trial.seeded: list(range(SEEDS[0], SEEDS[0] + samples))} if trial.seeded else {}
    return seeds | {
        key: {"distribution": "uniform", "low": 1.0 - part, "high": 1.0 + part, "relative": True}
        for key, part in parts.items()
    }


def _has_size(document: Mapping[str, Any], key: str) -> bool:
    """Return whether a scene has a disturbance whose size is at a key."""
    found, value = get_value(document, key)
    return found and any(value if isinstance(value, list) else [value])


def _changed_groups(base: Mapping[str, Any], document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the groups of a scene that differ from another one's."""
    keys = base.keys() | document.keys()
    return {key: document.get(key) for key in sorted(keys) if base.get(key) != document.get(key)}
