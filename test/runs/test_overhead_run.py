"""Overhead cranes as real processes: numbers as in one process, and runs that end early."""

from pathlib import Path

import numpy as np
import pytest

from crane_sim import acceleration, load_scene, orchestration
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate


def test_lockstep_equals_simulate_through_events() -> None:
    """A sticking trolley under a sampled law has the same bits over Fast DDS as in one process."""
    changes = {"duration": 1.5, "friction": {"trolley": {"coulomb": 14.0, "static": 20.0}}}
    scene = load_scene("overhead_energy", changes)
    over_ros, in_process = orchestration.run(scene, record=None), simulate(scene).summary
    assert over_ros["state_sha256"] == in_process["state_sha256"]
    assert over_ros["events"] == in_process["events"] and in_process["events"]


def test_a_run_that_the_model_ends_keeps_its_recording(tmp_path: Path) -> None:
    """A slack rigid link ends the run with its cause; the recording has every step up to there."""
    summary = orchestration.run(load_scene("overhead_slack"), record=tmp_path / "slack.rrd")
    assert "link 1 went slack" in summary["error"]
    assert summary["recorded_steps"] == summary["steps"] > 10 and summary["lost_steps"] == 0


@pytest.mark.parametrize(
    "scene", ["overhead_friction", pytest.param("overhead_drum", marks=pytest.mark.slow)]
)
def test_a_reset_repeats_the_run(scene: str) -> None:
    """A plant that is reset in mid-run repeats it bit for bit, events included."""
    plant = Plant(load_scene(scene))
    summaries = []
    for _ in range(2):
        for _ in range(200):
            plant.advance()
        summaries.append(plant.summary())
        plant.reset()
    assert summaries[0] == summaries[1] and np.isfinite(plant.q).all()


@pytest.mark.slow
def test_a_trolley_on_an_elastic_cable_breaks_loose() -> None:
    """Stick and slip on a stiff elastic cable are those of a rigid one, at nearly equal times."""
    scene = {
        "crane": "overhead",
        "duration": 3.0,
        "trolley": {"mass": 5.0},
        "friction": {"trolley": {"coulomb": 5.0, "static": 5.0}},
        "inputs": {"trolley": {"kind": "sine", "amplitude": 20.0, "frequency": 2.0}},
    }
    cable = {"lengths": 2.0, "node_masses": 10.0}
    rigid = simulate(scene | {"cable": cable})
    elastic = simulate(
        scene | {"cable": cable | {"model": "elastic", "stiffness": 1e6, "damping": 2e3}}
    )
    assert [what for _, what in rigid.events] == [what for _, what in elastic.events] and len(
        rigid.events
    ) > 2
    for (t, _), (other, _) in zip(rigid.events, elastic.events, strict=True):
        assert t == pytest.approx(other, abs=1e-3)  # the cable stretches by m g / k = 1e-4 m


def test_forward_dynamics_break_a_resting_trolley_loose() -> None:
    """A trolley at rest stays under less than its static friction, and moves under more."""
    changes = {"friction": {"trolley": {"coulomb": 4.0, "static": 6.0}}, "initial": {"angles": 0.0}}
    scene = load_scene("overhead_friction", changes)
    still = [0.0, 0.0]
    assert acceleration(scene, still, still, [5.9])[0] == 0.0
    assert acceleration(scene, still, still, [16.0])[0] == pytest.approx((16.0 - 4.0) / 10.0)


@pytest.mark.slow
def test_events_after_the_end_are_not_reported() -> None:
    """Adaptive steps may extend beyond the end of a run; events there are not reported."""
    run = simulate(load_scene("overhead_drop", {"duration": 0.995}))
    assert run.events == [] and run.summary["event_count"] == 0
