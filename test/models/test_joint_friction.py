"""Friction of joints of tower, mobile, bridge and gantry cranes: events, bristles, motors, and what they meet."""

from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from friction_events import Reference, Rubbing, Vector, check_events, sines
from mpmath import mp, mpf
from scipy.integrate import solve_ivp

import crane_sim
from crane_sim import load_scene, system
from crane_sim.models.supports.actuated_support import ActuatedSupport

pytestmark = pytest.mark.interpreted

ACCURATE = {"method": "dop853", "rtol": 1e-12, "atol": 1e-12}
BRIDGE: dict[str, Any] = {
    "crane": "bridge",
    "duration": 2.0,
    "trolley": {"mass": 1000.0},
    "bridge": {"mass": 3000.0},
    "payload": {"mass": 800.0},
    "rope": {"drive": "locked"},
    "initial": {"q": [0.0, 0.0, 5.0, 0.1, 0.05]},
    "integrator": ACCURATE,
}
AMPLITUDE, FREQUENCY, COULOMB, STATIC = 900.0, 3.0, 500.0, 700.0


def bridge_events(end: float) -> list[tuple[float, str]]:
    """Return the events of a mass on a rail under a sinusoidal force, from the roots of its speed in 30 digits."""
    with mp.workdps(30):
        a, w, fc, breaks = mpf(AMPLITUDE), mpf(FREQUENCY), mpf(COULOMB), mpmath.asin(mpf(STATIC) / mpf(AMPLITUDE))
        t, k, events = breaks / w, 0, []
        while t < end:
            sign, begin = (-1) ** k, t
            events.append((t, "the bridge slips forwards" if sign > 0 else "the bridge slips backwards"))

            def momentum(at: Any, begin: Any = begin, sign: int = sign) -> Any:
                return sign * a / w * (mpmath.cos(w * begin) - mpmath.cos(w * at)) - fc * (at - begin)

            t = mpmath.findroot(momentum, (begin + mpf("0.7"), begin + mpf("1.0")), solver="anderson")
            assert abs(a * mpmath.sin(w * t)) < STATIC and t - begin > mpf("0.7")
            events.append((t, "the bridge sticks"))
            k += 1
            t = (breaks + k * mp.pi) / w
        return [(float(at), what) for at, what in events if at < end]


def test_a_bridge_sticks_and_slips_at_the_instants_of_the_closed_form() -> None:
    """Under a sinusoidal force with its trolley held, a bridge sticks and slips at the roots of its speed."""
    sine = {"kind": "sine", "amplitude": AMPLITUDE, "frequency": FREQUENCY}
    group = {"bridge": {"coulomb": COULOMB, "static": STATIC}, "trolley": {"coulomb": 1.0, "static": 1.0}}
    light = {"payload": {"mass": 1e-9}, "initial": {"q": [0.0, 0.0, 5.0, 0.0, 0.0]}}  # kg: a part of 1e-13
    run = crane_sim.simulate(BRIDGE | light | {"duration": 4.0, "friction": group, "inputs": {"bridge": sine}})
    expected = bridge_events(4.0)
    assert len(expected) == 7 and [what for _, what in run.events] == [what for _, what in expected]
    np.testing.assert_allclose([t for t, _ in run.events], [t for t, _ in expected], rtol=0.0, atol=1e-12)
    assert run.summary["energy_audit_max"] < 1e-9


SECTIONS = (5.0, 2.0, 4.0), (3.0, 1.5, 2.0)  # mass, centre, inertia of the base section and of the telescoped one
FOOT, SUPERSTRUCTURE, LOAD, ROPE = (0.5, 1.2), 30.0, 10.0, 2.5
DRY: Rubbing = {
    "slew": {"coulomb": 18.0, "static": 24.0, "stribeck": 0.05},
    "boom": {"coulomb": 95.0, "static": 110.0, "viscous": 5.0},
    "telescope": {"coulomb": 25.0, "static": 32.0, "stribeck": 0.1, "viscous": 2.0},
}
WAVES = {"slew": (30.0, 4.0, 0.0), "boom": (160.0, 7.0, 781.0), "telescope": (60.0, 5.0, 74.0)}
MOBILE: dict[str, Any] = {
    "crane": "mobile",
    "duration": 2.0,
    "superstructure": {"inertia": SUPERSTRUCTURE, "foot": list(FOOT)},
    "boom": dict(zip(("mass", "centre", "inertia"), SECTIONS[0], strict=True)),
    "telescope": dict(zip(("mass", "centre", "inertia"), SECTIONS[1], strict=True)),
    "rope": {"drive": "locked"},
    "payload": {"mass": LOAD},
    "initial": {"q": [0.0, 0.6, 7.0, ROPE, 0.01, 0.05]},
    "inputs": sines(WAVES),
    "integrator": ACCURATE,
}


@cache
def mobile_functions() -> tuple[Any, Any, Any]:
    """Return (masses, Jacobians of places, their rates) of the mobile crane's points, functions of (q, v).

    Each section is two points on the boom; the superstructure is apart.
    """
    q, v = sympy.symbols("q0:5"), sympy.symbols("v0:5")
    a, boom, out, first, second = q
    radial = sympy.Matrix([sympy.cos(a), sympy.sin(a), 0])
    across, up = sympy.Matrix([-sympy.sin(a), sympy.cos(a), 0]), sympy.Matrix([0, 0, 1])
    along = radial * sympy.cos(boom) + up * sympy.sin(boom)
    foot = radial * FOOT[0] + up * FOOT[1]
    points, masses = [], []
    for (mass, _, inertia), middle in zip(SECTIONS, (SECTIONS[0][1], out - SECTIONS[1][1]), strict=True):
        half = (inertia / mass) ** 0.5
        points += [foot + along * (middle + side * half) for side in (1, -1)]
        masses += [mass / 2, mass / 2]
    hangs = radial * sympy.sin(second) + sympy.cos(second) * (across * sympy.sin(first) - up * sympy.cos(first))
    points.append(foot + along * out + hangs * ROPE)
    places = sympy.Matrix([x for point in points for x in point])
    jacobian = places.jacobian(q)
    rates = sum((jacobian.diff(x) * w for x, w in zip(q, v, strict=True)), sympy.zeros(*jacobian.shape))
    both = sympy.lambdify([q, v], [jacobian, rates * sympy.Matrix(v)], cse=True)
    return np.repeat([*masses, LOAD], 3), both, None


def mobile_equations(q: Vector, v: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return (mass matrix, generalised force) of (slew, boom, telescope, two swing angles): virtual work of points."""
    masses, both, _ = mobile_functions()
    jacobian, bias = both(q, v)
    gravity = np.tile([0.0, 0.0, -9.81], len(masses) // 3)
    matrix = jacobian.T @ (masses[:, None] * jacobian)
    matrix[0, 0] += SUPERSTRUCTURE
    return matrix, np.array([*u, 0.0, 0.0]) + jacobian.T @ (masses * (gravity - np.ravel(bias)))


@cache
def mobile_events(end: float) -> list[tuple[float, int, float]]:
    """Return the events of the scene MOBILE by the reference."""
    start = np.array([0.0, 0.6, 7.0, 0.01, 0.05, *np.zeros(5)])
    return Reference(mobile_equations, WAVES, DRY).events(start, end)


def test_three_joints_of_a_mobile_crane_stick_and_slip() -> None:
    """Slew, boom and telescope stick and slip at the times of virtual work with a constraint for each that sticks."""
    expected = mobile_events(2.0)
    assert len(expected) > 12 and {(0, 0.0), (1, 0.0), (2, 0.0)} <= {(j, mode) for _, j, mode in expected}
    check_events(crane_sim.simulate(MOBILE | {"friction": DRY}), expected, list(DRY))
