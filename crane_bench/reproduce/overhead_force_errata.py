"""Misprints of the overhead-crane report in velocities, energies and forces.

They are in Remark 2 and sections 4.2 to 4.4, 6.2 and 8.1.
"""

from collections.abc import Iterator
from math import cos, fsum

import numpy as np

from crane_bench.reproduce.lagrange import chain, coordinates, properties
from crane_bench.reproduce.lagrange.coordinates import Array, absolute, unpack
from crane_bench.reproduce.overhead_erratum import (
    Erratum,
    erratum,
    example,
    payload_only,
    sums_from,
)


def errata() -> Iterator[Erratum]:
    """Yield the misprints in the report's order."""
    yield rod_rotation()
    yield vertical_angle_force()
    yield large_payload_weights()
    yield small_angle_weights()
    yield joint_energy()
    yield joint_torques()
    yield free_lengths()
    yield hoist_coupling(1, "(182), (183), N = 1: the sum")
    yield hoist_coupling(3, "(182), (184), (186), N = 3")
    yield node_speeds()


def rod_rotation() -> Erratum:
    """Return the energy of turning rods, Remark 2 and section 8.1.

    In truth they turn as the lines between their ends.
    """
    _, q, v = example(3)
    inertias = np.array([0.5, 0.3, 0.2])
    arms = np.diff(chain.node_positions(q), axis=0)
    speeds = np.diff(properties.derivative_along(chain.node_positions, q, v), axis=0)
    turning = (arms[:, 0] * speeds[:, 1] - arms[:, 1] * speeds[:, 0]) / np.sum(arms**2, axis=1)
    printed, corrected, truth = (
        0.5 * fsum(inertias * w**2) for w in (v[1:4], absolute(v[1:4]), turning)
    )
    return erratum("Remark 2, section 8.1", "½ J_i (θ̇_1 + .. + θ̇_i)²", printed, corrected, truth)


def vertical_angle_force() -> Erratum:
    """Return ∂T/∂θ_n at the vertical with a large payload, (73)."""
    crane, q, v = example(3)
    heavy, upright = payload_only(crane), np.concatenate([q[:1], np.zeros(3), q[4:]])
    (speed, rates, paid), m = unpack(v), crane.masses[-1]
    swung, below = q[4:] * absolute(rates), sums_from(paid)
    corrected = m * (below * (speed + fsum(swung)) - fsum(paid) * sums_from(swung))
    truth = properties.gradient(lambda at: chain.kinetic_energy(heavy, at, v), upright)[1:4]
    correction = "m_N [(Σ_n l̇_k)(ẋ + Σ_1 l_k α̇_k) - (Σ_1 l̇_k)(Σ_n l_k α̇_k)]"
    return erratum("(73)", correction, m * below * speed, corrected, truth)


def large_payload_weights() -> Erratum:
    """Return gravity on the angles with a large payload, the text after (83)."""
    crane, q, _ = example(3)
    _, theta, lengths = unpack(q)
    moments = crane.gravity * crane.masses[-1] * lengths * np.sin(absolute(theta))
    truth = properties.gradient(lambda at: chain.potential_energy(payload_only(crane), at), q)[1:4]
    printed = np.full(3, fsum(moments))
    return erratum(
        "after (83), large payload", "the sum begins at k = n", printed, sums_from(moments), truth
    )


def small_angle_weights() -> Erratum:
    """Return gravity on the angles to first order in them, the text after (83)."""
    crane, q, _ = example(3)
    small = np.concatenate([q[:1], 1e-4 * q[1:4], q[4:]])  # second order is a relative 1e-8
    _, theta, lengths = unpack(small)
    first_order = crane.gravity * sums_from(sums_from(crane.masses) * lengths * absolute(theta))
    truth = properties.gradient(lambda at: chain.potential_energy(crane, at), small)[1:4]
    correction = "Σ_i m_i g Σ_{k=n}^i l_k α_k, not 0"
    return erratum(
        "after (83), small angles", correction, np.zeros(3), first_order, truth, tolerance=1e-7
    )


def joint_energy() -> Erratum:
    """Return the energy of joint springs in absolute angles, before (88)."""
    q, kappa = example(3)[1], np.array([5.0, 3.0, 2.0])
    first, *others = 0.5 * kappa * coordinates.relative(absolute(q[1:4])) ** 2
    printed, corrected = first + 2.0 * fsum(others), first + fsum(others)
    return erratum(
        "U_flex(α) before (88)", "½ on the sum too", printed, corrected, _joint_energy(kappa, q)
    )


def joint_torques() -> Erratum:
    """Return ∂U_flex/∂α, (91), where the vector of derivatives is said to be a matrix."""
    q, kappa = example(3)[1], np.array([5.0, 3.0, 2.0])
    upright, unbent = coordinates.absolute_map(3), np.linalg.inv(np.tri(3))
    stiffness = unbent.T @ np.diag(kappa) @ unbent
    truth = properties.gradient(
        lambda at: _joint_energy(kappa, np.linalg.solve(upright, at)), upright @ q
    )[1:4]
    return erratum(
        "(91): vector = matrix", "matrix times α", stiffness, stiffness @ absolute(q[1:4]), truth
    )


def _joint_energy(kappa: Array, q: Array) -> Array:
    crane = example(3)[0]._replace(gravity=0.0, joint_stiffness=kappa)
    return chain.potential_energy(crane, q)


def free_lengths() -> Erratum:
    """Return the tension of the last link of a crane that its hoist holds at rest.

    (93) leaves the link's length free.
    """
    crane, q, _ = example(3)
    hanging, weights = np.concatenate([q[:1], np.zeros(3), q[4:]]), crane.gravity * crane.masses
    load = np.array([0.0, 0.0, 0.0, 0.0, -fsum(weights), 0.0, 0.0])

    def tension(lengths: tuple[int, ...]) -> float:
        fall = chain.chain_acceleration(crane, hanging, np.zeros(7), load, lengths)
        return weights[-1] + crane.masses[-1] * chain.node_jacobian(hanging)[-1, 1] @ fall

    correction = "fix l_2 .. l_N, or add elasticity as (193) does"
    return erratum("(93): T_N at rest", correction, tension((1, 2, 3)), tension((1,)), weights[-1])


def hoist_coupling(n: int, where: str) -> Erratum:
    """Return the terms with l̇_1 in the row of θ_N, l_2 .. l_N fixed: (182), (184) and (186)."""
    crane, q, v = example(n)
    v[n + 2 :] = 0.0
    still = v.copy()
    still[n + 1] = 0.0
    _, rates, paid = unpack(v)
    scale = 2.0 * crane.masses[-1] * paid[0] * q[-1] * cos(fsum(q[2 : n + 1]))
    # for one link the terms in l̇_1² cancel, as they are absent for more
    printed = scale * (rates[0] - fsum(rates))
    truth = (chain.coriolis(crane, q, v) @ v - chain.coriolis(crane, q, still) @ still)[n]
    return erratum(
        where, "+2 m_N l̇_1 l_N θ̇_1 cos(θ_2 + .. + θ_N)", printed, scale * rates[0], truth
    )


def node_speeds() -> Erratum:
    """Return nodes' horizontal velocities by the rates of positions x_i, end of section 6.2.3."""
    _, q, v = example(3)
    rates = (coordinates.horizontal_jacobian(q) @ v)[4:]
    truth = properties.derivative_along(chain.node_positions, q, v)[1:, 0]
    return erratum("end of 6.2.3: V_Ai", "ẋ_i, not ẋ + ẋ_i", v[0] + rates, rates, truth)
