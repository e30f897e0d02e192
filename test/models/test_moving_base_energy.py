"""Energies of cranes on a moving base, in the world and relative to it.

They are compared with masses that are followed through the world.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from moving_base import G, motion, pose
from overhead_base_scenes import DIRECTIONS, LENGTHS, MASSES, PLANE, RATES, SHIP, start_of
from spatial_scenes import scene_of as spatial_of

import crane_sim

Array = np.ndarray[Any, Any]
STENCIL = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 12.0
STEP = 1e-3  # s, of differences of order 4: 1e-12 of the fifth derivatives, and 1e-13 from rounding
GAUSS = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
"""Where along a rod two halves of its mass have the moments of a uniform one, up to the second."""
TIME = 1.7  # s
BOOM, JIB, TOWER, LOAD = (5.0, 8.0), (3.0, 4.0), 5.0, 1.5  # length and mass of the rods


def rate(f: Callable[[float], Array]) -> Array:
    """Return the derivative of f at 0."""
    values = np.array([f(k * STEP) for k in range(-2, 3)])
    return np.tensordot(STENCIL, values, 1) / STEP


def energy_of(masses: Array, points_in_base: Callable[[float], Array], base: Any = SHIP) -> float:
    """Return the kinetic and potential energy [J] in the world of masses (n,), at TIME.

    Args:
        masses: kg.
        points_in_base: their points (n, 3) [m] in the base's frame, s seconds after TIME.
        base: its motion.
    """

    def world(s: float) -> Array:
        rotate, origin = pose(base, TIME + s)
        return origin[0] + points_in_base(s) @ rotate[0].T

    return float(0.5 * masses @ np.sum(rate(world) ** 2, axis=1) + G * masses @ world(0.0)[:, 2])


def unit_vectors(angles: Array) -> Array:
    """Return unit vectors (n, 3) in the x-z plane at elevations (n,)."""
    return np.stack([np.cos(angles), 0.0 * angles, np.sin(angles)], axis=1)


def knuckle_points(q: Array) -> tuple[Array, Array]:
    """Return masses (5,) and points (5, 3) of boom, jib and payload.

    Rods are two halves at the places of GAUSS.
    """
    s, c = np.sin(q[0]), np.cos(q[0])
    slewed = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    boom, jib = BOOM[0] * unit_vectors(q[1:2])[0], JIB[0] * unit_vectors(q[2:3])[0]
    (s1, c1), (s2, c2) = ((np.sin(a), np.cos(a)) for a in q[4:6])
    rope = q[3] * np.array([s2, c2 * s1, -c1 * c2])
    local = np.array(
        [*(a * boom for a in GAUSS), *(boom + a * jib for a in GAUSS), boom + jib + rope]
    )
    halves = [0.5 * BOOM[1]] * 2 + [0.5 * JIB[1]] * 2
    return np.array([*halves, LOAD]), local @ slewed.T


def knuckle() -> tuple[crane_sim.Scene, Array, Array, float]:
    """Return a boom crane of slender rods at q, v, and its energy in the world by quadrature."""
    (boom, heavy), (jib, light) = BOOM, JIB
    document = {
        "crane": "knuckle",
        "duration": 1.0,
        "boom": {
            "length": boom,
            "mass": heavy,
            "inertia": heavy * boom**2 / 12,
            "axial_inertia": 0.0,
        },
        "jib": {"length": jib, "mass": light, "inertia": light * jib**2 / 12, "axial_inertia": 0.0},
        "tower": {"inertia": TOWER},
        "payload": {"mass": LOAD},
        "initial": {"q": [0.2, 0.7, -0.3, 2.0, 0.1, -0.2]},
        "base_motion": SHIP,
    }
    q, v = np.array([0.2, 0.7, -0.3, 2.0, 0.1, -0.2]), np.array([0.5, -0.3, 0.4, 0.2, -0.6, 0.7])
    masses = knuckle_points(q)[0]
    actual = energy_of(masses, lambda s: knuckle_points(q + s * v)[1])

    def axes(
        s: float,
    ) -> Array:  # the tower's first two, in the world: its inertia is about its third one
        a = q[0] + s * v[0]
        rotate = pose(SHIP, TIME + s)[0][0]
        return np.array([[np.cos(a), np.sin(a), 0.0], [-np.sin(a), np.cos(a), 0.0]]) @ rotate.T

    turning = rate(axes)[0] @ axes(0.0)[1]
    return crane_sim.load_scene(document), q, v, actual + 0.5 * TOWER * float(turning) ** 2


def pendulum() -> tuple[crane_sim.Scene, Array, Array, float]:
    """Return a pendulum at a state q, v, and the energy of its payload in the world."""
    length, mass = 1.3, 10.0
    document = {
        "crane": "pendulum",
        "duration": 0.1,
        "rope": {"length": length},
        "payload": {"mass": mass},
    }
    scene = crane_sim.load_scene(
        document | {"base_motion": SHIP, "initial": {"tip": [1.0, -0.4, 0.7]}}
    )
    q, v = np.array([1.0, -0.4, 0.7, 0.6, 0.0, -0.8]), np.array([0.3, 0.2, -0.1, 0.4, 0.5, 0.3])
    return (
        scene,
        q,
        v,
        energy_of(
            np.array([mass]), lambda s: (q + s * v)[None, :3] + length * (q + s * v)[None, 3:]
        ),
    )


def overhead_plane() -> tuple[crane_sim.Scene, Array, Array, float]:
    """Return a chain of links that turn as rods at a state q, v, and its energy in the world."""
    inertia, trolley = 0.2, 5.0
    cable = {"lengths": LENGTHS, "node_masses": MASSES, "inertia": inertia}
    document = {
        "crane": "overhead",
        "duration": 1.0,
        "trolley": {"drive": "force", "mass": trolley},
        "cable": cable,
    }
    scene = crane_sim.load_scene(
        document | {"initial": {"angles": [0.4, -0.2, 0.1]}, "base_motion": PLANE}
    )
    q, v = np.array([0.3, 0.4, -0.2, 0.1]), np.array([0.8, 0.3, 0.6, -0.5])

    def links(s: float) -> Array:
        return unit_vectors((q + s * v)[1:] - 0.5 * np.pi)

    def points_in_base(s: float) -> Array:
        start = np.array([q[0] + s * v[0], 0.0, 0.0])
        return start + np.cumsum(
            np.vstack([np.zeros(3), np.array(LENGTHS)[:, None] * links(s)]), axis=0
        )

    def rotate(s: float) -> Array:
        return links(s) @ pose(PLANE, TIME + s)[0][0].T

    actual = energy_of(np.array([trolley, *MASSES]), points_in_base, PLANE)
    return scene, q, v, actual + 0.5 * inertia * float(np.sum(rate(rotate) ** 2))


def energy_with_bridge(points: Array, velocities: Array) -> float:
    """Return the energy in the world of trolley, nodes, and the bridge's own 3 kg at x = 0.

    `points`, `velocities` are those of trolley and nodes (n + 1, 3) in the frame of the base.
    """
    points = np.vstack([points, [0.0, points[0, 1], 0.0]])
    velocities = np.vstack([velocities, [0.0, velocities[0, 1], 0.0]])
    return energy_of(np.array([5.0, *MASSES, 3.0]), lambda s: points + s * velocities)


def overhead_space() -> tuple[crane_sim.Scene, Array, Array, float]:
    """Return a chain in space at a state q, v, and its energy in the world."""
    scene = spatial_of(MASSES, LENGTHS, DIRECTIONS.tolist(), RATES.tolist(), base_motion=SHIP)
    q = np.concatenate([[0.4, -0.7], DIRECTIONS.ravel()])
    v = np.concatenate([[0.9, 0.5], RATES.ravel()])
    points, velocities = start_of(LENGTHS, DIRECTIONS, RATES)
    return scene, q, v, energy_with_bridge(points + [0.4, -0.7, 0.0], velocities + [0.9, 0.5, 0.0])


def overhead_elastic() -> tuple[crane_sim.Scene, Array, Array, float]:
    """Return a spatial chain of springs at q, v, some stretched, and its energy in the world."""
    points, velocities = start_of(np.array(LENGTHS) * [1.1, 0.9, 1.05], DIRECTIONS, RATES)
    points, velocities = points + [0.4, -0.7, 0.0], velocities + [0.9, 0.5, 0.0]
    cable = {"model": "elastic", "lengths": LENGTHS, "node_masses": MASSES, "stiffness": 2e3}
    start = {"positions": points[1:].tolist(), "velocities": velocities[1:].tolist()}
    scene = spatial_of(MASSES, LENGTHS, None, cable=cable, initial=start, base_motion=SHIP)
    q, v = (np.concatenate([part[0, :2], part[1:].ravel()]) for part in (points, velocities))
    stretch = np.array(LENGTHS) * [0.1, -0.1, 0.05]
    return scene, q, v, energy_with_bridge(points, velocities) + 1e3 * float(stretch @ stretch)


CRANES = [knuckle, pendulum, overhead_plane, overhead_space, overhead_elastic]


@pytest.mark.parametrize("crane", CRANES, ids=lambda crane: crane.__name__)
def test_energy_in_the_world_is_that_of_its_masses(crane: Callable[[], Any]) -> None:
    """Kinetic and potential energy equal those of all masses.

    Their positions in the world are differentiated.
    """
    scene, q, v, expected = crane()
    actual = crane_sim.energy(scene, q, v, TIME)
    # differences leave 1e-11, energies are some 100 J
    assert actual == pytest.approx(expected, rel=1e-10, abs=1e-8)
    # J: the base matters
    assert abs(actual - crane_sim.energy(scene, q, v, TIME, frame="base")) > 1.0


def test_a_run_gives_both_energies() -> None:
    """A payload of 10 kg still on a heaving base has ½ m ż² + m g z more energy in the world."""
    heave = {"amplitude": 0.5, "frequency": 2.0, "phase": 0.3}
    document = {
        "crane": "pendulum",
        "duration": 0.1,
        "rope": {"length": 1.0},
        "payload": {"mass": 10.0},
    }
    run = crane_sim.simulate(document | {"base_motion": {"heave": heave}})
    axes = np.array([motion({"heave": heave}, t)[:, 2] for t in run.t])
    more = 10.0 * (G * axes[:, 0] + 0.5 * axes[:, 1] ** 2)
    # it hangs along the base's z, and heaving swings nothing
    assert run.energy - run.energy_relative == pytest.approx(more, abs=1e-9)
    assert run.energy_relative == pytest.approx(-10.0 * G, abs=1e-9)
    assert float(np.ptp(more)) > 5.0  # J


def test_an_unknown_frame_is_rejected() -> None:
    """A frame that does not exist is named with those that do."""
    scene, q, v, _ = pendulum()
    with pytest.raises(crane_sim.SceneError, match=r"frame = 'ship': possible: world, base"):
        crane_sim.energy(scene, q, v, frame="ship")
