"""Reads a recording back: single curves, or a whole run."""

from __future__ import annotations

import json
import warnings
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from rerun.chunk import RrdReader

from crane_sim.recording.run import AnimationFrames, RecordedRun, UnreadableRecording, crane_of
from crane_sim.recording.states import Changes

SCALARS = "Scalars:scalars"
_ROW_ID = "rerun.controls.RowId"  # in the order in which rows were logged, also within one instant
_SUMMARY, _RUN, _EVENTS = "__properties/summary", "__properties/run", "log/events"
_RUN_PREFIXES = ("plots/", "frames/", "states/", "log/")  # of the names of a run's entities
Batches = dict[str, list[pa.RecordBatch]]  # rows by entity


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
    curves = _curves(_batches(path, (entity,)), entity)
    if curves is None:
        raise KeyError(f"{path} has no curves {entity!r}")
    return curves


def _explain(reason: str) -> str:
    """Return what a reason of Rerun's means, before it."""
    if "exceeds file size" in reason:
        return "it is cut off: "
    # cut between two messages, or within the head of one
    return "it is cut off, or holds no recording: " if "No recording store" in reason else ""


def read_run(path: Path) -> RecordedRun:
    """Return the run in a recording.

    Raises:
        UnreadableRecording: the file is no recording of a run, or is damaged.
    """
    try:
        batches = _batches(path)
    except (OSError, ValueError, RuntimeError) as error:
        reason = str(error).partition("\n")[0].removeprefix(f"Failed to read RRD file at {path}: ")
        raise UnreadableRecording(f"{path}: cannot be read: {_explain(reason)}{reason}") from None
    run, document = _properties(batches, _RUN), _properties(batches, _SUMMARY).get("json")
    if "compared" in run:
        raise UnreadableRecording(f"{path}: holds a comparison of runs, no run; read the recordings of the runs")
    if "crane" not in run:
        raise UnreadableRecording(f"{path}: holds no run, or one of an older version of crane_sim, before this one")
    summary = json.loads(document) if document else {}
    crane = crane_of(run)
    values = _arrays(batches, path, bool(crane.actuated), summary)
    if len(values["t"]) != summary.get("recorded_steps", len(values["t"])):
        raise UnreadableRecording(f"{path}: is damaged: {len(values['t'])} of {summary['recorded_steps']} steps left")
    return RecordedRun(
        path=path,
        crane=crane,
        properties={key: value for key, value in run.items() if key not in ("crane", "urdf")},
        frames=_frames(batches),
        states=_state_changes(batches),
        events=_events(batches) or [(event["t"], event["what"]) for event in summary.get("events", ())],
        summary=summary,
        **values,
    )


_OPTIONAL = {name: name for name in ("base", "contact", "q_measured", "v_measured")} | {"reeved": "reeved_tension"}
_OF_EVERY_RUN = {name: name for name in ("q", "v", "tip", "payload", "swing")} | {"tensions": "tension"}
_OF_DRIVES = {"u": "effort", "commands": "effort_demanded"}


class _Plots(NamedTuple):
    """The curves of a run that have a row for each step."""

    batches: Batches
    path: Path
    step: NDArray[np.int64]  # (K,)

    def find(self, entity: str) -> Any:
        """Return the values (K, curves) of an entity, None where the recording has none."""
        curves = _curves(self.batches, f"plots/{entity}")
        if curves is None:
            return None
        if not np.array_equal(curves.step, self.step):
            counts = f"{len(curves.step)} of {len(self.step)} steps"
            raise UnreadableRecording(f"{self.path}: is damaged: plots/{entity} has {counts}")
        return curves.values

    def find_reference(self) -> Any:
        """Return the references (K, nu), NaN in steps before the first one of a scene without one; None without any."""
        curves = _curves(self.batches, "plots/q_ref")
        return None if curves is None else _spread(curves, self.step)

    def get(self, entity: str) -> Any:
        """Return the values (K, curves) of an entity that every run has."""
        values = self.find(entity)
        if values is None:
            raise UnreadableRecording(f"{self.path}: has no plots/{entity}: its recorder was killed in the first steps")
        return values


def _arrays(batches: Batches, path: Path, driven: bool, summary: dict[str, Any]) -> dict[str, Any]:
    """Return the attributes of a run that are arrays, by name; None for what it does not have."""
    states = _curves(batches, "plots/q")
    if states is None:
        reason = summary.get("error") or "its recorder was killed before the first ones"
        raise UnreadableRecording(f"{path}: has no steps: {reason}")
    plots = _Plots(batches, path, states.step)
    arrays = {name: plots.find(entity) for name, entity in _OPTIONAL.items()} | {"reference": plots.find_reference()}
    arrays |= {name: plots.get(entity) for name, entity in _OF_EVERY_RUN.items()}
    for name, entity in _OF_DRIVES.items():
        arrays[name] = plots.get(entity) if driven else np.empty((len(states.step), 0))
    arrays["swing"] = arrays["swing"][:, 0]
    arrays["contact"] = None if arrays["contact"] is None else arrays["contact"][:, 0]
    kinetic, potential = plots.get("energy_parts").T
    value = plots.find("lyapunov")
    lyapunov = None if value is None else np.hstack((value, plots.get("lyapunov_rate")))
    return arrays | {"t": states.time, "kinetic": kinetic, "potential": potential, "lyapunov": lyapunov}


def _frames(batches: Batches) -> AnimationFrames:
    nodes, target, falls = (_curves(batches, f"frames/{name}") for name in ("nodes", "target", "falls"))
    if nodes is None:
        return AnimationFrames(np.empty(0), np.empty((0, 0, 3)), None, None)
    count = len(nodes.time)
    ends = None if falls is None else falls.values.reshape(count, -1, 2, 3)
    targets = None if target is None else _spread(target, nodes.step)
    return AnimationFrames(nodes.time, nodes.values.reshape(count, -1, 3), targets, ends)


def _events(batches: Batches) -> list[tuple[float, str]]:
    rows = [
        (float(time) / 1e9, row, text[0])
        for batch in batches[_EVENTS]
        if "TextLog:text" in batch.schema.names
        for time, row, text in _columns(batch, _ROW_ID, "TextLog:text")
    ]
    return [(t, text) for t, _, text in sorted(rows)]


def _state_changes(batches: Batches) -> dict[str, Changes]:
    """Return the timelines of states, by name."""
    timelines: dict[str, Changes] = {}
    for entity in sorted(name for name in batches if name.startswith("states/")):
        rows = [
            (step, float(time) / 1e9, row, state[0])
            for batch in batches[entity]
            if "StateChange:state" in batch.schema.names
            for time, step, row, state in _columns(batch, "step", _ROW_ID, "StateChange:state")
        ]
        timelines[entity.removeprefix("states/").replace("_", " ")] = [(t, state) for _, t, _, state in sorted(rows)]
    return timelines


def _columns(batch: pa.RecordBatch, *names: str) -> Iterator[tuple[Any, ...]]:
    """Return an iterator over the rows of a batch: scene time [ns], then the named columns."""
    return zip(_nanoseconds(batch), *(batch[name].to_pylist() for name in names), strict=True)


def _properties(batches: Batches, entity: str) -> dict[str, Any]:
    """Return the properties of a recording, in which every value is a list of one."""
    values: dict[str, Any] = {}
    for batch in batches[entity]:
        values |= {name: value[0] for name, value in batch.to_pylist()[-1].items() if isinstance(value, list)}
    return values


def _batches(path: Path, prefixes: tuple[str, ...] = _RUN_PREFIXES) -> Batches:
    """Return the rows of entities whose names begin with one of the prefixes, by entity, and the file's properties."""
    batches: Batches = defaultdict(list)
    for chunk in _open_recording(path).stream():
        entity = chunk.entity_path.removeprefix("/")
        wanted = entity in (_RUN, _SUMMARY) or entity.startswith(prefixes)
        if wanted and (not chunk.is_static or entity in (_RUN, _SUMMARY)):
            batches[entity].append(chunk.to_record_batch())
    return batches


def _curves(batches: Batches, entity: str) -> Curves | None:
    """Return the curves of an entity, each step once; None where it has none."""
    found = [batch for batch in batches.get(entity, ()) if SCALARS in batch.schema.names]
    if not found:
        return None
    step = np.concatenate([batch["step"].to_numpy() for batch in found])
    time = np.concatenate([_nanoseconds(batch) for batch in found])
    values = np.concatenate([_rows(batch[SCALARS], batch.num_rows) for batch in found])
    _, order = np.unique(step, return_index=True)  # where two recorders wrote one step, they wrote the same
    return Curves(step[order], 1e-9 * time[order].astype(np.float64), values[order])


def _spread(curves: Curves, steps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the values (K, curves) of curves at all steps (K,), NaN where they have none."""
    values = np.full((len(steps), curves.values.shape[1]), np.nan)
    _, rows, own = np.intersect1d(steps, curves.step, return_indices=True)
    values[rows] = curves.values[own]
    return values


def read_summary(path: Path) -> dict[str, Any]:
    """Return the summary of a complete recording.

    Raises:
        KeyError: it has none: its recorder was killed.
    """
    for chunk in _open_recording(path).stream():
        if chunk.entity_path == "/__properties/summary":
            return json.loads(chunk.to_record_batch()["json"][0].as_py()[0])
    raise KeyError(f"{path} has no summary")


def _open_recording(path: Path) -> RrdReader:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "RRD file has no footer")  # that of a long run, or of a killed recorder
        return RrdReader(path)


def _nanoseconds(batch: pa.RecordBatch) -> NDArray[np.int64]:
    return batch["sim_time"].cast(pa.int64()).to_numpy()


def _rows(column: pa.Array, rows: int) -> NDArray[np.float64]:
    return column.flatten().to_numpy(zero_copy_only=False).reshape(rows, -1)
