"""Cases of a study: what each run changes of the scene, however the study is run."""

import hashlib
from collections.abc import Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.files.document import get_value
from crane_sim.files.errors import SceneError, shorten
from crane_sim.scenes.schema.uncertain import value_at
from crane_sim.study.designs import draw_probabilities, sample_count
from crane_sim.study.schema import MORRIS, SALTELLI, Study, Values, varied_document


class Case(NamedTuple):
    """One run of a study."""

    number: int  # of the run
    sample: int  # of the parameters' values: the same for all variants
    variant: str
    parameters: dict[str, Any]  # values by dotted key
    changes: dict[str, Any]  # of the scene: the parameters, the variant's, seed and duration


class CaseList:
    """The cases of a study, made on demand: variants of one sample follow one another."""

    def __init__(self, study: Study) -> None:
        """Take the study; draws its samples.

        Raises:
            SceneError: there is no such scene, or it has no such parameter.
        """
        self.study, self._document = study, varied_document(study)
        self.variants = study.variant_changes
        self._nominal = {key: self._own_value(key) for key in study.parameters}

    def _own_value(self, key: str) -> Any:
        """Return a parameter's own value in the scene with the study's changes.

        A parameter with a list of values needs none.
        """
        found, value = get_value(self._document, key)
        if not found and not isinstance(self.study.parameters[key], Values):
            raise SceneError(
                f"study: parameters.{key}: the scene has no {key} of its own to vary; list values "
                "of it"
            )
        return value

    def __len__(self) -> int:
        """Return the number of runs."""
        return self.samples * len(self.variants)

    @property
    def samples(self) -> int:
        """Number of samples of the parameters."""
        return sample_count(self.study)

    @cached_property
    def _probabilities(self) -> npt.NDArray[np.float64]:
        return draw_probabilities(self.study)

    def __getitem__(self, number: int) -> Case:
        """Return the case of this number.

        Raises:
            SceneError: the scene's own value of a parameter does not fit its distribution.
            IndexError: there is no such case.
        """
        if not 0 <= number < len(self):
            raise IndexError(number)
        sample, i = divmod(number, len(self.variants))
        variant = list(self.variants)[i]
        parameters = self._parameters(sample)
        # of a design of sensitivity one seed: else noise would count as a parameter's effect
        seed = scene_seed(self.study.seed, 0 if self.study.design in (MORRIS, SALTELLI) else sample)
        changes = (
            {"seed": seed}
            if self.study.duration is None
            else {"seed": seed, "duration": self.study.duration}
        )
        changes |= self.study.changes | self.variants[variant] | parameters
        return Case(number, sample, variant, parameters, changes)

    def __iter__(self) -> Iterator[Case]:
        """Yield all cases in order."""
        return (self[i] for i in range(len(self)))

    def _parameters(self, sample: int) -> dict[str, Any]:
        chosen = self.study.parameters
        if self.study.design == "grid":
            shape = tuple(len(each.values) for each in chosen.values())
            index = np.unravel_index(sample, shape)
            return {
                key: each.values[int(i)]
                for (key, each), i in zip(chosen.items(), index, strict=True)
            }
        return {
            key: self._quantile(key, float(p))
            for key, p in zip(chosen, self._probabilities[sample], strict=True)
        }

    def _quantile(self, key: str, p: float) -> Any:
        distribution = self.study.parameters[key]
        if isinstance(distribution, Values):
            return distribution.quantile(p, None)
        try:
            return value_at(distribution, key, self._nominal[key], p)
        except ValueError as error:
            raise SceneError(f"study: parameters.{key}: {error}") from None


def cases(study: Study) -> CaseList:
    """Return the cases of a study; raises SceneError where it does not fit its scene."""
    for key in study.parameters:
        if not key.strip("."):
            raise SceneError(f"study: parameters: {shorten(key)} is no key of a scene")
    return CaseList(study)


def scene_seed(seed: int, sample: int) -> int:
    """Return the seed of a sample's scenes: all variants have the same random numbers."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{sample}".encode()).digest()[:4], "big")
