"""The pictures of README and docs that no page's command makes.

They show runs, as the viewer shows their recordings.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from crane_sim.files.output import write_whole
from crane_sim.recording.rerun.screenshot import Shown, picture
from crane_sim.simulation.rollout import simulate


class Picture(NamedTuple):
    """A picture of a run of the catalogue."""

    scene: str
    at: float  # s, the instant that is shown
    shown: Shown = Shown("Overview")


PICTURES = {
    "run.png": Picture("knuckle_setpoint", 12.0),
    "run_overhead.png": Picture("overhead_spatial", 1.0),
}
"""The pictures by file. Those of pages that commands write are made by these commands."""


TITLE_BAR = 37  # pixels: the viewer's, which says what the machine that draws is


def save_pictures(folder: str | Path) -> None:
    """Run the scenes and draw their recordings into a folder.

    It needs a Vulkan driver, no display.
    """
    for name, (scene, at, shown) in PICTURES.items():
        with TemporaryDirectory() as temporary:
            recording = simulate(scene).record(Path(temporary, f"{scene}.rrd"))
            for error in picture(recording, Path(folder, name), at, shown):
                print(f"{name}: {error}")
        _cut_title_bar(Path(folder, name))
        print(Path(folder, name), flush=True)


def _cut_title_bar(file: Path) -> None:
    """Cut a picture of the viewer's whole window below its title bar."""
    from PIL import Image  # comes with Rerun

    with Image.open(file) as whole:
        below = whole.crop((0, TITLE_BAR, *whole.size))
    write_whole(file, below.save)
