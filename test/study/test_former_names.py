"""Names of the release before: keys of a study, a folder that it began, and Python's names are still understood."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import study as studies
from crane_sim.files.errors import SceneError
from crane_sim.study import former_names, store
from crane_sim.study.versions import versions

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


def test_a_folder_of_the_release_before_goes_on(own: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its block is kept, its columns by an own function are found, and the finished folder is read without a warning.

    Of the names in the source of the metrics only a change that is listed is a change of names.
    """
    study, folder = studies.load_study(STUDY | {"metrics": own}), tmp_path / "begun"
    whole = studies.run(study, tmp_path / "whole", workers=1)
    source = versions()["metrics_sha256"]
    monkeypatch.setattr(former_names, "SOURCES", {source: "0" * 64})
    known = former_names.former_identity(store.identity_of(study))
    assert known["study"]["figures"] == own and known["versions"]["metrics_sha256"] == "0" * 64
    (folder / "rows").mkdir(parents=True)
    (folder / "study.json").write_text(json.dumps({"hash": store.hash_of(known), **known}))
    with monkeypatch.context() as context:
        context.setattr(store, "OWN_METRIC", former_names.OWN_METRIC)
        first = whole.table.slice(0, 1).to_pydict() | {"wall_time": [1.0]}
        columns = {name: store.OwnMetric(values) if name == "furthest" else values for name, values in first.items()}
        store.Store(folder, study, 2).write(0, columns)
    done = list[int]()
    result = studies.run(study, folder, workers=1, on_progress=lambda count, _: done.append(count))
    assert done[0] == 1 and result.column("wall_time")[0] == 1.0
    assert result.own_metrics == ["furthest"]
    assert result.column("state_sha256").tolist() == whole.column("state_sha256").tolist()
    assert studies.read_result(folder).study == study
    monkeypatch.setattr(former_names, "SOURCES", {})
    with pytest.raises(SceneError, match=r"was begun with other versions \(metrics_sha256\)"):
        studies.run(study, folder, workers=1)


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
