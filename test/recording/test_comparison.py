"""Comparison of runs: zero with itself, the shift with a shifted run, refused for other cranes."""

import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, NO_CHROMIUM, evaluate_in_pages

import crane_sim
from crane_sim.cli.commands import app
from crane_sim.cli.compare import print_comparison
from crane_sim.laws import LawError
from crane_sim.recording.metric_units import metric_row
from crane_sim.report.comparison_page import comparison_data
from crane_sim.report.page import save_comparison
from crane_sim.report.page_data import page_data

SHIFT = 0.125  # m, a power of two: sums with it are exact at these magnitudes up to rounding
ACCURACY = 1e-6  # m: positions are quantised to their range / 2^32, the transforms add roundings
INSTANTS = 10
SCRIPT = """() => {
  const { times, link, drawn } = window.crane;
  const at = Array.from({ length: COUNT }, (_, k) => times[Math.round((k * (times.length - 1)) / (COUNT - 1))]);
  const rows = [0, 1].map((crane) => at.map((t) => [t, ...link("payload_link", t, crane)]));
  return {
    text: document.body.innerText, drawn: drawn(), charts: document.querySelectorAll("svg").length, rows,
    wide: document.documentElement.scrollWidth,
  };
}""".replace("COUNT", str(INSTANTS))  # noqa: E501


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> crane_sim.RecordedRun:
    """Record a second of the overhead crane."""
    file = tmp_path_factory.mktemp("runs") / "a.rrd"
    return crane_sim.read_recording(
        crane_sim.simulate("overhead_energy", duration=1.0).record(file)
    )


def shifted(run: crane_sim.RecordedRun, **changes: Any) -> crane_sim.RecordedRun:
    """Return the run with its trolley and payload shifted."""
    q, payload = run.q.copy(), run.payload.copy()
    q[:, 0] += SHIFT
    payload[:, 0] += SHIFT
    return replace(run, q=q, payload=payload, **changes)


def test_a_run_is_itself(run: crane_sim.RecordedRun) -> None:
    """All differences of a run from itself are zero, of metrics and of quantities."""
    comparison = crane_sim.compare(run, run)
    assert set(comparison.metric_differences(1).values()) == {0.0}
    assert {(each.largest, each.rms) for each in comparison.differences[0].values()} == {(0.0, 0.0)}
    assert comparison.names == ("a (1)", "a (2)") and len(comparison.t) == len(run.t)
    bag = replace(run, path=Path("a.mcap"))
    assert crane_sim.compare(run, bag).names == ("a.rrd", "a.mcap")


def test_a_run_that_was_not_in_real_time_is_marked(
    run: crane_sim.RecordedRun, capsys: pytest.CaptureFixture[str]
) -> None:
    """A comparison's outputs name a run that was not in real time; so do its figure and page."""
    late = replace(run, summary=run.summary | {"real_time_violation": "9 of 100 steps were late"})
    line = "not in real time: 9 of 100 steps were late"
    comparison = crane_sim.compare(run, late, names=("a", "b"))
    print_comparison(comparison)
    assert f"b: {line}" in capsys.readouterr().out.splitlines()
    assert comparison.to_dict()["real_time_violation"] == ["", line]
    assert comparison_data(comparison)["real_time_violation"] == f"b: {line}"
    assert (
        page_data(late)["real_time_violation"] == line and not page_data(run)["real_time_violation"]
    )
    assert line in late.plot().get_suptitle() and "real time" not in run.plot().get_suptitle()


def test_a_known_offset_is_found(run: crane_sim.RecordedRun) -> None:
    """A run that is shifted by an offset differs by it where it is shifted, and nowhere else."""
    other = shifted(
        run, summary=run.summary | {"peak_swing_deg": run.summary["peak_swing_deg"] + 0.5}
    )
    comparison = crane_sim.compare(run, other, names=("one", "two"))
    found = {name: each for name, each in comparison.differences[0].items() if each.largest}
    assert found.keys() == {"q.trolley", "payload", "payload.x"}
    for each in found.values():  # the sums round to the last bit of values below 1 m
        assert (
            each.unit == "m" and abs(each.largest - SHIFT) < 1e-15 and abs(each.rms - SHIFT) < 1e-15
        )
    differing = {name: value for name, value in comparison.metric_differences(1).items() if value}
    assert differing == {"peak_swing_deg": 0.5}


def test_metrics_in_other_units_are_not_subtracted(run: crane_sim.RecordedRun) -> None:
    """A run without a metric's joint has no value; one in another unit has no difference.

    Its own value and unit are shown.
    """
    cranes = [
        run.crane._replace(actuated=("hoist",), effort_units=(unit,)) for unit in ("N", "m/s²")
    ]
    force, speed = (replace(run, crane=crane) for crane in cranes)
    none = replace(run, crane=run.crane._replace(actuated=(), effort_units=()))
    runs = none, force, speed, force
    label, unit, texts = metric_row("peak_effort.hoist", runs, (None, 5.0, 2.0, 7.0))
    assert (label, unit, texts) == ("peak effort hoist", "N", ["", "5", "2 m/s²", "7", "", "", ""])
    assert metric_row("peak_effort.hoist", runs[1:], (5.0, 2.0, 7.0))[2] == [
        "5",
        "2 m/s²",
        "7",
        "",
        "2",
    ]
    assert metric_row("law_us.p99", runs[:2], (3.0, 4.0))[:2] == ("law p99", "µs")


def test_quantities_with_gaps_are_named(run: crane_sim.RecordedRun) -> None:
    """A quantity with a gap in one run is named, not compared; the payload's distance is a norm."""
    q, payload = run.q.copy(), run.payload + np.array([0.3, 0.0, 0.4])
    q[5, 1] = np.nan
    comparison = crane_sim.compare(run, replace(run, q=q, payload=payload))
    assert comparison.not_compared == (("q.swing_1",),)
    assert comparison.to_dict()["not_compared"] == [["q.swing_1"]]
    assert comparison.to_dict()["metric_differences"] == [comparison.metric_differences(1)]
    distance = comparison.differences[0]["payload"]
    # roundings
    assert (
        distance.unit == "m"
        and abs(distance.largest - 0.5) < 1e-15
        and abs(distance.rms - 0.5) < 1e-15
    )


def test_runs_of_another_length_and_period_share_their_time(run: crane_sim.RecordedRun) -> None:
    """A run of half the time at half the period is compared up to its end, at common steps."""
    changes = {"control.period": 0.005}
    finer = crane_sim.simulate("overhead_energy", duration=0.5, overrides=changes)
    comparison = crane_sim.compare(run, finer)
    assert comparison.t[-1] == pytest.approx(0.49) and len(comparison.t) == 50
    expected = np.abs(finer.q[:100:2, 0] - run.q[:50, 0]).max()
    largest = comparison.differences[0]["q.trolley"].largest
    assert largest == pytest.approx(expected, rel=1e-12)  # the times of both differ by roundings
    # the coarser run's efforts are held
    held = crane_sim.compare(finer, run).differences[0]["u.trolley"].largest
    assert held == pytest.approx(
        np.abs(finer.u[:100, 0] - np.repeat(run.u[:50, 0], 2))[:99].max(), rel=1e-12
    )
    with pytest.raises(crane_sim.SceneError, match="must be one for each of 2 runs"):
        crane_sim.compare(run, run, names=("one",))
    line = "^compare: needs two runs or more, here is one$"
    with pytest.raises(crane_sim.SceneError, match=line):
        crane_sim.compare(run)


def test_mistakes_are_one_line(run: crane_sim.RecordedRun, tmp_path: Path) -> None:
    """Unlike cranes, other files, and unknown or too few laws are refused before simulation."""
    unlike = replace(run, crane=run.crane._replace(joint_names=("trolley", "swing_2")), path=None)
    with pytest.raises(
        crane_sim.SceneError,
        match="is of trolley, swing_2, a of trolley, swing_1: only runs of one crane",
    ):
        crane_sim.compare(run, unlike)
    for arguments, line in (
        ((str(run.path), str(run.path), "-o", str(tmp_path / "a.txt")), "must end in .html"),
        (("overhead_energy", "--laws", "energy"), "must be two different laws or more"),
        (
            ("overhead_energy", "overhead_lqr", "--laws", "energy,lqr"),
            "takes one SCENE, here are 2",
        ),
        (("overhead_energy", "--laws", "energy,nope"), "control.law = 'nope': no such law"),
    ):
        with pytest.raises(crane_sim.SceneError, match=line):
            app(["compare", *arguments], standalone_mode=False)


def test_the_command_compares_laws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Both laws of a scene are simulated, their metrics are side by side, the page is written."""
    file = tmp_path / "both.html"
    source = tmp_path / "short.yaml"
    crane_sim.load_scene("overhead_energy", {"duration": 0.3}).dump(source)
    app(["compare", str(source), "--laws", "energy,lqr", "-o", str(file)], standalone_mode=False)
    shown = capsys.readouterr().out
    assert "lqr − energy" in shown and "q.trolley" in shown and file.name in shown.replace("\n", "")
    rows = [re.split(r"\s{2,}", line.strip()) for line in shown.splitlines()]
    units = {row[0]: row[-1] for row in rows}
    assert "at [s]" in shown
    expected = {
        "peak swing": "deg",
        "final error trolley": "m",
        "peak effort trolley": "N",
        "max rope tension": "N",
    }
    assert expected.items() <= units.items()
    assert file.stat().st_size < 2_000_000


def test_a_law_that_fails_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of several laws on a scene, one that raises an error is named, the others are compared."""
    law = f"{tmp_path / 'mine.py'}:law"
    (tmp_path / "mine.py").write_text("def law(t, q, v):\n    raise ValueError('no plan')\n")
    crane_sim.load_scene("overhead_energy", {"duration": 0.1}).dump(tmp_path / "short.yaml")
    line = f"^law '{law}': the law failed at t = 0 s: ValueError: no plan$"
    with pytest.raises(LawError, match=line):
        app(
            ["compare", str(tmp_path / "short.yaml"), "--laws", f"energy,{law}"],
            standalone_mode=False,
        )
    assert not capsys.readouterr().out  # one run is left, which is no comparison
    with pytest.raises(LawError, match=line):
        app(
            ["compare", str(tmp_path / "short.yaml"), "--laws", f"energy,{law},lqr"],
            standalone_mode=False,
        )
    assert "lqr − energy" in capsys.readouterr().out


def test_names_in_brackets_are_shown(
    run: crane_sim.RecordedRun,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The terminal shows the names of files as they are, also those that look like markup."""
    assert run.path is not None
    files = [str(shutil.copy(run.path, tmp_path / f"run[{name}].rrd")) for name in ("new", "old")]
    monkeypatch.setenv("COLUMNS", "200")
    app(["compare", *files], standalone_mode=False)
    shown = capsys.readouterr().out
    assert "run[old] − run[new]" in shown and "differences from run[new]" in shown
    assert re.search(r"^ run\[old\]  ", shown, re.MULTILINE)


@pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
def test_the_page_shows_all_runs(run: crane_sim.RecordedRun, tmp_path: Path) -> None:
    """In a browser the page draws and names both cranes in place, without fault or request."""
    other = crane_sim.read_recording(
        crane_sim.simulate("overhead_lqr", duration=1.0).record(tmp_path / "b.rrd")
    )
    save_comparison(crane_sim.compare(run, other, names=("one", "two")), tmp_path / "page.html")
    answer = evaluate_in_pages({"page": (tmp_path / "page.html").read_text()}, SCRIPT, tmp_path)[
        "page"
    ]
    assert not answer["faults"] and not answer["requests"]
    shown = answer["answer"]
    # of eight quantities or more
    assert shown["drawn"] and shown["charts"] >= 8 and shown["wide"] <= 900
    assert all(word in shown["text"] for word in ("one", "two", "two − one", "comparison"))
    for each, rows in zip((run, other), map(np.array, shown["rows"]), strict=True):
        at = np.searchsorted(each.t, rows[:, 0] - 0.5 * each.period)
        assert len(np.unique(at)) == INSTANTS
        assert np.abs(rows[:, 1:] - each.payload[at]).max() < ACCURACY
    # the second crane is not the first one again
    assert np.abs(run.payload - other.payload).max() > 1e-3


def test_a_run_without_steps_is_not_blamed_on_its_recorder() -> None:
    """A run that fails before its first step is not compared, and the line says why it failed."""
    push = {
        "control": None,
        "reference": None,
        "inputs": {"trolley": {"kind": "constant", "value": 1e3}},
    }
    with pytest.raises(crane_sim.SimulationError) as failed:
        crane_sim.simulate("overhead_energy", overrides=push | {"trolley.limits": [-1.0, 1e-6]})
    run = failed.value.run
    assert run is not None and run.summary["steps"] == 0
    with pytest.raises(
        crane_sim.SceneError, match="compare: a run of overhead_energy has no steps: stopped at"
    ):
        crane_sim.compare(run, run)
