"""PD law with gravity compensation for any crane at rest, independent of the project's own laws."""

from collections.abc import Sequence

import numpy as np

from crane_sim import acceleration
from crane_sim.scenes.scene import Scene

FREQUENCY = 1.5  # rad/s of the critically damped joints


class PdLaw:
    """u = u₀ - M (ω² (q - q₀) + 2 ω v) of the actuated joints.

    M and u₀ are those of the load at rest at the target q₀.
    """

    def __init__(self, scene: Scene) -> None:
        """Linearise a scene at its reference."""
        self._columns = [scene.joint_names.index(joint) for joint in scene.actuated]
        self._target = np.array(scene.reference)
        q, v, n = np.array(scene.initial_q), np.zeros(len(scene.joint_names)), len(self._columns)
        q[self._columns] = self._target
        free = acceleration(scene, q, v, np.zeros(n))[self._columns]
        mobility = np.array(
            [acceleration(scene, q, v, unit)[self._columns] - free for unit in np.eye(n)]
        ).T
        inertia = np.linalg.inv(mobility)
        self._gravity = -inertia @ free
        self._stiffness = FREQUENCY**2 * np.diag(inertia)
        self._damping = 2.0 * FREQUENCY * np.diag(inertia)

    def __call__(self, t: float, q: Sequence[float], v: Sequence[float]) -> tuple[float, ...]:
        """Return the efforts (nu,)."""
        error = np.array([q[i] for i in self._columns]) - self._target
        rate = np.array([v[i] for i in self._columns])
        return tuple((self._gravity - self._stiffness * error - self._damping * rate).tolist())
