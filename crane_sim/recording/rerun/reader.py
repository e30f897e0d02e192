"""Reads a recording back: single curves, or a whole run."""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import reduce
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from crane_sim.recording.completeness import Completeness, Steps, assess
from crane_sim.recording.digest import DIGEST, Rows, agrees, lacks_changes, verified_steps
from crane_sim.recording.rerun.rrd_file import NoRecording, read_chunks
from crane_sim.recording.rerun.writer import DIGESTS, EVENTS, STATES, is_verified
from crane_sim.recording.run import AnimationFrames, RecordedRun, UnreadableRecording, crane_of

SCALARS = "Scalars:scalars"
_ROW_ID = "rerun.controls.RowId"  # in the order in which rows were logged, also within one instant
_SUMMARY, _RUN = "__properties/summary", "__properties/run"
_RUN_ENTITIES = (_SUMMARY, _RUN, DIGESTS, EVENTS, STATES, "plots/", "frames/")
_CHANGED = {EVENTS: "TextLog:text", STATES: "StateChange:state"}  # columns
Batches = dict[str, list[pa.RecordBatch]]  # rows by entity
Instants = list[tuple[int, str]]  # (ns, event or state from then on)


class Curves(NamedTuple):
    """The rows of one entity, in the order of steps."""

    step: NDArray[np.int64]  # (K,)
    time: NDArray[np.float64]  # (K,) s, scene time
    values: NDArray[np.float64]  # (K, curves)


def read_curves(path: Path, entity: str) -> Curves:
    """Return the curves of an entity such as `plots/q`, each step once.

    Raises:
        KeyError: the recording has no such curves.
    """
    rows = _join_rows(entity, _read_batches(path, (entity,))[0][entity])
    if rows is None:
        raise KeyError(f"{path} has no curves {entity!r}")
    return Curves(rows.step, _seconds(rows.time), rows.values)


def read_summary(path: Path) -> dict[str, Any]:
    """Return the summary of a complete recording.

    Raises:
        KeyError: it has none: its recorder was killed.
    """
    properties = _properties(_read_batches(path, (_SUMMARY,))[0][_SUMMARY])
    if "json" not in properties:
        raise KeyError(f"{path} has no summary")
    return json.loads(properties["json"])


_DAMAGE = (ValueError, LookupError, TypeError, pa.ArrowException)  # of a file without digests


def read_run(path: Path) -> RecordedRun:
    """Return the run in a recording; of a cut or damaged one, the steps that are as written.

    Raises:
        UnreadableRecording: the file is no recording of a run, or none of its steps is good.
    """
    try:
        batches, unreadable = _read_batches(path)
    except (OSError, NoRecording) as error:
        raise UnreadableRecording(f"{path}: cannot be read: {error}") from None
    run = _properties(batches[_RUN])
    if "compared" in run:
        raise UnreadableRecording(
            f"{path}: holds a comparison of runs, no run; read the recordings of the runs"
        )
    if not agrees(run, required=bool(batches[DIGESTS])):
        raise UnreadableRecording(f"{path}: is damaged: its scene is not as it was written")
    if "crane" not in run:
        cut = "" if run else "is cut off before its first step, or "
        raise UnreadableRecording(
            f"{path}: {cut}holds no run, or one of an older version of crane_sim"
        )
    try:
        return _assemble(path, batches, run, unreadable)
    except UnreadableRecording:
        raise
    except _DAMAGE as error:
        reason = str(error).partition("\n")[0]
        raise UnreadableRecording(f"{path}: is damaged: {reason}") from error


def _assemble(path: Path, batches: Batches, run: dict[str, Any], unreadable: int) -> RecordedRun:
    """Return the run of a file's rows and properties `run`, given its `unreadable` messages."""
    checked, end = DIGEST in run, _properties(batches[_SUMMARY])
    is_whole = agrees(end, required=checked)
    summary = json.loads(end.get("json", "{}")) if is_whole else {}
    changes, curves = _changes(batches), _verified_curves(batches)
    blocks = [text for _, text in _texts(batches[DIGESTS], "TextDocument:text")]
    good = verified_steps(curves.values(), blocks) if checked else _common_steps(curves.values())
    damage = _describe_damage(unreadable, is_whole)
    if summary and lacks_changes(changes, blocks):
        damage.append("its events and states are not as they were written")
    _check_steps(path, good, summary)
    crane, rows = crane_of(run), {name: each.at(good) for name, each in curves.items()}
    arrays = _arrays(rows, path, bool(crane.actuated), good)
    events = _in_seconds(changes.get(EVENTS, []))
    kept = {key: value for key, value in run.items() if key not in ("crane", "urdf", DIGEST)}
    return RecordedRun(
        path=path,
        crane=crane,
        properties=kept,
        frames=_frames(rows),
        states=_select_states(changes),
        events=events or [(each["t"], each["what"]) for each in summary.get("events", ())],
        summary=summary,
        completeness=_assess(arrays["t"], run, summary, "; ".join(damage)),
        **arrays,
    )


def _describe_damage(unreadable: int, is_whole: bool) -> list[str]:
    """Return what is damaged of a file's parts and its summary, a line each."""
    damage: list[str] = []
    if unreadable:
        damage.append(f"{unreadable} of its parts cannot be read")
    if not is_whole:
        damage.append("its summary is not as it was written")
    return damage


def _select_states(changes: dict[str, Instants]) -> dict[str, list[tuple[float, str]]]:
    """Return the timelines of states, by name, of all changes."""
    names = [name for name in sorted(changes) if name != EVENTS]
    return {_timeline(name): _in_seconds(changes[name]) for name in names}


def _check_steps(path: Path, good: NDArray[np.int64], summary: dict[str, Any]) -> None:
    if not len(good):
        reason = (
            summary.get("error")
            or "it is cut off before the first ones are complete, or all are damaged"
        )
        raise UnreadableRecording(f"{path}: has no steps: {reason}")


def _assess(
    t: NDArray[np.float64], run: dict[str, Any], summary: dict[str, Any], damage: str
) -> Completeness:
    planned = round(run["duration"] / run["period"])
    recorded = summary.get("recorded_steps", len(t)) if summary else None
    # the rows of those commands are there
    lost = summary.get("lost_steps", 0) - summary.get("lost_commands", 0)
    return assess(Steps(len(t), float(t[-1]), planned, recorded, lost), damage)


_STORED = {name: name for name in ("q", "v", "tip", "payload", "swing", "energy_parts")} | {
    "tensions": "tension"
}
_OF_DRIVES = {"u": "effort", "commands": "effort_demanded"}
_OPTIONAL = {
    name: name
    for name in ("base", "contact", "q_measured", "v_measured", "lyapunov", "lyapunov_rate")
}
_OPTIONAL |= {"reeved": "reeved_tension"}
"""Entities below `plots/` by what they are: of every run, of one whose crane is driven, of some."""


def _arrays(
    rows: dict[str, Rows], path: Path, driven: bool, steps: NDArray[np.int64]
) -> dict[str, Any]:
    """Return a run's arrays at its good steps, by attribute name; None for those it lacks."""
    needed = _STORED | (_OF_DRIVES if driven else {})
    found: dict[str, Any] = {}
    for name, entity in (needed | _OPTIONAL).items():
        curves = rows.get(f"plots/{entity}")
        found[name] = (
            None if curves is None or not np.array_equal(curves.step, steps) else curves.values
        )
        if found[name] is None and name in needed:
            raise UnreadableRecording(f"{path}: is damaged: it has no plots/{entity}")
    if not driven:
        found |= dict.fromkeys(_OF_DRIVES, np.empty((len(steps), 0)))
    reference = rows.get("plots/q_ref")
    found["reference"] = None if reference is None else _spread(reference, steps)
    for name in ("swing", "contact"):
        found[name] = None if found[name] is None else found[name][:, 0]
    found["kinetic"], found["potential"] = found.pop("energy_parts").T
    value, rate = found["lyapunov"], found.pop("lyapunov_rate")
    found["lyapunov"] = None if value is None or rate is None else np.hstack((value, rate))
    return found | {"t": _seconds(rows["plots/q"].time)}


def _frames(rows: dict[str, Rows]) -> AnimationFrames:
    nodes, target, falls = (rows.get(f"frames/{name}") for name in ("nodes", "target", "falls"))
    if nodes is None:
        return AnimationFrames(np.empty(0), np.empty((0, 0, 3)), None, None)
    count = len(nodes.time)
    ends = None if falls is None else falls.values.reshape(count, -1, 2, 3)
    targets = None if target is None else _spread(target, nodes.step)
    return AnimationFrames(_seconds(nodes.time), nodes.values.reshape(count, -1, 3), targets, ends)


def _verified_curves(batches: Batches) -> dict[str, Rows]:
    joined = {name: _join_rows(name, batches[name]) for name in list(batches) if is_verified(name)}
    return {name: rows for name, rows in joined.items() if rows is not None}


def _common_steps(curves: Iterable[Rows]) -> NDArray[np.int64]:
    """Return the steps common to all curves that every run has.

    It is for recordings without digests, by an older version.
    """
    names = [f"plots/{name}" for name in _STORED.values()]
    found = [rows.step for rows in curves if rows.name in names]
    return reduce(np.intersect1d, found) if len(found) == len(names) else np.empty(0, np.int64)


def _changes(batches: Batches) -> dict[str, Instants]:
    """Return the events, and the states of each timeline, by entity."""
    changes: dict[str, Instants] = {}
    for entity in (name for name in batches if name.startswith((EVENTS, STATES))):
        changes[entity] = _texts(batches[entity], _CHANGED[EVENTS if entity == EVENTS else STATES])
    return changes


def _texts(batches: Sequence[pa.RecordBatch], column: str) -> Instants:
    """Return (scene time [ns], text) of a column's rows, in order; each text is a list of one."""
    rows: list[tuple[int, bytes, str]] = []
    for batch in batches:
        with suppress(KeyError):  # it has other columns, or is damaged
            columns = (
                _nanoseconds(batch).tolist(),
                batch[_ROW_ID].to_pylist(),
                batch[column].to_pylist(),
            )
            rows += [
                (time, row, texts[0]) for time, row, texts in zip(*columns, strict=True) if texts
            ]
    return [(time, text) for time, _, text in sorted(rows)]


def _timeline(entity: str) -> str:
    """Return the name of a timeline of states."""
    return entity.removeprefix(STATES).replace("_", " ")


def _in_seconds(changes: Instants) -> list[tuple[float, str]]:
    return [(time / 1e9, text) for time, text in changes]


def _properties(batches: Sequence[pa.RecordBatch]) -> dict[str, Any]:
    """Return the properties of a recording, in which every value is a list of one."""
    values: dict[str, Any] = {}
    for batch in batches:
        values |= {
            name: value[0]
            for name, value in batch.to_pylist()[-1].items()
            if isinstance(value, list) and value
        }
    return values


def _read_batches(path: Path, entities: tuple[str, ...] = _RUN_ENTITIES) -> tuple[Batches, int]:
    """Return the rows by entity, and the number of unreadable messages.

    `entities` are what the names of the entities begin with.
    """
    contents, batches = read_chunks(path, entities), defaultdict[str, list[pa.RecordBatch]](list)
    for chunk in contents.chunks:
        if not chunk.is_static or chunk.entity in (_RUN, _SUMMARY):
            batches[chunk.entity].append(chunk.batch)
    return batches, contents.unreadable


def _join_rows(entity: str, batches: Sequence[pa.RecordBatch]) -> Rows | None:
    """Return the rows of an entity's curves, each step once; None where it has none."""
    parts = list[Rows]()
    for batch in batches:
        with suppress(KeyError, ValueError):  # it has no curves but their style, or is damaged
            parts.append(_rows_of(entity, batch))
    if not parts:
        return None
    # others are damaged
    ((width, _),) = Counter(part.values.shape[1] for part in parts).most_common(1)
    parts = [part for part in parts if part.values.shape[1] == width]
    step, time, values = (np.concatenate([part[i] for part in parts]) for i in (1, 2, 3))
    # where two recorders wrote one step, they wrote the same
    _, order = np.unique(step, return_index=True)
    return Rows(entity, step[order], time[order], values[order])


def _rows_of(entity: str, batch: pa.RecordBatch) -> Rows:
    values = batch[SCALARS].flatten().to_numpy(zero_copy_only=False).reshape(batch.num_rows, -1)
    return Rows(entity, batch["step"].to_numpy(), _nanoseconds(batch), values)


def _spread(rows: Rows, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the values (K, curves) of rows at all steps (K,), NaN where they have none."""
    values = np.full((len(steps), rows.values.shape[1]), np.nan)
    _, at, own = np.intersect1d(steps, rows.step, return_indices=True)
    values[at] = rows.values[own]
    return values


def _seconds(nanoseconds: NDArray[np.int64]) -> NDArray[np.float64]:
    return 1e-9 * nanoseconds.astype(np.float64)


def _nanoseconds(batch: pa.RecordBatch) -> NDArray[np.int64]:
    return batch["sim_time"].cast(pa.int64()).to_numpy()
