"""The elastic cable's equations: exact derivatives, power, start, and what files refuse."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.models.energy_meter import Meter
from crane_sim.numerics.jit import entry_point


def scene_of(
    masses: Any, lengths: Any, stiffness: float, initial: Any, **groups: Any
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
        "trolley": {"drive": "force", "mass": 50.0},
        "cable": cable | groups.pop("cable", {}),
        "initial": initial,
    }
    return crane_sim.load_scene(document | groups)


WAVE = {"kind": "sine", "amplitude": 0.3, "frequency": 2.0}
SHAKE = {"amplitude": 0.3, "frequency": 2.0, "phase": 0.4}
WINDY = {
    "wind": {
        "speed": 9.0,
        "direction": 0.7,
        "origin_height": 20.0,
        "profile": {"law": "logarithmic", "roughness": 0.5},
        "gusts": {"spectrum": "dryden", "intensity": 0.3},
    },
    "payload": {"mass": 5.0, "windage": {"area": 30.0, "drag_coefficient": 1.2}},
}
SPACE = WINDY | {
    "dimensions": 3,
    "bridge": {"drive": "force", "mass": 30.0},
    "hoist": {"drive": "force", "inertia": 4.0},
    "friction": {
        "trolley": {"coulomb": 1.0, "static": 2.0, "viscous": 0.5},
        "bridge": {"coulomb": 1.0, "static": 2.0, "stribeck": 2.0},
    },
    "forces": [{"node": 2, "axis": "y", "force": {"kind": "constant", "value": 3.0}}],
    "cable": {"damping": 40.0},
    "base_motion": {axis: SHAKE for axis in ("surge", "sway", "heave", "roll", "pitch", "yaw")},
}
IMPOSED = WINDY | {
    "trolley": {"drive": "prescribed", "motion": WAVE},
    "hoist": {"drive": "prescribed", "profile": {**WAVE, "offset": 1.0}},
    "forces": [
        {"node": 1, "axis": "z", "force": {"kind": "sine", "amplitude": 3.0, "frequency": 5.0}}
    ],
    "cable": {"damping": 40.0},
}


@entry_point
def state_of(p, q, v):
    """Return the state at t = 0.37 s."""
    return system.state(p, 0.37, q, v)


@entry_point
def derivative(p, x, u):
    """Return (dx/dt, power, kinetic + potential energy) at t = 0.37 s."""
    out = np.empty_like(x)
    system.rhs_into(p, 0.37, x, u, out, system.workspace(p))
    return out, system.power(p, 0.37, x, u), system.kinetic(p, x) + system.potential(p, x)


@entry_point
def solve_shifted_system(p, x, u, shift, b):
    """Overwrite b with the solution of (shift I - J) y = b at t = 0.37 s."""
    system.solve_shifted(
        p, system.factor_shifted(p, system.compute_jacobian(p, 0.37, x, u)[0], shift), b
    )


@pytest.mark.parametrize("groups", [SPACE, IMPOSED], ids=["space", "imposed"])
def test_derivatives_are_exact(groups: Any) -> None:
    """Banded systems are solved as full ones, and the energy changes by the power.

    The full matrix is that of differences.
    """
    rng, spatial = np.random.default_rng(3), "bridge" in groups
    shape = (3, 3 if spatial else 2)
    down = np.cumsum([[0.2, 0.1, -0.9][:: 1 if spatial else 2]] * 3, axis=0) + 0.1 * rng.normal(
        size=shape
    )
    start = {"positions": down.tolist(), "velocities": rng.normal(size=shape).tolist()}
    scene = scene_of([1.0, 2.0, 5.0], [1.0, 0.7, 0.9], 2e3, start, **groups)
    p, u = scene.model._replace(energy_meter=Meter()), tuple(rng.normal(0, 20, len(scene.actuated)))
    v = np.array(scene.initial_v) + np.append(
        [0.7, 0.4][: 1 + spatial], np.zeros(len(scene.initial_v) - 1 - spatial)
    )
    x = state_of(p, np.array(scene.initial_q), v)
    n, h = 2 * len(v) + 1, 1e-5
    jacobian, slope, power = np.zeros((n, n)), *derivative(p, x, u)[:2]
    for j in range(n):
        ahead, behind = x.copy(), x.copy()
        ahead[j], behind[j] = x[j] + h, x[j] - h
        jacobian[:, j] = (derivative(p, ahead, u)[0][:n] - derivative(p, behind, u)[0][:n]) / (
            2.0 * h
        )
    for shift in (3.0, 300.0):
        b = np.append(rng.normal(size=n), np.zeros(len(x) - n))
        expected = np.linalg.solve(shift * np.eye(n) - jacobian, b[:n])
        solve_shifted_system(p, x, u, shift, b)
        # differences of h = 1e-5 are right to about 1e-9 of a derivative
        assert np.max(np.abs(b[:n] - expected)) < 1e-7 * np.max(np.abs(expected))
    change = (derivative(p, x + h * slope, u)[2] - derivative(p, x - h * slope, u)[2]) / (2.0 * h)
    assert change == pytest.approx(power, rel=1e-6)


def test_links_start_where_axes_and_hoist_are() -> None:
    """Angles hang unstretched links from where an imposed trolley is.

    Length and rate are those of an imposed hoist.
    """
    groups = {
        "trolley": {"drive": "prescribed", "motion": {**WAVE, "offset": 2.0}},
        "hoist": {"drive": "prescribed", "profile": {**WAVE, "offset": 1.5}},
    }
    scene = scene_of([1.0, 2.0], [1.5, 0.5], 2e3, {"angles": [0.0, np.pi / 2]}, **groups)
    assert np.allclose(scene.initial_q, [2.0, 1.5, 2.0, -1.5, 2.5, -1.5], rtol=0, atol=1e-15)
    assert np.allclose(scene.initial_v, [0.6, 0.6, 0.6, -0.6, 0.6, -0.6], rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("cable", "groups", "message"),
    [
        ({"stiffness": None}, {}, "cable.stiffness = None: an elastic cable has one"),
        ({"inertia": [1.0]}, {}, "cable.inertia: belongs to rigid links"),
        ({"joints": {}}, {}, "joints: belongs to rigid links"),
        ({"slack": "stop"}, {}, "cable.slack = 'stop': belongs to rigid links"),
        ({"model": "rigid"}, {}, "cable.stiffness: belongs to cable.model: elastic"),
        (
            {},
            {"hoist": {"drive": "force"}},
            "hoist.inertia = 0: the massless winch needs rigid links",
        ),
        ({"stiffness": [1.0, 2.0]}, {}, "cable.stiffness: has 2 values, the cable has 1 links"),
    ],
    ids=lambda case: str(case)[:30],
)
def test_a_bad_scene_is_a_single_line_error(cable: Any, groups: Any, message: str) -> None:
    """Keys that an elastic cable lacks or cannot have are named."""
    with pytest.raises(crane_sim.SceneError) as caught:
        scene_of([1.0], [1.0], 1e3, {}, cable=cable, **groups)
    assert message in str(caught.value) and "\n" not in str(caught.value)
