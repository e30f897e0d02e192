"""The soak tests in short: their metrics, the verdicts on their requirements, and their page."""

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from crane_bench.cli.soak import soak
from crane_bench.soak import inprocess, memory, realtime
from crane_bench.soak.drift import MAX_FALL, drift, drift_metrics
from crane_bench.soak.metrics import Metric, at_least, at_most, equal
from crane_bench.soak.store import save_findings, thin_lists, write_page
from crane_sim.files.errors import SceneError

STEPS = 20_000


def noisy_rates(fall: float) -> list[float]:
    """Return 900 rates that lose `fall` [%] by the end.

    A tenth of them is halved by a disturbance of the machine.
    """
    draw = random.Random(7)
    rates = [1000.0 * (1.0 - 0.01 * fall * i / 899) * draw.uniform(0.9, 1.1) for i in range(900)]
    for begin in (40, 400, 860):
        rates[begin : begin + 30] = [0.5 * rate for rate in rates[begin : begin + 30]]
    return rates


@pytest.mark.parametrize("fall", [0.0, 10.0, -10.0])
def test_a_drift_is_distinguished_from_noise(fall: float) -> None:
    """A rate that falls by 10 % is detected, one that stays or grows is not.

    There is noise of 10 %, and disturbances.
    """
    trend = drift(noisy_rates(fall))
    assert trend.low < -fall < trend.high
    # %: noise of 10 % over 30 medians of 30 leaves about 0.9 %
    assert trend.change == pytest.approx(-fall, abs=3.0)
    passed = [metric.passed for metric in drift_metrics(noisy_rates(fall), [1e7] * 900)]
    assert passed == [True, True, True, fall < MAX_FALL, True]


@pytest.mark.parametrize("fall", [0.0, 10.0])
def test_the_processor_s_clock_is_no_drift(fall: float) -> None:
    """A clock that falls by 30 % takes its share of a rate; further losses are detected."""
    clock = [1.0 - 0.3 * i / 899 for i in range(900)]
    rates = [rate * share for rate, share in zip(noisy_rates(fall), clock, strict=True)]
    named = {
        metric.what: metric for metric in drift_metrics(rates, [2e7 * share for share in clock])
    }
    assert named["rate, change from begin to end"].value < -25.0
    of_clock = named["processor's speed, change from begin to end"].value
    # % of 0.85; the medians of the ends are 29 / 30 of it apart
    assert of_clock == pytest.approx(-34.2, abs=0.3)
    judged = named["rate at constant speed, change from begin to end"]
    assert judged.value == pytest.approx(-fall, abs=3.0)  # %: see above
    assert judged.passed == (fall < MAX_FALL)


def test_steps_without_ros_leak_no_memory() -> None:
    """Neither way of simulating grows over twenty thousand steps.

    Each is sampled in equal blocks to the end.
    """
    metrics, data = inprocess.soak_inprocess(STEPS)
    assert set(data) == {"Plant.advance", "simulate"}
    for method, samples in data.items():
        named = {metric.what: metric for metric in metrics}
        growth = named[f"{method}, growth of resident memory"]
        assert growth.passed and growth.value == samples["memory_MB"][-1] - samples["memory_MB"][0]
        assert named[f"{method}, steps"].value == STEPS == samples["steps"][-1]
        assert len(samples["memory_MB"]) == len(samples["steps_per_second"]) == inprocess.BLOCKS
        assert min(samples["steps_per_second"]) > 0.0


@pytest.mark.long
def test_a_run_over_ros_is_sampled_to_its_end() -> None:
    """In a few seconds of lockstep every node is sampled as often as the rate.

    Growth is judged for each.
    """
    metrics, data = memory.soak_memory(6.0)
    named = {metric.what: metric for metric in metrics}
    assert set(data["memory_MB"]) == {"plant", "controller", "recorder"}
    for node, samples in data["memory_MB"].items():
        growth = named[f"{node}, growth since the warm-up"]
        assert len(samples) == len(data["seconds"]) == len(data["steps_per_second"]) >= 4
        warm = next(mb for t, mb in zip(data["seconds"], samples, strict=True) if t >= 2.0)
        assert growth.value == pytest.approx(samples[-1] - warm, abs=1e-9)
        assert growth.passed == (growth.value <= memory.MAX_GROWTH)
    # s; samples that a stall has delayed follow one another quickly
    lengths = np.diff([0.0, *data["seconds"]])
    assert named["steps"].value > lengths @ data["steps_per_second"] > 0.0
    # the recorder's buffers still fill in the first seconds
    assert named["plant, growth since the warm-up"].passed


def test_the_mean_rate_is_that_of_all_messages() -> None:
    """A late last message keeps the rate of ten seconds at 1 kHz.

    A clock that runs fast changes it, by as much.
    """
    sent = [1_000_000_000 + 1_000_000 * k for k in range(10_001)]
    assert realtime.mean_rate(sent) == pytest.approx(1000.0, rel=1e-12)
    late = [*sent[:-1], sent[-1] + 2_000_000]
    # Hz: 6 / 10 001 of the 0.2 Hz of the ends alone
    assert realtime.mean_rate(late) == pytest.approx(1000.0, abs=2e-4)
    fast = [1_000_000_000 + 999_900 * k for k in range(10_001)]
    # Hz: 1 / 0.9999 is 1.00010001
    assert realtime.mean_rate(fast) == pytest.approx(1000.1, abs=1e-4)


@pytest.mark.long
def test_overruns_are_those_that_a_subscriber_counts() -> None:
    """At 1 kHz the plant's count of overruns is that of a subscriber.

    The subscriber only has the times of sending.
    """
    for _ in range(
        5
    ):  # a busy machine holds steps up after their last message, which only the plant can count
        metrics, data = realtime.soak_real_time(3.0)
        if (
            data["monitored"][0]["deadline_misses"]
            <= data["counted"][0] + data["near_deadline"][0] + 3
        ):
            break
    named = {metric.what: metric for metric in metrics}
    (plant,) = data["monitored"]
    assert plant["steps"] == 3000
    assert named["overruns beside the monitor, the plant's count"].value == plant["deadline_misses"]
    assert named["overruns beside the monitor, its count"].value == sum(data["counted"])
    (counted,), (near_deadline,) = data["counted"], data["near_deadline"]
    # 3 of 3000: steps delayed after their last message is sent, which only the plant can count
    assert counted <= plant["deadline_misses"] <= counted + near_deadline + 3


KEPT, NOT_KEPT = at_most("growth", 1.25, 5.0, "MB"), equal("different state_sha256", 2, 1)


def test_the_page_has_all_parts_that_were_measured(tmp_path: Path) -> None:
    """A saved part is added to the page's others, in order, with requirements passed or not."""
    save_findings(
        "determinism",
        "crane soak determinism --count 4",
        [Metric("runs", 4), NOT_KEPT],
        {},
        tmp_path,
    )
    alone = (tmp_path / "soak.md").read_text()
    back = {"back_s": [0.25, float("inf"), 0.3]}
    save_findings(
        "kill",
        "crane soak kill --count 6 --seed 0",
        [KEPT, Metric("back", float("inf"))],
        back,
        tmp_path,
    )
    text = (tmp_path / "soak.md").read_text()
    assert text.endswith(alone[alone.index("## One scene") :])
    assert text.index("## Nodes that are killed") < text.index("## One scene, one run")
    assert (
        "`crane soak kill --count 6 --seed 0`" in text
        and "![Nodes that are killed](soak/kill.png)" in text
    )
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
        (
            "memory",
            {
                "seconds": series(9),
                "steps_per_second": series(9),
                "memory_MB": {"plant": series(9)},
            },
        ),
        ("inprocess", {"Plant.advance": SAMPLES, "simulate": SAMPLES}),
        (
            "signals",
            {"at": series(3), "took": series(3), "fresh": [True, False, True], "code": [1, 0, 1]},
        ),
    ],
)
def test_plots_need_only_the_saved_data(part: str, data: dict[str, Any], tmp_path: Path) -> None:
    """Each part's plot can be drawn from its saved data alone."""
    save_findings(part, f"crane soak {part}", [KEPT], data | {"more": series(5)}, tmp_path)
    assert (tmp_path / "soak" / f"{part}.png").stat().st_size > 0
    assert json.loads((tmp_path / "soak" / f"{part}.json").read_text())["data"] == data


def test_long_series_are_thinned_alike() -> None:
    """Lists of one length keep the same entries, the first and the last; short ones stay."""
    thinned = thin_lists({"a": series(1800), "b": {"c": series(1800)}, "d": series(5)})
    assert thinned["a"] == thinned["b"]["c"] and len(thinned["a"]) == 100
    assert (thinned["a"][0], thinned["a"][-1]) == (0.0, 1799.0) and thinned["a"] == sorted(
        set(thinned["a"])
    )
    assert thinned["d"] == series(5)


def test_other_files_are_no_data_of_a_soak(tmp_path: Path) -> None:
    """A folder without data, and a file of another shape, are single-line errors."""
    with pytest.raises(SceneError, match=f"{tmp_path}: has no data of a soak yet"):
        write_page(tmp_path)
    (tmp_path / "soak").mkdir()
    (tmp_path / "soak" / "kill.json").write_text('{"metrics": 3}')
    with pytest.raises(SceneError, match=r"kill\.json: cannot be read as data of a soak"):
        write_page(tmp_path)


def test_a_requirement_not_passed_is_an_exit_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The command exits with 1 if a requirement fails, prints that, and saves its metrics."""
    metrics = [at_least("rate", 0.5, 1.0, "Hz"), KEPT]
    monkeypatch.setattr(
        "crane_bench.soak.determinism.soak_determinism", lambda count: (metrics[:], {})
    )
    arguments = ["determinism", "--count", "4", "--save", str(tmp_path)]
    result = CliRunner().invoke(soak, arguments)
    assert result.exit_code == 1 and "at least 1 Hz  failed" in result.output
    assert "`crane soak determinism --count 4`" in (tmp_path / "soak.md").read_text()
    del metrics[0]
    assert CliRunner().invoke(soak, arguments).exit_code == 0
    assert "**no**" not in (tmp_path / "soak.md").read_text()
