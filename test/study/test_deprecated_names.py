"""Deprecated names still work: of a study's keys, in a finished folder, and in Python."""

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
from crane_sim.study.result import DEPRECATED_OWN_METRIC

STUDY: dict[str, Any] = {
    "scene": "overhead_energy",
    "duration": 0.1,
    "parameters": {"cable.node_masses.0": [8.0, 12.0]},
}
METRIC_FILE = """
def furthest(run):
    return {"furthest": abs(run.q[:, 0]).max()}
"""


@pytest.fixture
def metric(tmp_path: Path) -> str:
    """Return a function of metrics, as the file of a study names it."""
    file = tmp_path / "own.py"
    file.write_text(METRIC_FILE)
    return f"{file}:furthest"


def test_the_deprecated_key_works(metric: str, tmp_path: Path) -> None:
    """The key `figures` works as `metrics`, with a warning; both together are refused.

    That holds for a study's file as well.
    """
    with pytest.warns(FutureWarning, match="study: figures is now called metrics"):
        deprecated = studies.load_study(STUDY | {"figures": metric})
    assert deprecated == studies.load_study(STUDY | {"metrics": metric})
    file = tmp_path / "study.yaml"
    file.write_text(json.dumps(STUDY | {"figures": "own.py:furthest"}))
    with pytest.warns(FutureWarning, match="study: figures is now called metrics"):
        assert studies.load_study(file).metrics == metric
    with pytest.warns(FutureWarning), pytest.raises(SceneError, match="figures"):
        studies.load_study(STUDY | {"figures": metric, "metrics": metric})


def test_a_finished_folder_of_the_previous_release_is_read(metric: str, tmp_path: Path) -> None:
    """The study and the columns of its own function are read without a warning."""
    study, folder = studies.load_study(STUDY | {"metrics": metric}), tmp_path / "study"
    studies.run(study, folder, workers=1)
    file, table = folder / "study.json", pq.read_table(folder / "table.parquet")
    known = json.loads(file.read_text())
    known["study"]["figures"] = known["study"].pop("metrics")
    file.write_text(json.dumps(known))
    fields = [
        field.with_metadata(DEPRECATED_OWN_METRIC) if field.metadata else field
        for field in table.schema
    ]
    pq.write_table(table.cast(pa.schema(fields, table.schema.metadata)), folder / "table.parquet")
    result = studies.read_result(folder)
    assert result.study == study and result.own_metrics == ["furthest"]


def test_deprecated_names_in_python_work(metric: str, tmp_path: Path) -> None:
    """The old names in a study's result and in a batch warn and give what the new ones give.

    They are `figure` and `own_figures` of a result, and `figures` of a batch.
    """
    result = studies.run(STUDY | {"metrics": metric}, tmp_path / "study", workers=1)
    with pytest.warns(DeprecationWarning, match="StudyResult.figure is now StudyResult.metric"):
        assert np.array_equal(
            result.figure("furthest", "scene"), result.metric("furthest", "scene")
        )
    with pytest.warns(
        DeprecationWarning, match="StudyResult.own_figures is now StudyResult.own_metrics"
    ):
        assert result.own_figures == ["furthest"]
    changes = {"trolley.mass": [20.0]}
    with pytest.warns(
        DeprecationWarning,
        match=r"simulate_batch\(figures=...\) is now simulate_batch\(metrics=...\)",
    ):
        batch = crane_sim.simulate_batch("overhead_energy", changes, 0.1, figures=True)
    assert batch.metrics is not None
    with pytest.warns(DeprecationWarning, match=r"Batch.figures is now Batch.metrics"):
        assert batch.figures is batch.metrics
