"""The figure of a run: axes by curve size, each with a unit, and one colour for each joint."""

from pathlib import Path

import numpy as np
import pytest

import crane_sim
from crane_sim.recording.layout import layout_of_scene
from crane_sim.recording.read import as_recorded
from crane_sim.recording.rerun.curves import efforts, rates
from crane_sim.recording.run import RecordedRun
from crane_sim.report.decimation import encode_columns, rows_with_peaks
from crane_sim.report.figure import comparison_figure, save_run_figure
from crane_sim.report.panels import MIN_SPAN_FRACTION, panels_of
from crane_sim.scenes.scene import load_scene


@pytest.fixture(scope="module")
def run() -> RecordedRun:
    """Return a short run."""
    return as_recorded(crane_sim.simulate("knuckle_setpoint", duration=0.5))


def test_every_axis_has_a_unit(run: RecordedRun) -> None:
    """Every panel of the figure has a time axis in s, or a path in m, and its own unit."""
    axes = [axis for axis in run.plot().axes if axis.axison]
    assert len(axes) > 10
    for axis in axes:
        assert axis.get_xlabel() == "time [s]" or axis.get_xlabel().endswith("[m]")
        assert axis.get_ylabel().endswith("]") and axis.get_title(loc="left")


def test_curves_of_different_size_have_their_own_axis(run: RecordedRun) -> None:
    """A moving curve spans at least a tenth of its axis; a joint has one colour in all panels."""
    colors: dict[str, set[str]] = {}
    for panel in panels_of(run):
        whole = np.ptp(np.concatenate([curve.values for curve in panel.curves]))
        joints = {curve.name.split(" ")[0] for curve in panel.curves}
        if len(joints) > 1 and whole > 0.0:
            for joint in joints:
                values = [
                    curve.values for curve in panel.curves if curve.name.split(" ")[0] == joint
                ]
                assert np.ptp(np.concatenate(values)) >= MIN_SPAN_FRACTION * whole, (
                    panel.title,
                    joint,
                )
        for curve in panel.curves:
            colors.setdefault(curve.name.split(" ")[0], set()).add(curve.color)
    assert all(len(colors[joint]) == 1 for joint in run.crane.actuated)


def test_figures_are_files_of_their_kind(
    run: RecordedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """PNG, PDF and SVG begin as such files do; another kind is refused."""
    # seconds of drawing less
    monkeypatch.setattr("crane_sim.report.figure.panels_of", lambda run: panels_of(run)[:1])
    for kind, head in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")):
        save_run_figure(run, tmp_path / f"run.{kind}")
        assert Path(tmp_path, f"run.{kind}").read_bytes().startswith(head)
    with pytest.raises(crane_sim.SceneError, match=r"must end in \.png, \.pdf, \.svg"):
        save_run_figure(run, tmp_path / "run.gif")


def test_peaks_stay() -> None:
    """A single outlier of a long curve is among the rows that are kept, and so are its ends."""
    values = np.sin(np.arange(100_000.0))
    values[12_345], values[54_321] = 5.0, -7.0
    rows = rows_with_peaks(values, 1000)
    assert {0, 12_345, 54_321, 99_999} <= set(rows.tolist()) and len(rows) <= 1002
    assert np.array_equal(rows_with_peaks(values[:10], 1000), np.arange(10))
    values[70_000:70_003] = np.nan  # a short gap: it would be bridged by a line
    assert 70_000 in rows_with_peaks(values, 1000)


def test_integers_keep_nine_digits() -> None:
    """Encoded columns return within 2^-32 of their range, constants exactly, without integers."""
    from base64 import b64decode

    columns = np.column_stack(
        [np.linspace(-80.0, 120.0, 50), np.full(50, 3.25), np.geomspace(1.0, 1e-3, 50)]
    )
    encoded = encode_columns(columns)
    integers = np.frombuffer(b64decode(encoded["data"]), "<i4").reshape(2, 50)
    (o0, s0), (o1, s1), (o2, s2) = encoded["scales"]
    assert (o1, s1) == (3.25, 0.0)
    assert np.abs(o0 + s0 * integers[0] - columns[:, 0]).max() <= 200.0 / 2**32 + 1e-13
    assert np.abs(o2 + s2 * integers[1] - columns[:, 2]).max() <= 1.0 / 2**32 + 1e-13


def test_runs_share_panels_and_one_legend() -> None:
    """Each panel of several runs has one curve a run over its own times, named in one legend."""
    runs = [
        crane_sim.simulate("overhead_energy", duration=0.2, overrides={"payload.mass": m})
        for m in (8.0, 11.0)
    ]
    both = crane_sim.compare(*runs, names=("light", "heavy"))
    figure = comparison_figure(both)
    assert [text.get_text() for each in figure.legends for text in each.get_texts()] == [
        "light",
        "heavy",
    ]
    panels = {axis.get_title(loc="left"): axis for axis in figure.axes if axis.lines}
    assert "Payload y" not in panels and all(len(axis.lines) == 2 for axis in panels.values())
    for line, run in zip(panels["Trolley"].lines, both.runs, strict=True):
        assert np.array_equal(line.get_xdata(), run.t) and np.array_equal(
            line.get_ydata(), run.q[:, 0]
        )


def test_viewer_and_page_name_quantities_alike(run: RecordedRun) -> None:
    """Quantities with a viewer plot per unit have its title and unit in figure and page."""
    layout = layout_of_scene(load_scene(run.name), "run")
    viewer = {plot.title for quantity in (rates, efforts) for plot in quantity(layout)}
    panels = {
        f"{panel.title.partition(':')[0]} [{panel.unit.removeprefix('k')}]"
        for panel in panels_of(run)
    }
    assert viewer and viewer <= panels
