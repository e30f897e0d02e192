"""Which of several commands a recording shows as the demand of a step: the one that the plant took, or none."""

from types import SimpleNamespace

import pytest
from realtime_doubles import JOINTS, make_bench
from realtime_doubles import PERIOD as SECONDS

from crane_sim import load_scene
from crane_sim.recording.step_assembler import StepAssembler
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.recorder.decoder import MessageDecoder

PERIOD = 10_000_000  # ns
STEP = round(SECONDS * 1e9)  # ns, of the bench in real time
A, B, C = (1.0, 2.0, 3.0, 4.0), (5.0, 6.0, 7.0, 8.0), (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("commands", "applied", "demanded"),
    [([A], B, A), ([A, B], B, B), ([B, A, A], B, B), ([A, B], C, None), ([], B, None)],
)
def test_the_demand_is_what_the_plant_took(commands: list, applied: tuple, demanded: tuple | None) -> None:
    """A lone command is the demand, whatever drives made of it; of several the applied one is, else it is unknown."""
    pairing = StepAssembler(PERIOD, None)
    pairing.add_state(PERIOD, A, A)
    for command in commands:
        pairing.add_command(PERIOD, command)
    pairing.add_effort(PERIOD, applied)
    assert [row.demanded for row in pairing.take(final=True)] == [demanded]


def test_where_the_plant_tells_what_it_accepted_nothing_else_is_a_demand() -> None:
    """A lone command that was refused, as late or another one's, is no demand; of bare arrays the last one is."""
    pairing = StepAssembler(PERIOD, None)
    for k in range(1, 5):
        pairing.add_state(k * PERIOD, A, A)
        pairing.add_effort(k * PERIOD, C)
    pairing.add_command(PERIOD, B)  # refused
    pairing.add_accepted(2 * PERIOD, A)
    pairing.add_command(3 * PERIOD, B)  # refused, too
    pairing.add_accepted(4 * PERIOD, A)
    pairing.add_accepted(4 * PERIOD, B)
    assert [row.demanded for row in pairing.take(final=True)] == [None, A, None, B]


def test_in_real_time_the_plant_tells_what_it_accepted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command that counts is published with the stamp that it answers, and none that is late or no number."""
    bench, realtime = make_bench(monkeypatch, 20, 0.002)
    wire = JointWire(JOINTS, effort=True)

    def intrude() -> None:
        for stamp, effort in ((bench.stamp - 5 * STEP, (7.0, 7.0)), (bench.stamp, (float("nan"), 0.0))):
            bench.callbacks["joint_commands"](wire.encode(stamp, effort))

    bench.events = [(0.105, intrude)]
    realtime.run()
    published = [wire.decode(data) for data in bench.accepted]
    stamps = [frame.stamp for frame in published]
    assert stamps == list(range(stamps[0], stamps[0] + len(stamps) * STEP, STEP)) and len(stamps) >= 19
    efforts = [frame.effort for frame in published]
    assert efforts == [bench.answer(k) for k in range(len(efforts))]
    assert bench.validator.summary()["late"] == bench.validator.summary()["rejected"] == 1


@pytest.mark.parametrize("topic", ["joint_commands", "accepted_command"])
def test_what_the_gate_refuses_is_no_demand(topic: str) -> None:
    """Commands with numbers or names that no plant takes never come to the recorder."""
    scene, heard = load_scene("knuckle_setpoint"), []
    recorder = SimpleNamespace(command=lambda stamp, effort: heard.append((stamp, effort)))
    recorder.accept_effort = recorder.command
    take = MessageDecoder(scene, recorder).callbacks()[topic]  # type: ignore[arg-type]
    names = scene.actuated
    for bad in ((float("nan"), *A[1:]), (float("inf"), *A[1:]), (1e9, *A[1:])):
        take(JointWire(names, effort=True).encode(PERIOD, bad))
    take(JointWire((*names[:3], "hoist"), effort=True).encode(PERIOD, A))
    take(JointWire(names[:3], effort=True).encode(PERIOD, A[:3]))
    take(JointWire(names[::-1], effort=True).encode(PERIOD, A[::-1]))
    assert heard == [(PERIOD, A)]
