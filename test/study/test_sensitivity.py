"""Sensitivity of metrics to parameters, against functions whose indices are known."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from pyarrow.parquet import write_table

from crane_sim.files.errors import SceneError
from crane_sim.study.cases import cases
from crane_sim.study.designs import draw_probabilities
from crane_sim.study.result import StudyResult
from crane_sim.study.schema import load_study
from crane_sim.study.sensitivity import sensitivities

KEYS = ("cable.node_masses.0", "cable.lengths.0", "trolley.mass")


def study_of(design: str, samples: int) -> dict[str, Any]:
    """Return a study of three parameters, each of one unit from 1 on."""
    uniform = {"distribution": "uniform", "low": 1.0, "high": 2.0}
    return {
        "name": "indices",
        "scene": "overhead_energy",
        "design": design,
        "samples": samples,
        "duration": 1.0,
        "parameters": dict.fromkeys(KEYS, uniform),
    }


def result_of(folder: Path, design: str, samples: int, function: Any) -> StudyResult:
    """Return the result of a study whose metric `y` is a function of the probabilities.

    These are (runs, parameters).
    """
    study = load_study(study_of(design, samples))
    y = function(draw_probabilities(study))
    table = pa.table({"variant": ["scene"] * len(y), "status": ["ok"] * len(y), "y": y.tolist()})
    write_table(table, folder / "table.parquet")
    return StudyResult(study, folder)


def test_elementary_effects_of_a_linear_function_are_its_changes(tmp_path: Path) -> None:
    """Morris' mean magnitudes of a linear function are slope times range, strongest first.

    There is no interaction.
    """
    found = sensitivities(
        result_of(tmp_path, "morris", 4, lambda x: x @ [2.0, -5.0, 0.0]), "y", "scene"
    )
    assert [row.parameter for row in found] == [KEYS[1], KEYS[0], KEYS[2]]
    # rounding of sums and of differences by 2/3
    assert np.allclose(
        [row[1:] for row in found], [[5.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.0]], atol=1e-12
    )


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("design", ["morris", "saltelli"])
def test_rounding_depends_on_nothing(design: str, tmp_path: Path) -> None:
    """A metric constant up to rounding depends on no parameter; an infinite one is missing."""
    rounded = result_of(tmp_path, design, 8, lambda x: 0.3 + 1e-15 * np.sin(1e3 * x[:, 0]))
    assert [row[1:] for row in sensitivities(rounded, "y", "scene")] == [(0.0, 0.0, 0.0)] * 3
    infinite = result_of(
        tmp_path, design, 8, lambda x: np.where(np.arange(len(x)) == 3, np.inf, x[:, 0])
    )
    with pytest.raises(SceneError, match="1 of .* runs have none"):
        sensitivities(infinite, "y", "scene")


def test_total_indices_of_a_product_are_those_of_theory(tmp_path: Path) -> None:
    """Of y = x1 x2 the total indices are 4/7, of which 1/7 is interaction; x3 has none."""
    found = sensitivities(
        result_of(tmp_path, "saltelli", 4096, lambda x: x[:, 0] * x[:, 1]), "y", "scene"
    )
    by_key = {row.parameter: row for row in found}
    for key in KEYS[:2]:
        # var(x1 x2) = 7/144, of x1 alone 3/144: 4096 base samples of a Sobol sequence come within 1
        # % of 1
        assert by_key[key].strength == pytest.approx(4 / 7, abs=0.01)
        assert by_key[key].interaction == pytest.approx(1 / 7, abs=0.01)
    assert by_key[KEYS[2]].strength == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("design", "samples", "count"), [("morris", 3, 12), ("saltelli", 4, 20)])
def test_designs_change_what_they_should(design: str, samples: int, count: int) -> None:
    """Values lie in their distributions, and all runs have one seed.

    Morris' paths change one value at a time.
    """
    listed = cases(load_study(study_of(design, samples)))
    values = np.array([list(case.parameters.values()) for case in listed])
    assert len(listed) == count and len({case.changes["seed"] for case in listed}) == 1
    assert np.all((values > 1.0) & (values < 2.0))
    if design == "morris":
        changed = np.diff(values.reshape(samples, 4, 3), axis=1) != 0.0
        assert np.all(changed.sum(axis=2) == 1) and np.all(changed.sum(axis=1) == 1)
        assert set(np.unique(values)) == {1.125, 1.375, 1.625, 1.875}


def test_studies_without_indices(tmp_path: Path) -> None:
    """Designs, metrics and numbers of samples without sensitivities are refused.

    These are other designs, metrics that some runs lack, and numbers of samples that are no power
    of two.
    """
    drawn = result_of(tmp_path, "morris", 2, lambda x: x[:, 0])
    with pytest.raises(SceneError, match="sensitivities need morris or saltelli"):
        sensitivities(StudyResult(load_study(study_of("sobol", 8)), drawn.folder), "y", "scene")
    with pytest.raises(SceneError, match="1 of 8 runs have none"):
        sensitivities(
            result_of(
                tmp_path, "morris", 2, lambda x: np.where(np.arange(8) == 3, np.nan, x[:, 0])
            ),
            "y",
            "scene",
        )
    with pytest.raises(SceneError, match="4, 8"):
        load_study(study_of("saltelli", 6))
