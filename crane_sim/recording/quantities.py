"""The quantities of a run drawn in the viewer, pages, figures, comparisons; angles in degrees.

Titles and units stand here alone. The curves of a run that was read back are those of `curve_sets`:
pages and figures draw all of them, comparisons the first of each set. The viewer's are written
while a run goes on (`rerun/curves`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.layout import label
from crane_sim.recording.metric_units import shown_unit
from crane_sim.recording.suspension import COORDINATES

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from crane_sim.recording.layout import Array
    from crane_sim.recording.run import RecordedRun

POSITIONS = {"rad": "Joint angles", "m": "Joint lengths and positions"}
RATES = {"rad/s": "Joint angular speeds", "m/s": "Joint speeds", "1/s": "Joint speeds"}
EFFORTS = {
    "N m": "Joint torques",
    "N": "Drive forces",
    "m/s²": "Driven accelerations",
    "m/s": "Driven speeds",
    "rad/s": "Driven speeds",
    "m": "Driven positions",
    "rad": "Driven angles",
}
COMMANDS = {unit: title.replace("Driven", "Commanded") for unit, title in EFFORTS.items()} | {
    "N m": "Commanded torques",
    "N": "Commanded forces",
}
ERROR = "Tracking error"
SWING, PAYLOAD, TENSION, REEVED, CONTACT, ENERGY, LYAPUNOV = (
    *(
        "Swing",
        "Payload position",
        "Rope tension",
        "Tension of lead line and falls",
        "Contact force",
    ),
    *("Energy", "Lyapunov function of the law"),
)
"""Titles of quantities, those that each joint has by SI unit."""
TRUE, WANTED, MEASURED = "true", "wanted", "measured"
"""What a curve is: of the run itself, its target or command, or what a sensor measures of it."""
PALETTE = ("#1f6fb4", "#d9730d", "#2a9d5c", "#9450b3", "#008b94", "#c8332b", "#8a6d3b", "#c2418c")
"""Colours of joints, in the hues and the order of those in the Rerun viewer, dark enough for white
paper."""
TEXT_COLOR = "#2f3a45"
MAX_SWINGS = 4  # swing coordinates of a cable that are drawn
MIN_SPAN = 1e-12  # in any unit: a smaller span is rounding


class Quantity(NamedTuple):
    """Title and unit of a plot with one curve for each run."""

    title: str
    unit: str


class Curve(NamedTuple):
    """A curve over the steps of a run."""

    name: str
    values: Array  # (K,)
    hue: int | None = None  # number of its colour; None: a neutral one
    kind: str = TRUE

    @property
    def color(self) -> str:
        """Its colour on white paper, #rrggbb: measured ones are mixed with as much white."""
        color = TEXT_COLOR if self.hue is None else PALETTE[self.hue % len(PALETTE)]
        if not self.dotted:
            return color
        return "#" + "".join(f"{(int(color[k : k + 2], 16) + 255) // 2:02x}" for k in (1, 3, 5))

    @property
    def dashed(self) -> bool:
        """Whether it is a target or a command, or its colour is another one's already."""
        return self.kind == WANTED or (self.kind == TRUE and (self.hue or 0) >= len(PALETTE))

    @property
    def dotted(self) -> bool:
        """Whether it is what a sensor measures."""
        return self.kind == MEASURED


class CurveSet(NamedTuple):
    """A quantity's curve, with its target, command or measured one, which share an axis."""

    title: str  # of the axis
    unit: str
    curves: tuple[Curve, ...]
    alone: str = ""  # title of the first curve by itself, empty where runs are not compared by it


def drawn_unit(unit: str) -> tuple[str, float]:
    """Return the unit that is written at an axis for an SI unit, and the factor to it."""
    shown, factor = shown_unit(unit)
    return shown.replace("deg", "°"), factor


def shown_joints(run: RecordedRun) -> list[str]:
    """Return the names of the drawn joints: of a cable's many coordinates only a few swings."""
    names = run.crane.joint_names
    swings = [name for name in names if name.startswith("swing_")]
    return [
        name for name in names if not name.startswith(COORDINATES) and name not in "qwqxqyqz"
    ] + swings[:MAX_SWINGS]


def curve_sets(run: RecordedRun) -> list[CurveSet]:
    """Return all curves of a run in sets, in the order in which they are shown."""
    parts = (_positions, _swing, _payload, _rates, _efforts, _tensions, _energies)
    return [each for part in parts for each in part(run)]


def common_quantities(runs: Sequence[RecordedRun]) -> dict[Quantity, tuple[Array, ...]]:
    """Return the quantities that all runs have, in the first run's order, with values (K,)."""
    by_run = [
        {Quantity(s.alone, s.unit): s.curves[0].values for s in curve_sets(run) if s.alone}
        for run in runs
    ]
    shared = [key for key in by_run[0] if all(key in each for each in by_run)]
    return {key: tuple(each[key] for each in by_run) for key in shared}


def moving_quantities(runs: Sequence[RecordedRun]) -> dict[Quantity, tuple[Array, ...]]:
    """Return the common quantities without those that are constant and equal in all runs."""
    return {
        key: each for key, each in common_quantities(runs).items() if _moves(np.concatenate(each))
    }


def _moves(values: Array) -> bool:
    finite = values[np.isfinite(values)]
    return bool(finite.size and np.ptp(finite) > MIN_SPAN)


def _joints(run: RecordedRun) -> Iterator[tuple[str, int, int]]:
    """Yield (name, number among the coordinates, hue) of the joints that are drawn."""
    for hue, name in enumerate(shown_joints(run)):
        yield name, run.crane.joint_names.index(name), hue


def _positions(run: RecordedRun) -> Iterator[CurveSet]:
    """Yield the positions of joints that are no swings, with targets."""
    for name, i, hue in _joints(run):
        si = run.crane.joint_units[i]
        if name.startswith("swing_") or si not in POSITIONS:
            continue
        unit, factor = drawn_unit(si)
        curves = [Curve(label(name), factor * run.q[:, i], hue)]
        if run.reference is not None and name in run.crane.actuated:
            target = factor * run.reference[:, run.crane.actuated.index(name)]
            curves.append(Curve(f"{label(name)} target", target, hue, WANTED))
        curves += _measured(label(name), hue, factor, run.q, run.q_measured, i)
        yield CurveSet(POSITIONS[si], unit, tuple(curves), label(name))


def _rates(run: RecordedRun) -> Iterator[CurveSet]:
    for name, i, hue in _joints(run):
        si = f"{run.crane.joint_units[i]}/s"
        unit, factor = drawn_unit(si)
        curve = Curve(label(name), factor * run.v[:, i], hue)
        yield CurveSet(
            RATES[si], unit, (curve, *_measured(label(name), hue, factor, run.v, run.v_measured, i))
        )


def _measured(
    name: str, hue: int, factor: float, true: Array, measured: Array | None, i: int
) -> Iterator[Curve]:
    """Yield the measured curve of coordinate i, or its velocity, if it differs from `true`."""
    if measured is not None and not np.array_equal(true[:, i], measured[:, i]):
        yield Curve(f"{name} measured", factor * measured[:, i], hue, MEASURED)


def _efforts(run: RecordedRun) -> Iterator[CurveSet]:
    """Yield the efforts of the actuated joints, with commands in their units where they differ."""
    hues, crane = {name: hue for name, _, hue in _joints(run)}, run.crane
    for k, (name, si) in enumerate(zip(crane.actuated, crane.effort_units, strict=True)):
        unit, factor = drawn_unit(si)
        curves = [Curve(label(name), factor * run.u[:, k], hues.get(name))]
        if si == crane.command_units[k] and _differs(run.commands[:, k], run.u[:, k]):
            command = factor * run.commands[:, k]
            curves.append(Curve(f"{label(name)} command", command, hues.get(name), WANTED))
        yield CurveSet(EFFORTS[si], unit, tuple(curves), f"effort of {label(name)}")


def _differs(command: Array, effort: Array) -> bool:
    known = np.isfinite(command)
    return bool(np.any(np.abs(command - effort)[known] > 1e-6 * np.abs(effort).max(initial=1e-12)))


def _swing(run: RecordedRun) -> Iterator[CurveSet]:
    """Yield the swing from the vertical, and its coordinates where the joints have them."""
    vertical = Curve("from the vertical", np.degrees(run.swing))
    yield CurveSet(SWING, "°", (vertical,), "swing from the vertical")
    for name, i, hue in _joints(run):
        if name.startswith("swing_"):
            short, factor = _short_swing(name), drawn_unit("rad")[1]
            curve = Curve(short, np.degrees(run.q[:, i]), hue)
            measured = _measured(short, hue, factor, run.q, run.q_measured, i)
            yield CurveSet(SWING, "°", (curve, *measured), label(name))


def _short_swing(name: str) -> str:
    """Return the name of a swing angle beside others: `tangential`, or of a chain `link 2`."""
    short = label(name).removeprefix("swing ")
    return f"link {short}" if short.isdecimal() else short


def _payload(run: RecordedRun) -> Iterator[CurveSet]:
    for i, axis in enumerate("xyz"):
        yield CurveSet(PAYLOAD, "m", (Curve(axis, run.payload[:, i], i),), f"payload {axis}")


def _tensions(run: RecordedRun) -> Iterator[CurveSet]:
    """Yield the tensions of links, of falls if the frames have them, and of a rope over sheaves."""
    falls, several = run.frames.falls is not None, run.tensions.shape[1] > 1
    for k, values in enumerate(run.tensions.T if several or falls else [run.tension]):
        name = f"{'fall' if falls else 'link'} {k + 1}" if several or falls else "uppermost link"
        yield CurveSet(
            TENSION,
            "N",
            (Curve(name, values, k if several else None),),
            "" if k else "rope tension",
        )
    if run.reeved is not None:
        yield CurveSet(REEVED, "N", (Curve("lead line", run.lead_line),))
        for k, values in enumerate(run.falls.T):
            yield CurveSet(REEVED, "N", (Curve(f"fall {k + 1}", values, k),))
    if run.contact is not None:
        yield CurveSet(CONTACT, "N", (Curve("on the load", run.contact, 2),))


def _energies(run: RecordedRun) -> Iterator[CurveSet]:
    potential, energy = (each - each[0] for each in (run.potential, run.energy))
    yield CurveSet(ENERGY, "J", (Curve("total since the start", energy),), "energy since the start")
    yield CurveSet(ENERGY, "J", (Curve("kinetic", run.kinetic, 0),))
    yield CurveSet(ENERGY, "J", (Curve("potential since the start", potential, 2),))
    if run.lyapunov is not None:
        yield CurveSet(LYAPUNOV, "J", (Curve("V", run.lyapunov[:, 0], 3),))
