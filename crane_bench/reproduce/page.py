"""Pages of documentation that are written from the tables of `crane reproduce`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crane_bench.reproduce.figure import FIGURES
from crane_bench.reproduce.overhead_erratum import ROUNDING
from crane_bench.reproduce.table import Tables, format_value
from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_text
from crane_sim.report.plotting import save_figure

LEGENDS = {
    "overhead": "Differences are relative; an erratum is a printed form that differs from first principles where the "
    "corrected one agrees.",
    "hardcases": "Error: the largest distance of any node from its reference at any instant, in metres, unless the "
    "measure says otherwise. Events: the largest error of event times, in seconds. Time: wall time of the run in "
    "seconds, without compilation.",
    "knuckle": "The paper prints masses, lengths, gains and weights, and describes its figures in words. It prints no "
    "manoeuvre, no moments of inertia and no swing friction: taken here are the scenes `knuckle_setpoint` and "
    "`knuckle_lqr`, with uniform rods, no friction, and efforts every 10 ms; the rows called otherwise take other "
    "manoeuvres, or friction of 0.1 N m s. Difference: the energy law less LQR.\n\n"
    "**Not reproduced**: that the load swings much less with the energy law. Wherever the crane slews it swings "
    "further tangentially and for longer, because this law does not feed the swing back and the tip hardly damps it. "
    "Where boom and jib, or the rope, move alone, the largest swing is much less; and the length of the rope does "
    "oscillate less.",
    "offshore": "MSE: the mean of the squared distance between payload and path; MAE: that of the distance; both over "
    "60 s, once every period of the law. Ours is the median over seeds of features and camera noise, between the "
    "lowest and the highest; differences are relative to the paper. One servo of the suspension point serves all "
    "tables: the paper prints none.\n\n"
    "**Not reproduced**: the experiment of table 9, for which a stand-in is measured, and table 7 with the printed "
    "sway of 0.5 m, which at the load's own frequency throws it far off; 0.5 m/s2 gives that table. The rows called "
    "otherwise show what the numbers rest on. Feeding the path's acceleration forward to the angular law closes the "
    "gap of table 5, one constant feature learns as much as a hundred, and damping of 0.7 without learning follows "
    "more closely than learning with 0.2.",
    "observer": "Payload on the arc of table 7, base swaying by 0.5 m/s2; each row ten seeds that no law was tuned to. "
    "Errors are mean squared distances in m2 over 60 s, the start from rest included, medians of ten. times_less: the "
    "adaptive law's error over the harmonic law's, in the median, and the least of the ten runs; tip: the largest "
    "ratio of the peak accelerations of the suspension point, harmonic over adaptive. Part of the gain is that the "
    "harmonic law, which knows the velocity, can afford stiffer gains (stiffness 1.25, with a camera 2, damping 0.65) "
    "than the papers' (1, 0.2); with a camera it pays for that with a harder working tip.",
}
STAR = "\\* differs from run to run and from machine to machine, and is given to one digit; all else comes out again."
BY_ROUNDING = ("ours", "difference")  # columns of `Row`, where digits below ROUNDING are those of the processor
TITLES = {
    "overhead": "The overhead-crane paper: properties, numbers and misprints",
    "hardcases": "The hard cases of the overhead crane",
    "knuckle": "The knuckle paper's section 4: energy law against LQR",
    "offshore": "The offshore paper's tables 5, 7 and 9",
    "observer": "The harmonic observer on seas that it was not tuned to",
}


def save_pages(tables: Tables, folder: str) -> None:
    """Write one Markdown page for each item into the folder, with a figure where the item has one.

    Raises:
        SceneError: the folder cannot be written.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        for item, rows in tables.items():
            draw, picture = FIGURES.get(item), Path(folder) / f"{item}.png"
            drawn = draw is not None and save_figure(draw, rows, picture, dpi=120)
            write_text(Path(folder) / f"{item}.md", _write_item(item, list(rows), drawn))
    except OSError as error:
        raise SceneError(f"--save {folder!r}: {error.strerror}") from None


def _format_cell(column: str, value: Any, varies: Sequence[str]) -> str:
    """Return a value as text: one digit where it varies, and none of what only rounding makes."""
    if isinstance(value, float) and column in varies:
        return f"{value:.1g}"
    if isinstance(value, float) and column in BY_ROUNDING and 0.0 < abs(value) < ROUNDING:
        return f"< {ROUNDING:.0e}"
    return format_value(value).replace("|", "/")


def _write_item(item: str, rows: list[Any], drawn: bool) -> str:
    columns = rows[0]._fields
    lines = [f"# {TITLES.get(item, item)}", "", f"Written by `crane reproduce {item} --save docs`.", ""]
    lines += [LEGENDS.get(item, ""), ""]
    if drawn:
        lines += [f"![{item}]({item}.png)", ""]
    varies = getattr(rows[0], "VARIES", ())
    heads = [f"{name} \\*" if name in varies else name for name in columns]
    lines += [STAR, ""] if varies else []
    lines += [f"| {' | '.join(heads)} |", "|" + "---|" * len(columns)]
    lines += [f"| {' | '.join(map(_format_cell, columns, row, [varies] * len(columns)))} |" for row in rows]
    return "\n".join(lines) + "\n"
