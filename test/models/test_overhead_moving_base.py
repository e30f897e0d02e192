"""Overhead cranes on a moving base against Newton's law and equivalent cranes at rest.

Newton's law is that in the world.
"""

from typing import Any

import moving_base
import numpy as np
import pytest
from overhead_base_scenes import DIRECTIONS, LENGTHS, MASSES, PLANE, RATES, SHIP, start_of
from spatial_scenes import TIGHT, scene_of

import crane_sim


def spatial(**groups: Any) -> crane_sim.Scene:
    """Return the scene of a chain in space."""
    return scene_of(MASSES, LENGTHS, DIRECTIONS.tolist(), RATES.tolist(), duration=2.0, **groups)


@pytest.mark.long
def test_a_chain_in_space_obeys_newton_in_the_world() -> None:
    """Bridge, trolley and nodes obey Newton's law in the world.

    The base moves in all six axes.
    """
    run = crane_sim.simulate(spatial(base_motion=SHIP))
    crane = moving_base.Crane(5.0, 3.0, tuple(MASSES), tuple(LENGTHS))
    expected = moving_base.nodes(crane, SHIP, *start_of(LENGTHS, DIRECTIONS, RATES), run.t)
    # both integrate with 1e-12 a step, a few hundred steps
    assert np.max(np.abs(run.nodes - expected)) < 1e-9
    assert run.summary["energy_audit_error"] < 1e-11  # the imposed power is integrated as tightly


HOIST = {"kind": "sine", "offset": 1.0, "amplitude": 0.3, "frequency": 2.0}


def planar(viscous: float, static: float, **groups: Any) -> crane_sim.Scene:
    """Return the scene of a planar chain with all that a base acts on: rods, hoist, friction."""
    document = {
        "crane": "overhead",
        "duration": 2.0,
        "trolley": {"drive": "force", "mass": 5.0},
        "cable": {"lengths": LENGTHS, "node_masses": MASSES, "inertia": 0.2},
        "hoist": {"drive": "prescribed", "profile": HOIST},
        "friction": {"trolley": {"coulomb": static, "static": static, "viscous": viscous}},
        "initial": {
            "v": 0.0 if static else 2.0,
            "angles": [0.4, -0.2, 0.1],
            "rates": [0.3, 0.0, -0.5],
        },
        "integrator": TIGHT,
    }
    return crane_sim.load_scene(document | groups)


@pytest.mark.slow
def test_a_chain_in_the_plane_obeys_dalembert_in_the_world() -> None:
    """Trolley, hoisted link and rods with inertia move as d'Alembert's principle says.

    The principle is that in the world.
    """

    def hoist(t: float) -> Any:
        s, c = np.sin(2.0 * t), np.cos(2.0 * t)
        return np.array([1.0 + 0.3 * s, 0.6 * c, -1.2 * s])

    run = crane_sim.simulate(planar(1.5, 0.0, base_motion=PLANE))
    crane = moving_base.Plane(5.0, 1.5, tuple(MASSES), tuple(LENGTHS), 0.2, hoist)
    start = np.array([0.0, 0.4, -0.2, 0.1, 2.0, 0.3, 0.0, -0.5])
    # as in space
    assert np.max(np.abs(run.nodes - moving_base.plane_nodes(crane, PLANE, start, run.t))) < 1e-9
    assert run.summary["energy_audit_error"] < 1e-11


@pytest.mark.long
def test_friction_holds_a_trolley_until_the_base_shakes_it_loose() -> None:
    """A trolley that sticks stays on a base that shakes gently, and slips on a strong shake."""
    gentle, hard = (
        crane_sim.simulate(
            planar(0.0, 200.0, base_motion={"surge": {"amplitude": a, "frequency": 5.0}})
        )
        for a in (0.1, 2.0)
    )
    assert np.all(gentle.q[:, 0] == 0.0)
    assert np.max(np.abs(hard.q[:, 0])) > 0.1
    assert hard.summary["energy_audit_error"] < 1e-10  # events, each located to rounding


@pytest.mark.slow
def test_an_elastic_cable_obeys_newton_in_the_world() -> None:
    """Nodes on springs, trolley and bridge move as Newton's law in the world says."""
    positions, velocities = start_of(LENGTHS, DIRECTIONS, RATES)
    cable = {"model": "elastic", "lengths": LENGTHS, "node_masses": MASSES, "stiffness": 2e3}
    start = {"positions": positions[1:].tolist(), "velocities": velocities[1:].tolist()}
    scene = scene_of(
        MASSES, LENGTHS, None, cable=cable, initial=start, duration=2.0, base_motion=SHIP
    )
    run = crane_sim.simulate(scene)
    crane = moving_base.Crane(5.0, 3.0, tuple(MASSES), tuple(LENGTHS), 2e3)
    assert (
        np.max(np.abs(run.nodes - moving_base.nodes(crane, SHIP, positions, velocities, run.t)))
        < 1e-9
    )
    assert run.summary["energy_audit_error"] < 1e-11


def test_an_accelerated_heave_is_gravity() -> None:
    """A base that accelerates upwards acts as more gravity, a tilted one as leaning gravity."""
    # 2 m/s² upwards at t = 0
    rising = {"heave": {"amplitude": 2.0, "frequency": 1.0, "phase": -np.pi / 2}}
    heavy = spatial(gravity=11.81)
    actual, expected = (
        crane_sim.acceleration(scene, scene.initial_q, scene.initial_v, [3.0, -2.0])
        for scene in (spatial(base_motion=rising), heavy)
    )
    assert actual == pytest.approx(expected, abs=1e-13)  # rounding
    tilted = spatial(base_motion={"roll": {"amplitude": 0.0, "frequency": 0.0, "offset": 0.3}})
    down = np.array([0.0, -np.sin(0.3), -np.cos(0.3)])
    q = np.concatenate([np.zeros(2), np.tile(down, 3)])
    # the chain hangs along the leaning gravity, held against the rail by the force that the bridge
    # takes
    pull = np.array([0.0, 9.81 * np.sin(0.3) * (sum(MASSES) + 8.0)])
    assert np.max(np.abs(crane_sim.acceleration(tilted, q, np.zeros(11), pull))) < 1e-13


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ({"base_motion": {"sway": {"amplitude": 1.0, "frequency": 1.0}}}, "sway leaves the plane"),
        (
            {
                "base_motion": {},
                "cable": {"model": "straight", "lengths": [1.0, 1.0], "node_masses": 1.0},
            },
            "straight",
        ),
    ],
    ids=["plane", "straight"],
)
def test_what_a_moving_base_cannot_carry_is_a_single_line_error(groups: Any, message: str) -> None:
    """Motions that leave the plane, and straight cables, are rejected with what to do instead."""
    document = {
        "crane": "overhead",
        "duration": 1.0,
        "trolley": {"drive": "fixed"},
        "cable": {"lengths": [1.0], "node_masses": [1.0]},
    }
    with pytest.raises(crane_sim.SceneError) as caught:
        crane_sim.load_scene(document | groups)
    assert message in str(caught.value) and "\n" not in str(caught.value)
