"""Solve the knuckle crane on springs in extended precision and store it.

Usage: python test/reference/knuckle.py [--second].

Writes test/data/knuckle_springs.json, in the form of `make.py`: nodes are the boom's end, the tip
and the payload in the world with z up. Newton and Euler in world axes: the payload is a point in
inertial Cartesian coordinates; tower, boom and jib are rigid bodies with Jacobians of their centres
of mass and angular velocities, so neither the slewing frame nor swing angles appear. With --second
only its distance from `knuckle_lagrange.py` is measured, and trusted.
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import knuckle_lagrange
import numpy as np
from extrapolation import Setting, Walk
from rigid import Real, Vector, solve
from solution import LOOSE, TIGHT, agreement, listed, store
from starts import instants

NAME, TARGET = "23_knuckle_springs_S2k", Path(__file__).parents[1] / "data" / "knuckle_springs.json"
SPEC: dict[str, Any] = {
    "model": "knuckle boom on springs",
    "note": "scene S2k of the benchmark; inertias about the centre of mass, in the middle; gamma "
    "from the horizontal",
    "g": 9.81,
    "tower_inertia": 10.0,
    "length": [5.0, 4.0],
    "mass": [2.0, 3.0],
    "inertia": [4.166666666666667, 4.0],
    "axial_inertia": [0.01, 0.01],
    "payload": 1.0,
    "stiffness": [2000.0, 1000.0, 200.0],
    "rest": [float(np.deg2rad(45.0)), float(np.deg2rad(-60.0)), 2.0],
    "q0": [0.0, *np.deg2rad([45.0, -15.0]).tolist(), 2.0, *np.deg2rad([30.0, 20.0]).tolist()],
}
UP = np.array([0, 0, 1], Real)


class Arm:
    """A rod at an azimuth and elevation [rad] with rates: its unit vector u and its turning."""

    def __init__(self, place: int, q: Vector, v: Vector) -> None:
        """Take the rod whose elevation is q[place], q = (alpha, beta, gamma, ...)."""
        radial, self.side = (
            np.array([np.cos(q[0]), np.sin(q[0]), 0], Real),
            np.array([-np.sin(q[0]), np.cos(q[0]), 0]),
        )
        self.u = np.cos(q[place]) * radial + np.sin(q[place]) * UP
        self.turns = np.zeros((3, 3), Real)  # angular velocity by the rates of alpha, beta, gamma
        self.turns[:, 0], self.turns[:, place] = UP, -self.side
        # and its rate at constant joint rates
        self.omega, self.change = self.turns @ v[:3], v[0] * v[place] * radial

    def reach(self, length: Real) -> tuple[Vector, Vector, Vector]:
        """Return the vector of this length along the rod, its Jacobian (3, 3), its acceleration.

        The acceleration is that at constant rates.
        """
        vector = length * self.u
        bias = np.cross(self.change, vector) + np.cross(self.omega, np.cross(self.omega, vector))
        return vector, np.cross(self.turns.T, vector).T, bias

    def torque(self, across: Real, along: Real) -> tuple[Vector, Vector]:
        """Return the inertia about the centre of mass (3, 3) and the torque for constant rates.

        They are rates of the joints.
        """
        tensor = across * np.eye(3, dtype=Real) + (along - across) * np.outer(self.u, self.u)
        return tensor, tensor @ self.change + np.cross(self.omega, tensor @ self.omega)


@dataclass
class Knuckle:
    """The crane of SPEC; its state: alpha, beta, gamma, the payload's x, y, z, then rates."""

    spec: dict[str, Any]

    def __getitem__(self, name: str) -> Vector:
        """Return a parameter in extended precision."""
        return np.array(self.spec[name], Real)

    def start(self) -> Vector:
        """Return the first state: at rest, the payload where the swing angles put it."""
        q = self["q0"]
        tip, (s1, s2), (c1, c2) = self.points(q)[1], np.sin(q[4:]), np.cos(q[4:])
        side = np.array([0, 1, 0], Real)  # of azimuth 0
        line = s2 * np.array([1, 0, 0], Real) + c2 * s1 * side - c1 * c2 * UP
        return np.concatenate([q[:3], tip + q[3] * line, np.zeros(6, Real)])

    def points(self, q: Vector) -> Vector:
        """Return the boom's end and the tip (2, 3) [m]."""
        steps = [length * Arm(i + 1, q, 0 * q).u for i, length in enumerate(self["length"])]
        return np.cumsum(steps, axis=0)

    def rope(self, tip: Vector, payload: Vector) -> tuple[Vector, Real]:
        """Return the rope's unit vector, tip to payload, and its tension [N]."""
        line = payload - tip
        length = np.sqrt(np.sum(line * line))
        return line / length, self["stiffness"][2] * (length - self["rest"][2])

    def field(self, t: Real, y: Vector) -> Vector:
        """Return dy/dt."""
        q, v = np.split(y, 2)
        mass = np.diag(np.array([self.spec["tower_inertia"], 0, 0], Real))
        force, end, weight = self.springs(q), np.zeros((3, 5), Real), -self["g"] * UP
        for i, (length, m) in enumerate(zip(self["length"], self["mass"], strict=True)):
            arm = Arm(i + 1, q, v)
            reach = np.column_stack(arm.reach(length))
            centre = end + reach / 2
            tensor, torque = arm.torque(self["inertia"][i], self["axial_inertia"][i])
            mass += m * centre[:, 1:4].T @ centre[:, 1:4] + arm.turns.T @ tensor @ arm.turns
            force += m * centre[:, 1:4].T @ (weight - centre[:, 4]) - arm.turns.T @ torque
            end = end + reach
        line, tension = self.rope(end[:, 0], q[3:])
        joints = solve(mass, force + tension * end[:, 1:4].T @ line)
        return np.concatenate([v, joints, weight - tension / self["payload"] * line])

    def springs(self, q: Vector) -> Vector:
        """Return the torques (3,) of the joints' springs; the jib's acts between boom and jib."""
        boom = -self["stiffness"][0] * (q[1] - self["rest"][0])
        jib = -self["stiffness"][1] * (q[2] - q[1] - self["rest"][1])
        return np.array([0, boom - jib, jib], Real)

    def solved(self, times: list[float], setting: Setting) -> tuple[Vector, Vector]:
        """Return nodes (K, 3, 3) [m] and tensions (K,) [N] at the instants."""
        walk, nodes, tensions = Walk(0.0, self.start(), setting), [], []
        for t in times:
            walk.advance(self.field, Real(t), lambda t, y: y, lambda t, y: Real(1))
            points = self.points(walk.y)
            nodes.append([*points, walk.y[3:6]])
            tensions.append(self.rope(points[1], walk.y[3:6])[1])
        return np.array(nodes), np.array(tensions)


def main() -> None:
    """Solve with two settings and store, or only measure against the second derivation.

    It measures the distance of what is stored.
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--second", action="store_true")
    begin, crane, times = time.perf_counter(), Knuckle(SPEC), instants(10.0)
    if parser.parse_args().second:
        found = json.loads(TARGET.read_text())[NAME]
        others = knuckle_lagrange.course(SPEC, times)
        apart = float(np.max(np.abs(others - np.array(found["node_positions_xyz"]))))
        # the second derivation has more digits than what is stored
        trusted = max(found["trusted_abs_error_m"], apart)
        found |= {"agreement_second_m": apart, "trusted_abs_error_m": trusted}
    else:
        (nodes, tensions), (others, _) = (
            crane.solved(times, setting) for setting in (TIGHT, LOOSE)
        )
        found: dict[str, Any] = {"spec": SPEC, "t": times, "node_positions_xyz": listed(nodes)}
        found |= {"tension": listed(tensions)} | agreement(nodes, others)
    store(TARGET, NAME, found)
    told = {
        key: value
        for key, value in found.items()
        if key.startswith("agreement") and key.endswith("_m")
    }
    print(told, f"{time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
