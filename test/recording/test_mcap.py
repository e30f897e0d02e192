"""The run's messages in an MCAP file for other tools, and the run served live to viewers."""

import json
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from mcap_samples import DESCRIPTION, EFFORT_CODEC, SCENE, TOPICS, feed, read, stamp_of
from process_helpers import run_to_completion

from crane_sim import orchestration
from crane_sim.recording.files import unfinished_name
from crane_sim.recording.mcap.bag import Bag
from crane_sim.recording.mcap.topic import Topic
from crane_sim.recording.rerun.reader import read_curves, read_summary
from crane_sim.simulation.rollout import simulate

CRANE = Path(sys.executable).with_name("crane")


def test_the_file_has_the_run_bit_for_bit(tmp_path: Path, domain_id: int) -> None:
    """`crane run --mcap FILE` leaves one file: each message at its stamp, numbers of `simulate`."""
    path = tmp_path / "run.mcap"
    options = [
        "--no-record",
        "--mcap",
        path,
        "--duration",
        str(SCENE.duration),
        "--domain-id",
        str(domain_id),
    ]
    result = run_to_completion([CRANE, "run", *options, "--json"])
    assert result.returncode == 0, result.stderr
    summary, messages_by_topic, expected = json.loads(result.stdout), read(path), simulate(SCENE)
    assert list(tmp_path.iterdir()) == [path]
    assert (summary["mcap"], summary["recording"]) == (str(path), None)
    (
        states,
        efforts,
        commands,
    ) = (  # where the machine stalls, a state is sent and answered again: the first counts
        list(dict(reversed(messages_by_topic[f"/knuckle/{name}"])).items())[::-1]
        for name in ("joint_states", "applied_effort", "joint_commands")
    )
    stamps = [k * SCENE.period_ns for k in range(1, SCENE.steps + 2)]
    for messages, expected_stamps in (
        (states, stamps),
        (efforts, stamps[:-1]),
        (commands[: SCENE.steps], stamps[:-1]),
    ):
        assert (
            [time for time, _ in messages]
            == [stamp_of(message) for _, message in messages]
            == expected_stamps
        )
    assert np.array_equal([message.position for _, message in states], expected.q)
    assert np.array_equal([message.velocity for _, message in states], expected.v)
    for messages in (
        efforts,
        commands[: SCENE.steps],
    ):  # the last row of `expected` is the final state's
        assert np.array_equal([message.effort for _, message in messages], expected.u[:-1])
    assert "<robot" in messages_by_topic["/knuckle/robot_description"][0][1].data
    modes = [message.data for _, message in messages_by_topic["/knuckle/simulation_state"]]
    # of what is published in a row, a latched topic keeps the last
    assert (modes[0], modes[-1]) == (1, 0)
    poses = {
        stamp_of(message): message.pose.position
        for _, message in messages_by_topic["/knuckle/payload_pose"]
    }
    assert poses  # best effort: some may be missing
    for k, payload in enumerate(expected.payload, start=1):
        if point := poses.get(k * SCENE.period_ns):
            assert (point.x, point.y, point.z) == tuple(payload)


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """Yield an empty disk of 100 kB."""
    folder.mkdir()
    if (
        os.geteuid() != 0
        or run_to_completion(
            ["mount", "-t", "tmpfs", "-o", "size=100k", "tmpfs", folder]
        ).returncode
    ):
        pytest.skip("no right to mount here")
    try:
        yield folder
    finally:
        run_to_completion(["umount", folder], check=True)


def test_a_full_disk_spares_run_and_recording(tmp_path: Path, domain_id: int) -> None:
    """When the bag's disk fills up, run and recording are complete; the error names the file."""
    with small_disk(tmp_path / "disk") as disk:
        path = disk / "run.mcap"
        summary = orchestration.run(
            SCENE, record=tmp_path / "run.rrd", mcap=path, domain_id=domain_id
        )
    why, _, counts = summary["error"].rpartition("; it has ")
    assert why == f"recorder: {unfinished_name(path)}: No space left on device" and counts.endswith(
        f" of {SCENE.steps} steps"
    )
    assert summary["mcap"] == str(unfinished_name(path))
    assert (summary["steps"], summary["recorded_steps"], summary["lost_steps"]) == (
        SCENE.steps,
        SCENE.steps,
        0,
    )
    assert len(read_curves(tmp_path / "run.rrd", "plots/q").step) == SCENE.steps
    assert read_summary(tmp_path / "run.rrd") == summary


def test_a_reset_begins_a_new_file(tmp_path: Path) -> None:
    """Messages before a reset get their own file; the run after it has the latched ones."""
    bag = Bag(tmp_path / "run.mcap", TOPICS, SCENE.period_ns)
    bag.callbacks()["robot_description"](DESCRIPTION)
    feed(bag, 30)
    feed(bag, 20)
    assert bag.finish({"steps": 20}) == {"mcap": str(tmp_path / "run.mcap")}
    assert {file.name for file in tmp_path.iterdir()} == {"run.mcap", "run.before_reset_1.mcap"}
    for name, steps in (("run.before_reset_1.mcap", 30), ("run.mcap", 20)):
        messages_by_topic = read(tmp_path / name)
        assert [
            message.effort[0] for _, message in messages_by_topic["/knuckle/applied_effort"]
        ] == list(range(1, steps + 1))
        assert len(messages_by_topic["/knuckle/joint_states"]) == steps + 1
        assert [message.data for _, message in messages_by_topic["/knuckle/robot_description"]] == [
            "crane"
        ]


def test_a_reset_keeps_what_every_broadcaster_has_latched(tmp_path: Path) -> None:
    """A new file begins with each different message of a shared latched topic, newest last."""
    shared = Topic(
        "/tf_static", "std_msgs/msg/String", stamped=False, latched=True, reliable=True, shared=True
    )
    bag = Bag(tmp_path / "run.mcap", TOPICS | {"/tf_static": shared}, SCENE.period_ns)
    for letter in b"abac":
        bag.callbacks()["/tf_static"](b"\0\1\0\0\2\0\0\0" + bytes([letter, 0]))
    feed(bag, 3)
    feed(bag, 2)
    bag.finish({"steps": 2})
    assert [message.data for _, message in read(tmp_path / "run.mcap")["/tf_static"]] == [
        "b",
        "a",
        "c",
    ]


def test_a_replacing_recorder_restarts_its_count_at_a_reset(tmp_path: Path) -> None:
    """A bag that began after step 50 reports missing and saved steps of the run after a reset."""
    bag = Bag(tmp_path / "run.part2.mcap", TOPICS, SCENE.period_ns, after=50, resets=1)
    feed(bag, 60, after=50)
    feed(bag, 20)
    bag.save()
    assert (bag.resets, bag.last_step) == (2, 20)
    why = f"recorder: {tmp_path / 'run.part2.mcap'} is incomplete, it has 20 of 25 steps"
    assert bag.finish({"steps": 25})["error"] == why
    assert {file.name for file in tmp_path.iterdir()} == {
        "run.part2.mcap",
        "run.part2.before_reset_2.mcap",
    }


def test_a_message_without_a_usable_stamp_gets_the_run_s_time(tmp_path: Path) -> None:
    """A foreign message stamped before time zero is kept, at the time of the newest state."""
    bag = Bag(tmp_path / "run.mcap", TOPICS, SCENE.period_ns)
    feed(bag, 3)
    bag.callbacks()["applied_effort"](EFFORT_CODEC.encode(-1, (7.0,) * 4))
    bag.finish({})
    time, message = read(tmp_path / "run.mcap")["/knuckle/applied_effort"][-1]
    assert (time, stamp_of(message), message.effort[0]) == (4 * SCENE.period_ns, -1, 7.0)


def test_live_is_served_on_the_loopback_interface_only(tmp_path: Path, domain_id: int) -> None:
    """With a live port, viewers reach the ongoing run there, on 127.0.0.1 and no other address."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    addresses: set[str] = set()

    def look(*_progress: int) -> None:
        for table in (Path("/proc/net/tcp"), Path("/proc/net/tcp6")):
            for line in table.read_text().splitlines()[1:]:
                address, _, number = line.split()[1].partition(":")
                if int(number, 16) == port and line.split()[3] == "0A":  # listening
                    addresses.add(address)

    summary = orchestration.run(
        SCENE, record=tmp_path / "run.rrd", live_port=port, domain_id=domain_id, on_progress=look
    )
    assert "error" not in summary
    assert addresses == {"0100007F"}
