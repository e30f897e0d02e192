"""The planar overhead crane: second derivation, conservation, limits, imposed motions.

The second derivation has 60 digits.
"""

from typing import Any

import mpmath
import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.states import add_scaled
from crane_sim.simulation.rollout import simulate

G = 9.81


def scene_of(
    masses: Any, lengths: Any, angles: Any, rates: Any = (), **groups: Any
) -> crane_sim.Scene:
    """Return the scene of a chain below a force-driven trolley of 5 kg; groups change it."""
    document = {
        "crane": "overhead",
        "duration": 1.0,
        "trolley": {"drive": "force", "mass": 5.0},
        "cable": {"lengths": list(lengths), "node_masses": list(masses)},
        "initial": {"angles": list(angles), "rates": list(rates)},
    }
    return crane_sim.load_scene(document | groups)


def exact(m: Any, lengths: Any, q: Any, v: Any, force: float, trolley: float) -> np.ndarray:
    """Return the accelerations from the mass matrix in absolute angles, solved with 60 digits."""
    n = len(m)
    with mpmath.workdps(60):
        mass, bias = mpmath.matrix(n + 1), mpmath.matrix(n + 1, 1)
        below = [mpmath.fsum(m[i:]) for i in range(n)]
        a, w = [mpmath.mpf(x) for x in q[1:]], [mpmath.mpf(x) for x in v[1:]]
        mass[0, 0] = mpmath.mpf(trolley) + below[0]
        bias[0] = mpmath.mpf(force)
        for j in range(n):
            mass[0, j + 1] = mass[j + 1, 0] = below[j] * lengths[j] * mpmath.cos(a[j])
            bias[0] += below[j] * lengths[j] * mpmath.sin(a[j]) * w[j] ** 2
            bias[j + 1] = -mpmath.mpf(G) * below[j] * lengths[j] * mpmath.sin(a[j])
            for k in range(n):
                coupling = below[max(j, k)] * mpmath.mpf(lengths[j]) * lengths[k]
                mass[j + 1, k + 1] = coupling * mpmath.cos(a[j] - a[k])
                bias[j + 1] -= coupling * mpmath.sin(a[j] - a[k]) * w[k] ** 2
        return np.array([float(x) for x in mpmath.lu_solve(mass, bias)])


@pytest.mark.parametrize(("n", "ratio"), [(1, 2.0), (2, 1.0), (3, 10.0), (10, 1e4), (30, 1e8)])
def test_accelerations_equal_a_second_derivation(n: int, ratio: float) -> None:
    """Closed forms and tension form equal the Lagrange form in 60 digits.

    A ton on light links is included.
    """
    rng = np.random.default_rng(n)
    m, lengths = [0.1] * (n - 1) + [0.1 * ratio], rng.uniform(0.5, 1.5, n)
    for _ in range(3):
        q, v = np.array([0.3, *rng.uniform(-1, 1, n)]), rng.normal(0, 1, n + 1)
        actual = crane_sim.acceleration(scene_of(m, lengths, q[1:]), q, v, [7.0])
        expected = exact(m, lengths, q, v, 7.0, 5.0)
        # the tridiagonal system is positive definite; its condition does not grow with the ratio
        assert np.max(np.abs(actual - expected)) < 1e-12 * np.max(np.abs(expected))


@entry_point
def balance(p, t, q, v, u, h):
    """Return (dE/dt by central differences along the motion, power) at a state."""
    x = system.state(p, t, q, v)
    dx = system.rhs(p, t, x, u)
    ahead, behind = add_scaled(x, h, dx), add_scaled(x, -h, dx)
    gained = system.kinetic(p, ahead) - system.kinetic(p, behind)
    gained += system.potential(p, ahead) - system.potential(p, behind)
    return gained / (2.0 * h), system.power(p, t, x, u)


WAVE = {"kind": "sine", "amplitude": 0.3, "frequency": 2.0}
PUSH = {"node": 2, "axis": "x", "force": {"kind": "sine", "amplitude": 5.0, "frequency": 3.0}}
GROUPS: dict[str, dict[str, Any]] = {
    "force hoist, joints": {
        "hoist": {"drive": "force", "inertia": 2.0},
        "joints": {"stiffness": [3.0, 2.0, 1.0], "damping": 0.4},
    },
    "prescribed": {"trolley": {"drive": "prescribed", "motion": WAVE}, "forces": [PUSH]},
    "fixed, rods": {"trolley": {"drive": "fixed"}, "cable": {"inertia": [0.3, 0.2, 0.1]}},
    "massless hoist, friction": {
        "hoist": {"drive": "force"},
        "friction": {"trolley": {"coulomb": 3.0, "static": 4.0, "viscous": 0.5}},
    },
}


@pytest.mark.parametrize("kind", GROUPS, ids=lambda name: name.replace(", ", "-").replace(" ", "-"))
@pytest.mark.parametrize("n", [1, 3])
def test_power_balance(kind: str, n: int) -> None:
    """The energy changes by the power of efforts, imposed motions, forces and losses alone."""
    groups = GROUPS[kind]
    if n == 1 and kind in ("prescribed", "fixed, rods"):
        groups = {"trolley": groups["trolley"]}
    if n == 1 and kind == "force hoist, joints":
        groups = {"hoist": {"drive": "prescribed", "profile": {**WAVE, "offset": 1.0}}}
    cable = {"lengths": [1.0, 0.7, 0.4][:n], "node_masses": [1.0, 2.0, 5.0][:n]} | groups.get(
        "cable", {}
    )
    scene = scene_of([1.0], [1.0], [0.3, -0.5, 0.9][:n], **{**groups, "cable": cable})
    rng = np.random.default_rng(5)
    for _ in range(3):
        q, v = np.array(scene.initial_q), rng.normal(0, 1, len(scene.initial_v))
        v[0] = 0.0 if "fixed" in kind else v[0]
        u = tuple(rng.normal(0, 20, len(scene.actuated)))
        change, power = balance(scene.model, 0.37, q, v, u, 1e-5)
        # as for the knuckle crane: h^2, and rounding / h
        assert change == pytest.approx(power, rel=1e-6, abs=1e-5)


def test_an_imposed_motion_is_followed() -> None:
    """A prescribed trolley and a hoist through a table's knots move as their functions say.

    The functions are of time.
    """
    profile = {"kind": "table", "times": [0.2, 0.4, 0.7], "values": [1.0, 0.9, 0.6]}
    groups = {
        "trolley": {"drive": "prescribed", "motion": WAVE},
        "hoist": {"drive": "prescribed", "profile": profile},
    }
    run = simulate(scene_of([5.0], [1.0], [0.2], **groups))
    # integrated to 1e-11
    assert np.allclose(run.q[:, 0], 0.3 * np.sin(2.0 * run.t), rtol=0, atol=1e-10)
    for t, length in zip([0.0, 0.2, 0.4, 0.7, 1.0], [1.0, 1.0, 0.9, 0.6, 0.6], strict=True):
        assert run.q[round(t * 100), 1] == pytest.approx(length, abs=1e-10)
    assert run.summary["energy_audit_error"] < 1e-10


def test_massless_nodes_merge() -> None:
    """A massless node on a straight stretch is none: its two links are one.

    Nothing is divided by zero.
    """
    merged = scene_of([1.0, 0.0, 5.0], [1.0, 0.4, 0.3], [0.2, 0.3, 0.3])
    plain = scene_of([1.0, 5.0], [1.0, 0.7], [0.2, 0.3])
    assert merged.joint_names == plain.joint_names
    still = [0.0, 0.0, 0.0]
    actual, expected = (
        crane_sim.acceleration(scene, [0.0, 0.2, 0.3], still, [1.0]) for scene in (merged, plain)
    )
    assert np.array_equal(actual, expected)
