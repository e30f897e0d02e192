"""A recording's target: the crane at rest there, falls stretched, a flexible structure bent."""

from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from recording_samples import RowWriter

import crane_sim
from crane_sim.recording.blocks import MOST_REFERENCES, block_of
from crane_sim.recording.step_assembler import Row
from crane_sim.report.page_data import page_data
from crane_sim.simulation.derived import world_points

FREE: dict[str, Any] = {"control": None, "reference": None, "inputs": None, "duration": 1.0}
GIVEN = {"stiffness": 3e8, "deflection": -0.02}  # at t = 0, which is not at rest
REST = {"flexibility.vertical.deflection": None}
JIB = {"mass": 10.5e3, "centre": 30.0, "inertia": 3.15e6}
SCENES: dict[str, tuple[str, dict[str, Any], tuple[float, ...], dict[str, Any]]] = {
    "falls": (
        "spreader_skew",
        {"initial": {"length": 30.0}},
        (10.0, 2.0, 20.0),
        {"initial": {"trolley": 10.0, "bridge": 2.0, "length": 20.0}},
    ),
    "falls of a jib that bends": (
        "tower_set_down",
        {
            "initial": {"q": [0.1, 20.0, 12.0]},
            "friction": None,
            "flexibility": {"vertical": GIVEN, "jib": JIB},
        },
        (0.4, 30.0, 14.0),
        REST | {"initial": {"q": [0.4, 30.0, 14.0]}},
    ),
    "mast": ("tower_sway", {}, (0.5, 40.0, 20.0), {"initial.q": [0.5, 40.0, 20.0, 0.0, 0.0]}),
    "boom": (
        "mobile_lift",
        {"flexibility": {"vertical": GIVEN}},
        (0.5, 1.0, 40.0, 15.0),
        REST | {"initial.q": [0.5, 1.0, 40.0, 15.0, 0.0, 0.0]},
    ),
}
"""Scene, its changes, a target of the actuated joints, and the changes with which the crane begins
at rest there."""


def targets_of(scene: crane_sim.Scene, references: Any) -> Any:
    """Return a block's target nodes (K, N, 3) at references (K, nu), the crane at its start."""
    efforts = (0.0,) * len(scene.actuated)
    rows = [
        Row(k, scene.initial_q, scene.initial_v, efforts, efforts, each)
        for k, each in enumerate(references, 1)
    ]
    return block_of(scene, rows).target


@pytest.mark.parametrize("name", SCENES)
def test_the_target_is_where_the_payload_hangs_still(name: str) -> None:
    """The target's nodes are the same crane's at rest at the reference, wherever it is now."""
    source, changes, target, start = SCENES[name]
    scene, there = (crane_sim.load_scene(source, FREE | changes | each) for each in ({}, start))
    nodes, _ = world_points(there.model, 0.0, np.array(there.initial_q), np.array(there.initial_v))
    shown = targets_of(scene, [target, scene.initial_q[: len(target)], target])
    for k in (0, 2):
        assert shown[k] == pytest.approx(nodes, abs=1e-9)  # m: poses at rest are rounded to 1e-10
    assert np.abs(shown[1] - nodes).max() > 0.1


def test_references_at_which_nothing_rests_are_shown_all_the_same() -> None:
    """Impossible numbers on a topic neither end the recording nor move other targets."""
    scene = crane_sim.load_scene("tower_sway", FREE)
    sound = (0.5, 40.0, 20.0)
    with np.errstate(invalid="ignore", over="ignore"):
        shown = targets_of(scene, [(0.5, 1e300, 20.0), (0.5, nan, 20.0), sound])
        falls = crane_sim.load_scene("spreader_skew", FREE)
        hung = targets_of(falls, [(1.0, 2.0, -5.0), (1.0, 2.0, inf), (1.0, 2.0, 20.0)])
    assert (shown[2] == targets_of(scene, [sound])[0]).all()
    assert (hung[2] == targets_of(falls, [(1.0, 2.0, 20.0)])[0]).all()


def test_a_stream_of_references_costs_no_more_than_a_few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rest is solved once per reference of a block, and not at all where there are too many."""
    scene, asked = crane_sim.load_scene("spreader_skew", FREE), list[Any]()
    monkeypatch.setattr(
        type(scene.file), "resting_joints", lambda file, target: asked.append(target) or {}
    )
    references = [(1.0, 2.0, 20.0 + 0.01 * k) for k in range(MOST_REFERENCES + 1)]
    targets_of(scene, references[:2] * 50)
    assert asked == references[:2]
    targets_of(scene, references)
    assert asked == references[:2]


def test_a_reference_may_begin_in_the_middle_of_a_run(tmp_path: Path) -> None:
    """A scene gets its reference by a goal: the recording is NaN before it, and has a page."""
    scene = crane_sim.load_scene("knuckle_setpoint", {"control": None, "reference": None})
    session, effort = RowWriter(scene, tmp_path / "run.rrd"), (0.0,) * len(scene.actuated)
    goal, q, v = scene.initial_q[: len(effort)], scene.initial_q, scene.initial_v
    rows = [Row(k, q, v, effort, effort, goal if k > 15 else None) for k in range(1, 31)]
    for first in range(0, 30, 10):
        session.write_rows(rows[first : first + 10])
    file = session.finish({"scene": scene.name, "steps": 30, "recorded_steps": 30})["recording"]
    run = crane_sim.read_recording(file)
    assert run.reference is not None
    assert np.isnan(run.reference[:10]).all() and np.array_equal(run.reference[20:], [goal] * 10)
    assert page_data(run)["frames"]["rows"] > 0
