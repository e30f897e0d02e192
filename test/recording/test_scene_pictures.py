"""Pictures of catalogue scenes in the viewer: no complaint, nothing blank, the whole crane in the picture."""

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import crane_sim
from crane_sim.files.catalogue import scene_files
from crane_sim.recording.rerun.screenshot import Shown, camera
from crane_sim.recording.rerun.viewer import NO_DRAWING, PictureError

KINDS = ("knuckle_setpoint", "overhead_energy", "bridge_pick_up")
"""Scenes whose pictures the ordinary suite looks at; those of all others are long."""
TONES = 20  # different colours of a picture at least: a blank one has one, and the ground with its grid a few
EDGE = 3  # pixels at the rim of the picture, which no part of a crane may touch


def drawn(path: Path) -> dict[float, np.ndarray]:
    """Return pictures (h, w, 3) of a recording's crane at start, middle and end, about which no view complains."""
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
    """Return which pixels (h, w) are of a crane's yellow or a payload's red: nothing else has such a colour."""
    red, green, blue = np.moveaxis(picture.astype(int), 2, 0)
    return (red > 100) & (red - blue > 60) & (red >= green)


def check(scene: str, folder: Path) -> None:
    """Draw a short run of a scene."""
    loaded = crane_sim.load_scene(scene)
    try:
        run = crane_sim.simulate(scene, duration=min(loaded.duration, max(0.3, 12 * loaded.period)))
    except crane_sim.SimulationError as error:
        run = error.run
    for t, picture in drawn(run.record(folder / f"{scene}.rrd")).items():
        tones = len(np.unique(picture[::4, ::4].reshape(-1, 3), axis=0))
        crane = is_crane(picture[40:])  # below the title of the view
        assert tones > TONES, f"{scene} at {t:g} s is blank: {tones} colours"
        assert crane.sum() > 200, f"{scene} at {t:g} s: no crane is seen"
        rim = np.concatenate(
            [crane[-EDGE:].ravel(), crane[:, :EDGE].ravel(), crane[:, -EDGE:].ravel(), crane[:EDGE].ravel()]
        )
        assert not rim.any(), f"{scene} at {t:g} s: the crane leaves the picture"


@pytest.mark.interpreted
@pytest.mark.parametrize("scene", KINDS)
def test_a_crane_is_in_the_picture(scene: str, tmp_path: Path) -> None:
    """A crane is seen whole at start, middle and end of a short run."""
    check(scene, tmp_path)


@pytest.mark.long
@pytest.mark.interpreted
@pytest.mark.parametrize("scene", [name for name in sorted(scene_files()) if name not in KINDS])
def test_every_scene_is_in_the_picture(scene: str, tmp_path: Path) -> None:
    """Every other scene of the catalogue is, too."""
    check(scene, tmp_path)
