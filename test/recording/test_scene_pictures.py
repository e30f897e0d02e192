"""Viewer pictures of catalogue scenes: no error, nothing blank, the whole crane in view."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import crane_sim
from crane_sim.files.catalogue import scene_files
from crane_sim.recording.rerun.screenshot import Shown, camera
from crane_sim.recording.rerun.viewer import NO_DRAWING, PictureError

pytestmark = pytest.mark.unforked  # a client of the viewer

KINDS = ("overhead_energy", "bridge_pick_up")
"""Scenes whose pictures the ordinary suite looks at; those of all others are long."""
ENDLESS = {"overhead_long"}
"""An hour, whose recording has no picture that a shorter run has not."""
# different colours of a picture at least: a blank one has one, and the ground with its grid a few
TONES = 20
EDGE = 3  # pixels at the rim of the picture, which no part of a crane may touch


def drawn(path: Path) -> dict[float, np.ndarray]:
    """Return crane pictures (h, w, 3) at start, middle, end, with no complaint by any view."""
    try:
        with camera(path, Shown(view="Crane")) as viewer:
            pictures = {}
            for t in (0.0, 0.5 * viewer.end, viewer.end):
                pictures[t] = np.array(Image.open(io.BytesIO(viewer.at(t))).convert("RGB"))
                assert viewer.reports() == [], path.name
            return pictures
    except PictureError as error:
        if str(error) != NO_DRAWING:
            raise
        pytest.skip(NO_DRAWING)


def is_crane(picture: np.ndarray) -> np.ndarray:
    """Return which pixels (h, w) have a crane's yellow or a payload's red, used for no other."""
    red, green, blue = np.moveaxis(picture.astype(int), 2, 0)
    return (red > 100) & (red - blue > 60) & (red >= green)


def is_arrow(picture: np.ndarray) -> np.ndarray:
    """Return which pixels (h, w) are of the light blue of an effort's arrow; the sea is darker."""
    red, _, blue = np.moveaxis(picture.astype(int), 2, 0)
    return (blue > 180) & (blue - red > 80)


def brief(scene: str) -> float:
    """Return the duration [s] of a short run of a scene."""
    loaded = crane_sim.load_scene(scene)
    return min(loaded.duration, max(0.3, 12 * loaded.period))


@pytest.mark.long
def test_the_first_picture_of_an_instant_is_complete(tmp_path: Path) -> None:
    """The first picture of a recording of many parts has the rope, as every later one has."""
    file = crane_sim.simulate("offshore_resonant").record(tmp_path / "run.rrd")
    try:
        with camera(file, Shown(view="Crane")) as viewer:
            for t in (12.0, 24.0):
                first = viewer.at(t)
                assert [viewer.at(t) for _ in range(3)] == [first] * 3
    except PictureError as error:
        if str(error) != NO_DRAWING:
            raise
        pytest.skip(NO_DRAWING)


def check(
    scene: str, folder: Path, duration: float | None = None, overrides: dict[str, Any] | None = None
) -> None:
    """Draw a run of a scene, as long as it says unless a duration [s] is given."""
    try:
        run = crane_sim.simulate(scene, duration=duration, overrides=overrides)
    except crane_sim.SimulationError as error:
        run = error.run
    for t, picture in drawn(run.record(folder / f"{scene}.rrd")).items():
        tones = len(np.unique(picture[::4, ::4].reshape(-1, 3), axis=0))
        crane = is_crane(picture[40:])  # below the title of the view
        assert tones > TONES, f"{scene} at {t:g} s is blank: {tones} colours"
        assert crane.sum() > 200, f"{scene} at {t:g} s: no crane is seen"
        for part, seen in (("crane", crane), ("arrow of an effort", is_arrow(picture))):
            rim = np.concatenate(
                [
                    edge.ravel()
                    for edge in (seen[:EDGE], seen[-EDGE:], seen[:, :EDGE], seen[:, -EDGE:])
                ]
            )
            assert not rim.any(), f"{scene} at {t:g} s: the {part} leaves the picture"


@pytest.mark.parametrize("scene", KINDS)
def test_a_crane_is_in_the_picture(scene: str, tmp_path: Path) -> None:
    """A crane is seen whole at start, middle and end of a short run."""
    check(scene, tmp_path, brief(scene))


def test_a_crane_that_slews_away_from_its_target_is_in_the_picture(tmp_path: Path) -> None:
    """A crane that goes where its scene does not say is seen whole, at the end as at the start."""
    check("knuckle_setpoint", tmp_path, 1.0, {"initial.v": [-3.0, 0.0, 0.0, 0.0, 0.0, 0.0]})


@pytest.mark.long
@pytest.mark.parametrize("scene", [name for name in sorted(scene_files()) if name not in KINDS])
def test_every_scene_is_in_the_picture(scene: str, tmp_path: Path) -> None:
    """Every other scene of the catalogue is, too."""
    check(scene, tmp_path, brief(scene))


@pytest.mark.slow
@pytest.mark.parametrize("scene", [name for name in sorted(scene_files()) if name not in ENDLESS])
def test_every_scene_is_in_the_picture_to_its_end(scene: str, tmp_path: Path) -> None:
    """The same of whole runs: wherever the crane goes in its scene, it is seen whole."""
    check(scene, tmp_path)
