"""The elastic cable: references, slack links, energy, vibrations, the rigid limit."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.integrators import (
    apply_pending_events,
    dense_output,
    integrate_to,
    make_event_log,
    start,
)
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.rodas import Rodas
from crane_sim.models import guards
from crane_sim.models.energy_meter import Meter
from crane_sim.numerics.jit import entry_point

DATA = Path(__file__).parents[1] / "data"
CHAIN = json.loads((DATA / "chain.json").read_text())
CASES = {
    name: case
    for name, case in json.loads((DATA / "overhead.json").read_text()).items()
    if "r0_z" in case["spec"]
}
BILATERAL = [name for name in CASES if name.endswith("bilateral")]
SLACK = [name for name in CASES if name.endswith("tension_only")]
G = 9.81


def scene_of(
    masses: Any, lengths: Any, stiffness: float, positions: Any, **groups: Any
) -> crane_sim.Scene:
    """Return the scene of an elastic cable below a force-driven trolley; groups add to it.

    `cable` is one of the groups.
    """
    cable = {
        "model": "elastic",
        "lengths": list(lengths),
        "node_masses": list(masses),
        "stiffness": stiffness,
    }
    document = {
        "crane": "overhead",
        "duration": 1.0,
        "trolley": {"drive": "force", "mass": groups.pop("trolley_mass", 50.0)},
        "cable": cable | groups.pop("cable", {}),
        "initial": {
            "positions": np.array(positions).tolist(),
            "velocities": groups.pop("velocities", None),
        },
    }
    return crane_sim.load_scene(document | groups)


def scene_of_case(spec: Any) -> crane_sim.Scene:
    """Return the scene of a reference case."""
    height = "r0_z" if "r0_z" in spec else "r0_y"  # the older references have their y upwards
    still = [0.0] * len(spec["m_i"])
    return scene_of(
        spec["m_i"],
        spec["l0"],
        spec["k"],
        np.column_stack([spec["r0_x"], spec[height]]),
        velocities=np.column_stack(
            [spec.get("rdot0_x", still), spec.get("rdot0_z", still)]
        ).tolist(),
        trolley_mass=spec["trolley_mass"],
        cable={"damping": spec["c"], "tension_only": spec.get("tension_only", False)},
    )


@entry_point
def integrate_case(method, p, q, v, u, times, nodes):
    """Return (last integration, energy gained less supplied [J]); fill nodes (K, N + 1, 3)."""
    x = system.state(p, 0.0, q, v)
    integration = apply_pending_events(
        system.switching(p), p, u, start(p, 0.0, x, make_event_log(system.switching(p)))
    )
    for i in range(len(times)):
        integration = integrate_to(method, p, u, integration, times[i], times[len(times) - 1])
        system.points(p, times[i], dense_output(method, p, u, integration, times[i]), nodes[i])
    gained = (
        system.kinetic(p, integration.x)
        + system.potential(p, integration.x)
        - system.kinetic(p, x)
        - system.potential(p, x)
    )
    return integration, gained - system.energy_supplied(p, integration.x)


def run(scene: crane_sim.Scene, method: Any, times: Any) -> tuple[Any, np.ndarray, float]:
    """Return (integration, nodes (K, N, 3), energy gained less supplied [J]) of a scene.

    It is metered and without efforts.
    """
    nodes = np.empty((len(times), system.point_count(scene.model), 3))
    model, efforts = scene.model._replace(energy_meter=Meter()), (0.0,) * len(scene.actuated)
    q, v = np.array(scene.initial_q), np.array(scene.initial_v)
    integration, lost = integrate_case(method, model, q, v, efforts, np.array(times), nodes)
    return integration, nodes[:, 1:], lost


@pytest.mark.long
@pytest.mark.parametrize(
    "method", [DOP853(1e-12, 1e-14), Rodas(1e-10, 1e-13)], ids=lambda m: type(m).__name__
)
def test_the_stiff_reference_is_met(method: Any) -> None:
    """Explicit and Rosenbrock method follow five springs of 1e7 N/m as the reference does.

    They keep the energy.
    """
    case = CHAIN["14_elastic_k1e7"]
    integration, nodes, lost = run(scene_of_case(case["spec"]), method, case["t"])
    # the reference has its y upwards
    expected = np.array(case["node_positions_xyz"])[..., [0, 2, 1]]
    assert np.max(np.abs(nodes - expected)) < max(1e-9, 10.0 * case["trusted_abs_error_m"])
    assert integration.x[0] == pytest.approx(case["x"][-1], abs=1e-9)
    assert abs(lost) < 1e-7  # of 1e5 J that swing; the tolerance of 1e-12 a step, some 1e4 steps


@pytest.mark.long
def test_a_cable_as_stiff_as_steel() -> None:
    """Five springs of 1e9 N/m under one tonne move as the reference does.

    Axial vibrations are resolved.
    """
    case = CASES["16_elastic_k1e9"]
    _, nodes, _ = run(scene_of_case(case["spec"]), Rodas(1e-8, 1e-10), case["t"])
    expected = np.array(case["node_positions_xyz"])
    assert np.max(np.abs(nodes - expected)) < max(1e-9, 10.0 * case["trusted_abs_error_m"])


@pytest.mark.long(cases=["15_toss_N3_bilateral"])
@pytest.mark.parametrize("name", BILATERAL)
def test_springs_that_push_and_dampers(name: str) -> None:
    """A payload thrown beyond the horizontal on damped springs lands as the reference does.

    Its losses are metered.
    """
    case = CASES[name]
    _, nodes, lost = run(scene_of_case(case["spec"]), DOP853(1e-12, 1e-14), case["t"])
    expected = np.array(case["node_positions_xyz"])
    assert np.max(np.abs(nodes - expected)) < max(1e-9, 10.0 * case["trusted_abs_error_m"])
    assert abs(lost) < 1e-8  # of 1e3 J, to the tolerance of 1e-12 a step


@pytest.mark.parametrize("name", SLACK)
def test_a_slack_cable(name: str) -> None:
    """Links go slack and taut when the reference says, and the payload flies freely in between."""
    case = CASES[name]
    times, modes = np.array(case["event_times"]), case["modes_after_event"]
    taut = next(i for i, mode in enumerate(modes) if mode > 0)
    before = [t for t in case["t"] if t < times[taut]]
    integration, nodes, _ = run(
        scene_of_case(case["spec"]), DOP853(1e-12, 1e-14), [*before, float(times[taut]) + 1e-3]
    )
    events = integration.event_log.rows[: taut + 1]
    # after the first jolt errors grow without bound, before it they are those of the integration
    assert np.max(np.abs(nodes[:-1] - np.array(case["node_positions_xyz"])[: len(before)])) < 1e-8
    assert np.max(np.abs(events[:, 0] - times[: taut + 1])) < 1e-8
    expected = [
        (guards.Guard.LINK, abs(mode) - 1, guards.TAUT if mode > 0 else guards.SLACK)
        for mode in modes[: taut + 1]
    ]
    assert [guards.decode(int(number)) for number in events[:, 1]] == expected


def hanging(
    mass: float, length: float, stiffness: float, below: float, **cable: Any
) -> crane_sim.Scene:
    """Return a mass on one spring, that much below where it would hang."""
    return scene_of(
        [mass], [length], stiffness, [[0.0, -length - mass * G / stiffness - below]], cable=cable
    )


@pytest.mark.parametrize(
    "method", [DOP853(1e-11, 1e-13), Rodas(1e-9, 1e-11)], ids=lambda m: type(m).__name__
)
def test_a_spring_bounces_with_its_frequency(method: Any) -> None:
    """A mass on one vertical spring moves as a cosine of the frequency sqrt(k / m)."""
    # it needs a state that is an array, as that of a cable that may go slack
    slack = isinstance(method, Rodas)
    scene, period = (
        hanging(3.0, 2.0, 500.0, 0.05, tension_only=slack),
        2.0 * np.pi * np.sqrt(3.0 / 500.0),
    )
    times = np.array([0.25, 0.5, 1.0, 5.25]) * period
    _, nodes, _ = run(scene, method, times)
    rest = -2.0 - 3.0 * G / 500.0
    # 1e-9 a step, some hundred steps
    assert nodes[:, 0, 2] - rest == pytest.approx(
        -0.05 * np.cos(2.0 * np.pi * times / period), abs=2e-8
    )
    assert np.max(np.abs(nodes[:, 0, 0])) == 0.0


def test_the_rigid_cable_is_the_limit() -> None:
    """The distance from the rigid cable's reference shrinks like 1 / k."""
    case = CHAIN["02_N2_large_angle"]
    spec, times = case["spec"], case["t"][:1]
    rigid = np.array(case["node_positions_xyz"])[:1][..., [0, 2, 1]]
    a, lengths = np.array(spec["alpha0"]), np.array(spec["l_i"])
    start = np.cumsum(np.column_stack([lengths * np.sin(a), -lengths * np.cos(a)]), axis=0)
    rates = np.array(spec.get("alphadot0") or [0.0] * len(a)) * lengths
    speeds = np.cumsum(np.column_stack([rates * np.cos(a), rates * np.sin(a)]), axis=0)
    groups = {"trolley_mass": spec["trolley_mass"], "velocities": speeds.tolist()}
    errors = []
    for stiffness in (1e6, 1e7, 1e8):
        # vibrations of the first elongation die out
        damped = {"damping": 0.2 * float(np.sqrt(stiffness))}
        scene = scene_of(spec["m_i"], lengths, stiffness, start, cable=damped, **groups)
        errors.append(np.max(np.abs(run(scene, Rodas(1e-8, 1e-10), times)[1] - rigid)))
    assert errors[1] / errors[0] == pytest.approx(0.1, rel=0.1) and errors[2] / errors[
        1
    ] == pytest.approx(0.1, rel=0.1)
