"""A recorded run as a Python object: its steps' arrays, scene and metrics, and how it ended."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crane_sim.files.errors import PATH, SceneError, join_lines, shorten
from crane_sim.files.extensions import find_view
from crane_sim.files.installation import MissingPackage, import_optional
from crane_sim.files.yaml_text import YAML_ERRORS, parse_yaml
from crane_sim.recording.completeness import CUT, Completeness
from crane_sim.recording.path_units import path_unit

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Array
    from crane_sim.recording.states import Changes
    from crane_sim.scenes.scene import Scene

NOT_IN_REAL_TIME = "not in real time"
ENDS = {
    "orphaned": "its supervisor was killed",
    "interrupted": "the recorder was interrupted",
    "reset": "the plant was reset",
}
"""Ends of a run before its time, from what the recorder says in its summary."""


class UnreadableRecording(SceneError):
    """A file that is no recording, or a damaged one; the message is one line."""


class Crane(NamedTuple):
    """The facts of a crane that stay fixed during a run, as its recording has them."""

    kind: str  # kind of crane: knuckle, tower, overhead, ...
    joint_names: tuple[str, ...]  # nq, in the order of q
    joint_units: tuple[str, ...]  # "rad", "m" or, of components of unit vectors and quaternions,
    # "1"
    actuated: tuple[str, ...]  # nu of the joints
    effort_units: tuple[str, ...]  # (nu,)
    command_units: tuple[str, ...]  # (nu,) the same but of joints whose drives take a speed or a
    # position
    tip_index: int  # which of the nodes is the upper end of the cable
    framing: dict[str, Any]  # size, ground, ground_size, eye and look_at of
    # `crane_sim.recording.camera`, m
    urdf: str  # URDF document

    @property
    def driven(self) -> list[int]:
        """Return the indices (nu,) of the actuated joints among the coordinates."""
        return [self.joint_names.index(name) for name in self.actuated]


class AnimationFrames(NamedTuple):
    """Positions that only pictures need, at F instants, about 30 per second."""

    t: Array  # (F,) s
    nodes: Array  # (F, N, 3) m, polyline base .. tip .. payload in the world
    target: Array | None  # (F, 3) m, where the payload hangs still at the reference, in the world
    falls: Array | None  # (F, n, 2, 3) m, upper and lower ends of n falls in the frame of the base


@dataclass(frozen=True, repr=False)
class RecordedRun:
    """A run from its recording: K control steps, coordinates in the order of crane.joint_names.

    World frame, SI units, angles in rad. The attributes that a `Rollout` has as well have its
    names. A step's values are those at its start; the instant at which the run ended is no step.
    """

    path: Path | None  # the recording, None for a run that has none
    crane: Crane
    properties: dict[str, Any]  # scene, law, seed, period [s], duration [s], derived, scene_file,
    # provenance, drawn
    t: Array  # (K,) s
    q: Array  # (K, nq) m or rad
    v: Array  # (K, nq) m/s or rad/s
    q_measured: Array | None  # (K, nq) measured by sensors, where q is the true one; None without
    # sensors
    v_measured: Array | None  # (K, nq) likewise
    u: Array  # (K, nu) efforts applied from t on, after limits, in crane.effort_units
    commands: Array  # (K, nu) what the law demanded, in crane.command_units; NaN where it demanded
    # nothing
    reference: Array | None  # (K, nu) m or rad, targets of the actuated joints; None without
    tip: Array  # (K, 3) m
    payload: Array  # (K, 3) m
    base: Array | None  # (K, 6) surge, sway, heave [m], roll, pitch, yaw [rad] of a base that moves
    tensions: Array  # (K, L) N, of the links from the top to the payload, or of the falls; the
    # first 12 at most
    reeved: Array | None  # (K, 1 + n) N, of lead line and n falls of a rope that is reeved over
    # sheaves
    swing: Array  # (K,) rad, angle of the line from tip to payload from the vertical
    kinetic: Array  # (K,) J
    potential: Array  # (K,) J, from height 0 of the world
    lyapunov: Array | None  # (K, 2) V [J] and dV/dt [W] of a law that shapes an energy
    contact: Array | None  # (K,) N, normal force of a surface on a load that may touch one
    frames: AnimationFrames
    states: dict[str, Changes]  # by timeline, such as "brakes": (s, state from then on); none
    # without a change of state
    events: list[tuple[float, str]]  # (s, what happened)
    summary: dict[str, Any]  # the metrics, as docs/summary.md explains them; empty where the
    # recorder was killed
    completeness: Completeness = Completeness()  # of the file, whose steps that are not good are
    # left out

    def __repr__(self) -> str:
        """Return scene, law, length and how the run ended, in two lines."""
        extent = f"{len(self.t)} steps up to {self.t[-1]:g} s" if len(self.t) else "no steps"
        return (
            f"<RecordedRun of {self.name!r}, law {self.law!r}: {extent}, {self.q.shape[1]} "
            f"joints\n {self.status}>"
        )

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self.properties["scene"]

    @property
    def law(self) -> str:
        """Name of the law: "external" where commands came from elsewhere, "none" without any."""
        return self.properties["law"]

    @property
    def seed(self) -> int:
        """Seed of all random numbers."""
        return self.properties["seed"]

    @property
    def period(self) -> float:
        """Control period [s]."""
        return self.properties["period"]

    @property
    def urdf(self) -> str:
        """URDF document of the crane."""
        return self.crane.urdf

    @property
    def energy(self) -> NDArray[np.float64]:
        """Total energy in the world (K,) [J], weights from its height 0."""
        return self.kinetic + self.potential

    @property
    def tension(self) -> NDArray[np.float64]:
        """Tension of the uppermost link, or of the first fall (K,) [N]."""
        return self.tensions[:, 0]

    @property
    def falls(self) -> Array:
        """Tensions (K, n) [N] of a rope's falls over sheaves, from the drum on; (K, 0) without."""
        return np.empty((len(self.t), 0)) if self.reeved is None else self.reeved[:, 1:]

    @property
    def lead_line(self) -> Array:
        """Tension (K,) [N] of the lead line of a rope that is reeved over sheaves; (0,) without."""
        return np.empty(0) if self.reeved is None else self.reeved[:, 0]

    @property
    def nodes(self) -> NDArray[np.float64]:
        """Polyline base .. tip .. payload (F, N, 3) [m] at the instants `frames.t` (F,) [s]."""
        return self.frames.nodes

    @property
    def frame_steps(self) -> NDArray[np.int64]:
        """Rows (F,) of the steps at which the instants `frames.t` are."""
        return np.searchsorted(self.t, self.frames.t - 0.5 * self.period)

    @property
    def scene_text(self) -> str:
        """The scene file as YAML, with all changes of the run."""
        return self.properties["scene_file"]

    @cached_property
    def scene_values(self) -> dict[str, Any]:
        """The values of the scene file."""
        return parse_scene(self.scene_text, self.path)

    def load_scene(self, law: str | None = None) -> Scene:
        """Return the scene, as `crane_sim.load_scene` does; `simulate` of it repeats the run.

        Args:
            law: in place of the run's. A law FILE.py:FUNCTION or MODULE:FUNCTION is only executed
                if it is named here.

        Raises:
            SceneError: the run's law is such code, and no law is named; or the scene is none of
                this version.
        """
        from crane_sim.scenes.scene import load_scene

        scene = load_scene(
            self.scene_values if law is None else self._with_law(law), own_law=law is not None
        )
        if scene.law_name is not None and scene.law is None:
            line = (
                f"its law is the code of {shorten(scene.law_name, PATH)}, which is executed only "
                "where it is named"
            )
            raise SceneError(
                f"{self.path or self.name}: {line}: load_scene(law=...), crane replay --law ..."
            )
        return scene

    def _with_law(self, law: str) -> dict[str, Any]:
        """Return the values of the scene file with another law, with the run's law settings."""
        control = self.scene_values.get("control")
        return self.scene_values | {
            "control": (control if isinstance(control, dict) else {}) | {"law": law}
        }

    @cached_property
    def path_unit(self) -> str:
        """Unit of the path's coordinates: m of the payload's, empty if the joints' units differ."""
        path = (self.scene_values.get("reference") or {}).get("path") or {}
        return path_unit(
            path.get("of") == "joints", [self.crane.joint_units[i] for i in self.crane.driven]
        )

    @cached_property
    def versions(self) -> dict[str, str]:
        """Versions by package, and `python`, `system`, `cpu`, the lock file's `lock_sha256`."""
        return json.loads(self.properties["provenance"])

    @property
    def error(self) -> str:
        """One line on what failed, empty where nothing did."""
        error, extent = str(self.summary.get("error", "")), self.completeness.extent
        told = error and self.completeness.state == CUT  # the recorder has counted what it lacks
        recording = f"the recording {extent}" if extent and not told else ""
        return "; ".join(filter(None, (error, self._early_end, recording)))

    @property
    def _early_end(self) -> str:
        """One phrase on a run that ended early without an error, otherwise empty."""
        reason, planned = (
            self.summary.get("ended_by", ""),
            round(self.properties["duration"] / self.period),
        )
        steps = self.summary.get("steps", len(self.t))
        if not reason or steps >= planned:
            return ""
        return f"{ENDS.get(reason, reason)} after {steps} of {planned} steps"

    @property
    def real_time_violation(self) -> str:
        """One line on a run in real time that the machine was too slow for, empty for any other."""
        violation = self.summary.get("real_time_violation")
        return f"{NOT_IN_REAL_TIME}: {violation}" if violation else ""

    @property
    def finished(self) -> bool:
        """Whether the run came to its end and all of it was recorded."""
        return not self.error

    @property
    def status(self) -> str:
        """How the run ended: "finished", or "failed: " and why."""
        return f"failed: {self.error}" if self.error else "finished"

    def to_dataframe(self) -> Any:
        """Return a `pandas.DataFrame` (needs pandas), one row a step, index t [s].

        `attrs["units"]` has the unit of each column.

        Columns: `q.JOINT`, `v.JOINT`, `u.JOINT`, `command.JOINT`, `reference.JOINT`, `payload.x`,
        `tip.x`, ..., and `tension`, `swing`, `kinetic`, `potential`, `base.AXIS`, `lyapunov`,
        `lyapunov_rate` where the run has them; `tension.1`, `tension.2`, ... of a run with the
        tensions of several links or falls; `lead_line`, `fall.1`, ... of a rope over sheaves.
        """
        try:
            pandas = import_optional("pandas", "a data frame")
        except MissingPackage as error:
            raise MissingPackage(
                f"{error}; run.columns() has the same columns without it"
            ) from None
        columns = self.columns()
        frame = pandas.DataFrame(
            {name: values for name, (values, _) in columns.items()}, index=self.t
        )
        frame.index.name = "t"
        frame.attrs["units"] = {"t": "s"} | {name: unit for name, (_, unit) in columns.items()}
        frame.attrs |= {"scene": self.name, "law": self.law, "seed": self.seed}
        return frame

    def columns(self) -> dict[str, tuple[Array, str]]:
        """Return all quantities of the steps by name: (values (K,), unit)."""
        crane, driven = self.crane, self.crane.driven
        rates = [f"{unit}/s" for unit in crane.joint_units]
        targets = [crane.joint_units[i] for i in driven]
        metres, axes = ["m"] * 3, ["m"] * 3 + ["rad"] * 3
        tables = (
            ("q", crane.joint_names, crane.joint_units, self.q),
            ("v", crane.joint_names, rates, self.v),
            ("q_measured", crane.joint_names, crane.joint_units, self.q_measured),
            ("v_measured", crane.joint_names, rates, self.v_measured),
            ("u", crane.actuated, crane.effort_units, self.u),
            ("command", crane.actuated, crane.command_units, self.commands),
            ("reference", crane.actuated, targets, self.reference),
            ("payload", "xyz", metres, self.payload),
            ("tip", "xyz", metres, self.tip),
            ("base", ("surge", "sway", "heave", "roll", "pitch", "yaw"), axes, self.base),
        )
        columns = {name: column for table in tables for name, column in _split(*table).items()}
        columns |= {"tension": (self.tension, "N"), "swing": (self.swing, "rad")}
        columns |= self._further_forces()
        columns |= {"kinetic": (self.kinetic, "J"), "potential": (self.potential, "J")}
        if self.lyapunov is not None:
            columns["lyapunov"] = (self.lyapunov[:, 0], "J")
            columns["lyapunov_rate"] = (self.lyapunov[:, 1], "W")
        return columns

    def _further_forces(self) -> dict[str, tuple[Array, str]]:
        """Return the columns of forces that only some cranes have."""
        columns = _numbered("tension", self.tensions) if self.tensions.shape[1] > 1 else {}
        if self.reeved is not None:
            columns |= {"lead_line": (self.lead_line, "N"), **_numbered("fall", self.falls)}
        return columns if self.contact is None else columns | {"contact": (self.contact, "N")}

    def plot(self) -> Any:
        """Return a `matplotlib.figure.Figure` (needs matplotlib), SI units, angles in degrees.

        Positions with their targets, speeds, efforts, swing, payload, tension and energy over time.
        """
        return find_view("plot")(self)

    def show(self, height: int = 900) -> Any:
        """Return the page of `crane report`, which plays the run, for a notebook.

        Its frame is `height` pixels high.
        """
        return find_view("show")(self, height)


def parse_scene(text: str, path: Path | None) -> dict[str, Any]:
    """Return the values of a recording's scene file.

    Raises:
        UnreadableRecording: it cannot be read, as of a damaged file.
    """
    try:
        values = parse_yaml(text)
    except YAML_ERRORS as error:
        raise UnreadableRecording(
            f"{path}: its scene cannot be read: {join_lines(error)}"
        ) from None
    if not isinstance(values, dict):
        raise UnreadableRecording(
            f"{path}: its scene holds {type(values).__name__}, not groups of keys"
        )
    return values


def crane_of(properties: Mapping[str, Any]) -> Crane:
    """Return the crane of a recording's properties."""
    facts: dict[str, Any] = json.loads(properties["crane"])
    for key in ("joint_names", "joint_units", "actuated", "effort_units", "command_units"):
        facts[key] = tuple(facts[key])
    return Crane(**facts, urdf=properties["urdf"])


def _numbered(kind: str, tensions: Array) -> dict[str, tuple[Array, str]]:
    """Return the columns [N] of tensions (K, n) by name and number, from 1."""
    return {f"{kind}.{k + 1}": (column, "N") for k, column in enumerate(tensions.T)}


def _split(
    kind: str, names: Sequence[str], units: Sequence[str], table: Any
) -> dict[str, tuple[Array, str]]:
    """Return the columns of a table (K, n), which may be None, by name."""
    if table is None:
        return {}
    return {
        f"{kind}.{name}": (table[:, i], unit)
        for i, (name, unit) in enumerate(zip(names, units, strict=True))
    }
