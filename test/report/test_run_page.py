"""The page of a run shows what was recorded, for every kind of crane, and makes no request."""

import json
import re
from base64 import b64decode
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, NO_CHROMIUM, evaluate_in_pages

import crane_sim
from crane_sim.files.catalogue import scene_files
from crane_sim.recording.layout import FRAME_NS
from crane_sim.recording.read import as_recorded
from crane_sim.recording.run import RecordedRun
from crane_sim.report.page import page, save_page
from crane_sim.report.page_data import page_data

SIZE = 2_000_000  # bytes of a page at most
ACCURACY = 1e-6  # m: positions are quantised to their range / 2^32, the transforms add roundings
INSTANTS = 10
# of other files
LOADS = r"""<(?:script|img|link|iframe)[^>]*(?:src|href)=|@import|url\(\s*["']?(?!data:)"""
SCENES = {
    "knuckle": ("knuckle_sea", 0.5),
    "overhead": ("overhead_energy", 0.4),
    "gantry": ("port_sts_container", 0.6),
}
"""A crane on a ship, an overhead crane, and one with falls; the long test has the catalogue but for
`SLOW`."""
SLOW = {"overhead_long_cable", "overhead_steel", "pendulum_sea"}  # minutes without compilation
CATALOGUE = sorted(scene_files().keys() - SLOW)
PAGES_PER_BROWSER = 8  # it keeps at most 16 WebGL contexts
PUSHED: dict[str, Any] = {  # the point reaches its limit after three seconds: x = t² / 2
    "duration": 3.5,
    "initial": {"direction": [0.0, 0.0, -1.0]},
    "inputs": {"tip_x": {"kind": "constant", "value": 1.0}},
    "suspension.limits": {"x": [-1.0, 4.5]},
}
LATE = "9 of 100 steps were late, and 3 had no new command"
SCRIPT = """() => {
  const { times, payload, tip, link, drawn } = window.crane, rows = [];
  for (let k = 0; k < COUNT; k++) {
    const t = times[Math.round((k * (times.length - 1)) / (COUNT - 1))];
    rows.push([t, ...payload(t), ...tip(t), ...link("payload_link", t)]);
  }
  return { rows, drawn: drawn(), text: document.body.innerText, wide: document.documentElement.scrollWidth };
}""".replace("COUNT", str(INSTANTS))  # noqa: E501


def record_run(scene: str, duration: float) -> RecordedRun:
    """Return a short run as its recording has it."""
    return as_recorded(crane_sim.simulate(scene, duration=duration))


def record_failed_run() -> RecordedRun:
    """Return a run that ended where its suspension point ran into its limit."""
    with pytest.raises(crane_sim.SimulationError) as error:
        crane_sim.simulate("pendulum_free", overrides=PUSHED)
    return as_recorded(error.value.run)


@pytest.fixture(scope="module")
def runs() -> dict[str, RecordedRun]:
    """Return short runs, and one that fails."""
    found = {name: record_run(*each) for name, each in SCENES.items()} | {
        "failed": record_failed_run()
    }
    found["gantry"].summary["real_time_violation"] = LATE
    return found


@pytest.fixture(scope="module")
def answers(
    runs: dict[str, RecordedRun], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """Open all pages in a browser and return what they say."""
    if CHROMIUM is None:
        pytest.skip(NO_CHROMIUM)
    return evaluate_in_pages(
        {name: page(run) for name, run in runs.items()}, SCRIPT, tmp_path_factory.mktemp("pages")
    )


def check_positions(runs: dict[str, RecordedRun], answers: dict[str, Any]) -> None:
    """Check that payload, tip, and the payload's drawn solid are where the recordings have them."""
    for name, run in runs.items():
        rows = np.array(answers[name]["answer"]["rows"])
        at = np.searchsorted(run.t, rows[:, 0] - 0.5 * run.period)
        assert len(np.unique(at)) == INSTANTS and answers[name]["answer"]["drawn"]
        for drawn, known in (
            (rows[:, 1:4], run.payload),
            (rows[:, 4:7], run.tip),
            (rows[:, 7:], run.payload),
        ):
            assert np.abs(drawn - known[at]).max() < ACCURACY, name


def check_quiet(answers: dict[str, Any]) -> None:
    """Check that no page logs errors or warnings, sends requests, or is wider than its window."""
    for name, answer in answers.items():
        assert answer["faults"] == [] and answer["requests"] == [], name
        assert answer["answer"]["wide"] <= 900, name


def test_positions_are_those_of_the_recording(
    runs: dict[str, RecordedRun], answers: dict[str, Any]
) -> None:
    """Payload, tip, and the payload's drawn solid are where the recording has them."""
    check_positions(runs, answers)


def test_pages_are_self_contained_and_without_errors(answers: dict[str, Any]) -> None:
    """Pages are self-contained: no request, error or warning; none is wider than its window."""
    check_quiet(answers)


@pytest.mark.long
@pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
@pytest.mark.parametrize("first", range(0, len(CATALOGUE), PAGES_PER_BROWSER))
def test_pages_of_the_catalogue(first: int, tmp_path: Path) -> None:
    """The same of the scenes of the catalogue but for `SLOW`: positions, no error, no request."""
    runs = dict[str, RecordedRun]()
    for name in CATALOGUE[first : first + PAGES_PER_BROWSER]:
        scene = crane_sim.load_scene(name)
        frames = (INSTANTS + 1) * max(scene.period, 1e-9 * FRAME_NS)  # s
        runs[name] = record_run(name, min(scene.duration, frames))
    answers = evaluate_in_pages({name: page(run) for name, run in runs.items()}, SCRIPT, tmp_path)
    check_positions(runs, answers)
    check_quiet(answers)


def test_a_run_that_was_not_in_real_time_says_so(answers: dict[str, Any]) -> None:
    """The page of a run on a too slow machine begins with a line on it; others have none."""
    assert f"not in real time: {LATE};" in answers["gantry"]["answer"]["text"][:600]
    assert not any(
        "real time" in answers[name]["answer"]["text"][:600]
        for name in ("knuckle", "overhead", "failed")
    )


def test_a_failed_run_says_why(runs: dict[str, RecordedRun], answers: dict[str, Any]) -> None:
    """The page of a failed run begins with the cause, the one of another run has no such line."""
    assert "reached its travel limit" in runs["failed"].error and not runs["failed"].finished
    assert runs["failed"].error in answers["failed"]["answer"]["text"][:600]
    assert "stopped" not in answers["knuckle"]["answer"]["text"]


def test_pages_name_what_made_them(runs: dict[str, RecordedRun]) -> None:
    """A page holds scene text, versions and the states' hash, and loads nothing from elsewhere."""
    for run in runs.values():
        text = page(run)
        assert run.versions["numpy"] in text and run.summary["state_sha256"] in text
        assert json.dumps(run.scene_text, ensure_ascii=True) in text
        assert len(text) < SIZE and not re.search(LOADS, text)


def test_markup_of_a_scene_s_text_is_no_part_of_the_page(runs: dict[str, RecordedRun]) -> None:
    """Whatever a description says, a page's script elements end in place: its data have no <."""
    (run, *_) = runs.values()
    text = page(
        replace(
            run, properties=run.properties | {"scene_file": run.scene_text + "# <!-- <script>\n"}
        )
    )
    data = text.split('type="application/json"', 1)[1].split("</script>", 1)[0]
    assert "<" not in data.split(">", 1)[1] and "u003c!-- " in data


def test_a_long_run_stays_small(runs: dict[str, RecordedRun], tmp_path: Path) -> None:
    """A run of ten minutes at 100 Hz gives a page below 2 MB that keeps a curve's peaks."""
    run = lengthen(runs["knuckle"], 60_000)
    save_page(run, tmp_path / "long.html")
    assert (tmp_path / "long.html").stat().st_size < SIZE
    panel = next(
        panel for panel in page_data(run)["panels"] if panel["title"].startswith("Rope tension")
    )
    shown = np.frombuffer(b64decode(panel["curves"][0]["values"]), "<f4")
    assert len(shown) < 2000 and shown.max() == np.float32(run.tension.max())
    assert shown.min() == np.float32(run.tension.min())


def lengthen(run: RecordedRun, steps: int) -> RecordedRun:
    """Return a run of this many steps with noise for its motion, the worst to store."""
    random, stride = np.random.default_rng(1), 3
    count = len(range(0, steps, stride))
    names = "q v u commands reference tip payload tensions swing kinetic potential base".split()
    longer = {name: random.normal(size=(steps, *getattr(run, name).shape[1:])) for name in names}
    t = run.period * np.arange(steps)
    nodes = random.normal(size=(count, *run.frames.nodes.shape[1:]))
    frames = run.frames._replace(t=t[::stride], nodes=nodes, target=random.normal(size=(count, 3)))
    return replace(run, t=t, frames=frames, lyapunov=None, **longer)
