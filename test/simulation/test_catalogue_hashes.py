"""Every scene of the catalogue ends where it did: its whole run, bit for bit."""

import json
from pathlib import Path

import pytest

import crane_sim

HASHES: dict[str, str] = json.loads((Path(__file__).parents[1] / "data" / "state_sha256.json").read_text())
"""`state_sha256` of `simulate` by scene. What means to change a motion writes its scenes' lines anew, and the changelog
names them."""


@pytest.mark.slow
@pytest.mark.parametrize("name", HASHES)
def test_a_scene_ends_where_it_did(name: str) -> None:
    """The hash over every period's t, q, v is the one of the table, also of runs that end early."""
    try:
        summary = crane_sim.simulate(name).summary
    except crane_sim.SimulationError as error:
        summary = error.run.summary
    assert summary["state_sha256"] == HASHES[name]


def test_every_scene_has_a_hash() -> None:
    """The table names the scenes of the catalogue, and no others."""
    scenes = Path(__file__).parents[2] / "config" / "scenes"
    assert set(HASHES) == {file.stem for file in scenes.glob("*.yaml")}
