"""Bags that a killed recorder left."""

from pathlib import Path

import pytest
from mcap_samples import DESCRIPTION, EFFORT_CODEC, SCENE, STATE_CODEC, TOPICS
from rosbags.rosbag2 import Reader

from crane_sim.recording.mcap.file import McapFile, recover_bag

Written = list[tuple[str, int, bytes]]
"""Topics, times [ns] and contents of messages."""


def write(file: McapFile) -> tuple[Written, list[int]]:
    """Write the messages of 20 steps, and save twice; return (them, their number at each save)."""
    messages: Written = []
    saved: list[int] = []

    def add(topic: int, time: int, data: bytes) -> None:
        file.write(topic, time, data)
        messages.append((list(TOPICS.values())[topic].name, time, data))

    add(2, SCENE.period_ns, DESCRIPTION)
    for k in range(
        1, 21
    ):  # an effort follows the state that it leads to: their stamps are not in order
        state, effort = (k + 1) * SCENE.period_ns, k * SCENE.period_ns
        add(0, state, STATE_CODEC.encode(state, (float(k),) * 6, (0.0,) * 6, (0.0,) * 6))
        add(1, effort, EFFORT_CODEC.encode(effort, (float(k),) * 4))
        if k % 10 == 0:
            file.save()
            saved.append(len(messages))
    return messages, saved


def test_a_recovered_file_is_read_like_a_closed_one(tmp_path: Path) -> None:
    """A recovered file has its messages as a closed one has them: times, order, counts.

    An attempt for which there was no time has changed nothing. Older versions left a folder with
    the file.
    """
    file, left = McapFile(tmp_path / "run.mcap", list(TOPICS.values())), tmp_path / "left.mcap.part"
    write(file)
    left.mkdir()
    grown = left / "left.mcap.part.mcap"
    grown.write_bytes(file.part.read_bytes() + b"\x06\x99")  # the beginning of a record
    file.close({})
    with pytest.raises(TimeoutError):
        recover_bag(left, lambda: 0.0)  # no time left: it stays as it is
    recovered = recover_bag(left)
    assert recovered is not None and {each.name for each in tmp_path.iterdir()} == {
        "run.mcap",
        recovered.name,
    }
    with Reader(recovered) as recovered_bag, Reader(file.path) as closed_bag:
        messages = [
            [(about.topic, *rest) for about, *rest in bag.messages()]
            for bag in (recovered_bag, closed_bag)
        ]
        assert messages[0] == messages[1]
        for attribute in ("message_count", "start_time", "end_time"):
            assert getattr(recovered_bag, attribute) == getattr(closed_bag, attribute)


def test_every_chunk_that_is_complete_is_recovered(tmp_path: Path) -> None:
    """Wherever a file was cut, the index finds all messages of the chunks before the cut."""
    file, left = McapFile(tmp_path / "run.mcap", list(TOPICS.values())), tmp_path / "left.mcap.part"
    messages, saved = write(file)
    data = file.part.read_bytes()
    file.abandon()
    ends = record_ends(data)
    chunks = [end for end, opcode in ends.items() if opcode == CHUNK]
    assert len(chunks) == len(saved)
    for cut in sorted({*ends, *(end - 3 for end in ends), *(end + 5 for end in ends)}):
        left.write_bytes(data[:cut])
        recovered, expected = (
            recover_bag(left),
            messages[: [0, *saved][sum(end <= cut for end in chunks)]],
        )
        assert (recovered is not None) == bool(expected) and not left.exists(), cut
        if recovered is not None:
            with Reader(recovered) as bag:
                found = [(about.topic, *rest) for about, *rest in bag.messages()]
                assert bag.message_count == len(found), cut
                assert sorted(found) == sorted(expected), cut
            recovered.unlink()


CHUNK = 6  # opcode


def record_ends(data: bytes) -> dict[int, int]:
    """Return the ends of all records of a file that nothing closed, with their opcodes."""
    end, ends = 8, dict[int, int]()  # behind the file's first bytes
    while end < len(data):
        opcode, length = data[end], int.from_bytes(data[end + 1 : end + 9], "little")
        end += 9 + length
        ends[end] = opcode
    return ends
