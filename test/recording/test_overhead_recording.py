"""The recording of an overhead crane: pictures and plots of its nodes, small and in view."""

from math import radians, tan
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recording_samples import RowWriter
from rerun.chunk import RrdReader

from crane_sim import load_scene
from crane_sim.description.cables import SuspendedCable
from crane_sim.description.workspace import BoundingBox
from crane_sim.recording.camera import ASPECT, FIELD_OF_VIEW, of_room
from crane_sim.recording.rerun.curves import _cable_curves
from crane_sim.recording.rerun.reader import read_curves
from crane_sim.recording.rerun.screenshot import picture
from crane_sim.recording.rerun.viewer import NO_DRAWING, PictureError
from crane_sim.recording.step_assembler import Row
from crane_sim.recording.suspension import Suspension, hanging_still
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import derive

pytestmark = pytest.mark.unforked  # a client of the viewer

STEPS = 300
FRAMES = len(range(0, STEPS, 3))  # 30 Hz of the 100 Hz


def chain(links: int) -> Scene:
    """Return a scene with a cable of `links` links, 4 m in all, 10 kg."""
    masses = [6.0 / links] * (links - 1) + [4.0 + 6.0 / links]
    cable = {"links": links, "lengths": 4.0 / links, "node_masses": masses}
    return load_scene(
        {"crane": "overhead", "duration": 3.0, "trolley": {"mass": 5.0}, "cable": cable}
    )


class Run(NamedTuple):
    """A made-up motion and its recording."""

    path: Path
    scene: Scene
    q: np.ndarray  # (K, nq)
    nodes: np.ndarray  # (K, N+1, 3)


def record_cable_run(path: Path, links: int) -> Run:
    """Record a trolley that runs 60 m, beyond the first drawn rail, above a bending cable."""
    scene, t = chain(links), 0.01 * np.arange(STEPS)
    bend = np.sin(4.0 * t)[:, None] * np.linspace(0.2, 1.0, links)
    q = np.column_stack([20.0 * t, bend])
    rest = np.zeros_like(q)
    session = RowWriter(scene, path)
    rows = [Row(k + 1, tuple(q[k]), tuple(rest[k]), (1.0,), None, None) for k in range(STEPS)]
    session.write_rows(rows[:200])
    session.write_rows(rows[200:])
    session.finish({"scene": scene.name})
    exact = (np.asarray(part, dtype=np.float64) for part in (t, q, rest, np.ones((STEPS, 1))))
    return Run(path, scene, q, derive(scene, *exact).nodes)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Record a cable of seven links."""
    return record_cable_run(tmp_path_factory.mktemp("overhead") / "run.rrd", 7)


def chunks(path: Path, entity: str, column: str, static: bool = False) -> list[Any]:
    """Return the values of a component, one per row, in the order of the file."""
    batches = (
        c.to_record_batch()
        for c in RrdReader(path).stream()
        if c.entity_path == entity and c.is_static == static
    )
    return [
        value
        for batch in batches
        if column in batch.schema.names
        for value in batch[column].to_pylist()
    ]


def test_the_cable_is_a_line_through_the_nodes(run: Run) -> None:
    """Every third step the cable is drawn from node to node, trolley and payload at its ends."""
    nodes = run.nodes[::3]
    strips = np.array(chunks(run.path, "/rope", "LineStrips3D:strips"))
    assert strips.shape == (FRAMES, 7, 2, 3)
    # single precision of up to 60 m
    assert strips[:, :, 0] == pytest.approx(nodes[:, :-1], abs=1e-5)
    assert strips[:, :, 1] == pytest.approx(nodes[:, 1:], abs=1e-5)
    for frame, end in (("trolley", 0), ("payload", -1)):
        positions = np.array(chunks(run.path, f"/tf/{frame}", "Transform3D:translation"))[:, 0]
        assert positions == pytest.approx(nodes[:, end], abs=1e-5)


def test_a_few_links_stand_for_all_in_the_plots(run: Run) -> None:
    """Four of seven swings are plotted, first and last included; `plots/q` has all, bit for bit."""
    assert np.array_equal(read_curves(run.path, "plots/q").values, run.q)
    assert np.array_equal(
        read_curves(run.path, "shown/swing_deg").values, np.degrees(run.q[:, [1, 3, 5, 7]])
    )
    line = run.nodes[:, -1] - run.nodes[:, 0]
    total = read_curves(run.path, "shown/swing_total_deg").values[:, 0]
    assert total == pytest.approx(np.degrees(np.arctan2(line[:, 0], -line[:, 2])))
    parts, whole = (
        read_curves(run.path, "plots/energy_parts").values,
        read_curves(run.path, "plots/energy").values,
    )
    assert parts.sum(axis=1) == pytest.approx(whole[:, 0])
    assert np.ptp(parts[:, 1]) > 1.0  # J: the cable bends, so it is no sum of zeros


def test_the_rail_is_as_long_as_the_travel(run: Run) -> None:
    """The final rail is as long as the trolley's travel and half the cable's depth."""
    rails = chunks(run.path, "/crane/base/boxes", "Boxes3D:half_sizes", static=True)
    half = max(size[0] for size in rails[-1])
    travel, depth = np.ptp(run.nodes[::3, :, 0]), -run.nodes[::3, :, 2].min()
    assert len(rails) > 2  # expected, grown as the trolley moves, fitted
    assert 2.0 * half == pytest.approx(travel + 0.5 * depth, rel=1e-6)  # single precision


@pytest.mark.long
def test_many_links_cost_no_more_entities(run: Run, tmp_path: Path) -> None:
    """A cable of 120 links has the entities and rows of one of seven, less hidden node markers."""
    rows: list[dict[str, int]] = []
    for path in (run.path, record_cable_run(tmp_path / "long.rrd", 120).path):
        counts: dict[str, int] = {}
        for chunk in RrdReader(path).stream():
            if not chunk.is_static:
                counts[chunk.entity_path] = counts.get(chunk.entity_path, 0) + chunk.num_rows
        rows.append(counts)
    assert rows[0].pop("/rope/nodes") == FRAMES
    assert rows[0] == rows[1]


def test_the_viewer_shows_it_without_error(run: Run, tmp_path: Path) -> None:
    """The viewer opens the recording with its layout, draws it, and no view reports a problem."""
    try:
        errors = picture(run.path, tmp_path / "run.png", at=2.0)
    except PictureError as error:
        if str(error) == NO_DRAWING:
            pytest.skip(NO_DRAWING)
        raise
    assert errors == []


EDGE = st.floats(0.0, 4.0)


@given(st.floats(-50.0, 50.0), EDGE, EDGE, st.floats(0.5, 20.0), st.booleans(), st.booleans())
def test_all_of_the_motion_is_in_the_picture(
    x: float, dx: float, dy: float, depth: float, spatial: bool, lifts: bool
) -> None:
    """No corner of the crane's room is outside the field of view from the recorded eye."""
    dy = dy if spatial else 0.0
    room = BoundingBox((x, 0.0, -depth), (x + dx * depth, dy * depth, 0.0), depth, spatial)
    framing = of_room(room, lifts)
    top = 0.31 * framing.size if lifts else 0.0  # an arrow twice as long as its scale
    eye, at = np.array(framing.eye), np.array(framing.look_at)
    ahead = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    (left, end), (near, far) = room.rail(0), room.rail(1) if spatial else (0.0, 0.0)
    for corner in ((a, b, c) for a in (left, end) for b in (near, far) for c in (room.floor, top)):
        line = np.array(corner) - eye
        assert line @ ahead > 0.0
        slope = tan(radians(0.5 * FIELD_OF_VIEW)) * (line @ ahead)
        assert abs(line @ up) <= slope and abs(line @ right) <= ASPECT * slope


def test_a_far_way_is_followed() -> None:
    """With a travel far larger than the crane, the camera follows the trolley closely."""
    room = BoundingBox((0.0, 0.0, -2.0), (200.0, 0.0, 0.0), 2.0, spatial=False)
    framing = of_room(room, lifts=False)
    assert framing.follows == "crane/trolley/boxes"
    assert np.linalg.norm(np.subtract(framing.eye, framing.look_at)) < 10.0 * room.depth


def test_an_elastic_cable_has_the_coordinates_of_its_nodes() -> None:
    """The angles of a few links and the length of a cable of nodes follow from their positions."""
    angles = np.radians([10.0, 20.0, 30.0, 40.0, 50.0, 60.0])
    steps = np.column_stack([np.sin(angles), np.zeros(6), -np.cos(angles)]) * 1.1
    nodes = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)]) + (5.0, 0.0, 0.0)
    room = BoundingBox((5.0, 0.0, -6.0), (10.0, 0.0, 0.0), 5.0, spatial=False)
    cable = Suspension(SuspendedCable((1.0,) * 6, (1.0,) * 6), room, False, "positions")
    block: Any = SimpleNamespace(nodes=nodes[None])
    channels = {channel.entity: channel for channel in _cable_curves(cable)}
    assert channels["shown/swing_deg"].names == ("link 1", "link 3", "link 4", "link 6")
    assert channels["shown/swing_deg"].values(block) == pytest.approx(
        np.array([[10.0, 30.0, 40.0, 60.0]])
    )
    assert channels["shown/cable_m"].values(block) == pytest.approx([6.6])


def test_the_target_hangs_still_below_the_references() -> None:
    """The target has trolley, bridge and hoist at the reference, each link straight down.

    Each link has its own length.
    """
    nodes = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.6, -0.8]]])
    still = hanging_still(("trolley", "bridge", "hoist"), np.array([[4.0, -3.0, 2.5]]), nodes)
    assert still == pytest.approx(
        np.array([[[4.0, -3.0, 0.0], [4.0, -3.0, -2.5], [4.0, -3.0, -3.5]]])
    )
    kept = hanging_still(("bridge",), np.array([[-3.0]]), nodes)
    assert kept == pytest.approx(
        np.array([[[0.0, -3.0, 0.0], [0.0, -3.0, -1.0], [0.0, -3.0, -2.0]]])
    )
