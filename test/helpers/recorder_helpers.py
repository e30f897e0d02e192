"""A plant that feeds a recorder without ROS, and a disk that is full."""

from crane_sim import load_scene
from crane_sim.recording.rerun.part_file import RecordingError
from crane_sim.recording.rerun.recorder import Recorder
from crane_sim.recording.rerun.writer import RunWriter
from crane_sim.simulation.plant import Plant

PERIOD = 10_000_000  # ns
SCENE = load_scene("knuckle_setpoint", {"duration": 2.0})


def feed(recorder: Recorder, steps: int, after: int = 0, lost_command: int = 0) -> None:
    """Let the plant take steps, and record those after step `after`, one without its command."""
    plant = Plant(SCENE)
    for k in range(1, steps + 1):
        q, v = plant.q, plant.v
        assert SCENE.law is not None
        demanded = SCENE.law(plant.t, q, v)
        plant.advance(demanded)
        if k <= after:
            continue
        recorder.add_state(k * PERIOD, q, v)
        if k != lost_command:
            recorder.add_command(k * PERIOD, demanded)
        recorder.add_effort(k * PERIOD, plant.applied)


def fail_full_disk(writer: RunWriter, block: object) -> None:
    """Fail as a write to a full disk does, in place of `RunWriter.write`."""
    raise RecordingError("the disk is full")
