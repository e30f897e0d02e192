"""Small motions of a support about its posture at t = 0, from its kinematics and inertia."""

from math import cos, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.supports.support import Mechanism
from crane_sim.multibody.tree import (
    compute_inertia,
    compute_kinematics,
    point_position,
    to_base_axes,
    velocity_at_rates,
)


class Tip(NamedTuple):
    """Pose of what a support carries, relative to the base, in the base's axes."""

    position: tuple[float, float, float]  # m, of the tip
    yaw: float = 0.0  # rad, about the vertical


class SmallMotions(NamedTuple):
    """A support with n coordinates at rest in a posture, without its motors."""

    mechanism: Mechanism
    mobility: Any  # (n, n) 1/kg or 1/(kg m²), M⁻¹; 0 for a coordinate that no effort moves
    jacobian: Any  # (4, n) of the tip's x, y, z and the yaw, in the base's axes

    @property
    def tip_mobility(self) -> Any:
        """Mobility J M⁻¹ Jᵀ (4, 4) of x, y, z [1/kg] and yaw [1/(kg m²)] (Hogan, 1985)."""
        return self.jacobian @ self.mobility @ self.jacobian.T

    @property
    def bending_rate(self) -> float:
        """Bound [rad/s] of the frequencies and decay rates of what bends on its springs."""
        rates = [0.0]
        n = len(self.mobility)
        for spring in self.mechanism.springs:
            lever = np.array(spring.lever, dtype=float)
            if any(lever[n - self.mechanism.bending :]):
                mobility = float(lever @ self.mobility @ lever)
                rates.append(max(sqrt(spring.stiffness * mobility), spring.damping * mobility))
        return max(rates)


def tip_of(structure: Any, q: Any) -> Tip:
    """Return the pose of the tip at coordinates q (n,)."""
    mechanism = structure.mechanism()
    yaw = float(sum(q[i] for i in mechanism.yaw))
    if isinstance(structure, Knuckle):  # in closed form, which rounds less
        radius, _, height = structure.polyline(q)[-1]
        return Tip((radius * cos(yaw), radius * sin(yaw), height), yaw)
    kinematics = compute_kinematics(mechanism.tree, tuple(q), (0.0,) * len(q))
    place = to_base_axes(kinematics.turn, point_position(kinematics, mechanism.tree.tip))
    x, y, z = (float(part) for part in place)
    return Tip((x, y, z), yaw)


def small_motions(structure: Any, q: Any) -> SmallMotions:
    """Return the small motions about coordinates q (n,)."""
    mechanism, n = structure.mechanism(), len(q)
    tree = mechanism.tree
    kinematics = compute_kinematics(tree, tuple(q), (0.0,) * n)
    lower = compute_inertia(tree, kinematics, n).matrix
    mass = np.array(
        [[lower[max(i, k)][min(i, k)] for k in range(n)] for i in range(n)], dtype=float
    )
    free = [i for i in range(n) if not (mechanism.prescribed and mechanism.prescribed[i])]
    mobility, jacobian = np.zeros((n, n)), np.zeros((4, n))
    if free:
        mobility[np.ix_(free, free)] = np.linalg.inv(mass[np.ix_(free, free)])
    for i in range(n):
        unit = tuple(1.0 if k == i else 0.0 for k in range(n))
        velocity = velocity_at_rates(tree, kinematics, tree.tip, unit)
        jacobian[:3, i] = to_base_axes(kinematics.turn, velocity)
        jacobian[3, i] = float(i in mechanism.yaw)
    if not np.isfinite(mobility).all():
        raise OverflowError("inertias are out of range")
    return SmallMotions(mechanism, mobility, jacobian)
