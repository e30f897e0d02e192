"""A knuckle-boom crane on a moving base, against its masses' equations in the world.

The reference has forty digits.
"""

from typing import Any

import mpmath as mp
import numpy as np
import pytest
from comparison import relative
from knuckle_base_scenes import CRANE
from ship_motion import SHIP

import crane_sim

# N
PUSH = {
    axis: {"kind": "constant", "value": value}
    for axis, value in (("x", 4.0), ("y", -7.0), ("z", 2.0))
}
TURNING = {
    "boom.axial_inertia": 0.3,
    "jib.axial_inertia": 0.1,
    "payload_drag.coefficient": 0.3,
    "payload_force": PUSH,
}
# of differences with forty digits: their error is 1e-28 of a derivative, or rounding, 1e-12
STEP = mp.mpf(10) ** -14


def place(t: Any) -> list[Any]:
    """Return (surge, sway, heave, roll, pitch, yaw) of SHIP at time t."""
    return [
        wave.get("offset", 0)
        + wave["amplitude"] * mp.sin(wave["frequency"] * t + wave.get("phase", 0))
        for wave in SHIP.values()
    ]


def about(axis: int, angle: Any) -> np.ndarray:
    """Return the matrix (3, 3) of a right-handed turn about a coordinate axis."""
    c, s, (i, j) = mp.cos(angle), mp.sin(angle), ((axis + 1) % 3, (axis + 2) % 3)
    rotation = np.array([[mp.mpf(int(a == b)) for b in range(3)] for a in range(3)], dtype=object)
    rotation[i, i], rotation[i, j], rotation[j, i], rotation[j, j] = c, -s, s, c
    return rotation


def masses(scene: crane_sim.Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return (masses (12,) of the vectors that `vectors` lists, which of them gravity pulls).

    A body's kinetic energy is that of its mass at its centre, plus ½ Σ jₖ |ėₖ|² over unit vectors
    eₖ fixed in it, with jₖ its second moments along them: half the sum of all moments of inertia,
    less the one about eₖ. A rod without an axial inertia has one moment only, about the luffing
    axis; so has the tower, about the vertical.
    """
    support = scene.model.support
    rows = []
    for rod in (support.boom, support.jib):
        axial = rod.axial_inertia
        about_axes = (
            (axial, rod.inertia, rod.inertia) if axial is not None else (0.0, rod.inertia, 0.0)
        )
        rows += [0.5 * sum(about_axes) - moment for moment in about_axes]
    tower = support.tower.inertia
    rows += [0.5 * tower, 0.5 * tower, -0.5 * tower]
    return np.array([support.boom.mass, support.jib.mass, scene.model.load.mass, *rows]), np.arange(
        12
    ) < 3


def vectors(scene: crane_sim.Scene, q: Any, t: Any) -> np.ndarray:
    """Return (12, 3) in the world: centres of boom, jib, payload; axes of boom, jib, tower."""
    boom, jib = scene.model.support.boom.length, scene.model.support.jib.length
    x = place(t)
    ship = about(2, x[5]) @ about(1, x[4]) @ about(0, x[3])
    slewed = ship @ about(2, q[0])
    raised = [slewed @ about(1, -q[k]) for k in (1, 2)]
    rope = slewed @ about(0, q[4]) @ about(1, -q[5])
    elbow = np.array(x[:3], dtype=object) + boom * raised[0][:, 0]
    tip = elbow + jib * raised[1][:, 0]
    centres = [
        elbow - 0.5 * boom * raised[0][:, 0],
        elbow + 0.5 * jib * raised[1][:, 0],
        tip - q[3] * rope[:, 2],
    ]
    return np.array([*centres, *raised[0].T, *raised[1].T, *slewed.T])


def newton(scene: crane_sim.Scene, q: Any, v: Any, u: Any, t: float) -> np.ndarray:
    """Return the joint accelerations by which the masses obey d'Alembert's principle in the world.

    The fourth of the efforts u is the rope's force where the winch is driven by force, else the
    rope's acceleration.
    """
    at, moves = ([mp.mpf(x) for x in given] for given in (q, v))

    def along(s: Any, ways: Any, then: Any) -> np.ndarray:
        return vectors(
            scene, [x + s * way for x, way in zip(at, ways, strict=True)], mp.mpf(t) + then
        )

    unit = np.eye(6)
    slopes = [(along(STEP, unit[k], 0) - along(-STEP, unit[k], 0)) / (2 * STEP) for k in range(6)]
    ahead, here, behind = along(STEP, moves, STEP), along(0, moves, 0), along(-STEP, moves, -STEP)
    jacobian = np.array(slopes).astype(float)  # (6, 12, 3)
    second = ((ahead - 2 * here + behind) / STEP**2).astype(float)
    heavy, pulled = masses(scene)
    forces = -heavy[:, None] * second
    forces[pulled, 2] -= heavy[pulled] * scene.model.gravity
    if scene.model.drag is not None:
        velocity = ((ahead - behind) / (2 * STEP)).astype(float)[2]
        forces[2] -= scene.model.drag.coefficient * np.linalg.norm(velocity) * velocity
    if scene.model.force is not None:
        forces[2] += [PUSH[axis]["value"] for axis in "xyz"]
    mass = np.einsum("ikc,jkc,k->ij", jacobian, jacobian, heavy)
    known = np.einsum("ikc,kc->i", jacobian, forces) + [*u[:3], 0.0, 0.0, 0.0]
    return _with_winch(scene, mass, known, u[3])


def _with_winch(
    scene: crane_sim.Scene, mass: np.ndarray, known: np.ndarray, winch: float
) -> np.ndarray:
    if scene.effort_units[3] == "N":
        return np.linalg.solve(mass, known + winch * np.eye(6)[3])
    system = mass.copy()
    system[:, 3] = -np.eye(6)[3]  # the rope's force is unknown in place of its acceleration
    accelerations = np.linalg.solve(system, known - mass[:, 3] * winch)
    accelerations[3] = winch
    return accelerations


@pytest.mark.parametrize(
    "changes", [{"rope.drive": "rate"}, TURNING], ids=["plain", "turning rods in air"]
)
def test_accelerations_are_those_of_masses_in_the_world(changes: dict[str, Any]) -> None:
    """Forward dynamics on a base that moves in six ways equal those of masses in the world.

    They are equal for any state.
    """
    scene = crane_sim.load_scene(CRANE, changes)
    rng = np.random.default_rng(3)
    low, high = np.array([-3, -1.2, -1.2, 0.5, -1.4, -1.4]), np.array([3, 1.2, 1.2, 4.0, 1.4, 1.4])
    with mp.workdps(40):
        for _ in range(12):
            q, v, u, t = (
                rng.uniform(low, high),
                rng.normal(0, 1, 6),
                rng.normal(0, 50, 4),
                rng.uniform(0, 9),
            )
            actual = crane_sim.acceleration(scene, tuple(q), tuple(v), tuple(u), t)
            # two derivations in doubles differ by rounding times the condition of the 6x6 matrix,
            # ~1e3
            assert relative(actual, newton(scene, q, v, u, t)) < 1e-11


@pytest.mark.slow
def test_a_run_on_a_ship_accounts_for_its_energy_and_is_shown_in_the_world() -> None:
    """What joints, base and air supply is what the energy gains, and points follow joints."""
    run = crane_sim.simulate(
        crane_sim.load_scene(CRANE, TURNING | {"inputs.boom": {"kind": "constant", "value": 400.0}})
    )
    assert run.summary["energy_audit_error"] < 1e-9  # some hundred steps' tolerance of 1e-9
    last = len(run.t) - 1
    with mp.workdps(20):
        for k in (0, last // 2, last):
            assert run.payload[k] == pytest.approx(
                vectors(run.scene, run.q[k], run.t[k])[2].astype(float), abs=1e-13
            )
