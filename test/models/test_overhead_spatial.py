"""The overhead crane in space: references, planar motion, conservation, refusals."""

from typing import Any

import numpy as np
import pytest
from spatial_scenes import REFERENCE, error_in_tolerances, scene_of, sine, turned

import crane_sim
from crane_sim.simulation.rollout import Rollout, simulate


@pytest.mark.parametrize("name", ["10_3D_driven_N3", "11_3D_pole_N2"])
def test_references_in_space(name: str) -> None:
    """Sine forces on both axes, and links where angles would be singular, meet references."""
    case = REFERENCE[name]
    spec = case["spec"]
    groups = {
        "trolley": {"drive": "force", "mass": spec["trolley_mass"]},
        "bridge": {"drive": "force", "mass": spec["bridge_mass"]},
        "inputs": {"trolley": sine(spec["F_x"]), "bridge": sine(spec["F_y"])},
        "duration": case["t"][-1],
    }
    scene = scene_of(spec["m_i"], spec["l_i"], spec["n0"], spec["ndot0"], **groups)
    run = simulate(scene, sample_times=case["t"])
    assert error_in_tolerances(run, name) < 1.0
    assert np.allclose(
        run.tensions, case["tension"], rtol=0, atol=1e-8
    )  # N: position errors of 1e-9 m times some 10 kg/s²


FIXED: dict[str, Any] = {"trolley": {"drive": "fixed"}, "bridge": None, "inputs": None}


def test_planar_motion_stays_planar() -> None:
    """Planar motion stays planar: a start in the trolley's plane gives the planar trajectory.

    y = 0 throughout.
    """
    angles, rates = np.array([0.3, -0.5, 0.9]), np.array([0.5, 1.0, -0.7])
    m, lengths, force = (
        [1.0, 2.0, 5.0],
        [1.0, 0.7, 0.4],
        sine({"amplitude": 20.0, "frequency": 2.0}),
    )
    directions = np.stack([np.sin(angles), 0 * angles, -np.cos(angles)], axis=1).tolist()
    turning = (
        rates[:, None] * np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=1)
    ).tolist()
    space = simulate(
        scene_of(m, lengths, directions, turning, inputs={"trolley": force, "bridge": sine()})
    )
    document = {
        "dimensions": 2,
        "bridge": None,
        "initial": {"angles": angles.tolist(), "rates": rates.tolist()},
        "inputs": {"trolley": force},
    }
    plane = simulate(scene_of(m, lengths, None, None, **document))
    assert np.max(np.abs(space.nodes - plane.nodes)) < 1e-10  # both integrated to 1e-13 a step
    assert np.all(space.nodes[..., 1] == 0.0)
    assert np.max(np.abs(space.tensions - plane.tensions)) < 1e-9  # N; some 100 N


@pytest.mark.long
def test_every_vertical_plane_is_alike() -> None:
    """The heavy payload on ten links moves in a plane at an azimuth as its planar reference."""
    name, azimuth = "03_N10_S3a", 0.7
    run = simulate(turned(name, azimuth), sample_times=REFERENCE[name]["t"])
    assert error_in_tolerances(run, name, azimuth) < 1.0


def throw_round(duration: float) -> Rollout:
    """Return a run of three links that are thrown round below a fixed trolley."""
    directions = [[0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [0.0, 0.6, 0.8]]
    rates = [[0.0, 3.0, 0.0], [0.0, 0.0, 2.0], [1.0, 0.0, 0.0]]
    return simulate(
        scene_of([1.0, 0.5, 2.0], [1.0, 0.7, 0.4], directions, rates, duration=duration, **FIXED)
    )


@pytest.fixture(scope="module")
def long_run() -> Rollout:
    """Return a run of a minute."""
    return throw_round(60.0)


@pytest.mark.long
def test_angular_momentum_about_the_vertical_is_conserved(long_run: Rollout) -> None:
    """Below a fixed trolley nothing turns the cable about the vertical.

    Without losses its energy stays too.
    """
    m, lengths = np.array([1.0, 0.5, 2.0]), np.array([1.0, 0.7, 0.4])
    rates = long_run.v[:, 2:].reshape(-1, 3, 3)
    velocities = np.cumsum(lengths[:, None] * rates, axis=1)
    momenta = np.sum(m[:, None] * np.cross(long_run.nodes[:, 1:], velocities), axis=1)[:, 2]
    assert abs(momenta[0]) > 1.0
    assert (
        np.max(np.abs(momenta - momenta[0])) < 1e-10
    )  # errors of 1e-13 a step, of random sign, in some ten thousand steps
    assert np.ptp(long_run.energy) < 1e-10 * np.max(long_run.derived.kinetic)


def test_unit_vectors_stay_on_the_sphere() -> None:
    """Links keep their lengths to rounding, and their rates stay across them."""
    check_sphere(throw_round(2.0))


def check_sphere(run: Rollout) -> None:
    """Check lengths and rates of three links."""
    directions, rates = (part[:, 2:].reshape(-1, 3, 3) for part in (run.q, run.v))
    assert np.max(np.abs(np.linalg.norm(directions, axis=2) - 1.0)) < 1e-15
    # four roundings
    assert np.max(np.abs(np.sum(directions * rates, axis=2))) < 1e-15 * np.max(np.abs(rates)) * 4.0


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ({"joints": {"stiffness": 1.0}}, "joints: belongs to 2 dimensions"),
        (
            {"cable": {"lengths": [1.0], "node_masses": [1.0], "inertia": [0.1]}},
            "cable.inertia: belongs to 2 dim",
        ),
        (
            {"cable": {"lengths": [1.0], "node_masses": [1.0], "model": "straight"}},
            "cable.model = 'straight'",
        ),
        ({"bridge": {"drive": "force"}}, "bridge.mass = None"),
        ({"friction": {"bridge": {"coulomb": 2.0, "static": 1.0}}}, "friction.bridge.static = 1.0"),
        (
            {"initial": {"directions": [[0.0, 0.0, -2.0]]}},
            "initial.directions[0] = [0.0, 0.0, -2.0]",
        ),
        ({"initial": {"angles": [0.1]}}, "initial.angles: belong to 2 dimensions"),
    ],
    ids=lambda case: str(case)[:40],
)
def test_a_bad_scene_is_a_single_line_error(groups: dict[str, Any], message: str) -> None:
    """What has no meaning in space is rejected, with the key."""
    with pytest.raises(crane_sim.SceneError) as caught:
        scene_of([1.0], [1.0], [[0.0, 0.0, -1.0]], **groups)
    assert message in str(caught.value) and "\n" not in str(caught.value)
