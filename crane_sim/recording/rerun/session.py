"""One recording from its first to its last row: derives what is plotted, writes blocks, counts steps."""

from __future__ import annotations

import uuid
from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.recording.layout import Block, base_of, hanging_still, of_scene, to_base, to_world
from crane_sim.recording.rerun.repair import repair_leftovers
from crane_sim.recording.rerun.writer import RunWriter
from crane_sim.simulation.metrics import derive
from crane_sim.trajectories.base_motion import base_positions

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from crane_sim.recording.layout import Numbers
    from crane_sim.recording.rerun.live import LiveServer
    from crane_sim.recording.step_assembler import Row
    from crane_sim.scenes.scene import Scene


class Session:
    """Records the steps of one run of a scene.

    Attributes:
        recorded: steps that reached the disk.
    """

    def __init__(
        self, scene: Scene, path: Path, live: LiveServer | None = None, run_id: str = "", repairs: bool = True
    ) -> None:
        """Start the file, after recovering what an earlier, killed recorder left beside it.

        Args:
            scene: what is recorded.
            path: the complete file.
            live: serves the run to viewers, too.
            run_id: the viewer's recording id, the same for parts of one; empty: one of its own.
            repairs: look for leftovers.

        Raises:
            RecordingError: the file cannot be written.
        """
        self._scene = scene
        self.recorded = 0
        if repairs:
            repair_leftovers(path.parent)
        name = f"{scene.name}-{run_id or uuid.uuid4().hex[:12]}"
        self._writer = RunWriter(path, of_scene(scene, name), live)

    @property
    def part(self) -> Path:
        """The file while it grows."""
        return self._writer.part

    def write(self, rows: Sequence[Row]) -> None:
        """Append rows.

        Raises:
            RecordingError: they did not reach the disk.
        """
        if rows:
            self._writer.write(block_of(self._scene, rows))
            self.recorded += len(rows)

    def note(self, step: int, text: str) -> None:
        """Add a line to the recording's log."""
        self._writer.note(step, text)

    def pace(self, step: int, real_time_factor: float) -> None:
        """Add how fast the run was lately: simulated seconds per second."""
        self._writer.pace(step, real_time_factor)

    def simulation_state(self, step: int, name: str) -> None:
        """Add that the simulation went into another state at the start of a step."""
        self._writer.simulation_state(step, name)

    def close(self, summary: Mapping[str, Any], lost: int) -> dict[str, Any]:
        """Finish the file with the run's summary; return what the recorder adds to it.

        Raises:
            RecordingError: the end of the file did not reach the disk.
        """
        entries = {"recording": str(self._writer.path), "recorded_steps": self.recorded, "lost_steps": lost}
        self._writer.close({**summary, **entries})
        return entries

    def failed_summary(self, why: str, lost: int, older: int = 0) -> dict[str, Any]:
        """Return the summary's entries on a file that failed; `older` steps are of before a reset."""
        suffix = f" since the last reset, and {older} from before it" if older else ""
        error = f"recorder: {why}; it has {self.recorded} of {self.recorded + lost} steps{suffix}"
        return {"recorded_steps": self.recorded, "lost_steps": lost, "error": error}


def block_of(scene: Scene, rows: Sequence[Row]) -> Block:
    """Turn rows into arrays, with everything that follows from them."""
    q, v = _array(row.q for row in rows), _array(row.v for row in rows)
    effort = _array(row.effort for row in rows)
    t = _array((row.step - 1) * scene.period for row in rows)
    known = derive(scene, t, q, v, effort)
    reference, base = _write_reference(rows), _base(scene, t)
    return Block(
        step=np.array([row.step for row in rows], dtype=np.int64),
        q=q,
        v=v,
        effort=effort,
        demanded=_demands(rows, effort.shape[1]),
        reference=reference,
        nodes=known.nodes,
        base=base,
        target=None if reference is None else _targets(scene, t, reference, q, to_base(known.nodes, base), base),
        kinetic=known.kinetic,
        potential=known.potential,
        energy=known.energy,
        raised=known.potential - _potential_at_start(scene),
        tension=known.tension,
        swing=known.swing,
        lyapunov=_lyapunov(scene, t, rows),
    )


def _potential_at_start(scene: Scene) -> float:
    """Return the potential energy [J] at the initial state."""
    q, v, u = (np.array([row]) for row in (scene.initial_q, scene.initial_v, (0.0,) * len(scene.actuated)))
    return float(derive(scene, np.zeros(1), q, v, u).potential[0])


def _array(vectors: Any) -> Numbers:
    return np.array(list(vectors), dtype=np.float64)


def _demands(rows: Sequence[Row], nu: int) -> Numbers:
    return _array((np.nan,) * nu if row.demanded is None else row.demanded for row in rows)


def _base(scene: Scene, t: Numbers) -> Numbers | None:
    """Return where the base is at times t (K,), (K, 6); None where it rests."""
    moves = base_of(scene)
    return base_positions(moves, t) if moves is not None else None


def _write_reference(rows: Sequence[Row]) -> Numbers | None:
    references = [row.reference for row in rows]
    return _array(references) if all(reference is not None for reference in references) else None


UPRIGHT = {"_z": -1.0, "qw": 1.0}
"""Components, by the end of their names, of directions that point down and of an attitude that is the base's."""


def _targets(scene: Scene, t: Numbers, reference: Numbers, q: Numbers, nodes: Numbers, base: Numbers | None) -> Numbers:
    """Return the crane's nodes with the reference's posture and the payload hanging still below the tip.

    `nodes` are in the frame of the base (K, 6), what is returned is in the world.
    """
    if scene.crane == "overhead":
        return to_world(hanging_still(scene.actuated, reference, nodes), base)
    neutral_q = np.where(np.array(scene.joint_units) == "m", q, 0.0)  # undriven lengths stay as they are
    neutral_q[:, [scene.joint_names.index(name) for name in scene.actuated]] = reference
    for i, (name, unit) in enumerate(zip(scene.joint_names, scene.joint_units, strict=True)):
        if unit == "1" and name[-2:] in UPRIGHT:
            neutral_q[:, i] = UPRIGHT[name[-2:]]
    if "payload_x" in scene.joint_names:
        neutral_q[:, [scene.joint_names.index(name) for name in ("payload_x", "payload_y")]] = reference[:, :2]
    return derive(scene, t, neutral_q, np.zeros_like(neutral_q), np.zeros_like(reference)).nodes


def _lyapunov(scene: Scene, t: Numbers, rows: Sequence[Row]) -> Numbers | None:
    function = getattr(scene.law, "lyapunov", None)  # not every law has one
    if function is None:
        return None
    return _array(function(at, tuple(row.q), tuple(row.v)) for at, row in zip(t.tolist(), rows, strict=True))
