"""Measured states are in a recording, on its page and in its columns beside the true ones."""

from pathlib import Path

import numpy as np
import pytest

import crane_sim
from crane_sim.recording.layout import of_rollout
from crane_sim.recording.read import as_recorded
from crane_sim.recording.replay import replay
from crane_sim.recording.rerun.curves import channels
from crane_sim.recording.rerun.recorder import Recorder
from crane_sim.recording.run import RecordedRun
from crane_sim.report.panels import panels_of
from crane_sim.simulation.hardware import measure
from crane_sim.simulation.plant import Plant

FAULT = {"dark": {"kind": "sensor_loss", "joint": "swing_tangential", "at": 0.1}}


@pytest.fixture(scope="module")
def rollout() -> crane_sim.Rollout:
    """Run a crane with noise, digits and delays, of whose swing a sensor fails."""
    return crane_sim.simulate("knuckle_bench", overrides={"duration": 0.3, "faults": FAULT})


@pytest.fixture(scope="module")
def run(rollout: crane_sim.Rollout) -> RecordedRun:
    """Return the run as its recording has it."""
    return as_recorded(rollout)


def test_measured_values_are_those_that_the_law_got(rollout: crane_sim.Rollout) -> None:
    """Sensing the true states anew gives bit for bit the values that a run's law got."""
    seen: list[tuple[float, ...]] = []

    def law(t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        seen.append((*q, *v))
        return tuple(rollout.commands[len(seen) - 1])

    again = crane_sim.simulate(rollout.scene, law=law)
    assert np.array_equal(again.q, rollout.q), "the same commands make the same run"
    assert np.array_equal(measure(rollout.scene, rollout.q[:-1], rollout.v[:-1]), np.array(seen))


def test_a_recording_has_both(rollout: crane_sim.Rollout, run: RecordedRun) -> None:
    """A recording has the measured beside the true values; with ideal sensors only true ones."""
    shown = measure(rollout.scene, rollout.q[:-1], rollout.v[:-1])
    assert run.q_measured is not None and run.v_measured is not None
    assert np.array_equal(np.hstack([run.q_measured, run.v_measured]), shown)
    assert np.array_equal(run.q, rollout.q[:-1])
    assert np.array_equal(run.columns()["v_measured.jib"][0], shown[:, 8]), (
        "columns are named after the joints"
    )
    ideal = crane_sim.simulate("knuckle_setpoint", duration=0.05)
    assert not of_rollout(ideal, "ideal").sensed
    assert not [
        channel for channel in channels(of_rollout(ideal, "ideal")) if "measured" in channel.entity
    ]


def test_a_recorder_of_messages_has_both(
    rollout: crane_sim.Rollout, run: RecordedRun, tmp_path: Path
) -> None:
    """From joint and true states a recorder makes the recording of the run without ROS.

    Its replay has no difference.
    """
    scene, plant = rollout.scene, Plant(rollout.scene)
    recorder = Recorder(scene, tmp_path / "run.rrd")
    for k, command in enumerate(rollout.commands, start=1):
        stamp, effort = k * scene.period_ns, tuple(command.tolist())
        recorder.add_true_state(stamp, plant.q, plant.v)  # topics may overtake each other
        recorder.add_state(stamp, *plant.seen)
        plant.advance(effort)
        recorder.add_command(stamp, effort)
        recorder.add_effort(stamp, plant.applied)
    assert recorder.has_all(len(rollout.commands))
    assert recorder.finish({"steps": len(rollout.commands)})["lost_steps"] == 0
    heard = crane_sim.read_recording(tmp_path / "run.rrd")
    for name in ("q", "v", "q_measured", "v_measured", "commands", "tensions", "swing", "kinetic"):
        assert np.array_equal(getattr(heard, name), getattr(run, name)), name
    assert replay(heard).difference is None


def test_measured_curves_share_the_axis_of_the_true_ones(run: RecordedRun) -> None:
    """Measured curves are dotted, in their joint's panel and its unit; ideal sensors have none."""
    found: dict[str, str] = {}
    for panel in panels_of(run):
        names = [curve.name for curve in panel.curves]
        for curve in panel.curves:
            if curve.dotted:
                assert curve.name.removesuffix(" measured") in names, panel.title
                found[f"{curve.name} {panel.unit}"] = curve.color
    assert {
        "slew measured °",
        "slew measured °/s",
        "rope measured m",
        "tangential measured °",
    } <= found.keys()
    assert found["slew measured °"] == found["slew measured °/s"], "a joint has one colour"
