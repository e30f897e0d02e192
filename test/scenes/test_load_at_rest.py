"""A load at rest on elastic falls: known cases, and independent minimisations of its potential."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from crane_sim import load_scene
from crane_sim.models.falls.crane import Falls
from crane_sim.models.loads import RigidLoad
from crane_sim.scenes.schema.load_at_rest import load_at_rest

GRAVITY = 9.81
NOTHING = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
BEAM: dict[str, Any] = {
    "crane": "pendulum",
    "gravity": 9.8,
    "duration": 1.0,
    "falls": {
        "top": [[-3, 0, 0], [3, 0, 0]],
        "bottom": [[-2, 0, 0], [2, 0, 0]],
        "axial_stiffness": 1e6,
        "offsets": [-0.5, 0.5],
    },
    "payload": {"mass": 120.0, "inertia": [1.0, 160.0, 160.0]},
    "initial": {"length": 3.2},
}


def posture_of(scene: Any) -> tuple[Any, Any]:
    """Return place of the load from the suspension point [m], and its (roll, pitch, yaw) [deg]."""
    q = np.array(scene.initial_q)
    return q[3:6] - q[:3], Rotation.from_quat([*q[7:], q[6]]).as_euler("ZYX", degrees=True)[::-1]


def test_a_beam_on_two_cables_hangs_aside_and_tilted() -> None:
    """A beam on cables of 2.7 and 3.7 m from wider anchors hangs as in a published solution."""
    place, angles = posture_of(load_scene(BEAM))
    np.testing.assert_allclose(place, [-0.235, 0.0, -3.024], atol=5e-4)  # its digits
    np.testing.assert_allclose(angles, [0.0, 12.94, 0.0], atol=5e-3)
    stiff, _ = posture_of(load_scene(BEAM, {"falls.axial_stiffness": 1e12}))
    ends = [np.array([-2.0, 0.0, 0.0]), np.array([2.0, 0.0, 0.0])]
    turn = Rotation.from_quat(
        [*np.array(load_scene(BEAM, {"falls.axial_stiffness": 1e12}).initial_q)[[7, 8, 9, 6]]]
    )
    cables = [np.linalg.norm(stiff + turn.apply(end) - 1.5 * end) for end in ends]
    np.testing.assert_allclose(cables, [2.7, 3.7], atol=1e-8)  # rigid ones


def test_a_boat_is_trimmed_by_its_falls() -> None:
    """The lifeboat on falls that differ by 0.4 m hangs at its trim, whatever the signs' order."""
    place, (roll, pitch, yaw) = posture_of(
        load_scene("pendulum_lifeboat", {"falls.offsets": [0.2, -0.2]})
    )
    np.testing.assert_allclose(place, [-0.1724, 0.0, -3.1942], atol=5e-5)
    np.testing.assert_allclose([roll, pitch, yaw], [0.0, 3.4246, 0.0], atol=5e-5)


@pytest.mark.parametrize("offset", np.linspace(-1.9, 1.9, 15))
def test_offsets_move_the_boat_continuously(offset: float) -> None:
    """Rest is found for any offsets, and near that of neighbouring ones."""
    places = [
        posture_of(load_scene(BEAM, {"falls.offsets": [o, -o]}))[0] for o in (offset, offset + 1e-6)
    ]
    assert np.linalg.norm(places[1] - places[0]) < 1e-4


def test_a_load_on_one_of_two_falls_hangs_on_end() -> None:
    """A beam with a slack second cable hangs upright below the first: roll and yaw coincide."""
    place, _ = posture_of(load_scene(BEAM, {"falls.offsets": [-0.5, 6.0]}))
    stretch = 120.0 * 9.8 * 2.7 / 1e6
    np.testing.assert_allclose(place, [-3.0, 0.0, -(2.7 + stretch + 2.0)], atol=1e-9)


def test_rest_is_no_saddle() -> None:
    """A load with its centre of mass exactly above its only fall's end comes to rest below it."""
    payload = {"mass": 120.0, "inertia": [20.0, 20.0, 20.0], "attachment": [0.0, 0.0, -0.5]}
    falls = {"top": [[0, 0, 0]], "bottom": [[0, 0, 0]], "axial_stiffness": 1e6, "offsets": None}
    place, _ = posture_of(load_scene(BEAM, {"falls": falls, "payload": payload}))
    np.testing.assert_allclose(
        place, [0.0, 0.0, -(3.2 * (1.0 + 120.0 * 9.8 / 1e6) + 0.5)], atol=1e-9
    )


def test_a_given_posture_is_where_the_search_begins() -> None:
    """A load that rests at any yaw has, at rest about a target, the yaw of the scene's posture."""
    falls = {"top": [[0, 0, 0]], "bottom": [[0, 0, 0]], "axial_stiffness": 1e6}
    turned = {"position": [0.0, 0.0, -3.6], "orientation": [np.cos(0.3), 0.0, 0.0, np.sin(0.3)]}
    payload = {"mass": 120.0, "inertia": [20.0, 20.0, 20.0], "attachment": [0.0, 0.0, 0.5]}
    scene = load_scene(
        BEAM | {"falls": falls, "payload": payload, "initial": {"length": 3.2} | turned}
    )
    rest = scene.file.rest_positions((0.0, 0.0))
    assert rest is not None
    np.testing.assert_allclose(rest[6:], turned["orientation"], atol=1e-9)
    np.testing.assert_allclose(
        rest[3:6], [0.0, 0.0, -(3.2 * (1.0 + 120.0 * 9.8 / 1e6) + 0.5)], atol=1e-9
    )


def random_falls(rng: np.random.Generator, stiffest: float) -> tuple[Falls, RigidLoad]:
    """Return a load on two, three or four falls with ends, lengths and offsets at random."""
    n, length, width, mass = (
        rng.integers(2, 5),
        rng.uniform(1.0, 10.0),
        rng.uniform(0.5, 3.0),
        10.0 ** rng.uniform(0, 4.5),
    )
    corners = width * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])[rng.permutation(4)[:n]]
    top, bottom = (
        np.column_stack([corners * rng.uniform(0.3, 1.0, (n, 2)), rng.uniform(-0.2, 0.2, n)])
        for _ in "tb"
    )
    bottom[:, 2] += rng.uniform(0.0, 1.5)  # the centre of mass is below
    offsets = rng.uniform(-0.6, 0.6, n) * min(length, width)
    stiffness = np.full(n, mass * GRAVITY * 10.0 ** rng.uniform(1.5, stiffest))
    return Falls(top, bottom, length, offsets, stiffness, np.zeros(n)), RigidLoad(
        mass, NOTHING, NOTHING, NOTHING[0]
    )


def potential(z: Any, falls: Falls, weight: float, place: Any, turn: Rotation) -> float:
    """Return the potential [m] of a weight of 1, displaced and turned by z (6,) from a posture."""
    ends = place + z[:3] + (Rotation.from_rotvec(z[3:]) * turn).apply(falls.bottom)
    rest = falls.length + falls.offset
    stretch = np.maximum(np.linalg.norm(falls.top - ends, axis=1) - rest, 0.0)
    return float(place[2] + z[2] + 0.5 * np.sum(falls.axial_stiffness / rest * stretch**2) / weight)


@pytest.mark.parametrize("seed", range(40))
def test_rest_is_a_minimum_of_the_potential(seed: int) -> None:
    """Beside a posture at rest, an independent minimisation finds no lower one and comes back."""
    rng = np.random.default_rng(seed)
    falls, load = random_falls(rng, 3.0)
    place, (w, *xyz) = load_at_rest(falls, load, GRAVITY, None)
    given = falls, load.mass * GRAVITY, place, Rotation.from_quat([*xyz, w])
    lowest = potential(np.zeros(6), *given)
    beside = minimize(potential, 1e-4 * rng.normal(size=6), given, "BFGS", options={"gtol": 1e-8})
    assert abs(beside.fun - lowest) < 1e-9  # m; 1e-4 m beside it is 1e-9 to 1e-5 higher


@pytest.mark.parametrize("seed", range(100, 140))
def test_rest_is_found_on_falls_of_any_stiffness(seed: int) -> None:
    """Forces and moments balance on falls that stretch by 3 % to 3e-7, whichever are slack."""
    falls, load = random_falls(np.random.default_rng(seed), 6.0)
    place, (w, *xyz) = load_at_rest(falls, load, GRAVITY, None)
    arms, rest = Rotation.from_quat([*xyz, w]).apply(falls.bottom), falls.length + falls.offset
    apart = falls.top - place - arms
    distance = np.linalg.norm(apart, axis=1)
    pulls = (falls.axial_stiffness / rest * np.maximum(distance - rest, 0.0) / distance)[
        :, None
    ] * apart
    rounding = 1e-9 * falls.axial_stiffness.max() / rest.min()  # N: places are rounded to 1e-10 m
    weight = [0.0, 0.0, load.mass * GRAVITY]
    np.testing.assert_allclose(pulls.sum(axis=0), weight, atol=rounding)
    # m, of the longest levers
    np.testing.assert_allclose(np.cross(arms, pulls).sum(axis=0), 0.0, atol=5.0 * rounding)


@pytest.mark.parametrize("yaw", [0.0, 0.3, -1.2])
def test_a_load_held_at_a_yaw_tilts_freely(yaw: float) -> None:
    """A load that is held about the vertical has no force on it and no moment about level axes."""
    rng = np.random.default_rng(7)
    falls, load = random_falls(rng, 3.0)
    _, (w, *xyz) = load_at_rest(falls, load, GRAVITY, yaw)
    assert Rotation.from_quat([*xyz, w]).as_euler("ZYX")[0] == pytest.approx(yaw, abs=1e-9)
