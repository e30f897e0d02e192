"""A recording holds every step exactly, with derived quantities; the viewer shows no error."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from recording_samples import SCENE, STEPS, RowWriter, steps_of
from rerun.chunk import RrdReader

from crane_sim.recording.rerun.cranes import turn_from_z
from crane_sim.recording.rerun.reader import read_curves, read_summary
from crane_sim.recording.rerun.screenshot import picture
from crane_sim.recording.rerun.viewer import NO_DRAWING, PictureError
from crane_sim.simulation.derived import derive

pytestmark = pytest.mark.unforked  # a client of the viewer


class Run(NamedTuple):
    """A run of a plant, and its recording."""

    path: Path
    t: np.ndarray  # (K,)
    q: np.ndarray  # (K, nq)
    v: np.ndarray  # (K, nq)
    u: np.ndarray  # (K, nu)
    summary: dict[str, Any]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Record one run."""
    path = tmp_path_factory.mktemp("recording") / "run.rrd"
    session, rows = RowWriter(SCENE, path), list(steps_of(SCENE))
    session.add_timeline_state("simulation", "stopped", 1, "playing")
    session.write_rows(rows[:500])
    session.write_rows(rows[500:])
    session.add_speed(STEPS, 12.5)
    summary = {
        "scene": SCENE.name,
        "steps": STEPS,
        "final_error": {"slew": 0.25},
        "settling_time": {"slew": None},
    }
    added = session.finish(summary)
    q, v, u = (np.array([row[i] for row in rows]) for i in (1, 2, 3))
    return Run(path, SCENE.period * np.arange(STEPS), q, v, u, summary | added)


def test_every_step_is_there_exactly(run: Run) -> None:
    """State and effort of each step are recorded once, bit for bit, at the right time."""
    for entity, values in (("plots/q", run.q), ("plots/v", run.v), ("plots/effort", run.u)):
        curves = read_curves(run.path, entity)
        assert np.array_equal(curves.step, np.arange(1, STEPS + 1))
        assert np.array_equal(curves.values, values)
        # the rounding of ns to s
        assert curves.time == pytest.approx(SCENE.period * np.arange(STEPS), abs=1e-12)


def test_derived_quantities_are_there(run: Run) -> None:
    """Derived quantities equal `simulation.metrics`, V and dV/dt the law's, at every step."""
    known = derive(SCENE, run.t, run.q, run.v, run.u)
    law: Any = SCENE.law
    lyapunov = np.array(
        [law.lyapunov(*at) for at in zip(run.t, map(tuple, run.q), map(tuple, run.v), strict=True)]
    )
    expected = {
        "plots/energy": known.energy[:, None],
        "plots/tension": known.tension[:, None],
        "plots/swing": known.swing[:, None],
        "plots/payload": known.payload,
        "plots/q_err": np.array(SCENE.reference) - run.q[:, :4],
        "plots/lyapunov": lyapunov[:, :1],
        "plots/lyapunov_rate": lyapunov[:, 1:],
        "shown/angle_deg": np.degrees(run.q[:, :3]),
        "shown/swing_deg": np.degrees(run.q[:, 4:]),
    }
    for entity, values in expected.items():
        assert np.array_equal(read_curves(run.path, entity).values, values), entity


def test_the_crane_moves_in_3d(run: Run) -> None:
    """Joints, rope, trail and target have a frame for every third step, without a gap."""
    rows: dict[str, int] = {}
    for chunk in RrdReader(run.path).stream():
        if not chunk.is_static:
            rows[chunk.entity_path] = rows.get(chunk.entity_path, 0) + chunk.num_rows
    frames = len(range(0, STEPS, 3))  # 30 Hz of the 100 Hz
    moving = [f"/tf/{name}" for name in (*SCENE.joint_names, "boom_level", "jib_level")]
    efforts = [f"/effort/{name}" for name in SCENE.actuated]
    others = ["/rope", "/payload/trail", "/reference/path", "/reference/target"]
    assert {entity: rows.get(entity) for entity in (*moving, *efforts, *others)} == dict.fromkeys(
        (*moving, *efforts, *others), frames
    )


def test_the_summary_is_in_the_file(run: Run) -> None:
    """The summary is read back unchanged, and the viewer has it as a table."""
    assert read_summary(run.path) == run.summary
    tables = [
        chunk for chunk in RrdReader(run.path).stream() if chunk.entity_path == "/summary/table"
    ]
    text = tables[0].to_record_batch()["TextDocument:text"][0].as_py()[0]
    assert "| steps | 637 |" in text and "| slew | 0.25 | – |" in text


def test_a_finished_recording_is_one_file_with_its_views(run: Run) -> None:
    """A closed recording is its folder's only file, and holds the viewer's layouts."""
    assert [entry.name for entry in run.path.parent.iterdir()] == ["run.rrd"]
    assert len(RrdReader(run.path).recordings()) == 1 and RrdReader(run.path).blueprints()


@given(
    arrays(float, (5, 3), elements=st.floats(-10.0, 10.0)).filter(
        lambda a: np.linalg.norm(a, axis=1).min() > 1e-3
    )
)
def test_the_rope_points_along_itself(directions: np.ndarray) -> None:
    """The rope cylinder's rotation maps z to the rope's direction, also straight down."""
    directions[:2] = (0.0, 0.0, -1.0), (1e-6, 0.0, -1.0)
    x, y, z, w = turn_from_z(directions).T
    turned = np.column_stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    assert turned == pytest.approx(unit, abs=1e-14)  # a few roundings of numbers up to one


def test_the_viewer_shows_it_without_error(run: Run, tmp_path: Path) -> None:
    """The viewer draws the recording in its layout, and no view reports a problem."""
    try:
        errors = picture(run.path, tmp_path / "run.png", at=3.0)
    except PictureError as error:
        if str(error) == NO_DRAWING:
            pytest.skip(NO_DRAWING)
        raise
    assert errors == []
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
