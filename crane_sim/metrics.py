"""Figures of a run, gathered block by block in constant memory, and quantities derived from joint coordinates."""

import hashlib
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import outputs as _outputs  # noqa: F401  registers what a crane shows
from crane_sim import system
from crane_sim.jit import entry
from crane_sim.scene import Scene
from crane_sim.tracking import Tracking

Array = npt.NDArray[np.float64]
Vector = tuple[float, ...]
SETTLED = 0.02
"""A joint has settled when its error stays below this part of its initial error."""
LAST = 0.25
"""The residual swing is the largest one in this last part of the run."""


class Derived(NamedTuple):
    """Quantities of K instants, world frame."""

    nodes: Array  # (K, N, 3) m, base .. tip .. payload
    tip: Array  # (K, 3) m
    payload: Array  # (K, 3) m
    kinetic: Array  # (K,) J
    potential: Array  # (K,) J
    tension: Array  # (K,) N
    swing: Array  # (K,) rad, angle of the rope from the vertical

    @property
    def energy(self) -> Array:
        """Total energy (K,) [J]."""
        return self.kinetic + self.potential


@entry
def fill_derived(p, t, q, v, u, nodes, scalars):
    """Fill nodes (K, N, 3) and scalars (K, 3: kinetic, potential, tension) from joint coordinates at times t (K,)."""
    for i in range(len(q)):
        x = system.state(p, t[i], q[i], v[i])
        system.points(p, t[i], x, nodes[i])
        scalars[i, 0] = system.kinetic(p, x)
        scalars[i, 1] = system.potential(p, x)
        scalars[i, 2] = system.tension(p, t[i], x, system.held(p, u[i]))


@entry
def energies(p, x):
    """Return (kinetic + potential energy [J], energy supplied [J] as metered, or 0)."""
    return system.kinetic(p, x) + system.potential(p, x), system.supplied(p, x)


@entry
def polyline(p, t, q, v):
    """Return (points base .. tip .. payload in the world [m] (N, 3), index of the tip) at t [s] and joints q, v."""
    points = np.empty((system.point_count(p), 3))
    system.points(p, t, system.state(p, t, q, v), points)
    return points, system.tip_index(p)


def derived(scene: Scene, t: Array, q: Array, v: Array, u: Array) -> Derived:
    """Return what follows from positions q (K, nq), velocities v (K, nq), efforts applied u (K, nu) at times t (K,)."""
    points, tip = polyline(scene.model, 0.0, np.array(scene.initial_q), np.array(scene.initial_v))
    nodes, scalars = np.empty((len(q), *points.shape)), np.empty((len(q), 3))
    rows = (np.ascontiguousarray(part, dtype=np.float64) for part in (t, q, v, u))
    fill_derived(scene.model, *rows, nodes, scalars)
    rope = nodes[:, -1] - nodes[:, tip]
    swing = np.arctan2(np.hypot(rope[:, 0], rope[:, 1]), -rope[:, 2])
    kinetic, potential, tension = scalars.T
    return Derived(nodes, nodes[:, tip], nodes[:, -1], kinetic, potential, tension, swing)


class Metrics:
    """Figures of one run, from blocks of rows [q, v, effort applied, tension], one row a control period."""

    def __init__(self, scene: Scene, model: Any, x: Any) -> None:
        """Start with state x of the model that is integrated."""
        self._scene, self._model = scene, model
        self._nq, self._nu = len(scene.joint_names), len(scene.actuated)
        self._driven: list[int] = [scene.joint_names.index(name) for name in scene.actuated]
        self._initial, (self._energy0, _) = self._of_driven(scene.initial_q), energies(model, x)
        self._sha = hashlib.sha256()
        self._last: Array | None = None
        self._work = self._before = 0.0
        self._peak = np.zeros(self._nu)
        self._unsettled = np.full(self._nu, -1.0)
        self._swing = self._residual = 0.0
        self._tension = np.inf
        self._kinetic, self._potential = 0.0, (np.inf, -np.inf)
        self._tracking = Tracking(scene) if scene.path is not None else None

    def _split(self, rows: Array) -> tuple[Array, Array, Array, Array]:
        nq, nu = self._nq, self._nu
        return rows[:, :nq], rows[:, nq : 2 * nq], rows[:, 2 * nq : 2 * nq + nu], rows[:, -1]

    def extend(self, t: Array, rows: Array) -> None:
        """Take the rows of the periods that begin at times t (K,) [s]."""
        if not len(rows):
            return
        q, v, u, tension = self._split(rows)
        self._sha.update(np.column_stack([t, q, v]).astype("<f8").tobytes())
        before = rows if self._last is None else np.vstack([self._last, rows])
        self._add_work(before[:, : self._nq], before[:-1, 2 * self._nq : 2 * self._nq + self._nu])
        self._last = rows[-1].copy()
        self._peak = np.maximum(self._peak, np.abs(u).max(axis=0))
        self._tension = min(self._tension, float(tension.min()))
        self._watch(t, q, v, u)

    def _add_work(self, q: Array, u: Array) -> None:
        self._work += float(np.sum(u * np.diff(q[:, self._driven], axis=0)))

    def _watch(self, t: Array, q: Array, v: Array, u: Array) -> None:
        """Note errors, swing and energies."""
        now = derived(self._scene, t, q, v, u)
        self._swing = max(self._swing, float(now.swing.max()))
        late = t >= (1.0 - LAST) * self._scene.duration
        self._residual = max(self._residual, float(now.swing[late].max(initial=0.0)))
        self._kinetic = max(self._kinetic, float(now.kinetic.max()))
        low, high = self._potential
        self._potential = min(low, float(now.potential.min())), max(high, float(now.potential.max()))
        if self._tracking is not None:
            self._tracking.extend(t, q, v, u, now.payload)
        if self._scene.reference is not None:
            error = np.abs(self._scene.reference - q[:, self._driven])
            outside = error > SETTLED * np.abs(np.subtract(self._scene.reference, self._initial))
            self._unsettled = np.maximum(self._unsettled, np.where(outside, t[:, None], -1.0).max(axis=0))

    def change(self, scene: Scene, model: Any, q: Vector, given: float = 0.0) -> None:
        """Go on from positions q with another model: one with a meter, or a payload that brought `given` energy [J]."""
        self._before = given + (self._worked(q) if self._model.meter is None else self._before)
        self._scene, self._model = scene, model

    def summary(self, t: float, q: Vector, v: tuple[float, ...], flow: Any, saturated: int) -> dict[str, Any]:
        """Return the figures of the run that ends at time t [s] with joint coordinates q, v.

        `settling_time` is the time after which a joint stays within 2 % of its initial error, None if it has not;
        `residual_swing_deg` is the largest swing in the last quarter of the scene's duration; `energy_audit_error` is
        the energy that appeared from nowhere, relative to the energies in play; `state_sha256` is over the
        little-endian float64 bytes of t, q, v of every control step and of the final state.
        """
        scene = self._scene
        sha = self._sha.copy()
        sha.update(np.array([t, *q, *v], dtype="<f8").tobytes())
        final = derived(scene, np.array([t]), np.array([q]), np.array([v]), np.zeros((1, self._nu)))
        further = dict(scene.notes)
        if self._tracking is not None:
            further |= self._tracking.summary(np.array([t]), np.array([q]), final.payload)
        angles = np.degrees([self._swing, self._residual, final.swing[0]])
        return {
            "steps": round(t / scene.period),
            "sim_time": t,
            "rhs_evaluations": flow.evaluations,
            "final_error": self._final_error(q),
            "peak_swing_deg": float(max(angles[0], angles[2])),
            "residual_swing_deg": float(max(angles[1:])),
            "settling_time": self._settling(t, q),
            "peak_effort": dict(zip(scene.actuated, map(float, self._peak), strict=True)),
            "saturated_steps": saturated,
            "min_rope_tension": float(self._tension) if np.isfinite(self._tension) else None,
            "energy_audit_error": self._audit(q, flow),
            "state_sha256": sha.hexdigest(),
        } | further

    def _final_error(self, q: Vector) -> dict[str, float]:
        reference = self._scene.reference or ()
        return {name: r - x for name, r, x in zip(self._scene.actuated, reference, self._of_driven(q), strict=False)}

    def _of_driven(self, q: Vector) -> Array:
        """Return the actuated joints' part of the positions q."""
        return np.array(q)[self._driven]

    def _settling(self, t: float, q: Vector) -> dict[str, float | None]:
        reference, period = self._scene.reference or (), self._scene.period
        now, times = self._of_driven(q), dict[str, float | None]()
        for i, (name, r) in enumerate(zip(self._scene.actuated, reference, strict=False)):
            inside = abs(r - now[i]) <= SETTLED * abs(r - self._initial[i])
            times[name] = float(self._unsettled[i]) + period if inside and self._unsettled[i] >= 0.0 else None
            if inside and self._unsettled[i] < 0.0:
                times[name] = 0.0
        return times

    def _worked(self, q: Vector) -> float:
        """Return the work [J] of held efforts up to positions q."""
        if self._last is None:
            return 0.0
        way = self._of_driven(q) - self._last[self._driven]
        return self._work + float(self._last[2 * self._nq : 2 * self._nq + self._nu] @ way)

    def _audit(self, q: Vector, flow: Any) -> float:
        if self._last is None:
            return 0.0
        energy, supplied = energies(self._model, flow.x)
        supplied += self._worked(q) if self._model.meter is None else self._before
        low, high = self._potential
        scale = max(self._kinetic + high - low, 1e-9 * max(abs(low), abs(high)), 1e-12)
        return abs(energy - self._energy0 - supplied) / scale
