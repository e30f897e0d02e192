"""The recorded demand of a step with several commands: the one applied by the plant, or none."""

from types import SimpleNamespace

import pytest
from realtime_doubles import JOINTS, PERIOD, make_bench

from crane_sim import load_scene
from crane_sim.recording.step_assembler import StepAssembler
from crane_sim.ros.common.serialization import EFFORT, JointStateCodec
from crane_sim.ros.recorder.decoder import MessageDecoder

PERIOD_NS = round(PERIOD * 1e9)
EFFORT_A, EFFORT_B, EFFORT_C = (1.0, 2.0, 3.0, 4.0), (5.0, 6.0, 7.0, 8.0), (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("commands", "applied", "demanded"),
    [
        ([EFFORT_A], EFFORT_B, EFFORT_A),
        ([EFFORT_A, EFFORT_B], EFFORT_B, EFFORT_B),
        ([EFFORT_B, EFFORT_A, EFFORT_A], EFFORT_B, EFFORT_B),
        ([EFFORT_A, EFFORT_B], EFFORT_C, None),
        ([], EFFORT_B, None),
    ],
)
def test_the_demand_is_the_applied_command(
    commands: list, applied: tuple, demanded: tuple | None
) -> None:
    """A single command is the demand, whatever the drives do; of several the applied, if any."""
    assembler = StepAssembler(PERIOD_NS, None)
    assembler.add_state(PERIOD_NS, EFFORT_A, EFFORT_A)
    for command in commands:
        assembler.add_command(PERIOD_NS, command)
    assembler.add_effort(PERIOD_NS, applied)
    assert [row.demanded for row in assembler.pop_rows(final=True)] == [demanded]


def test_demands_are_accepted_commands_only() -> None:
    """A single refused command is no demand; of several accepted ones the last is."""
    assembler = StepAssembler(PERIOD_NS, None)
    for k in range(1, 5):
        assembler.add_state(k * PERIOD_NS, EFFORT_A, EFFORT_A)
        assembler.add_effort(k * PERIOD_NS, EFFORT_C)
    assembler.add_command(PERIOD_NS, EFFORT_B)  # refused
    assembler.add_accepted(2 * PERIOD_NS, EFFORT_A)
    assembler.add_command(3 * PERIOD_NS, EFFORT_B)  # refused, too
    assembler.add_accepted(4 * PERIOD_NS, EFFORT_A)
    assembler.add_accepted(4 * PERIOD_NS, EFFORT_B)
    assert [row.demanded for row in assembler.pop_rows(final=True)] == [
        None,
        EFFORT_A,
        None,
        EFFORT_B,
    ]


def test_in_real_time_accepted_commands_are_published(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each accepted command is published with the stamp that it answers, no late or NaN one."""
    bench, realtime = make_bench(monkeypatch, 20, 0.002)
    codec = JointStateCodec(JOINTS, EFFORT)

    def intrude() -> None:
        for stamp, effort in (
            (bench.stamp - 5 * PERIOD_NS, (7.0, 7.0)),
            (bench.stamp, (float("nan"), 0.0)),
        ):
            bench.callbacks["joint_commands"](codec.encode(stamp, effort))

    bench.events = [(0.105, intrude)]
    realtime.run()
    published = [codec.decode(data) for data in bench.accepted]
    stamps = [each.stamp for each in published]
    assert (
        stamps == list(range(stamps[0], stamps[0] + len(stamps) * PERIOD_NS, PERIOD_NS))
        and len(stamps) >= 19
    )
    efforts = [each.effort for each in published]
    assert efforts == [bench.answer(k) for k in range(len(efforts))]
    assert bench.validator.summary()["late"] == bench.validator.summary()["rejected"] == 1


@pytest.mark.parametrize("topic", ["joint_commands", "accepted_command"])
def test_invalid_commands_are_no_demands(topic: str) -> None:
    """Commands with invalid numbers or names do not reach the recorder."""
    scene, received = load_scene("knuckle_setpoint"), []
    recorder = SimpleNamespace(add_command=lambda stamp, effort: received.append((stamp, effort)))
    recorder.add_accepted = recorder.add_command
    decode = MessageDecoder(scene, recorder).callbacks()[topic]  # type: ignore[arg-type]
    names = scene.actuated
    for bad in ((float("nan"), *EFFORT_A[1:]), (float("inf"), *EFFORT_A[1:]), (1e9, *EFFORT_A[1:])):
        decode(JointStateCodec(names, EFFORT).encode(PERIOD_NS, bad))
    decode(JointStateCodec((*names[:3], "hoist"), EFFORT).encode(PERIOD_NS, EFFORT_A))
    decode(JointStateCodec(names[:3], EFFORT).encode(PERIOD_NS, EFFORT_A[:3]))
    decode(JointStateCodec(names[::-1], EFFORT).encode(PERIOD_NS, EFFORT_A[::-1]))
    assert received == [(PERIOD_NS, EFFORT_A)]


def test_held_commands_are_the_demands() -> None:
    """A period's demand is what it took, not what came later; none while the brakes acted."""
    assembler = StepAssembler(PERIOD_NS, None)
    demands: list[tuple[int, tuple | None]] = []
    recorder = SimpleNamespace(add_accepted=lambda stamp, effort: demands.append((stamp, effort)))
    scene = load_scene("knuckle_setpoint")
    callbacks = MessageDecoder(scene, recorder).callbacks()  # type: ignore[arg-type]
    codec, nan = JointStateCodec(scene.actuated, EFFORT), float("nan")
    sent = [
        ("accepted_command", 1, EFFORT_A),
        ("held_command", 1, EFFORT_A),
        ("held_command", 2, EFFORT_A),
    ]
    sent += [
        ("accepted_command", 2, EFFORT_B),
        ("held_command", 3, (nan,) * 4),
        ("held_command", 4, EFFORT_B),
    ]
    for topic, k, effort in sent:
        callbacks[topic](codec.encode(k * PERIOD_NS, effort))
    for stamp, effort in demands:
        assembler.add_accepted(stamp, effort)
    for k in range(1, 5):
        assembler.add_state(k * PERIOD_NS, EFFORT_A, EFFORT_A)
        assembler.add_effort(k * PERIOD_NS, EFFORT_C)
    rows = assembler.pop_rows(final=True)
    assert [row.demanded for row in rows] == [EFFORT_A, EFFORT_A, None, EFFORT_B]
    assert [row.braked for row in rows] == [False, False, True, False]


@pytest.mark.parametrize("values", [(float("nan"), 1.0, 2.0, 3.0), (1e30,) * 4, (1.0,) * 3, ()])
def test_what_is_no_held_command_is_refused(values: tuple[float, ...]) -> None:
    """Invalid numbers, or ones that no drive takes, are no commands or brakes, but counted."""
    received: list[tuple] = []
    recorder = SimpleNamespace(add_accepted=lambda *command: received.append(command))
    scene = load_scene("knuckle_setpoint")
    decoder = MessageDecoder(scene, recorder)  # type: ignore[arg-type]
    held = decoder.callbacks()["held_command"]
    held(JointStateCodec(scene.actuated[: len(values)], EFFORT).encode(PERIOD_NS, values))
    held(JointStateCodec(scene.actuated, EFFORT).encode(-PERIOD_NS, EFFORT_A))
    assert not received and decoder.refused == {"held_command": 2}


def test_a_stranger_before_the_first_held_command_hides_no_command() -> None:
    """Commands of others, also of later states, end with the first held one.

    A row waits for its own.
    """
    assembler = StepAssembler(PERIOD_NS, None)
    assembler.add_state(PERIOD_NS, EFFORT_A, EFFORT_A)
    assembler.add_command(50 * PERIOD_NS, EFFORT_C)
    assembler.add_accepted(PERIOD_NS, EFFORT_B)
    assembler.add_effort(PERIOD_NS, EFFORT_B)
    for k in (2, 3):
        assembler.add_state(k * PERIOD_NS, EFFORT_A, EFFORT_A)
        assembler.add_effort(k * PERIOD_NS, EFFORT_B)
    assert [row.demanded for row in assembler.pop_rows()] == [EFFORT_B]
    assembler.add_accepted(3 * PERIOD_NS, EFFORT_B)
    assert [row.demanded for row in assembler.pop_rows()] == [None, EFFORT_B]
    assert assembler.lost_commands == 1


def test_a_lost_command_is_no_braking() -> None:
    """In lockstep a step whose command was lost has no demand; brakes act where the plant says.

    Here that is at the run's end.
    """
    assembler = StepAssembler(PERIOD_NS, None)
    for k in range(1, 5):
        assembler.add_state(k * PERIOD_NS, EFFORT_A, EFFORT_A)
        assembler.add_effort(k * PERIOD_NS, EFFORT_B)
    assembler.add_command(PERIOD_NS, EFFORT_B)
    assembler.add_command(3 * PERIOD_NS, EFFORT_B)
    assembler.add_accepted(4 * PERIOD_NS, None)
    rows = assembler.pop_rows(final=True)
    assert [row.demanded for row in rows] == [EFFORT_B, None, EFFORT_B, None]
    assert [row.braked for row in rows] == [False, False, False, True]
    assert assembler.lost_commands == 1
