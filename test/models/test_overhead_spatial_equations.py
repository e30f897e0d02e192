"""Equations of the overhead crane in space against a second derivation, and their power.

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

Array = np.ndarray[Any, Any]
G = 9.81
exactly = np.vectorize(mpmath.mpf, otypes=[object])


def scene_of(masses: Any, lengths: Any, **groups: Any) -> crane_sim.Scene:
    """Return the scene of a chain below a 5 kg trolley on a 3 kg bridge; groups change it."""
    document = {
        "crane": "overhead",
        "dimensions": 3,
        "duration": 1.0,
        "trolley": {"drive": "force", "mass": 5.0},
        "bridge": {"drive": "force", "mass": 3.0},
        "cable": {"model": "rigid", "lengths": list(lengths), "node_masses": list(masses)},
    }
    return crane_sim.load_scene(document | groups)


def state_of(rng: np.random.Generator, scene: crane_sim.Scene, n: int) -> tuple[Array, Array]:
    """Return random positions and velocities: unit vectors, perpendicular rates, to rounding."""
    units, rates = rng.normal(0, 1, (2, n, 3))
    units /= np.linalg.norm(units, axis=1)[:, None]
    rates -= np.sum(units * rates, axis=1)[:, None] * units
    axes = len(scene.initial_q) - 3 * n
    q, v = np.array(scene.initial_q[:axes]), rng.normal(0, 1, axes)
    return np.concatenate([q, units.ravel()]), np.concatenate([v, rates.ravel()])


def normalise_links(q: Array, v: Array, n: int) -> tuple[Array, Array]:
    """Return unit vectors and rates (n, 3) in many digits, without the given ones' rounding."""
    units, rates = (exactly(part[-3 * n :]).reshape(n, 3) for part in (q, v))
    units = (
        units / exactly([mpmath.sqrt(square) for square in np.sum(units * units, axis=1)])[:, None]
    )
    return units, rates - np.sum(units * rates, axis=1)[:, None] * units


def exact(m: Any, lengths: Any, q: Array, v: Array, axes: Any, hoist: Any) -> Array:
    """Return the joint accelerations from Newton's law and link constraints, in 60 digits.

    Newton's law is that for every node.

    Args:
        m, lengths: masses [kg] and lengths [m] of the links.
        q, v: joint positions and velocities.
        axes: of x and y: (mass [kg], force [N]), or (None, acceleration [m/s²]) of an imposed
            motion.
        hoist: the same of the first length, a mass 0 allowed; None where there is none.
    """
    with mpmath.workdps(60):
        n, (units, rates) = len(m), normalise_links(q, v, len(m))
        length, length_rate = exactly(lengths), exactly(np.zeros(n))
        if hoist is not None:
            length[0], length_rate[0] = mpmath.mpf(q[2]), mpmath.mpf(v[2])
        # unknown: accelerations of nodes, tensions, acceleration of the length
        nodes, last = 3 * n + 3, 4 * n + 3
        a, b = exactly(np.zeros((last + 1, last + 1))), exactly(np.zeros(last + 1))
        for k in range(n):
            low, link = 3 * k + 3, nodes + k
            for c in range(3):
                a[low + c, low + c], b[low + c] = (
                    mpmath.mpf(m[k]),
                    -mpmath.mpf(m[k]) * G if c == 2 else 0,
                )
                a[low + c, link], a[low - 3 + c, link] = units[k, c], -units[k, c]
                a[link, low + c], a[link, low - 3 + c] = units[k, c], -units[k, c]
            b[link] = -length[k] * np.sum(rates[k] * rates[k])
        a[nodes, last], a[last, nodes] = mpmath.mpf(-1), mpmath.mpf(-1)
        for row, (mass, rhs) in (
            (0, axes[0]),
            (1, axes[1]),
            (2, (None, 0.0)),
            (last, hoist or (None, 0.0)),
        ):
            a[row] = a[row] if mass is not None else 0 * a[row]
            a[row, row], b[row] = mpmath.mpf(1.0 if mass is None else mass), mpmath.mpf(rhs)
        x = exactly(list(mpmath.lu_solve(mpmath.matrix(a.tolist()), mpmath.matrix(b.tolist()))))
        length_acc = np.append(x[last], exactly(np.zeros(n - 1)))[:, None]
        apart = np.diff(x[:nodes].reshape(n + 1, 3), axis=0)
        turning = (apart - length_acc * units - 2 * length_rate[:, None] * rates) / length[:, None]
        return np.concatenate(
            [x[:2], x[last:] if hoist is not None else [], turning.ravel()]
        ).astype(float)


def error(actual: Any, expected: Array) -> float:
    """Return the largest error relative to the largest acceleration."""
    return float(np.max(np.abs(actual - expected)) / np.max(np.abs(expected)))


@pytest.mark.parametrize(("n", "ratio"), [(1, 2.0), (2, 1.0), (10, 1e4), (10, 1e8)])
def test_accelerations_equal_a_second_derivation(n: int, ratio: float) -> None:
    """The tension form equals Newton's law for every node in 60 digits.

    Heavy payloads on light cables are included.
    """
    rng = np.random.default_rng(n)
    m, lengths = [0.1] * (n - 1) + [0.1 * ratio], rng.uniform(0.5, 1.5, n)
    scene = scene_of(m, lengths)
    for _ in range(2):
        q, v = state_of(rng, scene, n)
        actual = crane_sim.acceleration(scene, q, v, [7.0, -3.0])
        # the tridiagonal system is positive definite; its condition does not grow with the ratio
        assert error(actual, exact(m, lengths, q, v, ((5.0, 7.0), (8.0, -3.0)), None)) < 1e-12


@entry_point
def balance(p, t, q, v, row, h):
    """Return (accelerations, dE/dt, power, actuated coordinates) under the efforts in `row`.

    dE/dt is by central differences.
    """
    u = system.efforts_from_row(p, row)
    x = system.project(p, system.state(p, t, q, v))
    dx = system.rhs(p, t, x, u)
    ahead, behind = add_scaled(x, h, dx), add_scaled(x, -h, dx)
    gained = system.kinetic(p, ahead) - system.kinetic(p, behind)
    gained += system.potential(p, ahead) - system.potential(p, behind)
    return (
        system.acceleration(p, t, x, u),
        gained / (2.0 * h),
        system.power(p, t, x, u),
        system.actuated_joints(p, x),
    )


WAVE = {"kind": "sine", "amplitude": 0.3, "frequency": 2.0}
IMPOSED = None, -0.3 * 4.0 * np.sin(2.0 * 0.37)  # its acceleration at 0.37 s
STILL = None, 0.0
DRIVES: dict[str, tuple[dict[str, Any], Any, Any]] = {
    "forces": ({}, ((5.0, 11.0), (8.0, -4.0)), None),
    "one axis": ({"bridge": None}, ((5.0, 11.0), STILL), None),
    "bridge only": ({"trolley": {"drive": "fixed", "mass": 2.0}}, (STILL, (5.0, 11.0)), None),
    "imposed": ({"trolley": {"drive": "prescribed", "motion": WAVE}}, (IMPOSED, (3.0, 11.0)), None),
    "imposed and carried": (
        {"trolley": {"drive": "prescribed", "motion": WAVE, "mass": 2.0}},
        (IMPOSED, (5.0, 11.0)),
        None,
    ),
    "hoist": (
        {"hoist": {"drive": "force", "inertia": 2.0}},
        ((5.0, 11.0), (8.0, -4.0)),
        (2.0, 9.0),
    ),
    "massless hoist": ({"hoist": {"drive": "force"}}, ((5.0, 11.0), (8.0, -4.0)), (0.0, 9.0)),
    "imposed hoist": (
        {
            "hoist": {"drive": "prescribed", "profile": WAVE | {"offset": 1.0}},
            "trolley": {"drive": "fixed"},
        },
        (STILL, (3.0, 11.0)),
        IMPOSED,
    ),
}


@pytest.mark.parametrize("drive", DRIVES, ids=lambda name: name.replace(" ", "-"))
def test_every_drive(drive: str) -> None:
    """For every drive accelerations are the second derivation's, power is the energy's gain."""
    groups, axes, hoist = DRIVES[drive]
    m, lengths = [1.0, 2.0, 5.0], [1.0, 0.7, 0.4]
    scene, rng = scene_of(m, lengths, **groups), np.random.default_rng(5)
    driven = [i for i, (mass, _) in enumerate((*axes, hoist or STILL)) if mass is not None]
    u = np.array([(*axes, hoist or STILL)[i][1] for i in driven])
    for _ in range(3):
        q, v = state_of(rng, scene, 3)
        v[:2] = [0.0 if axis is STILL else rate for axis, rate in zip(axes, v[:2], strict=True)]
        actual, change, power, actuated = balance(scene.model, 0.37, q, v, u, 1e-5)
        # nothing heavy: rounding only
        assert error(actual, exact(m, lengths, q, v, axes, hoist)) < 1e-13
        # the step's square, and rounding over the step
        assert change == pytest.approx(power, rel=1e-6, abs=1e-5)
        assert np.array_equal(actuated, [q[driven], v[driven]])


def test_forces_on_nodes() -> None:
    """A force on a node along each axis accelerates it as Newton's law says.

    Its power is what the energy gains.
    """
    pushes = [("x", 2.0), ("y", -3.0), ("z", 50.0)]
    forces = [
        {"node": 1, "axis": axis, "force": {"kind": "constant", "value": f}} for axis, f in pushes
    ]
    scene = scene_of([2.0], [1.0], forces=forces, trolley={"drive": "fixed"}, bridge=None)
    q, v = state_of(np.random.default_rng(3), scene, 1)
    v[:2] = 0.0
    unit, rate = q[2:], v[2:]
    actual, change, power, _ = balance(scene.model, 0.0, q, v, np.zeros(0), 1e-5)
    pull = np.array([2.0, -3.0, 50.0 - 2.0 * G]) / 2.0
    assert np.allclose(
        actual[2:], pull - (pull @ unit) * unit - (rate @ rate) * unit, rtol=0, atol=1e-13
    )
    assert change == pytest.approx(power, rel=1e-6, abs=1e-5)
