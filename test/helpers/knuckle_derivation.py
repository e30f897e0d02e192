"""The knuckle crane's equations derived again, by sympy from T and U in joint coordinates."""

from collections.abc import Callable
from functools import cache
from math import cos
from typing import Any

import numpy as np
import sympy as sp

import crane_sim


@cache
def derivation() -> Callable[..., Any]:
    """Return the function that returns (M, bias, payload Jacobian), from T and U by sympy.

    T and U have all energies.
    """
    q = sp.symbols("a b c d t1 t2")
    v = sp.symbols("a_ b_ c_ d_ t1_ t2_")
    lb, mb, ib, xb, lj, mj, ij, xj, tower, m, g = p = sp.symbols(
        "lb mb ib xb lj mj ij xj tower m g"
    )
    kb, rb, kj, rj, kr, rr, share = springs = sp.symbols("kb rb kj rj kr rr share")
    a, b, c, d, t1, t2 = q
    radial, across = sp.Matrix([sp.cos(a), sp.sin(a), 0]), sp.Matrix([-sp.sin(a), sp.cos(a), 0])
    up = sp.Matrix([0, 0, 1])
    boom, jib = sp.cos(b) * radial + sp.sin(b) * up, sp.cos(c) * radial + sp.sin(c) * up
    rope = sp.sin(t2) * radial + sp.cos(t2) * sp.sin(t1) * across - sp.cos(t1) * sp.cos(t2) * up
    payload = lb * boom + lj * jib + d * rope

    def speed2(x: Any) -> Any:
        return sum(r**2 for r in x.jacobian(q) * sp.Matrix(v))

    def twice_slew_energy(transverse: Any, axial: Any, angle: Any) -> Any:
        return (transverse * sp.cos(angle) ** 2 + axial * sp.sin(angle) ** 2) * v[0] ** 2

    twice_kinetic = (
        mb * speed2(lb / 2 * boom) + mj * speed2(lb * boom + lj / 2 * jib) + m * speed2(payload)
    )
    twice_kinetic += tower * v[0] ** 2 + ib * v[1] ** 2 + ij * v[2] ** 2
    twice_kinetic += sp.Symbol("rods") * (
        twice_slew_energy(ib, xb, b) + twice_slew_energy(ij, xj, c)
    )
    mass_moment = mb * lb / 2 * boom + mj * (lb * boom + lj / 2 * jib) + m * payload
    twice_spring_energy = kb * (b - rb) ** 2 + kj * (c - share * b - rj) ** 2 + kr * (d - rr) ** 2
    lagrangian = twice_kinetic / 2 - g * mass_moment[2] - twice_spring_energy / 2
    momentum = sp.Matrix([lagrangian.diff(x) for x in v])
    bias = momentum.jacobian(q) * sp.Matrix(v) - sp.Matrix([lagrangian.diff(x) for x in q])
    names = (*q, *v, *p, *springs, sp.Symbol("rods"))
    return sp.lambdify(names, (momentum.jacobian(v), bias, payload.jacobian(q)), "numpy", cse=True)


def second_derivation(scene: crane_sim.Scene, q: Any, v: Any, u: Any) -> np.ndarray:
    """Return the accelerations (6,) by M, bias, friction and drag of the second derivation."""
    return np.linalg.solve(*mass_and_force(scene, q, v, u))


def mass_and_force(scene: crane_sim.Scene, q: Any, v: Any, u: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return mass matrix (6, 6) and generalised force (6,) under efforts u (4,).

    They are those of the second derivation.
    """
    s, boom, jib = scene.model.support, scene.model.support.boom, scene.model.support.jib
    rods = float(boom.axial_inertia is not None)
    numbers = [boom.length, boom.mass, boom.inertia, boom.axial_inertia or 0.0]
    numbers += [jib.length, jib.mass, jib.inertia, jib.axial_inertia or 0.0]
    numbers += [s.tower.inertia, scene.model.load.mass, scene.model.gravity]
    rope = getattr(scene.model.cable, "spring", None)
    for spring in (s.boom_spring, s.jib_spring, rope):
        numbers += [spring.stiffness, spring.rest] if spring else [0.0, 0.0]
    numbers += [float(s.jib_spring.relative) if s.jib_spring else 0.0, rods]
    mass, bias, jacobian = derivation()(*q, *v, *numbers)
    force = np.array([*u, 0.0, 0.0]) - bias[:, 0]
    if scene.model.drag:
        velocity = jacobian @ v
        force -= jacobian.T @ (scene.model.drag.coefficient * np.linalg.norm(velocity) * velocity)
    if scene.model.swing_friction:
        f = scene.model.swing_friction
        lever = {
            "QuadraticFriction": np.abs(v[4:]),
            "LinearFriction": np.ones(2),
            "PaperFriction": np.abs(q[4:]),
        }
        force[4:] -= (
            np.array([f.tangential * cos(q[5]) ** 2, f.radial]) * lever[type(f).__name__] * v[4:]
        )
    return mass, force
