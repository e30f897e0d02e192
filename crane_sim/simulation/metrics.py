"""Metrics of a run, gathered block by block in constant memory, and quantities derived from joint coordinates.

Tracking error of a run, accumulated block by block: the same bits for any length of the blocks.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.models.moving_base import pose_at, rotate_to_base
from crane_sim.numerics.jit import LIGHT, NONE, entry_point, optimisation, seldom_called
from crane_sim.numerics.lanes import take_entry
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.energy_balance import EnergyBalance
from crane_sim.simulation.extremes import Extremes
from crane_sim.simulation.flat_summary import one_run, or_none
from crane_sim.simulation.peaks import LAST, Peaks, fill_watched, no_peaks, swing_angles, watch_instants
from crane_sim.simulation.reeving import FallPeaks, fall_tensions
from crane_sim.simulation.settling import Settling, nearness, settling_times
from crane_sim.simulation.state_hash import StateHash
from crane_sim.stepping.rows import split
from crane_sim.trajectories.trajectory import sample_trajectory

Array = npt.NDArray[np.float64]


DIFFERENCE_STEP = 1e-3  # s: rounding leaves 1e-8 of an acceleration, what the third power of time does less


@entry_point
@optimisation(LIGHT)
def tip_accelerations(p, t, q, v, u, step, out):
    """Write the magnitude of the tip's acceleration relative to the base (K,) [m/s²] into `out`.

    Second difference of the tip's position, along parabolas of the joints with the model's
    accelerations: exact up to `step` squared. Positions q, v (K, nq), efforts applied u (K, nu), times t (K,) [s].
    """
    points = np.empty((3, system.point_count(p), 3))
    tip = system.tip_index(p)
    for i in range(len(q)):
        qdd = system.acceleration(p, t[i], system.state(p, t[i], q[i], v[i]), system.efforts_from_row(p, u[i]))
        for k in range(3):
            s, position = (k - 1) * step, q[i].copy()
            for j in range(len(position)):
                position[j] += s * (v[i, j] + 0.5 * s * qdd[j])
            system.points(p, t[i], system.state(p, t[i], position, v[i]), points[k])
        squared_norm = 0.0
        for j in range(3):
            second = (points[0, tip, j] - 2.0 * points[1, tip, j] + points[2, tip, j]) / (step * step)
            squared_norm += second * second
        out[i] = np.sqrt(squared_norm)


@entry_point
@optimisation(LIGHT)
def in_base(base, t, points):
    """Return points of the world (K, 3) [m] at times t (K,) [s] in the axes of the base, from its origin."""
    out = np.empty_like(points)
    for i in range(len(points)):
        pose = pose_at(base, t[i])
        x, y, z = pose.origin
        out[i] = rotate_to_base(pose.rows, (points[i, 0] - x, points[i, 1] - y, points[i, 2] - z))
    return out


@entry_point
def in_bases(bases, t, points):
    """Return points of the world (n, 3) [m] at times t (n,), each in the axes of its base; `bases` are columns."""
    out = np.empty_like(points)
    for i in range(len(points)):
        out[i] = in_base(take_entry(bases, i), t[i : i + 1], points[i : i + 1])[0]
    return out


class TrackingError:
    """Errors of a run from the path of its scene, and how hard the tip was accelerated."""

    def __init__(self, scene: Any) -> None:
        """Begin with nothing seen of a scene that has a path."""
        self._path, self._model = scene.trajectory, scene.model
        self._driven: list[int] = [scene.joint_names.index(name) for name in scene.actuated]
        self._count, self._squares, self._sizes, self._worst, self._hardest = 0, 0.0, 0.0, 0.0, 0.0

    def extend(self, t: Array, q: Array, v: Array, u: Array, payload: Array) -> None:
        """Take K instants: times (K,), joints (K, nq), efforts applied (K, nu), the payload in the world (K, 3)."""
        sizes = self._errors(t, q, payload)
        self._count += len(sizes)
        self._squares, self._sizes = _add_terms(self._squares, sizes**2), _add_terms(self._sizes, sizes)
        self._worst = max(self._worst, float(sizes.max()))
        rows = (np.ascontiguousarray(part, dtype=np.float64) for part in (t, q, v, u))
        accelerations = np.empty(len(t))
        tip_accelerations(self._model, *rows, DIFFERENCE_STEP, accelerations)
        self._hardest = max(self._hardest, float(accelerations.max()))

    def change(self, model: Any) -> None:
        """Continue with another model of the crane."""
        self._model = model

    def summary(self, t: Array, q: Array, payload: Array) -> dict[str, float]:
        """Return the metrics of the run that ends at one more instant; arguments of `extend`, K = 1.

        Over all control steps and the final state, e the error of the path's own coordinates: `tracking_mse` is the
        mean of e·e, `tracking_mae` of |e|, `tracking_peak` the largest |e|, in the coordinates' unit (m in the base
        frame, for a payload). `peak_tip_acceleration` [m/s²] is relative to the base, at the control steps.
        """
        last = self._errors(t, q, payload)
        count = self._count + 1
        return {
            "tracking_mse": _add_terms(self._squares, last**2) / count,
            "tracking_mae": _add_terms(self._sizes, last) / count,
            "tracking_peak": max(self._worst, float(last[0])),
            "peak_tip_acceleration": self._hardest,
        }

    def _errors(self, t: Array, q: Array, payload: Array) -> Array:
        """Return the sizes of the errors (K,)."""
        goal = sample_trajectory(self._path, np.ascontiguousarray(t, dtype=np.float64))[:, 0]
        base = getattr(self._model, "base", None)
        if self._path.of_joints:
            points = q[:, self._driven]
        else:
            # contiguous for one signature: of one instant a column is contiguous, of several it is not
            points = payload if base is None else in_base(base, *map(np.ascontiguousarray, (t, payload)))
        return np.sqrt(np.sum((points[:, : goal.shape[1]] - goal) ** 2, axis=1))


def _add_terms(total: float, terms: Array) -> float:
    """Return the total with terms (K,) added one after another, so that it does not depend on where blocks end."""
    return float(np.cumsum(np.concatenate([[total], terms]))[-1])


Vector = tuple[float, ...]


class Derived(NamedTuple):
    """Quantities of K instants, world frame unless it says otherwise."""

    nodes: Array  # (K, N, 3) m, base .. tip .. payload
    tip: Array  # (K, 3) m
    payload: Array  # (K, 3) m
    kinetic: Array  # (K,) J
    potential: Array  # (K,) J, from height 0 of the world
    kinetic_relative: Array  # (K,) J, relative to the base
    potential_relative: Array  # (K,) J, as if the base were level at height 0
    tensions: Array  # (K, L) N, of the links from the top to the payload
    swing: Array  # (K,) rad, angle of the rope from the vertical
    falls: Array  # (K, n + 2), of a rope with n falls, see `crane_sim.simulation.reeving`; (K, 0) without one

    @property
    def energy(self) -> Array:
        """Total energy (K,) [J]."""
        return self.kinetic + self.potential

    @property
    def energy_relative(self) -> Array:
        """Total energy relative to the base (K,) [J]: the same where the base rests."""
        return self.kinetic_relative + self.potential_relative

    @property
    def tension(self) -> Array:
        """Tension of the uppermost link (K,) [N]."""
        return self.tensions[:, 0]


@entry_point
@optimisation(LIGHT)
def fill_derived(p, t, q, v, u, nodes, scalars, tensions):
    """Fill what follows from joint coordinates at times t (K,).

    Args:
        p: parameters.
        t, q, v, u: times, positions, velocities, efforts applied.
        nodes: (K, N, 3), to fill.
        scalars: (K, 4), to fill: kinetic and potential energy relative to the base, and what the base adds to each.
        tensions: (K, L), to fill.
    """
    for i in range(len(q)):
        x = system.state(p, t[i], q[i], v[i])
        system.points(p, t[i], x, nodes[i])
        scalars[i, 0] = system.kinetic(p, x)
        scalars[i, 1] = system.potential(p, x)
        scalars[i, 2], scalars[i, 3] = system.base_energy(p, t[i], x)
        system.tensions(p, t[i], x, system.efforts_from_row(p, u[i]), tensions, i, 0)


@entry_point
@seldom_called
def read_meters(p, x):
    """Return (energy relative to the base [J], energy supplied [J] as metered, or 0)."""
    return system.kinetic(p, x) + system.potential(p, x), system.energy_supplied(p, x)


@entry_point
@optimisation(NONE)
def world_points(p, t, q, v):
    """Return (points base .. tip .. payload in the world [m] (N, 3), index of the tip) at t [s] and joints q, v."""
    points = np.empty((system.point_count(p), 3))
    system.points(p, t, system.state(p, t, q, v), points)
    return points, system.tip_index(p)


@entry_point
@optimisation(LIGHT)
def fill_contact_forces(p, t, q, v, out):
    """Fill out (K,) with the normal force [N] of a surface on the load at times t (K,) and joints q, v."""
    for i in range(len(q)):
        out[i] = system.contact_force(p, t[i], system.state(p, t[i], q[i], v[i]))


def derive(scene: Scene, t: Array, q: Array, v: Array, u: Array) -> Derived:
    """Return what follows from positions q (K, nq), velocities v (K, nq), efforts applied u (K, nu) at times t (K,)."""
    points, tip_index = world_points(scene.model, 0.0, np.array(scene.initial_q), np.array(scene.initial_v))
    nodes, scalars = np.empty((len(q), *points.shape)), np.empty((len(q), 4))
    tensions = np.empty((len(q), system.link_count(scene.model)))
    rows = (np.ascontiguousarray(part, dtype=np.float64) for part in (t, q, v, u))
    fill_derived(scene.model, *rows, nodes, scalars, tensions)
    swing = swing_angles(nodes[:, tip_index], nodes[:, -1])
    kinetic, potential, more_kinetic, more_potential = scalars.T
    world = kinetic + more_kinetic, potential + more_potential
    falls = fall_tensions(scene.model, t, q, v, u)
    return Derived(nodes, nodes[:, tip_index], nodes[:, -1], *world, kinetic, potential, tensions, swing, falls)


def derive_instant(scene: Scene, t: float, q: Sequence[float], v: Sequence[float]) -> Derived:
    """Return `derive` of one instant, K = 1, without efforts: positions q (nq,), velocities v (nq,), t in s."""
    return derive(scene, np.array([t]), np.array([q]), np.array([v]), np.zeros((1, len(scene.actuated))))


class Metrics:
    """Metrics of one run, from blocks of rows, one row a control period: the same bits however long the blocks are."""

    def __init__(self, scene: Scene, model: Any, x: Any, picklable: bool = False) -> None:
        """Start with state x of the model that is integrated; `picklable`: as of `StateHash`."""
        self._scene, self._model = scene, model
        self._nq, self._nu = len(scene.joint_names), len(scene.actuated)
        self._driven: list[int] = [scene.joint_names.index(name) for name in scene.actuated]
        self._balance = EnergyBalance(read_meters(model, x)[0], model.energy_meter is not None, self._nu)
        self._settling: Settling | None = None
        if scene.reference is not None:
            self._settling = Settling(np.array(scene.reference), self._of_driven(scene.initial_q))
        self._hash = StateHash(picklable)
        self._peaks = no_peaks(self._nu)
        self._extremes = Extremes(scene)
        self._contact_force = 0.0 if getattr(model, "contact", None) is not None else None
        self._tracking = TrackingError(scene) if scene.trajectory is not None else None
        self._falls = FallPeaks()

    def extend(self, t: Array, rows: Array) -> None:
        """Take the rows of the periods that begin at times t (K,) [s]."""
        if not len(rows):
            return
        q, v, u, supplied, tensions = (np.ascontiguousarray(part) for part in split(rows, self._nq, self._nu))
        self._hash.extend(np.column_stack([t, q, v]))
        energies, ends = np.empty((len(t), 2)), np.empty((len(t), 6))
        fill_watched(self._scene.model, t, q, v, energies, ends)
        self._balance.extend(q[:, self._driven], u, supplied, energies[:, 0], energies[:, 1])
        watch_instants(self._peaks, t, (1.0 - LAST) * self._scene.duration, u, tensions, ends)
        self._extremes.extend(q)
        if self._settling is not None:
            self._settling.extend(t, q[:, self._driven])
        self._watch_groups(t, q, v, u, ends[:, 3:])

    def _watch_groups(self, t: Array, q: Array, v: Array, u: Array, payload: Array) -> None:
        """Note metrics of groups that only some scenes have."""
        self._falls.extend(fall_tensions(self._scene.model, t, q, v, u))
        if self._contact_force is not None:
            normal_forces = np.empty(len(t))
            fill_contact_forces(self._scene.model, t, q, v, normal_forces)
            self._contact_force = max(self._contact_force, float(normal_forces.max()))
        if self._tracking is not None:
            self._tracking.extend(t, q, v, u, payload)

    def change(self, scene: Scene, model: Any, q: Vector, energy: float = 0.0) -> None:
        """Continue from positions q with another model: with a meter, or a payload whose change supplied `energy`."""
        self._balance.change(self._of_driven(q), energy, model.energy_meter is not None)
        self._scene, self._model = scene, model
        if self._tracking is not None:
            self._tracking.change(scene.model)

    def summary(self, t: float, q: Vector, v: tuple[float, ...], integration: Any, saturated: int) -> dict[str, Any]:
        """Return the metrics of the run that ends at time t [s] with joint coordinates q, v.

        `settling_time` is the time after which a joint stays near its target, see `crane_sim.simulation.settling`,
        None if it does not; `residual_swing_deg` is the largest swing in the last quarter of the scene's duration;
        tensions are the smallest and the largest of all links at the start of every period, `negative_tension_steps`
        the periods that began with a link that pushed; `energy_audit_error` is the energy that appeared from nowhere up
        to the end, `energy_audit_max` up to any period, both relative to the energies in play, as of
        `crane_sim.simulation.energy_balance`; `state_sha256` is over the little-endian float64 bytes of t, q, v of
        every control step and of the final state.
        """
        final = derive_instant(self._scene, t, q, v)
        audit = self._balance.errors(self._of_driven(q), *read_meters(self._model, integration.x))
        target, near, outside = self._targets()
        ended = RunTotals(
            t=np.array([t]),
            q=self._of_driven(q)[None],
            swing=final.swing,
            evaluations=np.array([integration.evaluations]),
            saturated=np.array([saturated]),
            peaks=Peaks(*(part[None] for part in self._peaks)),
            target=target,
            near=near,
            outside=outside,
            audit=np.array([audit]),
            sha=[self._hash.hexdigest(np.array([t, *q, *v]))],
        )
        return one_run(name_metrics(self._scene, ended)) | self._further(t, q, final.payload)

    def _targets(self) -> tuple[Array | None, Array, Array]:
        """Return target, near and outside of `RunTotals`."""
        nothing = np.zeros((1, self._nu))
        if self._settling is None or self._scene.reference is None:
            return None, nothing, nothing
        target = np.array([self._scene.reference])
        return target, nearness(target, self._of_driven(self._scene.initial_q)[None]), self._settling.outside[None]

    def _further(self, t: float, q: Vector, payload: Array) -> dict[str, Any]:
        """Return what only some scenes have: notes, extremes of joints, and how well a path was followed."""
        end = np.array([t]), np.array([q]), payload
        tracking = self._tracking.summary(*end) if self._tracking is not None else {}
        pressed = {} if self._contact_force is None else {"peak_contact_force": self._contact_force}
        further = dict(self._scene.notes) | pressed | self._falls.summary() | self._extremes.summary(np.array(q))
        return further | tracking

    def _of_driven(self, q: Vector) -> Array:
        """Return the actuated joints' part of the positions q."""
        return np.array(q)[self._driven]


class RunTotals(NamedTuple):
    """What n runs have shown up to their ends."""

    t: Array  # (n,) s, the ends
    q: Array  # (n, nu), positions of the actuated joints there
    swing: Array  # (n,) rad, there
    evaluations: npt.NDArray[np.int64]  # (n,) of the equations
    saturated: npt.NDArray[np.int64]  # (n,) periods in which a command was limited
    peaks: Peaks  # columns
    target: Array | None  # (n, nu), of the actuated joints; None without
    near: Array  # (n, nu), which distance from it counts as near
    outside: Array  # (n, nu) s, when joints were last further away
    audit: Array  # (n, 2), energy errors
    sha: Sequence[str]  # (n,)


def name_metrics(first: Scene, ended: RunTotals) -> dict[str, Any]:
    """Return the metrics of n runs of a scene's kind by name, arrays (n,) in groups by joint.

    The names are those of `Metrics.summary`. Where a run has none, a metric is None.
    """
    peaks, nothing = ended.peaks, np.zeros(3)
    swings = [swing_angles(nothing, peaks.swing[:, i]) for i in range(2)]
    peak, residual = (np.degrees(np.maximum(each, ended.swing)) for each in swings)
    low, high = or_none(peaks.tension, np.isfinite(peaks.tension)).T
    return {
        "steps": np.rint(ended.t / first.period).astype(np.int64),
        "sim_time": ended.t,
        "rhs_evaluations": ended.evaluations,
        "final_error": _by_joint(first, ended.target - ended.q) if ended.target is not None else {},
        "peak_swing_deg": peak,
        "residual_swing_deg": residual,
        "settling_time": _settling_by_joint(first, ended),
        "peak_effort": _by_joint(first, peaks.effort),
        "saturated_steps": ended.saturated,
        "min_rope_tension": low,
        "max_rope_tension": high,
        "negative_tension_steps": peaks.pushed[:, 0],
        "energy_audit_error": ended.audit[:, 0],
        "energy_audit_max": ended.audit[:, 1],
        "state_sha256": np.array(ended.sha, object),
    }


def _by_joint(scene: Scene, values: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    """Return values of the actuated joints (n, nu) by joint."""
    return dict(zip(scene.actuated, values.T, strict=True))


def _settling_by_joint(first: Scene, ended: RunTotals) -> dict[str, npt.NDArray[Any]]:
    if ended.target is None:
        return {}
    times = settling_times(ended.target, ended.near, ended.outside, ended.t[:, None], ended.q, first.period)
    return _by_joint(first, or_none(times, ~np.isnan(times)))
