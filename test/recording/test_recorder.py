"""The recorder assembles a run from messages in any order between topics, and counts lost steps."""

import json
import os
import random
import subprocess
import sys
import warnings
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr
from process_helpers import run_to_completion, wait_until
from recorder_helpers import PERIOD, SCENE, fail_full_disk, feed
from rerun.chunk import RrdReader

from crane_sim import read_recording
from crane_sim.recording.completeness import COMPLETE
from crane_sim.recording.files import existing_parts
from crane_sim.recording.rerun.live import live_address
from crane_sim.recording.rerun.reader import read_curves, read_summary
from crane_sim.recording.rerun.recorder import Recorder
from crane_sim.recording.rerun.repair import EarlierFiles, repair
from crane_sim.recording.rerun.viewer import free_ports, rerun_executable
from crane_sim.recording.rerun.writer import RunWriter
from crane_sim.recording.step_assembler import MAX_ROWS_PENDING, StepAssembler

TARGET = (0.0, 0.0, 0.0, 2.0)


def number(k: int, size: int) -> tuple[float, ...]:
    """Return a vector (size,) that names its step."""
    return (float(k),) * size


@pytest.mark.parametrize("seed", range(2))
def test_topics_may_overtake_each_other(seed: int) -> None:
    """In any interleaving of the three topics, each step is assembled once, in order.

    It is made of its own messages.
    """
    assembler, draw = StepAssembler(PERIOD, TARGET), random.Random(seed)
    queues = [[(topic, k) for k in range(1, 201)] for topic in ("state", "effort", "command")]
    rows = []
    while any(queues):
        topic, k = draw.choice([queue for queue in queues if queue]).pop(0)
        if topic == "state":
            assembler.add_state(k * PERIOD, number(k, 6), number(-k, 6))
        elif topic == "effort":
            assembler.add_effort(k * PERIOD, number(k, 4))
        else:
            assembler.add_command(k * PERIOD, number(2 * k, 4))
        if draw.random() < 0.1:
            rows += assembler.pop_rows()
    rows += assembler.pop_rows(final=True)
    assert [row.step for row in rows] == list(range(1, 201))
    assert all(
        (row.q[0], row.v[0], row.effort[0]) == (row.step, -row.step, row.step) for row in rows
    )
    assert [row.demanded for row in rows] == [number(2 * k, 4) for k in range(1, 201)]
    assert assembler.lost_steps == 0


def test_lost_steps_are_counted() -> None:
    """A step whose effort never came is lost and counted; its neighbours are not."""
    assembler = StepAssembler(PERIOD, TARGET)
    for k in range(1, 11):
        assembler.add_state(k * PERIOD, number(k, 6), number(k, 6))
        if k not in (3, 7, 8):
            assembler.add_effort(k * PERIOD, number(k, 4))
    assert [row.step for row in assembler.pop_rows(final=True)] == [1, 2, 4, 5, 6, 9, 10]
    assert assembler.lost_steps == 3


def test_a_repeated_state_is_one_step() -> None:
    """A state that lockstep sent again, before or after it was written, adds nothing."""
    assembler = StepAssembler(PERIOD, TARGET)
    for k in (1, 1, 2):
        assembler.add_state(k * PERIOD, number(k, 6), number(k, 6))
        assembler.add_command(k * PERIOD, number(k, 4))
        assembler.add_effort(k * PERIOD, number(k, 4))
    assert [row.step for row in assembler.pop_rows()] == [1, 2]
    assembler.add_state(2 * PERIOD, number(2, 6), number(2, 6))
    assert assembler.pop_rows(final=True) == []


def test_a_step_waits_for_its_command() -> None:
    """A step whose command is in transit is held back, but neither forever nor at the end."""
    assembler = StepAssembler(PERIOD, TARGET)
    for k in range(1, MAX_ROWS_PENDING + 4):
        assembler.add_state(k * PERIOD, number(k, 6), number(k, 6))
        assembler.add_effort(k * PERIOD, number(k, 4))
    assembler.add_command(1 * PERIOD, number(1, 4))
    held = assembler.pop_rows()
    assert [(row.step, row.demanded) for row in held] == [(1, number(1, 4)), (2, None), (3, None)]
    assert len(assembler.pop_rows(final=True)) == MAX_ROWS_PENDING


def test_a_reference_holds_from_its_stamp_on() -> None:
    """A new target does not change the steps before it, however late it is received."""
    assembler, later = StepAssembler(PERIOD, TARGET), (0.5, 0.5, 0.5, 1.0)
    for k in range(1, 5):
        assembler.add_state(k * PERIOD, number(k, 6), number(k, 6))
        assembler.add_effort(k * PERIOD, number(k, 4))
    assembler.add_reference(3 * PERIOD, later)
    assert [row.reference for row in assembler.pop_rows(final=True)] == [
        TARGET,
        TARGET,
        later,
        later,
    ]


def test_a_reset_begins_a_new_recording(tmp_path: Path) -> None:
    """The recording before a reset is in its own file; the run after it is in the usual one.

    A viewer on the live port receives the steps before and after the reset, each as a recording of
    its own.
    """
    (port, own_port), received = free_ports(2), tmp_path / "received.rrd"
    recorder = Recorder(SCENE, tmp_path / "run.rrd", port, "one")
    command = [
        str(rerun_executable()),
        live_address(port),
        "--save",
        str(received),
        "--bind",
        "127.0.0.1",
    ]
    with subprocess.Popen([*command, "--port", str(own_port)], stderr=subprocess.DEVNULL) as viewer:
        feed(recorder, 30)
        feed(recorder, 20)
        added = recorder.finish({"steps": 20})
        try:
            wait_until(
                lambda: (
                    passes_in(received)
                    == {"knuckle_setpoint-one": 30, "knuckle_setpoint-one-1": 20}
                )
            )
        finally:
            viewer.kill()
    assert added == {"recording": str(tmp_path / "run.rrd"), "recorded_steps": 20, "lost_steps": 0}
    for name, steps in (("run.rrd", 20), ("run.before_reset_1.rrd", 30)):
        assert len(read_curves(tmp_path / name, "plots/q").step) == steps


def test_a_live_viewer_has_the_views_of_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A watched run's views are sent before its first step, as active ones, and follow it."""
    sent, send = list[tuple[Any, bool]](), rr.RecordingStream.send_blueprint

    def record(stream: rr.RecordingStream, views: Any, **options: bool) -> None:
        sent.append((views, options.get("make_active", True)))
        send(stream, views, **options)

    monkeypatch.setattr(rr.RecordingStream, "send_blueprint", record)
    (port,) = free_ports(1)
    recorder = Recorder(SCENE, tmp_path / "run.rrd", port, "one")
    assert [(views.time_panel.play_state, active) for views, active in sent] == [
        ("following", True)
    ]
    feed(recorder, 30)
    recorder.finish({"steps": 30})
    assert sent[-1][0].time_panel.play_state == "paused"


def passes_in(file: Path) -> dict[str, int]:
    """Return the steps of each recording in a file; none before it has a whole row."""
    with (
        warnings.catch_warnings(action="ignore"),
        suppress(RuntimeError, ValueError, OSError),
    ):  # it grows
        reader = RrdReader(file)
        counts = Counter[str]()
        for store in reader.recordings():
            for chunk in reader.stream(store=store):
                counts[store.recording_id] += chunk.num_rows * (
                    chunk.entity_path == "/plots/q" and not chunk.is_static
                )
        return dict(counts)
    return {}


def test_a_replacing_recorder_overwrites_no_file_before_a_reset(tmp_path: Path) -> None:
    """A second reset, received by a replacing recorder, does not change the first one's file."""
    path = tmp_path / "run.rrd"
    first, reports = Recorder(SCENE, path, run_id="one"), list[tuple[int, int, int, bool]]()
    set_aside = tmp_path / "run.before_reset_1.rrd"
    first.on_reset = lambda: reports.append(
        (first.resets, first.last_step, first.recorded, set_aside.exists())
    )
    feed(first, 30)
    feed(first, 20)
    first.save()
    assert reports == [(1, 0, 0, True)]
    previous = EarlierFiles(20, 20, (tmp_path / "run.rrd.part",), first.resets)
    successor = Recorder(
        SCENE, tmp_path / "run.part2.rrd", run_id="one", complete_file=path, previous=previous
    )
    feed(successor, 25, after=20)
    feed(successor, 10)
    assert successor.resets == 2 and successor.finish({"steps": 10})["recorded_steps"] == 10
    files = {"run.before_reset_1.rrd": 30, "run.before_reset_2.rrd": 25, "run.rrd": 10}
    assert {file.name for file in tmp_path.iterdir()} == set(files)
    for name, steps in files.items():
        assert np.array_equal(read_curves(tmp_path / name, "plots/q").step, np.arange(1, steps + 1))


def test_a_part_that_is_complete_already_is_joined_too(tmp_path: Path) -> None:
    """A recorder that died after completing its file loses no step, and leaves one file."""
    path = tmp_path / "run.rrd"
    dead = Recorder(SCENE, path, run_id="one")
    feed(dead, 30)
    dead.finish({"steps": 30})
    previous = EarlierFiles(30, 30, tuple(existing_parts(str(path), 1, since=0.0)))
    successor = Recorder(
        SCENE, tmp_path / "run.part2.rrd", run_id="one", complete_file=path, previous=previous
    )
    assert successor.has_all(30)
    added = successor.finish({"steps": 30})
    assert added == {"recording": str(path), "recorded_steps": 30, "lost_steps": 0}
    assert np.array_equal(read_curves(path, "plots/q").step, np.arange(1, 31))
    # of the last one that wrote it
    assert read_summary(path)["recording"] == str(tmp_path / "run.part2.rrd")
    assert [file.name for file in tmp_path.iterdir()] == ["run.rrd"]


def test_the_error_of_a_full_disk_has_counts_and_parts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The error of a file that could not be written has its number of steps, and earlier parts."""
    part = tmp_path / "run.rrd.part"
    part.touch()
    previous = EarlierFiles(20, 20, (part,))
    successor = Recorder(
        SCENE, tmp_path / "run.part2.rrd", complete_file=tmp_path / "run.rrd", previous=previous
    )
    feed(successor, 30, after=20)
    monkeypatch.setattr(RunWriter, "write", fail_full_disk)
    added = successor.finish({"steps": 32})
    files = [str(part), str(tmp_path / "run.part2.rrd.part")]
    assert added["error"] == "recorder: the disk is full; it has 20 of 32 steps"
    assert (added["recording"], added["parts"], added["lost_steps"]) == (files[1], files, 12)


def test_a_recording_in_parts_becomes_one_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recorder that resumes after another's last known step leaves one file, each step once."""
    # what comes is written at once
    monkeypatch.setattr("crane_sim.recording.rerun.recorder.BLOCK_SECONDS", 0.0)
    path = tmp_path / "run.rrd"
    dead = Recorder(SCENE, path, run_id="one")
    feed(dead, 30)
    # it had not reported the last ten steps
    previous = EarlierFiles(last_step=20, recorded=20, parts=(tmp_path / "run.rrd.part",))
    successor = Recorder(
        SCENE, tmp_path / "run.part2.rrd", run_id="one", complete_file=path, previous=previous
    )
    feed(successor, 60, after=20)
    added = successor.finish({"steps": 60})
    assert added == {"recording": str(path), "recorded_steps": 60, "lost_steps": 0}
    assert np.array_equal(read_curves(path, "plots/q").step, np.arange(1, 61))
    assert read_recording(path).completeness.state == COMPLETE
    assert [file.name for file in tmp_path.iterdir()] == ["run.rrd"]


def test_commands_that_a_dead_recorder_lost_stay_lost(tmp_path: Path) -> None:
    """A recorder that replaces one whose steps lack a command says so in its summary.

    The recording has the same summary.
    """
    path = tmp_path / "run.rrd"
    dead = Recorder(SCENE, path, run_id="one")
    feed(dead, 20, lost_command=7)
    dead.save()
    previous = EarlierFiles(
        20, dead.recorded, (tmp_path / "run.rrd.part",), lost_commands=dead.lost_commands
    )
    successor = Recorder(
        SCENE, tmp_path / "run.part2.rrd", run_id="one", complete_file=path, previous=previous
    )
    feed(successor, 40, after=20, lost_command=33)
    added = successor.finish({"steps": 40})
    assert added == {
        "recording": str(path),
        "recorded_steps": 40,
        "lost_steps": 2,
        "lost_commands": 2,
    }
    assert np.flatnonzero(np.isnan(read_recording(path).commands[:, 0])).tolist() == [6, 32]
    assert "2 of them without their command" in read_summary(path)["error"]


RUN = """
import json, sys
from pathlib import Path
from crane_sim import load_scene, orchestration
scene = load_scene("knuckle_setpoint", {"duration": 60.0})
print(json.dumps(orchestration.run(scene, mode="realtime", rate=10.0, record=Path(sys.argv[1]))))
"""
FULL = 6000  # steps of that scene, twice as many as four megabytes hold


@pytest.mark.long
def test_a_full_disk_never_touches_the_run(tmp_path: Path) -> None:
    """With a full disk the run still ends; its summary has the missing steps and the reason."""
    disk, copy = tmp_path / "disk", tmp_path / "run.rrd.part"
    disk.mkdir()
    script = (
        'mount -t tmpfs -o size=4m tmpfs "$1" && "$2" -c "$3" "$1/run.rrd" && cp "$1/run.rrd.part" '
        '"$4"'
    )
    command = [
        "unshare",
        "-Urm",
        "sh",
        "-c",
        script,
        "sh",
        str(disk),
        sys.executable,
        RUN,
        str(copy),
    ]
    env = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    done = run_to_completion(command, env=env)
    if not done.stdout and ("unshare" in done.stderr or "mount" in done.stderr):
        pytest.skip("no mount namespace of one's own here")
    summary = json.loads(done.stdout.splitlines()[-1])
    assert summary["steps"] == FULL
    assert summary["error"].startswith("recorder: recording ")
    assert summary["error"].endswith(f"; it has {summary['recorded_steps']} of {FULL} steps")
    assert summary["lost_steps"] == FULL - summary["recorded_steps"] > 0
    recovered = repair(copy)
    assert recovered is not None
    # what was on its way to the disk when it was full may be there, too
    assert len(read_curves(recovered, "plots/q").step) >= summary["recorded_steps"] > 0
