"""Recording of a crane on a moving base: solids aboard, nodes in the world, one frame between."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from knuckle_base_scenes import CRANE
from rerun.chunk import RrdReader
from urdf_kinematics import link_position

import crane_sim
from crane_sim.description import urdf
from crane_sim.recording.base_frame import base_quaternions, to_base, to_world
from crane_sim.recording.rerun.reader import read_curves
from crane_sim.recording.rerun.scene3d import CREST_POINTS
from crane_sim.trajectories.base_motion import base_positions


@pytest.fixture(scope="module")
def run() -> crane_sim.Rollout:
    """Return a run on a ship."""
    target = {"reference": {"q": [0.3, 0.8, -0.2, 1.8]}, "control": {"law": "energy"}}
    return crane_sim.simulate(crane_sim.load_scene(CRANE | target, {"duration": 0.5}))


def test_the_frame_of_the_base_takes_the_solids_to_the_nodes(run: Any) -> None:
    """Joint positions place the payload aboard; the base's frame takes it to the model's place."""
    scene = run.scene
    base = base_positions(scene.model.base, run.t)
    for k in (0, len(run.t) - 1):
        joints = dict(zip(scene.joint_names, run.q[k], strict=True))
        solid = link_position(urdf(scene), joints, "payload_link")
        solid_position = to_world(solid[None, None], base[k : k + 1])[0, 0]
        # the URDF prints nine digits
        assert solid_position == pytest.approx(run.payload[k], abs=1e-7)
    # rounding
    assert to_base(to_world(run.nodes, base), base) == pytest.approx(run.nodes, abs=1e-13)


def test_a_recording_moves_the_base(run: Any, tmp_path: Path) -> None:
    """The recording has the base's place and turn in every picture as in its definition."""
    path = run.record(tmp_path / "ship.rrd")
    chunks = [c for c in RrdReader(path).stream() if c.entity_path == "/tf/base_link"]
    (batch,) = [chunk.to_record_batch() for chunk in chunks]
    at = (
        batch["Transform3D:translation"]
        .flatten()
        .flatten()
        .to_numpy(zero_copy_only=False)
        .reshape(-1, 3)
    )
    turn = (
        batch["Transform3D:quaternion"]
        .flatten()
        .flatten()
        .to_numpy(zero_copy_only=False)
        .reshape(-1, 4)
    )
    base = base_positions(
        run.scene.model.base, np.array(batch["step"].to_numpy() - 1) * run.scene.period
    )
    assert len(at) > 10
    assert at == pytest.approx(base[:, :3], abs=1e-6)  # the recording keeps single precision
    assert turn == pytest.approx(base_quaternions(base), abs=1e-6)  # likewise


def test_a_recording_has_the_rate_of_v_at_every_instant(run: Any, tmp_path: Path) -> None:
    """The base's part of V is evaluated at each step's time, in recording and run."""
    rate = read_curves(run.record(tmp_path / "ship.rrd"), "plots/lyapunov_rate").values
    law = run.scene.law
    expected = [
        law.lyapunov(t, tuple(q), tuple(v))[1] for t, q, v in zip(run.t, run.q, run.v, strict=True)
    ]
    assert np.array_equal(rate[:, 0], expected[:-1])
    assert np.array_equal(run.lyapunov()[:, 1], expected)
    at_first = law.lyapunov(0.0, tuple(run.q[-1]), tuple(run.v[-1]))[1]
    assert abs(expected[-1] - at_first) > 1.0  # W: the instant matters


def test_the_water_is_the_sea_of_the_base(tmp_path: Path) -> None:
    """At every picture the water at the origin rises and falls as a base that only heaves."""
    sea = {"significant_height": 1.5, "peak_period": 7.0, "components": 5}
    scene = crane_sim.load_scene(CRANE | {"base_motion": {"sea": sea}}, {"duration": 0.5})
    path = crane_sim.simulate(scene).record(tmp_path / "sea.rrd")
    heave = {
        c.entity_path: c.to_record_batch() for c in RrdReader(path).stream() if not c.is_static
    }["/tf/base_link"]
    (water,) = [
        c.to_record_batch()
        for c in RrdReader(path).stream()
        if c.entity_path == "/water" and not c.is_static
    ]
    points = water["Mesh3D:vertex_positions"].flatten().flatten().to_numpy(zero_copy_only=False)
    points = points.reshape(len(water), CREST_POINTS, 2, 3)
    level = [np.interp(0.0, row[:, 0, 0], row[:, 0, 2]) for row in points]
    at = (
        heave["Transform3D:translation"]
        .flatten()
        .flatten()
        .to_numpy(zero_copy_only=False)
        .reshape(-1, 3)[:, 2]
    )
    assert np.ptp(at) > 0.01 and len(level) == len(at)
    # a chord between two points of the water
    assert np.diff(level) == pytest.approx(np.diff(at), abs=1e-3)


def test_curves_of_one_plot_have_one_unit(run: Any, tmp_path: Path) -> None:
    """Errors, rates, efforts, commands are recorded in a curve per unit, angles in degrees."""
    path, scene = run.record(tmp_path / "ship.rrd"), run.scene
    rates = read_curves(path, "shown/rate_deg_s").values
    angles = [i for i, unit in enumerate(scene.joint_units) if unit == "rad"]
    # rounding of the conversion
    assert rates == pytest.approx(np.degrees(run.v[:-1, angles]), abs=1e-12)
    assert np.array_equal(
        read_curves(path, "shown/rate_m_s").values[:, 0],
        run.v[:-1, scene.joint_names.index("rope")],
    )
    assert np.array_equal(read_curves(path, "shown/effort_Nm").values, run.u[:-1, :3])
    energy = read_curves(path, "shown/energy_J").values
    assert energy[0, 1] == 0.0 and np.array_equal(energy[:, 0] + energy[:, 1], energy[:, 2])
