"""The same knuckle crane a second way: Lagrange's equations in joint coordinates, in 30 digits.

The Lagrangian is written down with positions and rotation matrices as functions of alpha, beta,
gamma, rope length and the two swing angles, and differentiated by sympy. The integrator is Gauss
collocation with 16 stages (order 32; Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, section II.7), the arithmetic that of mpmath.
"""

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import sympy as sp

DIGITS, STAGES, STEP = 30, 16, 0.1  # s
Numbers = list[mp.mpf]
Slope = Callable[[Numbers], Numbers]

JOINTS = sp.symbols("alpha beta gamma d theta1 theta2", real=True)
RATES = sp.symbols("valpha vbeta vgamma vd vtheta1 vtheta2", real=True)
KEYS = {
    "g": 0,
    "tower_inertia": 0,
    "length": 2,
    "mass": 2,
    "inertia": 2,
    "axial_inertia": 2,
    "payload": 0,
}
KEYS |= {"stiffness": 3, "rest": 3}
SYMBOLS: dict[str, Any] = {
    n: sp.symbols(f"{n}:{count}") if count else sp.Symbol(n) for n, count in KEYS.items()
}


def flat(values: dict[str, Any]) -> list[Any]:
    """Return the parameters in one list, in the order of KEYS."""
    return [x for name, count in KEYS.items() for x in (values[name] if count else [values[name]])]


def frame(elevation: Any) -> sp.Matrix:
    """Return the rotation whose first column points along a rod."""
    return sp.rot_ccw_axis3(JOINTS[0]) * sp.rot_ccw_axis2(-elevation)


def points() -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """Return the boom's end, the tip and the payload."""
    _, beta, gamma, d, one, two = JOINTS
    ahead = sp.Matrix([1, 0, 0])
    knee = SYMBOLS["length"][0] * frame(beta) * ahead
    tip = knee + SYMBOLS["length"][1] * frame(gamma) * ahead
    line = sp.Matrix([sp.sin(two), sp.cos(two) * sp.sin(one), -sp.cos(two) * sp.cos(one)])
    return knee, tip, tip + d * sp.rot_ccw_axis3(JOINTS[0]) * line


def rate(value: sp.Matrix) -> sp.Matrix:
    """Return the time derivative."""
    return value.applyfunc(
        lambda entry: sum(entry.diff(q) * v for q, v in zip(JOINTS, RATES, strict=True))
    )


def spin(turn: sp.Matrix) -> sp.Matrix:
    """Return the angular velocity in the body's axes."""
    skew = turn.T * rate(turn)
    return sp.Matrix([skew[2, 1], skew[0, 2], skew[1, 0]])


def energies() -> tuple[Any, Any]:
    """Return kinetic and potential energy."""
    s, half = SYMBOLS, sp.Rational(1, 2)
    knee, tip, payload = points()
    centres, masses = [knee / 2, (knee + tip) / 2, payload], [*s["mass"], s["payload"]]
    kinetic = half * s["tower_inertia"] * RATES[0] ** 2
    potential = sum(m * s["g"] * r[2] for m, r in zip(masses, centres, strict=True))
    for m, r in zip(masses, centres, strict=True):
        kinetic += half * m * rate(r).dot(rate(r))
    for i, elevation in enumerate(JOINTS[1:3]):
        inertia = sp.diag(s["axial_inertia"][i], s["inertia"][i], s["inertia"][i])
        omega = spin(frame(elevation))
        kinetic += half * (omega.T * inertia * omega)[0]
    stretched = (JOINTS[1], JOINTS[2] - JOINTS[1], JOINTS[3])
    for k, at, rest in zip(s["stiffness"], stretched, s["rest"], strict=True):
        potential += half * k * (at - rest) ** 2
    return kinetic, potential


def equations(spec: dict[str, Any]) -> Slope:
    """Return dy/dt of the joint coordinates and their rates."""
    kinetic, potential = energies()
    momenta = [sp.diff(kinetic, v) for v in RATES]
    terms = [sp.diff(p, v) for p in momenta for v in RATES]
    for p, q in zip(momenta, JOINTS, strict=True):
        terms.append(sp.diff(kinetic - potential, q))
        terms[-1] -= sum(sp.diff(p, other) * v for other, v in zip(JOINTS, RATES, strict=True))
    # no direction is special: shorter, and exact
    terms = [sp.sympify(term).subs(JOINTS[0], 0) for term in terms]
    evaluate = sp.lambdify([*JOINTS, *RATES, *flat(SYMBOLS)], terms, "mpmath", cse=True)
    numbers = [mp.mpf(x) for x in flat(spec)]

    def slope(y: Numbers) -> Numbers:
        found = evaluate(*y, *numbers)
        matrix = mp.matrix([found[6 * i : 6 * i + 6] for i in range(6)])
        return [*y[6:], *mp.lu_solve(matrix, mp.matrix(found[36:]))]

    return slope


def gauss() -> tuple[list[Numbers], Numbers]:
    """Return the coefficients a (stages, stages) and weights b of the collocation."""
    with mp.workdps(3 * DIGITS):  # the systems of powers are badly conditioned
        legendre = sp.Poly(sp.legendre(STAGES, sp.Symbol("x"))).all_coeffs()
        nodes = [
            (1 + x) / 2
            for x in mp.polyroots([mp.mpf(c.p) / c.q for c in legendre], 200, extraprec=400)
        ]
        powers = mp.matrix([[c**k for c in nodes] for k in range(STAGES)])
        rows = [
            mp.lu_solve(powers, mp.matrix([c ** (k + 1) / (k + 1) for k in range(STAGES)]))
            for c in [*nodes, 1]
        ]
    return [list(row) for row in rows[:-1]], list(rows[-1])


def sums(rows: list[Numbers], slopes: list[Numbers], y: Numbers, h: Any) -> list[Numbers]:
    """Return y + h (rows times slopes), row by row."""
    columns = list(zip(*slopes, strict=True))
    return [
        [start + h * mp.fdot(row, column) for start, column in zip(y, columns, strict=True)]
        for row in rows
    ]


def advance(slope: Slope, y: Numbers, h: Any, a: list[Numbers], b: Numbers) -> Numbers:
    """Return y(t + h): the stages by fixed-point iteration until they stand still."""
    slopes, change = [slope(y)] * STAGES, mp.inf
    while change > mp.mpf(10) ** (4 - DIGITS):
        found = [slope(stage) for stage in sums(a, slopes, y, h)]
        change = max(
            abs(p - q)
            for new, old in zip(found, slopes, strict=True)
            for p, q in zip(new, old, strict=True)
        )
        slopes = found
    return sums([b], slopes, y, h)[0]


def course(spec: dict[str, Any], times: list[float]) -> np.ndarray:
    """Return the nodes (K, 3, 3) [m]: boom's end, tip and payload, at equal steps from 0 on."""
    place = sp.lambdify([*JOINTS, *flat(SYMBOLS)], [p.flat() for p in points()], "mpmath", cse=True)
    with mp.workdps(DIGITS):
        slope, (a, b), numbers = equations(spec), gauss(), [mp.mpf(x) for x in flat(spec)]
        y, found = [mp.mpf(x) for x in [*spec["q0"], *[0.0] * 6]], []
        count = round(times[0] / STEP)
        for _ in times:
            for _ in range(count):
                y = advance(slope, y, mp.mpf(times[0]) / count, a, b)
            found.append([[float(x) for x in point] for point in place(*y[:6], *numbers)])
    return np.array(found)
