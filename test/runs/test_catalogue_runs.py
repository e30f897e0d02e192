"""Every scene of the catalogue over ROS, with real processes and a recorder."""

from pathlib import Path

import pytest
from graph_messages import check_payload, messages_of
from scene_runs import run_scenes

from crane_sim import load_scene
from crane_sim.files.catalogue import scene_files

NAMES = sorted(scene_files())
SHARES = 4


@pytest.mark.long
@pytest.mark.parametrize("share", range(SHARES))
def test_every_scene_runs_and_is_recorded(share: int, tmp_path: Path) -> None:
    """Every catalogue scene runs to the bits of `simulate`, all steps on disk; messages agree."""
    check_runs(NAMES[share::SHARES], tmp_path)


def test_a_scene_of_other_cranes_runs_and_is_recorded(tmp_path: Path) -> None:
    """The same of the first scene of every kind of crane but those of the other tests of runs."""
    first = {load_scene(name).crane: name for name in reversed(NAMES)}
    check_runs(
        sorted(name for crane, name in first.items() if crane not in ("knuckle", "overhead")),
        tmp_path,
    )


def check_runs(names: list[str], tmp_path: Path) -> None:
    """Run scenes over ROS and check what they leave."""
    run_scenes(names, tmp_path)
    for name in names:
        check_payload(load_scene(name), messages_of(tmp_path / f"{name}.mcap"))
