"""Names of the release before: keys of a study, its finished folder, and Python's names are still understood."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import crane_sim
from crane_sim import study as studies
from crane_sim.files.errors import SceneError
from crane_sim.study import former_names

pytestmark = pytest.mark.interpreted
STUDY: dict[str, Any] = {
    "scene": "overhead_energy",
    "duration": 0.1,
    "parameters": {"cable.node_masses.0": [8.0, 12.0]},
}
OWN = """
def furthest(run):
    return {"furthest": abs(run.q[:, 0]).max()}
"""


@pytest.fixture
def own(tmp_path: Path) -> str:
    """Return a function of metrics, as a study's file names it."""
    file = tmp_path / "own.py"
    file.write_text(OWN)
    return f"{file}:furthest"


def test_the_former_key_is_understood(own: str, tmp_path: Path) -> None:
    """`figures` of a study is its `metrics`, in a file, too, with a warning; both together are refused."""
    with pytest.warns(FutureWarning, match="study: figures is now called metrics"):
        former = studies.load_study(STUDY | {"figures": own})
    assert former == studies.load_study(STUDY | {"metrics": own})
    file = tmp_path / "study.yaml"
    file.write_text(json.dumps(STUDY | {"figures": "own.py:furthest"}))
    with pytest.warns(FutureWarning, match="study: figures is now called metrics"):
        assert studies.load_study(file).metrics == own
    with pytest.warns(FutureWarning), pytest.raises(SceneError, match="figures"):
        studies.load_study(STUDY | {"figures": own, "metrics": own})


def test_a_finished_folder_of_the_release_before_is_read(own: str, tmp_path: Path) -> None:
    """Its study and its columns by an own function are found, without a warning."""
    study, folder = studies.load_study(STUDY | {"metrics": own}), tmp_path / "study"
    studies.run(study, folder, workers=1)
    file, table = folder / "study.json", pq.read_table(folder / "table.parquet")
    known = json.loads(file.read_text())
    known["study"]["figures"] = known["study"].pop("metrics")
    file.write_text(json.dumps(known))
    former = [field.with_metadata(former_names.OWN_METRIC) if field.metadata else field for field in table.schema]
    pq.write_table(table.cast(pa.schema(former, table.schema.metadata)), folder / "table.parquet")
    result = studies.read_result(folder)
    assert result.study == study and result.own_metrics == ["furthest"]


def test_former_names_of_python_are_understood(own: str, tmp_path: Path) -> None:
    """`figure` and `own_figures` of a study's result, `figures` of a batch: each warns and is what the new name is."""
    result = studies.run(STUDY | {"metrics": own}, tmp_path / "study", workers=1)
    with pytest.warns(DeprecationWarning, match="StudyResult.figure is now StudyResult.metric"):
        assert np.array_equal(result.figure("furthest", "scene"), result.metric("furthest", "scene"))
    with pytest.warns(DeprecationWarning, match="StudyResult.own_figures is now StudyResult.own_metrics"):
        assert result.own_figures == ["furthest"]
    changes = {"trolley.mass": [20.0]}
    with pytest.warns(DeprecationWarning, match=r"simulate_batch\(figures=...\) is now simulate_batch\(metrics=...\)"):
        batch = crane_sim.simulate_batch("overhead_energy", changes, 0.1, figures=True)
    assert batch.metrics is not None
    with pytest.warns(DeprecationWarning, match=r"Batch.figures is now Batch.metrics"):
        assert batch.figures is batch.metrics
