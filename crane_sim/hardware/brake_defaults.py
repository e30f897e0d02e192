"""The brakes of a scene in numbers: its own, and what it leaves open computed from the crane at its initial posture.

The static load is that at the mean of what disturbs the crane (`crane_sim.averaging`), whatever a sea does at t = 0.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.averaging import averaged
from crane_sim.functions import energy, joint_acceleration
from crane_sim.hardware.brakes import CAPACITY, DAMPING, FOLLOWS, STIFFNESS
from crane_sim.hardware.equipment import BrakeSettings
from crane_sim.scene import Scene

Array = npt.NDArray[np.float64]
HOLDING = 2.0
"""Static loads of the initial posture that a brake holds."""
DECELERATION = 2.0
"""rad/s² or m/s², which a brake gives a joint beyond them, with all that it carries."""
FASTEST = 100.0  # rad/s, of a joint with all that it carries on the spring of its brake
MARGIN = 4.0  # of frequencies, between a posture's inertia and another's, where a step cannot adapt
_SLIPPING = 1e-9  # rad/s or m/s: what dry friction holds would answer no effort


class Mechanics(NamedTuple):
    """The actuated joints at the initial posture, (nu,) each, in units of their efforts."""

    free: Array  # inertia of a joint when all others are free
    carried: Array  # inertia when all others are locked
    load: Array  # what holds them at rest


def fit(board: Any, scene: Scene) -> None:
    """Write the scene's brakes onto a board of drives (DRIVE_ROWS, nu)."""
    settings = scene.hardware.brake if scene.hardware is not None else BrakeSettings()
    spring = np.array([unit not in ("m/s", "m") for unit in scene.effort_units], dtype=float)
    board[FOLLOWS] = [unit == "m" for unit in scene.effort_units]
    if not spring.any():
        return
    joints = mechanics(scene)
    stiffness = stiffness_of(scene, joints) if settings.frequency is None else joints.free * settings.frequency**2
    board[STIFFNESS] = spring * stiffness
    board[DAMPING] = spring * 2.0 * settings.damping * np.sqrt(stiffness * joints.free)
    board[CAPACITY] = spring * (HOLDING * np.abs(joints.load) + DECELERATION * joints.carried)
    if settings.capacity is not None:
        board[CAPACITY] = spring * settings.capacity


def mechanics(scene: Scene) -> Mechanics:
    """Return what the crane's equations tell of its actuated joints at the initial posture."""
    nu = len(scene.actuated)
    places = [scene.joint_names.index(name) for name in scene.actuated]
    q, v = np.array(scene.initial_q), np.zeros(len(scene.joint_names))
    v[places] = _SLIPPING
    model = averaged(scene).model

    def answer(u: Any) -> Array:
        return np.array(joint_acceleration(model, 0.0, q, v, tuple(map(float, u))))[places]

    at_rest = answer(np.zeros(nu))
    mobility: Array = np.column_stack([answer(unit) - at_rest for unit in np.eye(nu)])
    load: Array = -np.linalg.lstsq(mobility, at_rest, rcond=None)[0].astype(np.float64)
    free: Array = 1.0 / np.maximum(np.diag(mobility), 1e-12)
    rest, units = energy(scene, q, 0.0 * q, frame="base"), np.eye(len(q))[places]
    moving = [2.0 * (energy(scene, q, unit, frame="base") - rest) for unit in units]
    forces = np.array([unit in ("N", "N m") for unit in scene.effort_units])
    return Mechanics(free, np.where(forces, np.maximum(moving, free), free), load)


def stiffness_of(scene: Scene, joints: Mechanics) -> Array:
    """Return springs (nu,) so stiff that references which slip once a period, and the steps, keep up with them."""
    safe = getattr(scene.method, "safe_step", None)
    most = np.inf if safe is None else safe(1.0) / scene.method.step / MARGIN
    wanted = min(FASTEST, 1.0 / scene.period)
    return np.minimum(joints.carried * wanted**2, joints.free * most**2)
