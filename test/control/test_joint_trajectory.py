"""The law `joint_trajectory`: drives that take speeds or positions follow a path of the joints."""

from math import exp, inf
from typing import Any

import numpy as np
import pytest

from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.rollout import simulate
from crane_sim.trajectories.trajectory import sample_trajectory

PATH = {
    "kind": "point_to_point",
    "of": "joints",
    "from": [0.0],
    "to": [0.4],
    "velocity": 0.4,
    "acceleration": 0.5,
}


def scene(drive: str, path: dict[str, Any] | None, **groups: Any) -> Scene:
    """Return the scene of a trolley whose drive follows its reference, with a payload.

    The drive is exact, the rope is 4 m long.
    """
    servo = {"gain": inf, "max_acceleration": 50.0, "max_speed": 5.0}
    document = {
        "crane": "overhead",
        "duration": 2.5,
        "trolley": {"mass": 1200.0},
        "cable": {"lengths": 4.0, "node_masses": 500.0},
        "actuators": {"trolley": {"drive": drive, "servo": servo}},
        "control": {"law": "joint_trajectory", "period": 0.01, "drive": drive}
        | groups.pop("control", {}),
    }
    return load_scene(document | ({"reference": {"path": path}} if path else {}) | groups)


def test_commands_are_those_of_the_formula() -> None:
    """Drives by position are commanded x*, those by speed v* + h (x* - x), at any time."""
    for t in (0.0, 0.3, 1.1, 9.0):
        loaded = scene("velocity", PATH, control={"position_gain": 3.0})
        ((x,), (rate,), _), q = sample_trajectory(loaded.trajectory, np.array([t]))[0], (0.7, 0.1)
        assert loaded.law is not None
        # rounding
        assert loaded.law(t, q, (0.0, 0.0)) == pytest.approx((rate + 3.0 * (x - 0.7),), abs=1e-15)
        by_position = scene("position", PATH).law
        assert by_position is not None and by_position(t, q, (0.0, 0.0)) == (x,)


def test_a_deviation_decays_by_the_gain() -> None:
    """Below an exact speed drive a trolley that begins beside its path comes to it as exp(-h t)."""
    path = {"kind": "trajectory", "of": "joints", "joint_names": ["trolley"]}
    path |= {"points": [{"positions": [0.5], "velocities": [0.0], "time_from_start": 0.0}]}
    run = simulate(scene("velocity", path, control={"position_gain": 2.0}, duration=1.0))
    # a speed held for a period T: (1 - h T) a period in place of exp(-h T), 1 % at h t = 2; and the
    # drive's ramp
    assert 0.5 - run.q[100, 0] == pytest.approx(0.5 * exp(-2.0), rel=0.06)


def test_without_a_path_the_joints_stay() -> None:
    """A scene without a path is held where it starts."""
    run = simulate(scene("position", None, duration=0.5, initial={"x": 1.5, "angles": 0.1}))
    assert np.max(np.abs(run.q[:, 0] - 1.5)) < 1e-9


def test_what_the_law_cannot_follow_is_refused() -> None:
    """A path of the payload, drives of another kind, and a crane without any are errors.

    They are errors of one line.
    """
    of_payload = {key: value for key, value in PATH.items() if key != "of"} | {
        "from": [0.0, 0.0],
        "to": [1.0, 0.0],
    }
    with pytest.raises(SceneError, match="joint_trajectory' follows paths of the joints only"):
        scene("velocity", of_payload)
    with pytest.raises(
        SceneError, match="commands velocity of the trolley, whose drive takes position"
    ):
        scene("position", None, control={"drive": "velocity"})
    with pytest.raises(SceneError, match="'joint_trajectory': no joint of this crane is actuated"):
        load_scene("overhead_pole", {"control.law": "joint_trajectory"})
