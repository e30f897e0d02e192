"""Metrics of runs: functions of their `totals`, the same for one run and for many."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.flexibility import DEFLECTION
from crane_sim.simulation.derived import swing_angles
from crane_sim.simulation.energy_balance import supplied_up_to
from crane_sim.simulation.flat_summary import one_run, or_none
from crane_sim.simulation.settling import settling_times
from crane_sim.simulation.state_hash import StateHash
from crane_sim.simulation.totals import (
    LARGEST_ERROR,
    TIP_ACCELERATION,
    Tilt,
    Totals,
    Watched,
    add_rows,
    empty_totals,
    finish,
    read_final_meters,
    read_meters,
    watched_of,
)
from crane_sim.tracing.trees import rebuilt

Array = npt.NDArray[np.float64]
Vector = tuple[float, ...]


class Metrics:
    """Metrics of one run, from blocks of rows, one row a control period.

    They have the same bits however long the blocks are.
    """

    def __init__(self, scene: Scene, model: Any, x: Any, picklable: bool = False) -> None:
        """Start with state x of the model that is integrated; `picklable`: as of `StateHash`."""
        self._scene, self._model = scene, model
        self._watched, self._totals = (
            watched_of(scene, model.energy_meter is not None),
            empty_totals(scene),
        )
        self._totals.balance.start[0] = read_meters(model, x)[0]
        self._hash = StateHash(picklable)

    def extend(self, t: Array, rows: Array) -> None:
        """Take the rows of the periods that begin at times t (K,) [s]."""
        self._hash.extend(np.column_stack([t, rows[:, : 2 * len(self._scene.joint_names)]]))
        add_rows(self._scene.model, self._watched, self._totals, t, rows)

    def change(self, scene: Scene, model: Any, q: Vector, energy: float = 0.0) -> None:
        """Continue from positions q with another model.

        It has a meter, or a payload whose change supplied `energy` [J].
        """
        balance, metered = self._totals.balance, model.energy_meter is not None
        if metered and not self._watched.metered:  # the work of held efforts ends here
            balance.start[1] = supplied_up_to(balance, self._watched, q, 0.0)
        balance.start[1] += energy
        self._watched = self._watched._replace(metered=metered)
        self._scene, self._model = scene, model

    def summary(
        self, t: float, q: Vector, v: Vector, integration: Any, saturated: int
    ) -> dict[str, Any]:
        """Return the metrics of the run that ends at t [s] with q, v; see `name_metrics`."""
        totals, end = _copy(self._totals), (np.array(q), np.array(v))
        meters = read_final_meters(self._model, integration.x, t, *end)
        finish(self._scene.model, self._watched, totals, t, *end, meters)
        sha = self._hash.hexdigest(np.array([t, *q, *v]))
        counts = np.array([integration.evaluations]), np.array([saturated])
        ended = Ended(
            np.array([t]), *counts, [sha], _as_columns(self._watched), _as_columns(totals)
        )
        named, of_some = name_metrics(self._scene, ended), name_further_metrics(self._scene, ended)
        return one_run(named) | dict(self._scene.notes) | one_run(of_some)


def _copy(tree: Any) -> Any:
    """Return a tree with copies of its arrays."""
    if isinstance(tree, tuple):
        return rebuilt(tree, [_copy(part) for part in tree])
    return None if tree is None else tree.copy()


def _as_columns(tree: Any) -> Any:
    """Return a tree of one run as columns of one."""
    if isinstance(tree, tuple):
        return rebuilt(tree, [_as_columns(part) for part in tree])
    return None if tree is None else np.asarray(tree)[None]


class Ended(NamedTuple):
    """What n runs of one kind have shown up to their ends."""

    t: Array  # (n,) s, the ends
    evaluations: npt.NDArray[np.int64]  # (n,) of the equations
    saturated: npt.NDArray[np.int64]  # (n,) periods in which a command was limited
    sha: Sequence[str]  # (n,)
    watched: Watched  # columns
    totals: Totals  # columns, their runs finished


def name_metrics(first: Scene, ended: Ended) -> dict[str, Any]:
    """Return the metrics of n runs of a scene's kind by name, arrays (n,), grouped by joint.

    None: a run has none.

    `settling_time` is the time after which a joint stays near its target, see
    `crane_sim.simulation.settling`; `residual_swing_deg` is the largest swing in the last quarter
    of the scene's duration; tensions are the smallest and the largest of all links at the start of
    every period, `negative_tension_steps` the periods that began with a link that pushed;
    `energy_audit_error` is the energy that appeared from nowhere up to the end, `energy_audit_max`
    up to any period, both relative to the energies in play, as of
    `crane_sim.simulation.energy_balance`; `state_sha256` is over the little-endian float64 bytes of
    t, q, v of every control step and of the final state.
    """
    totals, nothing = ended.totals, np.zeros(3)
    peak, residual = (
        np.degrees(swing_angles(nothing, totals.swing[:, part, :3])) for part in range(2)
    )
    low, high = or_none(totals.tension, np.isfinite(totals.tension)).T
    errors, settled = _of_targets(first, ended) if first.reference is not None else ({}, {})
    return {
        "steps": np.rint(ended.t / first.period).astype(np.int64),
        "sim_time": ended.t,
        "rhs_evaluations": ended.evaluations,
        "final_error": errors,
        "peak_swing_deg": peak,
        "residual_swing_deg": residual,
        "settling_time": settled,
        "peak_effort": _by_joint(first, totals.effort),
        "saturated_steps": ended.saturated,
        "min_rope_tension": low,
        "max_rope_tension": high,
        "negative_tension_steps": totals.pushed[:, 0],
        "energy_audit_error": totals.balance.errors[:, 0],
        "energy_audit_max": totals.balance.errors[:, 1],
        "state_sha256": np.array(ended.sha, object),
    }


def _of_targets(first: Scene, ended: Ended) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (final errors, settling times) of the actuated joints."""
    target, near, q = ended.watched.target, ended.watched.near, ended.totals.balance.last[:, 0]
    times = settling_times(target, near, ended.totals.outside, ended.t[:, None], q, first.period)
    return _by_joint(first, target - q), _by_joint(first, or_none(times, ~np.isnan(times)))


def _by_joint(scene: Scene, values: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    """Return values of the actuated joints (n, nu) by joint."""
    return dict(zip(scene.actuated, values.T, strict=True))


def name_further_metrics(first: Scene, ended: Ended) -> dict[str, Any]:
    """Return the metrics that only some scenes have, as `name_metrics` does.

    `peak_contact_force` is the largest normal force of a surface on the load; of a reeved rope
    there are the largest tensions of lead line and falls, and of the drum's torque, all at the
    start of every period; `limit_margin` is the least distance of each joint to its travel limits,
    negative beyond them; `peak_tilt_deg` is the largest angle of the load's z axis from the base's,
    and `peak_skew_deg`, `peak_trim_deg`, `peak_list_deg` its largest rotations about z, y and x
    below a support that does not slew; `peak_JOINT_deg` the largest angles by which a structure
    bends.

    Over all control steps and the final state, e the error of the path's own coordinates:
    `tracking_mse` is the mean of e·e, `tracking_mae` of |e|, `tracking_peak` the largest |e|, in
    the coordinates' unit (m in the base frame, for a payload). `peak_tip_acceleration` [m/s²] is
    relative to the base, at the control steps.
    """
    totals = ended.totals
    contact = {} if totals.contact is None else {"peak_contact_force": totals.contact[:, 0]}
    falls = {} if totals.falls is None else _of_falls(totals.falls[:, 0])
    tracking = (
        {} if totals.tracking is None else _of_path(totals.tracking, totals.balance.count[:, 0] + 1)
    )
    return contact | falls | _margins(first, ended) | _angles(first, totals) | tracking


def _of_falls(peaks: Array) -> dict[str, Any]:
    """Return the metrics of a reeved rope by its largest tensions and torque (n, falls + 2)."""
    falls = np.empty(len(peaks), object)
    for i, row in enumerate(peaks):
        falls[i] = row[1:-1].tolist()
    named = {"max_lead_line_tension": peaks[:, 0], "max_fall_tensions": falls}
    return named | ({"max_drum_torque": peaks[:, -1]} if np.any(peaks[:, -1]) else {})


def _of_path(tracking: Array, count: npt.NDArray[np.int64]) -> dict[str, Any]:
    """Return the metrics of a path by `Totals.tracking` (n, 4) of so many instants (n,)."""
    means = {"tracking_mse": tracking[:, 0] / count, "tracking_mae": tracking[:, 1] / count}
    return means | {
        "tracking_peak": tracking[:, LARGEST_ERROR],
        "peak_tip_acceleration": tracking[:, TIP_ACCELERATION],
    }


def _margins(first: Scene, ended: Ended) -> dict[str, Any]:
    """Return the least distances of joints to their travel limits."""
    found = dict[str, Array]()
    for k, limit in enumerate(first.limits):
        ranges, (low, high) = (
            ended.totals.ranges[:, :, first.joint_names.index(limit.joint)],
            ended.watched.limits[k],
        )
        found[limit.joint] = np.minimum(ranges[:, 0] - low, high - ranges[:, 1])
    return {"limit_margin": found} if found else {}


def _angles(first: Scene, totals: Totals) -> dict[str, Any]:
    """Return the largest angles of a load and of a structure that bends."""
    # a slewing crane turns the load on purpose
    shown = ("tilt",) if "slew" in first.joint_names else Tilt._fields
    load = {} if totals.tilt is None else dict(zip(shown, totals.tilt.T, strict=False))
    furthest = np.abs(totals.ranges).max(axis=1)
    bends = {
        name: furthest[:, i]
        for i, name in enumerate(first.joint_names)
        if name.endswith(DEFLECTION)
    }
    return {f"peak_{name}_deg": np.degrees(angle) for name, angle in (load | bends).items()}
