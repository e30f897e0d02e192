"""A second solution of joints with dry friction.

It has a constraint for each one that sticks, by events of scipy.
"""

from collections.abc import Callable, Sequence
from math import copysign, exp, sin
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

EVENT_TIME = 1e-9  # s, what is promised; both solutions are good to some 1e-11
Vector = np.ndarray
Rubbing = dict[str, dict[str, float]]
"""Keys of friction by joint, in the order of the joints."""


def sines(waves: dict[str, tuple[float, float, float]]) -> dict[str, Any]:
    """Return inputs of a scene: (amplitude, frequency, offset) by joint."""
    return {
        name: {"kind": "sine", "amplitude": a, "frequency": w, "offset": b}
        for name, (a, w, b) in waves.items()
    }


def bristle_forces(bristles: Rubbing, v: Vector, z: Vector) -> tuple[Vector, Vector]:
    """Return (friction (n,), rates of the bristles' deflections (n,)) by the LuGre paper."""
    keys = ("coulomb", "static", "stribeck", "stiffness", "damping", "viscous")
    f = {key: np.array([group.get(key, 0.0) for group in bristles.values()]) for key in keys}
    g = f["coulomb"] + (f["static"] - f["coulomb"]) * np.exp(-((v / f["stribeck"]) ** 2))
    rates = v - f["stiffness"] * np.abs(v) * z / g
    return f["stiffness"] * z + f["damping"] * rates + f["viscous"] * v, rates


class Reference(NamedTuple):
    """An independent solution in coordinates whose first ones are joints.

    There is a constraint for each joint that sticks.
    """

    equations: Callable[[Vector, Vector, Vector], tuple[Vector, Vector]]  # of (q, v, u): mass
    # matrix and force
    waves: dict[str, tuple[float, float, float]]
    friction: Rubbing

    def slip(self, name: str, mode: float, v: float) -> float:
        """Return the friction [N or N m] of a joint that slips with `mode` at velocity v."""
        f = self.friction[name]
        fall = exp(-((v / f["stribeck"]) ** 2)) if "stribeck" in f else 0.0
        return (
            mode * (f["coulomb"] + (f["static"] - f["coulomb"]) * fall) + f.get("viscous", 0.0) * v
        )

    def motion(self, t: float, y: Vector, modes: Vector) -> tuple[Vector, Vector]:
        """Return accelerations, and what constraints have to supply."""
        q, v = np.split(y, 2)
        u = np.array([b + a * sin(w * t) for a, w, b in self.waves.values()])
        at = zip(self.friction, modes, v[: len(modes)], strict=True)
        u -= [self.slip(*joint) if joint[1] else 0.0 for joint in at]
        mass, force = self.equations(q, v, u)
        free = np.array([*(modes != 0.0), *[True] * (len(q) - len(modes))])
        qdd = np.zeros(len(q))
        qdd[free] = np.linalg.solve(mass[np.ix_(free, free)], force[free])
        return qdd, (force - mass @ qdd)[: len(modes)]

    def margins(self, t: float, y: Vector, modes: Vector) -> Vector:
        """Return what is left of the modes: of the speeds, or of the static friction."""
        static = np.array([f["static"] for f in self.friction.values()])
        v = y[len(y) // 2 :][: len(modes)]
        return np.where(modes != 0.0, modes * v, static - np.abs(self.motion(t, y, modes)[1]))

    def events(self, y: Vector, end: float) -> list[tuple[float, int, float]]:
        """Return (time, joint, its mode from then on) of all events from rest on, 0 sticks."""
        t, modes, found = 0.0, np.zeros(len(self.friction)), []

        def lowest(t: float, y: Vector) -> float:
            return min(self.margins(t, y, modes))

        def rates(t: float, y: Vector) -> list[float]:
            return [*y[len(y) // 2 :], *self.motion(t, y, modes)[0]]

        event: Any = lowest
        event.terminal, event.direction = True, -1.0

        def solve(t: float, y: Vector, max_step: float) -> Any:
            steps: dict[str, Any] = {
                "method": "DOP853",
                "rtol": 1e-13,
                "atol": 1e-14,
                "max_step": max_step,
            }
            return solve_ivp(rates, (t, end), y, events=event, **steps)

        while True:
            solution = solve(t, y, 0.05)
            if not len(solution.t_events[0]):
                return found
            # once more in short steps: events are located by interpolation of lower order
            before = solution.t[-2]
            solution = solve(before, solution.y[:, -2], (solution.t[-1] - before) / 20.0)
            t, y = solution.t[-1], solution.y[:, -1]
            joint = int(np.argmin(self.margins(t, y, modes)))
            failed, modes[joint] = modes[joint], 0.0
            y[len(y) // 2 + joint] = 0.0
            load, static = (
                self.motion(t, y, modes)[1][joint],
                [*self.friction.values()][joint]["static"],
            )
            modes[joint] = 0.0 if failed and abs(load) <= static else copysign(1.0, load)
            found.append((t, joint, modes[joint]))


OUTCOMES = {0.0: "sticks", 1.0: "slips forwards", -1.0: "slips backwards"}


def check_events(run: Any, expected: Any, names: Sequence[str]) -> None:
    """Assert that a run's events are those of a reference, at the same instants.

    Its energy adds up, too.
    """
    assert [text for _, text in run.events] == [
        f"the {names[joint]} {OUTCOMES[mode]}" for _, joint, mode in expected
    ]
    assert (
        np.max(np.abs([a - b for (a, _), (b, _, _) in zip(run.events, expected, strict=True)]))
        < EVENT_TIME
    )
    assert run.summary["energy_audit_max"] < 1e-9
