"""Every scene of the catalogue ends where it did: its whole run, bit for bit."""

import ctypes
import json
from pathlib import Path

import numpy as np
import pytest

import crane_sim

HASHES: dict[str, str | dict[str, str]] = json.loads(
    (Path(__file__).parents[1] / "data" / "state_sha256.json").read_text()
)
"""`state_sha256` of `simulate` by scene. A change that is meant to alter a motion replaces its
scenes' lines, and the changelog names them. LQR's gains and the spline through waypoints are
LAPACK's, whose last bits depend on the processor: their scenes have one hash for each OpenBLAS
kernel family that was measured. `other` is compared on every family without an entry of its own."""


def processor_family() -> str:
    """Return the kernel family that OpenBLAS has chosen; `other` for another library.

    The hash of `other` is then compared.
    """
    for library in (Path(np.__file__).parents[1] / "numpy.libs").glob("*openblas*"):
        function = getattr(ctypes.CDLL(str(library)), "scipy_openblas_get_corename64_", None)
        if function is not None:
            function.restype = ctypes.c_char_p
            return function().decode()
    return "other"


@pytest.mark.slow
@pytest.mark.parametrize("name", HASHES)
def test_a_scene_ends_where_it_did(name: str) -> None:
    """The hash over every period's t, q, v is that of the table, even where a run ends early."""
    try:
        summary = crane_sim.simulate(name).summary
    except crane_sim.SimulationError as error:
        summary = error.run.summary
    expected = HASHES[name]
    if isinstance(expected, dict):
        expected = expected.get(processor_family(), expected.get("other"))
        if expected is None:
            pytest.skip("not measured on processors of this family")
    assert summary["state_sha256"] == expected


def test_every_scene_has_a_hash() -> None:
    """The table names the scenes of the catalogue, and no others."""
    scenes = Path(__file__).parents[2] / "config" / "scenes"
    assert set(HASHES) == {file.stem for file in scenes.glob("*.yaml")}
