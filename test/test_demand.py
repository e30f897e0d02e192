"""Which of several commands a recording shows as the demand of a step: the one that the plant took, or none."""

from types import SimpleNamespace

import pytest

from crane_sim import load_scene
from crane_sim.recording.pairing import Pairing
from crane_sim.ros.transcript import Transcript
from crane_sim.ros.wire import JointWire

PERIOD = 10_000_000  # ns
A, B, C = (1.0, 2.0, 3.0, 4.0), (5.0, 6.0, 7.0, 8.0), (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("commands", "applied", "demanded"),
    [([A], B, A), ([A, B], B, B), ([B, A, A], B, B), ([A, B], C, None), ([], B, None)],
)
def test_the_demand_is_what_the_plant_took(commands: list, applied: tuple, demanded: tuple | None) -> None:
    """A lone command is the demand, whatever drives made of it; of several the applied one is, or nobody knows."""
    pairing = Pairing(PERIOD, None)
    pairing.add_state(PERIOD, A, A)
    for command in commands:
        pairing.add_command(PERIOD, command)
    pairing.add_effort(PERIOD, applied)
    assert [row.demanded for row in pairing.take(final=True)] == [demanded]


def test_what_the_gate_refuses_is_no_demand() -> None:
    """Commands with numbers or names that no plant takes never come to the recorder."""
    scene, heard = load_scene("knuckle_setpoint"), []
    recorder = SimpleNamespace(command=lambda stamp, effort: heard.append((stamp, effort)))
    take = Transcript(scene, recorder).takers()["joint_commands"]  # type: ignore[arg-type]
    names = scene.actuated
    for bad in ((float("nan"), *A[1:]), (float("inf"), *A[1:]), (1e9, *A[1:])):
        take(JointWire(names, effort=True).encode(PERIOD, bad))
    take(JointWire((*names[:3], "hoist"), effort=True).encode(PERIOD, A))
    take(JointWire(names[:3], effort=True).encode(PERIOD, A[:3]))
    take(JointWire(names[::-1], effort=True).encode(PERIOD, A[::-1]))
    assert heard == [(PERIOD, A)]
