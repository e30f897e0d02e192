"""Chain of rigid links in Cartesian coordinates by constraint forces (index 1).

It is put back on the constraints each step.

Node 0 is the trolley, node N the payload. With d_k = r_k - r_(k-1), the link constraints (|d_k|^2 -
L_k^2) / 2 = 0 have multipliers lambda_k = T_k / L_k. Their second derivative gives one linear
system S lambda = b, whose matrix is S_kl = sum over axes of d_k d_l (B W B')_kl with B the
difference between neighbours and W the inverse mass matrix of the axis: no angle, no recursion. It
is factored in double precision and refined in extended precision.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import lu_factor, lu_solve

Real = np.longdouble
Vector = np.ndarray


def solve(matrix: Vector, right: Vector) -> Vector:
    """Return the solution in extended precision, from a double factorisation and its refinement."""
    factors = lu_factor(matrix.astype(float))
    found = np.zeros_like(right)
    for _ in range(4):
        found = found + lu_solve(factors, (right - matrix @ found).astype(float))
    return found


def inverse(matrix: Vector) -> Vector:
    """Return the inverse in extended precision (columns by `solve`)."""
    return np.stack([solve(matrix, column) for column in np.eye(len(matrix), dtype=Real)], axis=1)


def silent(t: Real) -> Vector:
    """Return no drive force."""
    return np.zeros(2, Real)


@dataclass
class Rigid:
    """Parameters [SI]; `trolley` holds the mass along each axis (inf: held), 1 (2D) or 2 (3D).

    The axes are horizontal.
    """

    trolley: list[float]
    masses: list[float]
    lengths: list[float]
    gravity: float = 9.81
    drive: Callable[[Real], Vector] = silent  # force on the trolley along x and y
    profile: Callable[[Real], tuple[Real, Real, Real]] | None = None  # length of link 1 and its two
    # derivatives
    winch_inertia: float | None = None  # kg, a winch driven by `winch_force`; 0: the tension is
    # minus that force
    winch_force: Callable[[Real], Real] = field(default=lambda t: Real(0))  # lengthening positive
    rotational_inertias: list[float] | None = None  # J_k, kg m^2
    stiffness: list[float] | None = None  # of joint k, at the upper end of link k, N m / rad
    damping: list[float] | None = None  # N m s / rad

    def __post_init__(self) -> None:
        """Prepare the inverse mass matrices (axes, N + 1, N + 1) and B W B' (axes, N, N)."""
        n, self.axes = len(self.masses), len(self.trolley) + 1
        difference = (np.eye(n, n + 1, 1) - np.eye(n, n + 1)).astype(Real)
        mass = np.diag(np.array([1.0, *self.masses], Real))
        if self.rotational_inertias is not None:
            # J alphadot^2 / 2 = J |v_k - v_(k-1)|^2 / (2 l^2) on the constraints
            per_area = np.array(self.rotational_inertias, Real) / np.array(self.lengths, Real) ** 2
            mass = mass + difference.T @ np.diag(per_area) @ difference
        self.inverse_mass = np.zeros((self.axes, n + 1, n + 1), Real)
        for axis, moved in enumerate([*self.trolley, np.inf]):
            here = mass.copy()
            here[0, 0] += Real(moved) - 1
            free = slice(0 if np.isfinite(moved) else 1, None)
            self.inverse_mass[axis, free, free] = inverse(here[free, free])
        self.constraint_inverse_mass = np.array(
            [difference @ w @ difference.T for w in self.inverse_mass]
        )
        self.weight = np.array([0.0, *self.masses], Real) * Real(self.gravity)
        self.link_lengths = np.array(self.lengths, Real)

    @property
    def hoisted(self) -> bool:
        """Whether the state ends with the length of link 1: a winch with inertia."""
        return bool(self.winch_inertia)

    def split(self, half: Vector) -> tuple[Vector, Real]:
        """Return nodes (N + 1, axes) and winch length of one half of the state."""
        count = len(self.weight) * self.axes
        return half[:count].reshape(-1, self.axes), half[count] if self.hoisted else Real(0)

    def join(self, nodes: Vector, winch: Real) -> Vector:
        """Return half of the state from nodes and winch length."""
        return np.append(nodes.ravel(), winch) if self.hoisted else nodes.ravel()

    def links(self, t: Real, winch: Real, rate: Real) -> Vector:
        """Return lengths, rates, second derivatives (3, N), without a winch's own acceleration.

        That is left to the system.
        """
        table = np.array([self.link_lengths, 0 * self.link_lengths, 0 * self.link_lengths])
        if self.profile is not None:
            table[:, 0] = self.profile(t)
        elif self.hoisted:
            table[:2, 0] = winch, rate
        return table

    def compute_multiplier_matrix(self, d: Vector, lengths: Vector) -> Vector:
        """Return the matrix S (N, N) of the multipliers; a massless winch frees link 1."""
        matrix = np.zeros((len(d), len(d)), Real)
        for a in range(self.axes):
            matrix += np.outer(d[:, a], d[:, a]) * self.constraint_inverse_mass[a]
        if self.winch_inertia:
            matrix[0, 0] += lengths[0] ** 2 / Real(self.winch_inertia)
        if self.winch_inertia == 0:
            matrix[0, :], matrix[0, 0] = 0, 1
        return matrix

    def apply_inverse_mass(self, force: Vector) -> Vector:
        """Return the accelerations (N + 1, axes) of nodal forces without constraints."""
        return np.stack([self.inverse_mass[a] @ force[:, a] for a in range(self.axes)], axis=1)

    def compute_joint_forces(self, d: Vector, rate: Vector) -> Vector:
        """Return nodal forces of springs and dampers in the joints (plane).

        Torques act as couples on the links.
        """
        force = np.zeros((len(d) + 1, 2), Real)
        if self.stiffness is None or self.damping is None:
            return force
        above = np.vstack([np.array([[0, -1]], Real), d[:-1]])
        turn = np.arctan2(above[:, 0] * d[:, 1] - above[:, 1] * d[:, 0], np.sum(above * d, axis=1))
        normal = np.stack([-d[:, 1], d[:, 0]], axis=1)  # alpha grows towards +x: t_k = (cos, sin)
        spin = np.sum(normal * rate, axis=1) / np.sum(d * d, axis=1)
        torque = -np.array(self.stiffness, Real) * turn - np.array(self.damping, Real) * np.diff(
            spin, prepend=Real(0)
        )
        net = torque - np.append(torque[1:], Real(0))
        couple = (net / np.sum(d * d, axis=1))[:, None] * normal
        force[1:] += couple
        force[:-1] -= couple
        return force

    def solve_accelerations(self, t: Real, q: Vector, v: Vector) -> tuple[Vector, Real, Vector]:
        """Return accelerations of nodes (N + 1, axes) and winch, and multipliers lambda (N,)."""
        (r, winch), (w, rate) = self.split(q), self.split(v)
        d, dd = np.diff(r, axis=0), np.diff(w, axis=0)
        table = self.links(t, winch, rate)
        force = np.zeros_like(r)
        force[:, -1] -= self.weight
        force[0, :-1] += self.drive(t)[: self.axes - 1]
        if self.stiffness is not None:
            force = force + self.compute_joint_forces(d, dd)
        relative = np.diff(self.apply_inverse_mass(force), axis=0)
        right = np.sum(d * relative + dd * dd, axis=1) - table[1] ** 2 - table[0] * table[2]
        pull = self.winch_force(t)
        if self.winch_inertia:
            right[0] -= table[0, 0] * pull / Real(self.winch_inertia)
        if self.winch_inertia == 0:
            right[0] = -pull / np.sqrt(np.sum(d[0] ** 2))
        multipliers = solve(self.compute_multiplier_matrix(d, table[0]), right)
        nodes = self.apply_inverse_mass(force + self.nodal_forces(multipliers[:, None] * d))
        drum = (
            (pull + multipliers[0] * table[0, 0]) / Real(self.winch_inertia)
            if self.winch_inertia
            else Real(0)
        )
        return nodes, drum, multipliers

    @staticmethod
    def nodal_forces(pull: Vector) -> Vector:
        """Return the nodal forces (N + 1, axes) of link pulls (N, axes): towards the neighbours."""
        return np.vstack([pull, 0 * pull[:1]]) - np.vstack([0 * pull[:1], pull])

    def field(self, t: Real, y: Vector) -> Vector:
        """Return dy/dt, y being positions and velocities, each nodes and then the winch."""
        q, v = np.split(y, 2)
        nodes, drum, _ = self.solve_accelerations(t, q, v)
        return np.concatenate([v, self.join(nodes, drum)])

    def project(self, t: Real, y: Vector) -> Vector:
        """Return y moved onto the constraints by the least change in the masses' metric."""
        q, v = np.split(y, 2)
        (r, winch), (w, rate) = self.split(q), self.split(v)
        held = self.winch_inertia == 0
        for _ in range(2):
            d, table = np.diff(r, axis=0), self.links(t, winch, rate)
            r, winch = self.shift(
                d, table[0], (np.sum(d * d, axis=1) - table[0] ** 2) / 2, r, winch, held
            )
        d, table = np.diff(r, axis=0), self.links(t, winch, rate)
        slip = np.sum(d * np.diff(w, axis=0), axis=1) - table[0] * table[1]
        w, rate = self.shift(d, table[0], slip, w, rate, held)
        return np.concatenate([self.join(r, winch), self.join(w, rate)])

    def tension(self, t: Real, y: Vector) -> Vector:
        """Return the link tensions (N,) [N]."""
        q, v = np.split(y, 2)
        return self.solve_accelerations(t, q, v)[2] * np.sqrt(
            np.sum(np.diff(self.split(q)[0], axis=0) ** 2, axis=1)
        )

    def event(self, t: Real, y: Vector) -> Real:
        """Return what becomes negative at an event: there is none."""
        return Real(1)

    def switch(self, t: Real, y: Vector) -> tuple[Vector, list[int]]:
        """Return the state after an event and what it did."""
        raise NotImplementedError

    def shift(
        self, d: Vector, lengths: Vector, gap: Vector, nodes: Vector, winch: Real, free: bool
    ) -> tuple[Vector, Real]:
        """Return nodes and winch after the impulses along the links that close the gap (N,)."""
        impulse = solve(
            self.compute_multiplier_matrix(d, lengths),
            gap * np.where((np.arange(len(gap)) == 0) & free, 0, 1),
        )
        drum = impulse[0] * lengths[0] / Real(self.winch_inertia) if self.winch_inertia else Real(0)
        return nodes + self.apply_inverse_mass(
            self.nodal_forces(impulse[:, None] * d)
        ), winch + drum
