"""Blocks of steps, from a run's messages or a run without ROS, with the derived quantities."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.recording.base_frame import base_of, to_base, to_world
from crane_sim.recording.layout import Block, of_rollout, select_tensions
from crane_sim.recording.run import AnimationFrames, RecordedRun, crane_of
from crane_sim.recording.states import (
    BRAKES,
    CONTACT,
    EFFORTS,
    MIN_FORCE,
    make_event_timelines,
    make_fault_timelines,
)
from crane_sim.recording.suspension import hanging_still
from crane_sim.simulation.derived import Derived, derive, derive_instant, fill_contact_forces
from crane_sim.simulation.flat_summary import plain
from crane_sim.simulation.hardware import is_sensed, measure
from crane_sim.trajectories.base_motion import base_positions

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Array, Layout
    from crane_sim.recording.states import Changes
    from crane_sim.recording.step_assembler import Row
    from crane_sim.scenes.scene import Scene
    from crane_sim.simulation.rollout import Rollout

    # timeline, steps at which it changes, states from then on
    StepChanges = tuple[str, NDArray[np.int64], list[str]]


class Motion(NamedTuple):
    """K control steps as they were sent or computed: fields as those of `Block`."""

    step: NDArray[np.int64]
    q: Array
    v: Array
    effort: Array
    demanded: Array
    reference: Array | None
    braked: NDArray[np.bool_]


def block_of(scene: Scene, rows: Sequence[Row]) -> Block:
    """Turn rows into arrays, with everything that follows from them."""
    q, v = _array(row.q for row in rows), _array(row.v for row in rows)
    effort = _array(row.effort for row in rows)
    step, braked = (
        np.array([row.step for row in rows], dtype=np.int64),
        np.array([row.braked for row in rows]),
    )
    motion = Motion(step, q, v, effort, _demands(rows, effort.shape[1]), _references(rows), braked)
    t = ((step - 1) * scene.period).astype(np.float64)
    return _complete(scene, motion, derive(scene, t, q, v, effort))._replace(
        measured=_measured_array(rows)
    )


def block_of_rollout(rollout: Rollout) -> Block:
    """Return all control steps of a run without ROS; the instant at which it ended is no step.

    Raises:
        ValueError: the run was sampled at other instants than those of its control periods.
    """
    scene, steps = rollout.scene, rollout.summary["steps"]
    instants = np.arange(steps + 1) * scene.period
    if not np.array_equal(rollout.t, instants):
        raise ValueError(
            "this run has samples at other times than its control periods: simulate without "
            "sample_times"
        )
    reference = None if scene.reference is None else np.tile(scene.reference, (steps, 1))
    step = np.arange(1, steps + 1)
    calm = np.zeros(steps, dtype=bool)
    motion = Motion(
        step, rollout.q[:-1], rollout.v[:-1], rollout.u[:-1], rollout.commands, reference, calm
    )
    block = _complete(scene, motion, Derived(*(each[:-1] for each in rollout.derived)))
    return (
        block._replace(measured=measure(scene, motion.q, motion.v)) if is_sensed(scene) else block
    )


def _complete(scene: Scene, motion: Motion, known: Derived) -> Block:
    """Return the block of a motion with what is derived from it."""
    t, reference = ((motion.step - 1) * scene.period).astype(np.float64), motion.reference
    base = _base(scene, t)
    local = to_base(known.nodes, base)
    return Block(
        **motion._asdict(),
        nodes=known.nodes,
        base=base,
        target=None if reference is None else _targets(scene, t, reference, motion.q, local, base),
        kinetic=known.kinetic,
        potential=known.potential,
        energy=known.energy,
        raised=known.potential - _potential_at_start(scene),
        tensions=select_tensions(known.tensions),
        reeved=known.falls[:, :-1] if known.falls.size else None,
        swing=known.swing,
        measured=None,
        contact=_contact(scene, t, motion.q, motion.v),
        lyapunov=_lyapunov(scene, t, motion.q, motion.v),
    )


def _potential_at_start(scene: Scene) -> float:
    """Return the potential energy [J] at the initial state."""
    return float(derive_instant(scene, 0.0, scene.initial_q, scene.initial_v).potential[0])


def _contact(scene: Scene, t: Array, q: Array, v: Array) -> Array | None:
    """Return the normal force (K,) [N] on a load that may touch a surface; None for another one."""
    if getattr(scene.model, "contact", None) is None:
        return None
    forces = np.empty(len(t))
    fill_contact_forces(scene.model, *map(np.ascontiguousarray, (t, q, v)), forces)
    return forces


def _array(vectors: Any) -> Array:
    return np.array(list(vectors), dtype=np.float64)


def _demands(rows: Sequence[Row], nu: int) -> Array:
    return _array((np.nan,) * nu if row.demanded is None else row.demanded for row in rows)


def _measured_array(rows: Sequence[Row]) -> Array | None:
    shown = [row.measured for row in rows if row.measured is not None]
    return _array((*q, *v) for q, v in shown) if len(shown) == len(rows) else None


def _base(scene: Scene, t: Array) -> Array | None:
    """Return where the base is at times t (K,), (K, 6); None where it rests."""
    moves = base_of(scene)
    return base_positions(moves, t) if moves is not None else None


def _references(rows: Sequence[Row]) -> Array | None:
    """Return the targets (K, nu), NaN before the first one; None without any."""
    known = next((row.reference for row in rows if row.reference is not None), None)
    if known is None:
        return None
    return _array(
        (np.nan,) * len(known) if row.reference is None else row.reference for row in rows
    )


NEUTRAL_COMPONENTS = {"_z": -1.0, "qw": 1.0}
"""Components, by the end of their names, of directions that point down and of an attitude that is
the base's."""

MOST_REFERENCES, MANY_STEPS = 20, 2000
"""References in as many steps at which the crane's rest is solved for, some ms each: a stream of
setpoints has more."""


def _targets(
    scene: Scene, t: Array, reference: Array, q: Array, nodes: Array, base: Array | None
) -> Array:
    """Return the crane's nodes in the reference's posture, the payload at rest below the tip.

    `nodes` are in the frame of the base (K, 6), what is returned is in the world.
    """
    if scene.crane == "overhead":
        return to_world(hanging_still(scene.actuated, reference, nodes), base)
    # undriven lengths stay as they are
    neutral_q = np.where(np.array(scene.joint_units) == "m", q, 0.0)
    neutral_q[:, [scene.joint_names.index(name) for name in scene.actuated]] = reference
    for i, (name, unit) in enumerate(zip(scene.joint_names, scene.joint_units, strict=True)):
        if unit == "1" and name[-2:] in NEUTRAL_COMPONENTS:
            neutral_q[:, i] = NEUTRAL_COMPONENTS[name[-2:]]
    still = np.zeros_like(neutral_q), np.zeros_like(reference)
    if "payload_x" in scene.joint_names:
        above = to_base(derive(scene, t, neutral_q, *still).nodes, base)[
            :, system.tip_index(scene.model)
        ]
        neutral_q[:, [scene.joint_names.index(name) for name in ("payload_x", "payload_y")]] = (
            above[:, :2]
        )
    _fill_resting_joints(scene, reference, neutral_q)
    return derive(scene, t, neutral_q, *still).nodes


def _fill_resting_joints(scene: Scene, reference: Array, q: Array) -> None:
    """Fill into positions (K, nq) those of falls' loads and bending parts at rest.

    They are at rest at the references (K, nu).
    """
    rows, of = np.unique(reference, axis=0, return_inverse=True)
    is_stream = len(rows) > MOST_REFERENCES * (1 + len(q) // MANY_STEPS)
    for i, row in enumerate(() if is_stream else rows.tolist()):
        try:
            resting = scene.file.resting_joints(tuple(row))
        except (ArithmeticError, ValueError):  # no rest there: a topic may carry any numbers
            continue
        for name, position in resting.items():
            q[of.ravel() == i, scene.joint_names.index(name)] = position


def _lyapunov(scene: Scene, t: Array, q: Array, v: Array) -> Array | None:
    function = getattr(scene.law, "lyapunov", None)  # not every law has one
    if function is None:
        return None
    return _array(
        function(*at) for at in zip(t.tolist(), map(tuple, q), map(tuple, v), strict=True)
    )


def run_of_rollout(rollout: Rollout) -> RecordedRun:
    """Return a run of `simulate`.

    Raises:
        ValueError: it has samples at other times than its control periods.
    """
    block, steps = block_of_rollout(rollout), rollout.summary["steps"]
    entries = {"recorded_steps": steps, "lost_steps": 0}
    return run_of_block(of_rollout(rollout, ""), block, rollout.summary | entries, rollout.events)


_UNCHANGED = (  # what a run has as its block has it
    *("base", "tensions", "reeved", "swing", "contact"),
    *("kinetic", "potential", "lyapunov"),
)


def run_of_block(
    layout: Layout,
    block: Block,
    summary: Mapping[str, Any],
    events: Sequence[tuple[float, str]] = (),
) -> RecordedRun:
    """Return the run of a block that has all its steps."""
    t = 1e-9 * ((block.step - 1) * layout.period_ns).astype(np.float64)
    q_measured, v_measured = _split_measured(layout, block)
    about = layout.properties.items()
    return RecordedRun(
        path=None,
        crane=crane_of(layout.properties),
        properties={key: value for key, value in about if key not in ("crane", "urdf")},
        t=t,
        q=block.q,
        v=block.v,
        q_measured=q_measured,
        v_measured=v_measured,
        u=block.effort,
        commands=block.demanded,
        reference=block.reference,
        tip=block.nodes[:, layout.ropes.tip],
        payload=block.nodes[:, -1],
        frames=_frames(layout, block, t),
        states=_states(layout, block, summary, events),
        events=[(round(1e9 * time) / 1e9, text) for time, text in events],
        summary=json.loads(json.dumps(summary, default=plain)),
        **{name: getattr(block, name) for name in _UNCHANGED},
    )


def _split_measured(layout: Layout, block: Block) -> Sequence[Any]:
    """Return the measured positions and velocities, None where they are the true ones."""
    if not layout.sensed or block.measured is None:
        return None, None
    return np.hsplit(block.measured, 2)


def _frames(layout: Layout, block: Block, t: Any) -> AnimationFrames:
    kept = (block.step - 1) % layout.frame_stride == 0
    shown = block.part(kept)
    target = None if shown.target is None else shown.target[:, -1]
    return AnimationFrames(t[kept], shown.nodes, target, layout.fall_ends(shown))


def _states(
    layout: Layout, block: Block, summary: Mapping[str, Any], events: Sequence[tuple[float, str]]
) -> dict[str, Changes]:
    timelines = make_event_timelines(events) | make_fault_timelines(summary)
    for timeline, steps, states in StateTimelines(layout).find_changes(block):
        timelines[timeline] = [
            *zip(((steps - 1) * layout.period_ns / 1e9).tolist(), states, strict=True)
        ]
    return {name.replace("_", " "): timelines[name] for name in sorted(timelines)}


class StateTimelines:
    """The last states of a run's timelines, from which their changes follow."""

    def __init__(self, layout: Layout) -> None:
        """Begin before the first step, all in their normal states."""
        self._layout, self._inputs = layout, layout.timeline_inputs
        self._last: dict[str, str] = {}
        self._tripped = np.zeros(len(layout.actuated), dtype=bool)

    def find_changes(self, block: Block) -> Iterator[StepChanges]:
        """Yield (timeline, steps at which its state changes, new states) of the next block."""
        for timeline, normal, other, where in self._evaluate(block):
            yield from self._compare(timeline, normal, block.step, np.where(where, other, normal))

    def find_change(
        self, timeline: str, normal: str, step: int, state: str
    ) -> Iterator[StepChanges]:
        """Yield a timeline's change at one step, as `find_changes` does.

        The timeline begins in the state `normal`.
        """
        yield from self._compare(timeline, normal, np.array([step]), np.array([state]))

    def _compare(
        self, timeline: str, normal: str, step: NDArray[np.int64], values: Any
    ) -> Iterator[StepChanges]:
        known = timeline in self._last
        before = np.concatenate([[self._last.get(timeline, normal)], values[:-1]])
        rows = np.flatnonzero(values != before)
        if not rows.size:
            return
        self._last[timeline] = str(values[-1])
        steps, states = step[rows], [str(state) for state in values[rows]]
        if not known and steps[0] > 1:
            steps, states = np.concatenate([[1], steps]), [normal, *states]
        yield timeline, steps, states

    def _evaluate(self, block: Block) -> Iterator[tuple[str, str, Any, Any]]:
        """Yield (timeline, normal state, other state, whether in the other (K,)) of a block."""
        layout = self._layout
        if layout.actuated and layout.commanded:
            yield BRAKES, "released", "acting", block.braked
        if (
            layout.actuated
            and self._inputs.only_limits_change_efforts
            and layout.effort_units == layout.command_units
        ):
            differs = np.isfinite(block.demanded) & (block.demanded != block.effort)
            yield EFFORTS, "free", "limited", differs.any(axis=1)
        for name, tension in zip(layout.ropes.tensions, block.tensions.T, strict=True):
            pushing = tension < -MIN_FORCE
            yield _short(name), "taut", np.where(pushing, "pushes", "slack"), tension <= MIN_FORCE
        if block.contact is not None:
            yield CONTACT, "apart", "touches", block.contact > MIN_FORCE
        yield from self._limit_switches(block)

    def _limit_switches(self, block: Block) -> Iterator[tuple[str, str, str, Any]]:
        """Yield the timelines of limit switches; a switch that has tripped stays so."""
        if self._inputs.limit_switches is None:
            return
        q, (low, high) = block.q[:, self._layout.driven], self._inputs.limit_switches
        tripped = np.logical_or.accumulate((q > high) | (q < low), axis=0) | self._tripped
        self._tripped = tripped[-1]
        for name, each in zip(self._layout.actuated, tripped.T, strict=True):
            yield f"limit switch of the {name}", "clear", "tripped", each


def _short(name: str) -> str:
    """Return the name of a link, a fall or the only rope, from that of its tension."""
    return {
        "rope tension": "rope",
        "tension of the top link": "link 1",
        "tension of fall 1": "fall 1",
    }.get(name, name)
