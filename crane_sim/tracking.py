"""How well a run followed its scene's path, gathered block by block: the same bits however long the blocks are."""

from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.base import into, pose_at
from crane_sim.jit import entry
from crane_sim.references import Array, references

LOOK = 1e-3  # s, before and after: rounding leaves 1e-8 of an acceleration, what the third power of time does less


@entry
def tip_accelerations(p, t, q, v, u, look, out):
    """Write the size of the tip's acceleration relative to the base (K,) [m/s²] into `out`.

    The second difference of where the tip is, on the parabolas that the joints begin with the model's own
    accelerations: exact up to `look` squared. Positions q, v (K, nq), efforts applied u (K, nu), times t (K,) [s].
    """
    points = np.empty((3, system.point_count(p), 3))
    tip = system.tip_index(p)
    for i in range(len(q)):
        bent = system.acceleration(p, t[i], system.state(p, t[i], q[i], v[i]), system.held(p, u[i]))
        for k in range(3):
            s, moved = (k - 1) * look, q[i].copy()
            for j in range(len(moved)):
                moved[j] += s * (v[i, j] + 0.5 * s * bent[j])
            system.points(p, t[i], system.state(p, t[i], moved, v[i]), points[k])
        square = 0.0
        for j in range(3):
            second = (points[0, tip, j] - 2.0 * points[1, tip, j] + points[2, tip, j]) / (look * look)
            square += second * second
        out[i] = np.sqrt(square)


@entry
def in_base(base, t, points):
    """Return points of the world (K, 3) [m] at times t (K,) [s] in the axes of the base, from its origin."""
    out = np.empty_like(points)
    for i in range(len(points)):
        pose = pose_at(base, t[i])
        x, y, z = pose.place
        found = into(pose.rows, (points[i, 0] - x, points[i, 1] - y, points[i, 2] - z))
        for j in range(3):
            out[i, j] = found[j]
    return out


class Tracking:
    """Errors of a run from the path of its scene, and how hard the tip was accelerated."""

    def __init__(self, scene: Any) -> None:
        """Begin with nothing seen of a scene that has a path."""
        self._path, self._model = scene.path, scene.model
        self._driven: list[int] = [scene.joint_names.index(name) for name in scene.actuated]
        self._count, self._squares, self._sizes, self._worst, self._hardest = 0, 0.0, 0.0, 0.0, 0.0

    def extend(self, t: Array, q: Array, v: Array, u: Array, payload: Array) -> None:
        """Take K instants: times (K,), joints (K, nq), efforts applied (K, nu), the payload in the world (K, 3)."""
        sizes = self._errors(t, q, payload)
        self._count += len(sizes)
        self._squares, self._sizes = _added(self._squares, sizes**2), _added(self._sizes, sizes)
        self._worst = max(self._worst, float(sizes.max()))
        rows = (np.ascontiguousarray(part, dtype=np.float64) for part in (t, q, v, u))
        accelerations = np.empty(len(t))
        tip_accelerations(self._model, *rows, LOOK, accelerations)
        self._hardest = max(self._hardest, float(accelerations.max()))

    def summary(self, t: Array, q: Array, payload: Array) -> dict[str, float]:
        """Return the figures of the run that ends at one more instant; arguments as of `extend`, K = 1.

        Over all control steps and the final state, e the error of the path's own coordinates: `tracking_mse` is the
        mean of e·e, `tracking_mae` of |e|, `tracking_peak` the largest |e|, in the coordinates' unit (m in the base
        frame, for a payload). `peak_tip_acceleration` [m/s²] is relative to the base, at the control steps.
        """
        last = self._errors(t, q, payload)
        count = self._count + 1
        return {
            "tracking_mse": _added(self._squares, last**2) / count,
            "tracking_mae": _added(self._sizes, last) / count,
            "tracking_peak": max(self._worst, float(last[0])),
            "peak_tip_acceleration": self._hardest,
        }

    def _errors(self, t: Array, q: Array, payload: Array) -> Array:
        """Return the sizes of the errors (K,)."""
        goal = references(self._path, np.ascontiguousarray(t, dtype=np.float64))[:, 0]
        base = getattr(self._model, "base", None)
        if self._path.of_joints:
            found = q[:, self._driven]
        else:
            found = payload if base is None else in_base(base, np.asarray(t, dtype=np.float64), payload)
        return np.sqrt(np.sum((found[:, : goal.shape[1]] - goal) ** 2, axis=1))


def _added(total: float, terms: Array) -> float:
    """Return the total with terms (K,) added one after another, so that it does not depend on where blocks end."""
    return float(np.cumsum(np.concatenate([[total], terms]))[-1])
