"""Closed forms of planar overhead cranes against the tree of joints, at random states."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.models.guards import Guard, encode

T = 0.37  # s
WAVE = {"kind": "sine", "amplitude": 0.3, "frequency": 2.0, "offset": 1.0}
ONE = {"lengths": [1.2], "node_masses": [5.0]}
TWO = {"lengths": [1.2, 0.7], "node_masses": [1.0, 5.0]}
MANY = {"lengths": [1.0, 0.7, 0.4, 0.6], "node_masses": [1.0, 2.0, 0.5, 9.0]}
SEA = {
    "surge": {"amplitude": 0.5, "frequency": 0.8},
    "heave": {"amplitude": 0.7, "frequency": 0.6, "phase": 0.4},
    "pitch": {"amplitude": "5 deg", "frequency": 0.9, "phase": 1.0},
}
PUSH = [
    {"node": 2, "axis": "x", "force": WAVE},
    {"node": 4, "axis": "z", "force": {"kind": "constant", "value": 7.0}},
]
DRY = {"trolley": {"coulomb": 3.0, "static": 5.0, "viscous": 0.7, "stribeck": 0.2}}
BRISTLES = {
    "trolley": {
        "coulomb": 3,
        "static": 5,
        "stribeck": 0.1,
        "stiffness": 1e4,
        "damping": 9,
        "viscous": 0.4,
    }
}
EVENTS = [{"at": 0.1, "set": {"payload": {"mass": 7.0}}}]
WINDY = {
    "wind": {"speed": 12.0, "direction": "20 deg"},
    "payload": {"mass": 9.0, "windage": {"area": 1.3, "drag_coefficient": 1.1}},
}
FORCE = {"x": WAVE, "z": {"kind": "constant", "value": -6.0}}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "rod": ("RodCrane", {"cable": ONE}),
    "rod, fixed": ("RodCrane", {"cable": ONE, "trolley": {"drive": "fixed"}}),
    "rod, prescribed": (
        "RodCrane",
        {"cable": ONE, "trolley": {"drive": "prescribed", "motion": WAVE}},
    ),
    "rod, drum": (
        "RodCrane",
        {"cable": ONE, "hoist": {"drive": "force", "inertia": 3.0}, "friction": DRY},
    ),
    "rod, winch": ("RodCrane", {"cable": ONE, "hoist": {"drive": "force"}}),
    "rod, profile": (
        "RodCrane",
        {"cable": ONE, "hoist": {"drive": "prescribed", "profile": WAVE | {"offset": 1.2}}},
    ),
    "rod, events": ("RodCrane", {"cable": ONE, "events": EVENTS, "lugre": BRISTLES}),
    "double": ("DoubleCrane", {"cable": TWO}),
    "planar": ("PlanarCrane", {"cable": MANY}),
    "planar, drum": (
        "PlanarCrane",
        {"cable": MANY, "hoist": {"drive": "force", "inertia": 3.0}, "friction": DRY},
    ),
    "planar, winch": (
        "PlanarCrane",
        {"cable": MANY, "hoist": {"drive": "force"}, "lugre": BRISTLES},
    ),
    "planar, events": ("PlanarCrane", {"cable": MANY, "events": EVENTS}),
    "planar, pushed": ("PlanarCrane", {"cable": MANY, "forces": PUSH}),
    "planar, at sea": (
        "PlanarCrane",
        {"cable": MANY, "base_motion": SEA, "hoist": {"drive": "force", "inertia": 3.0}},
    ),
    "planar, in air": (
        "PlanarCrane",
        {"cable": ONE, "payload_drag": {"coefficient": 2.0}, "payload_force": FORCE},
    ),
    "planar, in wind": (
        "PlanarCrane",
        {"cable": MANY, "base_motion": SEA, "wind": WINDY["wind"]} | WINDY,
    ),
}


def scene_of(groups: dict[str, Any]) -> crane_sim.Scene:
    """Return the scene of a trolley of 8 kg, unless groups say otherwise."""
    return crane_sim.load_scene(
        {"crane": "overhead", "duration": 1.0, "trolley": {"mass": 8.0}} | groups
    )


def answers(scene: crane_sim.Scene, q: Any, v: Any, efforts: Any) -> tuple[Any, ...]:
    """Return accelerations, tensions and (energies, those of a base, power) in a state."""
    p = scene.model
    x, u, tensions = (
        system.state(p, T, q, v),
        system.efforts_from_row(p, efforts),
        np.empty((1, system.link_count(p))),
    )
    system.tensions(p, T, x, u, tensions, 0, 0)
    whole = (
        system.kinetic(p, x),
        system.potential(p, x),
        *system.base_energy(p, T, x),
        system.power(p, T, x, u),
    )
    return np.array(system.acceleration(p, T, x, u)), tensions[0], np.array(whole)


def lift(q: Any, v: Any, n: int) -> tuple[Any, Any]:
    """Return positions and velocities in space of planar joints; the last n are link angles."""
    top, rates, a, w = q[:-n], v[:-n], q[-n:], v[-n:]
    units = np.stack([np.sin(a), 0.0 * a, -np.cos(a)], axis=1)
    turning = w[:, None] * np.stack([np.cos(a), 0.0 * a, np.sin(a)], axis=1)
    insert = np.insert(top, 1, 0.0), np.insert(rates, 1, 0.0)
    return np.concatenate([insert[0], units.ravel()]), np.concatenate([insert[1], turning.ravel()])


def random_state(rng: np.random.Generator, scene: crane_sim.Scene, n: int) -> tuple[Any, Any]:
    """Return joint positions and velocities; what does not move by a force is as it is at t = 0."""
    q, v = np.array(scene.initial_q), np.array(scene.initial_v)
    q[-n:], v[-n:] = rng.normal(0.0, 1.0, (2, n))
    for i, name in enumerate(scene.joint_names[:-n]):
        if name in scene.actuated:
            v[i] = rng.normal()
    return q, v


@pytest.mark.parametrize("case", CASES)
def test_links_in_the_plane_are_those_of_the_tree(case: str) -> None:
    """A closed form agrees with the crane in space on a fixed bridge.

    It has the same accelerations, tensions, energies and power.
    """
    name, groups = CASES[case]
    flat, rng = scene_of(groups), np.random.default_rng(7)
    space = scene_of(groups | {"dimensions": 3})
    assert (type(flat.model).__name__, type(space.model).__name__) == (name, "SuspendedCrane")
    n = len(groups["cable"]["lengths"])
    for _ in range(3):
        (q, v), efforts = random_state(rng, flat, n), rng.normal(0.0, 20.0, len(flat.actuated))
        mine, theirs = answers(flat, q, v, efforts), answers(space, *lift(q, v, n), efforts)
        along = np.stack([np.cos(q[-n:]), 0.0 * q[-n:], np.sin(q[-n:])], axis=1)
        turning = np.sum(along * theirs[0][-3 * n :].reshape(n, 3), axis=1)
        accelerations = np.concatenate([np.delete(theirs[0][: -3 * n], 1), turning])
        for got, expected in zip(mine, (accelerations, *theirs[1:]), strict=True):
            # rounding of some hundred terms, which the largest of them bounds
            np.testing.assert_allclose(
                got, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max()
            )


def test_one_spring_is_the_elastic_cable() -> None:
    """The closed form of one spring agrees with the elastic cable.

    It has the same accelerations, tension, energies and power.
    """
    cable = ONE | {"model": "elastic", "stiffness": 2e3, "damping": 7.0}
    none = [{"node": 1, "axis": "x", "force": {"kind": "constant", "value": 0.0}}]
    alone, chain, rng = (
        scene_of({"cable": cable}),
        scene_of({"cable": cable, "forces": none}),
        np.random.default_rng(3),
    )
    assert (type(alone.model).__name__, type(chain.model).__name__) == (
        "SpringCrane",
        "ElasticCrane",
    )
    for _ in range(3):
        q, v, efforts = (
            np.array(alone.initial_q) + rng.normal(0, 0.3, 3),
            rng.normal(0.0, 1.0, 3),
            rng.normal(0, 20, 1),
        )
        for got, expected in zip(
            answers(alone, q, v, efforts), answers(chain, q, v, efforts), strict=True
        ):
            # rounding
            np.testing.assert_allclose(
                got, expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max()
            )


def test_what_is_taken_up_at_rest_jerks_an_elastic_cable() -> None:
    """A load taken up at rest shares the payload's momentum; the energy balance holds.

    The payload's velocity jumps.
    """
    spring = ONE | {"model": "elastic", "stiffness": 5e3}
    event = {"at": 0.1, "velocity": [0.0, 0.0, 0.0], "set": {"payload": {"mass": 7.0}}}
    groups = {
        "cable": spring,
        "duration": 0.2,
        "initial": {"angles": [0.4], "rates": [1.5]},
        "events": [event],
    }
    run = crane_sim.simulate(
        scene_of(groups | {"integrator": {"method": "dop853", "rtol": 1e-11, "atol": 1e-13}})
    )
    p, q, v = run.scene.model, np.array(run.scene.initial_q), np.array([0.3, 1.0, -2.0])
    y, _, _ = system.apply_reset_map(
        p, 0.1, system.state(p, 0.0, q, v), (0.0,), encode(Guard.PAYLOAD, 0)
    )
    np.testing.assert_allclose(system.joints(p, y)[1], [0.3, 5.0 / 7.0, -10.0 / 7.0], rtol=1e-15)
    assert run.summary["energy_audit_max"] < 1e-9
    with pytest.raises(
        SceneError, match=r"events\[0\].velocity: takes 3 dimensions or an elastic cable"
    ):
        scene_of({"cable": ONE, "events": [event]})
