"""The league as lines of tables, for a terminal and for a page of documentation."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from crane_bench.league.cells import Cell, CellMetrics
from crane_bench.league.scenes import BEST, read_tuned_gains
from crane_bench.reproduce.table import Shown, format_value

NONE = "-"
NO_EFFORT = 1e-9  # m/s², m, N or N m: smaller ones are rounding, whose digits are the processor's
HEAD = """# The league: every law on every scene that suits it

Written by `crane league --save docs`, with [league.json](league.json). [The same trials over
samples](league_samples.md) have intervals, and show which differences between laws are significant.
"""
FIGURE = """
![heat map of errors, swing and accelerations](league.png)

Numbers in the picture are as in the tables; colours compare the laws of one crane in one column: white is the least of
them, the darkest thirty times as much or more. Grey: does not apply. Red: not controlled, the reason is below.
"""
HOW = """
Laws are designed for the catalogue's scene on a base at rest, without wind, and not for what a trial adds to it.
Each has the gains that the catalogue gives it, or its defaults where the catalogue gives none; none was tuned for this
table. Those named **tuned** have the gains of a search by `crane tune`, over the distances, masses and ropes that its
study in `config/tuning` names, none of them a trial of this table: the best compromise of settling or tracking error,
residual swing and peak effort ([below](#tuned-gains)). Seas and the camera's noise are medians over ten
seeds that nothing in the catalogue uses.

- **Errors** are distances of the payload, in the axes of the base, from its desired position at that time: on the
  path, or for cranes with a target, at the target from the start on. A shaped path arrives later by half a swing (ZV)
  or a whole one (ZVD), which counts as error.
- **Settling**: from the end of the path, or from the start where there is none, until the payload stays within 2 % of
  the way; 0: it is there from the path's end on. **Residual swing**: the largest in the last quarter, of the rope from
  the vertical of the world.
- **Effort** is the largest of each actuated joint: a force or torque, also of drives that follow speeds; of winches
  with `drive: rate` their command. **Tip acceleration** is relative to the base. **Saturated**: part of the periods
  in which a demand was limited.
- **30 Hz vision** is the catalogue's `offshore_vision`: its base sways at the payload's own frequency as well, a
  little more than in the column of the resonant base.
- **Angular** damps the swing angles, and tracks the path with the suspension point. **Cartesian** tracks it with the
  payload, **adaptive** learns the disturbance of the payload as well, and **harmonic** estimates one of unknown
  frequency. **Energy** shapes the crane's energy, **lqr** is a linear-quadratic regulator, and **energy, weighing**
  is the energy law with estimation of the payload's mass from the tension of the rope.
- **Open loop** is the law angular without damping: its gains kp and kd act on the suspension point, which follows the
  path with its acceleration, without feedback of the payload. **ZV** and **ZVD** are paths shaped against the swing.
  The mass of a payload below an ideally driven point changes nothing.
- The knuckle boom appears three times: as a small crane that carries the suspension point of the tracking laws, as
  the knuckle paper's that is brought to a target, and as a ship's. The laws of that paper follow no path, and the
  tracking laws have no target.
- The cranes of ports and sites have masses, lengths and drives of real machines. There **lqr** commands forces; its
  nominal model has a point mass at the hook in place of hook, sling and body, but a load on falls as it is. The others
  command drives that follow speeds, as frequency converters do: **speeds** moves them along a path to the target
  without feedback of the load, **speeds, ZV** along one that is shaped against its swing, and **anti-swing** goes to
  the target with feedback of the rope's angle, which a load on falls does not have. The energy laws are for knuckle
  boom and overhead crane with one rope, the tracking laws for a point mass below knuckle boom or driven point; other
  cranes are refused. With another mass the inertia changes in proportion. Another rope is another sling. The tower
  crane's gust is the scene's own turbulent wind, which acts all the time and rotates the load; a median over ten seeds
  as well.
"""
TUNED_HEAD = """## Tuned gains

`./crane tune config/tuning/NAME.yaml --save config/tuned_gains.json` found them; the means below are over samples that
the search has not seen, the differences those of pairs with their 95 % intervals. In the searches of the knuckle boom
and of trolley and hoist the laws know the payload's mass; above, the trials of another mass show what becomes of
these gains when they do not.
"""


class CellLine(NamedTuple):
    """A cell, as a line of a table."""

    law: str
    trial: str
    runs: Shown
    MSE_m2: Shown
    MAE_m: Shown
    peak_error_m: Shown
    residual_error_m: Shown
    peak_swing_deg: Shown
    residual_swing_deg: Shown
    settling_s: Shown
    tip_acceleration_m_s2: Shown
    effort: str
    saturated: Shown


def tables_by_crane(cells: Iterable[Cell]) -> dict[str, list[CellLine]]:
    """Return the lines of each crane; cells of laws that do not apply have none."""
    by_crane: dict[str, list[CellLine]] = {}
    for cell in cells:
        if not cell.refused:
            by_crane.setdefault(cell.crane, []).append(_line(cell))
    return by_crane


def _line(cell: Cell) -> CellLine:
    name = cell.law, f"{cell.trial}: not controlled" if cell.failed else cell.trial, cell.runs
    metrics = cell.metrics
    if metrics is None:
        return CellLine._make((*name, *[NONE] * (len(CellLine._fields) - len(name))))
    settling = NONE if metrics.settling is None else metrics.settling
    numbers = metrics._asdict() | {"settling": settling, "effort": _efforts(metrics)}
    del numbers["effort_units"]
    return CellLine._make((*name, *numbers.values()))


def _efforts(metrics: CellMetrics) -> str:
    """Return the largest effort of each joint, with its unit."""
    peaks = {joint: peak if peak > NO_EFFORT else 0.0 for joint, peak in metrics.effort.items()}
    return ", ".join(f"{joint} {_with_unit(peak, metrics.effort_units[joint])}" for joint, peak in peaks.items())


def _with_unit(value: float, unit: str) -> str:
    """Return a value with its unit; of forces and torques in kN and MN where they are large."""
    if unit.startswith("N"):
        for size, prefix in ((1e6, "M"), (1e3, "k")):
            if value >= size:
                return f"{format_value(value / size)} {prefix}{unit}"
    return f"{format_value(value)} {unit}"


def format_comparison(cells: Sequence[Cell], drawn: bool) -> str:
    """Return the page in Markdown; `drawn`: its figure is of these cells."""
    sections = [HEAD + FIGURE * drawn + HOW]
    for crane, own in tables_by_crane(cells).items():
        sections.append(f"## {crane.capitalize()}\n\n" + markdown_of(own))
    for title, reasons in (("Not controlled", "failed"), ("Does not apply", "refused")):
        rows = [f"- {c.crane}, {c.law}, {c.trial}: {getattr(c, reasons)}" for c in cells if getattr(c, reasons)]
        sections.append(f"## {title}\n\n" + ("\n".join(rows) or "Nothing.") + "\n")
    sections.append(_tuned_section(read_tuned_gains()))
    return "\n".join(sections)


def markdown_of(rows: Sequence[Any]) -> str:
    """Return lines, NamedTuples of one kind, as a table in Markdown; units end the names of their fields."""
    head = [name.replace("_m_s2", ", m/s²").replace("_m2", ", m²").replace("_deg", ", deg") for name in rows[0]._fields]
    head = [name[:-2] + f", {name[-1]}" if name.endswith(("_m", "_s")) else name for name in head]
    text = [f"| {' | '.join(name.replace('_', ' ') for name in head)} |", "|" + "---|" * len(head)]
    return "\n".join(text + [f"| {' | '.join(map(format_value, row))} |" for row in rows]) + "\n"


def _tuned_section(searches: dict[str, Any]) -> str:
    """Return what the searches found, and how the gains do on samples that no search has seen."""
    lines = [TUNED_HEAD]
    for name, found in searches.items():
        best = found["chosen"][BEST]["gains"]
        gains = ", ".join(f"`{key}` {format_value(value)}" for key, value in best.items())
        lines.append(f"- **{name}**, {found['trials']} trials, {found['samples']} held-out samples: {gains}.")
    lines.append(
        "\n| search | objective | own gains | tuned | difference | from | to | |\n|---|---|---|---|---|---|---|---|"
    )
    for name, found in searches.items():
        for objective, rows in found["held_out"].items():
            own, tuned = rows[found["baseline"]], rows[BEST]
            numbers = own["mean"], tuned["mean"], tuned["difference"], tuned["low"], tuned["high"]
            cells = (NONE if value is None else format_value(value) for value in numbers)
            missing = found["samples"] - own["runs"]
            objective += f", {missing} of {found['samples']} without with own gains" if missing else ""
            lines.append(f"| {name} | {objective} | {' | '.join(cells)} | {tuned['verdict']} |")
    return "\n".join(lines) + "\n"
