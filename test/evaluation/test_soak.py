"""The soaks in short: what they measure is right, what was promised is judged, and their page says it."""

import json
import random
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from crane_sim.cli.soak import soak
from crane_sim.evaluation.soak import inprocess, memory, realtime
from crane_sim.evaluation.soak.drift import MAX_FALL, drift, drift_figures
from crane_sim.evaluation.soak.figures import Figure, at_least, at_most, equal
from crane_sim.evaluation.soak.store import save_findings, thin_lists, write_page
from crane_sim.files.errors import SceneError

STEPS = 20_000


def noisy_rates(fall: float) -> list[float]:
    """Return 900 rates that lose so much [%] by the end, on a machine that halves every tenth of them for a while."""
    draw = random.Random(7)
    rates = [1000.0 * (1.0 - 0.01 * fall * i / 899) * draw.uniform(0.9, 1.1) for i in range(900)]
    for begin in (40, 400, 860):
        rates[begin : begin + 30] = [0.5 * rate for rate in rates[begin : begin + 30]]
    return rates


@pytest.mark.parametrize("fall", [0.0, 10.0, -10.0])
def test_a_drift_is_told_from_noise(fall: float) -> None:
    """A rate that falls by 10 % is found out, one that stays or grows is not, beside noise of 10 % and disturbances."""
    found = drift(noisy_rates(fall))
    assert found.low < -fall < found.high
    assert found.change == pytest.approx(-fall, abs=3.0)  # %: noise of 10 % over 30 medians of 30 leaves about 0.9 %
    assert [figure.kept for figure in drift_figures(noisy_rates(fall))] == [True, fall < MAX_FALL, True]


def test_a_drift_that_cannot_be_told_has_a_wide_interval() -> None:
    """Where a machine is so restless that nothing follows from the change, the figure beside it says so."""
    draw = random.Random(3)
    assert drift_figures([draw.uniform(500.0, 1500.0) for _ in range(30)])[-1].value > MAX_FALL


def test_steps_without_ros_leave_no_memory_behind() -> None:
    """Neither way of simulating grows over twenty thousand steps, and each is looked at in equal blocks to the end."""
    figures, data = inprocess.soak(STEPS)
    assert set(data) == {"Plant.advance", "simulate"}
    for way, found in data.items():
        named = {figure.what: figure for figure in figures}
        growth = named[f"{way}, growth of resident memory"]
        assert growth.kept and growth.value == found["memory_MB"][-1] - found["memory_MB"][0]
        assert named[f"{way}, steps"].value == STEPS == found["steps"][-1]
        assert len(found["memory_MB"]) == len(found["steps_per_second"]) == inprocess.BLOCKS
        assert min(found["steps_per_second"]) > 0.0


def test_a_run_over_ros_is_watched_to_its_end() -> None:
    """A few seconds of lockstep: every node is looked at as often as the rate, and growth is judged for each."""
    figures, data = memory.soak(6.0)
    named = {figure.what: figure for figure in figures}
    assert set(data["memory_MB"]) == {"plant", "controller", "recorder"}
    for node, samples in data["memory_MB"].items():
        growth = named[f"{node}, growth since"]
        assert len(samples) == len(data["seconds"]) == len(data["steps_per_second"]) >= 4
        warm = next(mb for t, mb in zip(data["seconds"], samples, strict=True) if t >= 2.0)
        assert growth.value == pytest.approx(samples[-1] - warm, abs=2e-3)  # MB: they are rounded to 1e-3
        assert growth.kept == (growth.value <= memory.GROWTH)
    assert named["steps"].value > sum(data["steps_per_second"][:3])  # they took about a second each
    assert named["plant, growth since"].kept  # the recorder's buffers still fill in the first seconds


def test_overruns_are_those_that_a_subscriber_counts() -> None:
    """At 1 kHz the plant's own count of overruns is that of a subscriber, which only knows the times of sending."""
    figures, data = realtime.soak(3.0)
    named = {figure.what: figure for figure in figures}
    (plant,) = data["plant"]
    assert plant["steps"] == 3000
    assert named["overruns, the plant's own count"].value == plant["deadline_misses"]
    assert named["overruns, the subscriber's count"].value == sum(data["counted"])
    (counted,), (unclear,) = data["counted"], data["unclear"]
    # 3 of 3000: a machine that stalls a step behind its last message
    assert counted <= plant["deadline_misses"] <= counted + unclear + 3


KEPT, BROKEN = at_most("growth", 1.25, 5.0, "MB"), equal("different state_sha256", 2, 1)


def test_the_page_has_all_parts_that_were_measured(tmp_path: Path) -> None:
    """A part that is saved joins those that are there, in the page's order, with its promises, kept or not."""
    save_findings("determinism", "crane soak determinism --count 4", [Figure("runs", 4), BROKEN], {}, tmp_path)
    alone = (tmp_path / "soak.md").read_text()
    back = {"back_s": [0.25, float("inf"), 0.3]}
    save_findings("kill", "crane soak kill --count 6 --seed 0", [KEPT, Figure("back", float("inf"))], back, tmp_path)
    text = (tmp_path / "soak.md").read_text()
    assert text.endswith(alone[alone.index("## One scene") :])
    assert text.index("## Nodes that are killed") < text.index("## One scene, one run")
    assert "`crane soak kill --count 6 --seed 0`" in text and "![Nodes that are killed](soak/kill.png)" in text
    assert "| growth | 1.25 MB | at most 5 MB | yes |" in text and "| back | — |  |  |" in text
    assert "| runs | 4 |  |  |" in alone and "| different state_sha256 | 2 | 1 | **no** |" in alone
    assert (tmp_path / "soak" / "kill.png").stat().st_size > 0
    write_page(tmp_path)
    assert (tmp_path / "soak.md").read_text() == text


def series(length: int) -> list[float]:
    """Return a series with a begin, an end and something between."""
    return [float(i) for i in range(length)]


SAMPLES = {"steps": series(9), "memory_MB": series(9), "steps_per_second": series(9)}


@pytest.mark.parametrize(
    ("part", "data"),
    [
        ("memory", {"seconds": series(9), "steps_per_second": series(9), "memory_MB": {"plant": series(9)}}),
        ("inprocess", {"Plant.advance": SAMPLES, "simulate": SAMPLES}),
        ("signals", {"at": series(3), "took": series(3), "fresh": [True, False, True], "code": [1, 0, 1]}),
    ],
)
def test_plots_need_only_the_saved_data(part: str, data: dict[str, Any], tmp_path: Path) -> None:
    """Each part's plot can be drawn of the data that are saved of it, and of nothing else."""
    save_findings(part, f"crane soak {part}", [KEPT], data | {"more": series(5)}, tmp_path)
    assert (tmp_path / "soak" / f"{part}.png").stat().st_size > 0
    assert json.loads((tmp_path / "soak" / f"{part}.json").read_text())["data"] == data


def test_long_series_are_thinned_alike() -> None:
    """Of lists of one length the same entries are kept, first and last among them; short ones stay as they are."""
    found = thin_lists({"a": series(1800), "b": {"c": series(1800)}, "d": series(5)})
    assert found["a"] == found["b"]["c"] and len(found["a"]) == 100
    assert (found["a"][0], found["a"][-1]) == (0.0, 1799.0) and found["a"] == sorted(set(found["a"]))
    assert found["d"] == series(5)


def test_other_files_are_no_data_of_a_soak(tmp_path: Path) -> None:
    """A folder without data, and a file of another shape, are told in one line that names them."""
    with pytest.raises(SceneError, match=f"{tmp_path}: has no data of a soak yet"):
        write_page(tmp_path)
    (tmp_path / "soak").mkdir()
    (tmp_path / "soak" / "kill.json").write_text('{"figures": 3}')
    with pytest.raises(SceneError, match=r"kill\.json: cannot be read as data of a soak"):
        write_page(tmp_path)


def test_a_broken_promise_is_an_exit_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command ends with 1 where a promise was not kept, prints so, and saves what it found all the same."""
    found = [at_least("rate", 0.5, 1.0, "Hz"), KEPT]
    monkeypatch.setattr("crane_sim.evaluation.soak.determinism.soak", lambda count: (found[:], {}))
    arguments = ["determinism", "--count", "4", "--save", str(tmp_path)]
    done = CliRunner().invoke(soak, arguments)
    assert done.exit_code == 1 and "at least 1 Hz  not kept" in done.output
    assert "`crane soak determinism --count 4`" in (tmp_path / "soak.md").read_text()
    del found[0]
    assert CliRunner().invoke(soak, arguments).exit_code == 0
    assert "**no**" not in (tmp_path / "soak.md").read_text()
