"""A load below a massless trolley: the limit of ever lighter trolleys, in closed form."""

from typing import Any

import numpy as np
import pytest

import crane_sim

LENGTH, GRAVITY, ANGLE = 4.0, 9.81, np.radians(25.0)
SCENE: dict[str, Any] = {
    "crane": "overhead",
    "duration": 2.0,
    "gravity": GRAVITY,
    "trolley": {"mass": 0},
    "cable": {"lengths": [LENGTH], "node_masses": [100.0]},
    "initial": {"angles": [ANGLE]},
}
INCLINED = [0.6 * np.sin(ANGLE), 0.8 * np.sin(ANGLE), -np.cos(ANGLE)]
IN_SPACE = {"dimensions": 3, "bridge": {"mass": 0}, "initial": {"directions": [INCLINED]}}


@pytest.mark.parametrize("groups", [{}, IN_SPACE], ids=["in the plane", "in space"])
def test_a_load_below_a_massless_trolley_falls_and_bounces(groups: dict[str, Any]) -> None:
    """Nothing pulls a massless trolley aside: the link carries nothing, and the load falls.

    Until the link is upright; there its end cannot go down further, and without loss the load goes
    up as fast.
    """
    run = crane_sim.simulate(SCENE | groups)
    period = 2.0 * np.sqrt(2.0 * LENGTH * (1.0 - np.cos(ANGLE)) / GRAVITY)
    since_top = (run.t + 0.5 * period) % period - 0.5 * period
    height = -LENGTH * np.cos(ANGLE) - 0.5 * GRAVITY * since_top**2
    # a trolley of 1e-10 of the load: it delays each bounce by about 1e-5 of its own time, and takes
    # 1e-10 of the way
    assert np.abs(run.payload[:, 2] - height).max() < 1e-6 * LENGTH
    assert np.abs(run.payload[:, :2] - run.payload[0, :2]).max() < 1e-9 * LENGTH
    assert run.summary["rounded"][0] == "trolley.mass: 0 kg is taken as 1e-08 kg"


def test_a_pushed_massless_trolley_pulls_the_load() -> None:
    """A force on a massless trolley accelerates the load from rest by x = F t² / (2 m).

    m is the load's mass.
    """
    run = crane_sim.simulate(
        SCENE | {"initial": {}, "inputs": {"trolley": {"kind": "constant", "value": 50.0}}}
    )
    # 1e-10 of the force moves the trolley
    assert np.abs(run.payload[:, 0] - 0.25 * run.t**2).max() < 1e-8
