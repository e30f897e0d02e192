"""Recordings hold the tensions of all links of a chain and all falls, unless very many."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import crane_sim
from crane_sim.recording.layout import MAX_TENSIONS, layout_of_scene
from crane_sim.recording.quantities import Curve
from crane_sim.recording.run import RecordedRun
from crane_sim.report.panels import panels_of

STEPS = 4


def chain(links: int) -> crane_sim.Rollout:
    """Run a chain of `links` links, each bent against the one above it, for a few steps."""
    cable = {
        "model": "rigid",
        "links": links,
        "lengths": 4.0 / links,
        "node_masses": [1.0] * (links - 1) + [4.0],
    }
    start = {"angles": np.linspace(0.1, 0.6, links).tolist()}
    document = {"crane": "overhead", "trolley": {"mass": 5.0}, "cable": cable, "initial": start}
    return crane_sim.simulate(crane_sim.load_scene(document | {"duration": 0.01 * STEPS}))


@pytest.fixture(scope="module")
def rollouts() -> dict[str, crane_sim.Rollout]:
    """Run a spreader on falls whose lengths differ, and a chain of three links."""
    return {"fall": crane_sim.simulate("spreader_skew", duration=0.01 * STEPS), "link": chain(3)}


@pytest.fixture(scope="module")
def runs(
    rollouts: dict[str, crane_sim.Rollout], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, RecordedRun]:
    """Record both and read them back."""
    folder = tmp_path_factory.mktemp("tensions")
    return {
        kind: crane_sim.read_recording(run.record(folder / f"{kind}.rrd"))
        for kind, run in rollouts.items()
    }


def tension_curves(run: RecordedRun) -> dict[str, Curve]:
    """Return the curves of the panels of tensions by name, forces in kN back in N."""
    panels = [panel for panel in panels_of(run) if panel.title.startswith("Rope tension")]
    scale = {"N": 1.0, "kN": 1e3, "MN": 1e6}
    return {
        curve.name: curve._replace(values=scale[panel.unit] * curve.values)
        for panel in panels
        for curve in panel.curves
    }


@pytest.mark.parametrize(("kind", "count"), [("fall", 4), ("link", 3)])
def test_every_tension_is_recorded(
    kind: str, count: int, rollouts: dict[str, crane_sim.Rollout], runs: dict[str, RecordedRun]
) -> None:
    """The run's tensions, all different, are read back bit for bit; `tension` is the first."""
    run, expected = runs[kind], rollouts[kind].derived.tensions[:-1]
    assert run.tensions.shape == (STEPS, count) and np.array_equal(run.tensions, expected)
    assert len(np.unique(expected[0])) == count
    assert np.array_equal(run.tension, expected[:, 0])


@pytest.mark.parametrize("kind", ["fall", "link"])
def test_every_tension_has_its_name(kind: str, runs: dict[str, RecordedRun]) -> None:
    """Viewer, panels and columns name link or fall, and each name has its own values and colour."""
    run = runs[kind]
    assert run.path is not None
    names = [f"{kind} {k}" for k in range(1, 1 + run.tensions.shape[1])]
    styles = [
        c for c in RrdReader(run.path).stream() if c.entity_path == "/plots/tension" and c.is_static
    ]
    assert styles[0].to_record_batch()["SeriesLines:names"][0].as_py() == [
        f"{name} [N]" for name in names
    ]
    curves, columns = tension_curves(run), run.columns()
    assert sorted(curves) == names and len({curve.color for curve in curves.values()}) == len(names)
    assert np.array_equal(columns["tension"][0], run.tension)
    for k, name in enumerate(names):
        # N to kN and back
        assert curves[name].values == pytest.approx(run.tensions[:, k], rel=1e-15)
        assert np.array_equal(columns[f"tension.{k + 1}"][0], run.tensions[:, k])


def test_of_very_many_links_the_first_is_recorded(tmp_path: Path) -> None:
    """A chain of more links than are recorded keeps the top one's tension, and says so."""
    rollout = chain(MAX_TENSIONS + 1)
    run = crane_sim.read_recording(rollout.record(tmp_path / "run.rrd"))
    assert np.array_equal(run.tensions, rollout.derived.tensions[:-1, :1])
    assert layout_of_scene(rollout.scene, "run").ropes.tensions == ("tension of the top link",)
    assert list(tension_curves(run)) == ["uppermost link"] and "tension.1" not in run.columns()


def test_recordings_with_one_tension_are_shown(runs: dict[str, RecordedRun]) -> None:
    """A falls' recording with one tension, as older ones have, shows it as the first fall's."""
    run = runs["fall"]
    old = replace(run, tensions=run.tensions[:, :1])
    assert list(tension_curves(old)) == ["fall 1"]
    assert "tension.1" not in old.columns()
    assert run.reeved is None and run.falls.shape == (STEPS, 0) and run.lead_line.size == 0
    assert "lead_line" not in run.columns() and "fall.1" not in run.columns()


def test_lead_line_and_falls_of_a_reeved_rope_are_recorded(tmp_path: Path) -> None:
    """Twelve falls and their lead line are read back bit for bit.

    Each has its name in viewer, page and columns.
    """
    rollout = crane_sim.simulate("reeved_twelve_falls", duration=0.05 * STEPS)
    run = crane_sim.read_recording(rollout.record(tmp_path / "run.rrd"))
    assert run.falls.shape == (STEPS, 12) and np.array_equal(run.falls, rollout.falls[:-1])
    assert np.array_equal(run.lead_line, rollout.lead_line[:-1])
    names = ["lead line", *(f"fall {k}" for k in range(1, 13))]
    assert run.path is not None
    styles = [
        c
        for c in RrdReader(run.path).stream()
        if c.entity_path == "/plots/reeved_tension" and c.is_static
    ]
    assert styles[0].to_record_batch()["SeriesLines:names"][0].as_py() == [
        f"{name} [N]" for name in names
    ]
    shown = [
        c.name
        for panel in panels_of(run)
        if panel.title.startswith("Tension of lead")
        for c in panel.curves
    ]
    assert sorted(shown) == sorted(names)
    columns = run.columns()
    assert (
        np.array_equal(columns["fall.12"][0], run.falls[:, 11]) and columns["lead_line"][1] == "N"
    )
