"""The page of the cranes of ports and sites: its drawings."""

from pathlib import Path

import numpy as np
import pytest
from urdf_kinematics import link_position

from crane_bench.documentation.drawing import polygons
from crane_bench.documentation.scenes_page import PORTS_AND_SITES, format_metrics, ropes, save_page
from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.files.errors import SceneError
from crane_sim.simulation.goals import express_in_base
from crane_sim.simulation.rollout import simulate


@pytest.mark.parametrize(
    "name", ["knuckle_ship_falls", "pendulum_lifeboat", "bridge_hook_and_sling"]
)
def test_path_and_ropes_meet_the_crane_that_is_drawn(name: str) -> None:
    """On a moving base the load's path, ropes' ends and drawn links are in the same axes.

    Links are where forward kinematics of the document by another program has them.
    """
    scene = load_scene(name, {"duration": 2.0})
    run, document = simulate(scene), urdf(scene)
    path, distances = express_in_base(scene.model, run.t, run.payload), []
    for k in (0, -1):
        joints = dict(zip(scene.joint_names, run.q[k].tolist(), strict=True))
        load = link_position(document, joints, "payload_link")
        assert path[k] == pytest.approx(load, abs=1e-9)
        ends = np.array([rope[-1] for rope in ropes(scene, float(run.t[k]), run.q[k], run.v[k])])
        distances.append(np.linalg.norm(ends - load, axis=1))
        corners = np.concatenate([face.corners for face in polygons(scene, run.q[k].tolist())])
        # some corner of the load is no further from its centre than its size, some 10 m
        assert np.linalg.norm(corners - load, axis=1).min() < 10.0 and np.isfinite(corners).all()
    assert distances[0] == pytest.approx(distances[1], abs=1e-9)  # they are fixed to the load


def test_metrics_that_a_run_lacks_are_left_out() -> None:
    """A line of metrics has what the summary has, with units."""
    assert (
        format_metrics({"sim_time": 3.0, "peak_swing_deg": 1.2345}) == "3 s · largest swing 1.23 °"
    )


def test_sections_of_other_scenes_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene drawn anew replaces its section of the page alone.

    Another name is refused in one line.
    """
    page, written = tmp_path / "scenes.md", "## tower_gust\n\nNew.\n"
    stored = (Path(__file__).parents[2] / "docs" / "scenes.md").read_text()
    page.write_text(stored)
    monkeypatch.setattr(
        "crane_bench.documentation.scenes_page.write_section", lambda name, folder: written
    )
    save_page(tmp_path, ["tower_gust"])
    first, second = (stored.index(f"## {name}\n") for name in PORTS_AND_SITES[:2])
    assert page.read_text() == stored[:first] + written + "\n" + stored[second:]
    with pytest.raises(SceneError, match="unknown SCENE of the page 'overhead_swing'"):
        save_page(tmp_path, ["overhead_swing"])
