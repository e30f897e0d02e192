"""The HTML page of a study: failures, metrics by variant, their differences, worst runs."""

import io
import json
import re
from collections.abc import Iterator, Sequence
from os.path import relpath
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np
import numpy.typing as npt

from crane_sim.files.installation import import_optional
from crane_sim.files.output import write_output
from crane_sim.report.assets import read_asset
from crane_sim.study.columns import PARAMETER
from crane_sim.study.identity import read_identity
from crane_sim.study.result import StudyResult, read_result
from crane_sim.study.sensitivity import COLUMN_HEADINGS
from crane_sim.study.summary import first_errors, shown_metrics, summarise

COLORS = ("#2a78b8", "#c43d3d", "#2f9e62", "#8a5fb0", "#d9730d", "#555555")
MAX_SCATTER_POINTS = 2000
SENSITIVITY_COLUMNS = ("strength", "interval", "interaction")
WORST_COUNT = 5  # runs that are listed for each metric
_WIDTH = 5.6  # inches, of a drawing


def save_study_page(folder: Path, file: Path) -> None:
    """Write the page of the study in a folder; drawings need matplotlib.

    Raises:
        SceneError: the folder holds no finished study, or the file cannot be written.
    """
    document = study_page(read_result(folder), file.parent)
    write_output("-o", file, lambda path: path.write_text(document, encoding="utf-8"))


def study_page(result: StudyResult, folder: Path | None = None) -> str:
    """Return the HTML document of a study, which is to be in a folder; None: in the study's own."""
    study, summary, names = result.study, summarise(result), shown_metrics(result)
    scene = study.scene if isinstance(study.scene, str) else study.scene.get("name", "scene")
    drawn = f"{study.design.replace('_', ' ')} of {', '.join(study.parameters)}"
    known = read_identity(result.folder / "study.json")
    return _template().render(
        name=study.name,
        style=read_asset("page.css"),
        about=f"{summary['runs']} runs of {Path(str(scene)).stem}: {drawn}; seed {study.seed}",
        failed=sum(summary["failures"].values()),
        errors=first_errors(result, 10),
        tables=[_metrics(summary), *_differences(summary), *_sensitivities(summary, study.design)],
        figures={
            "Distributions": _distributions(result, names),
            "Metrics against parameters": _scatters(result, names),
        },
        worst=list(_worst(result, names, folder or result.folder)),
        study=json.dumps({name: known.get(name) for name in ("study", "versions")}, indent=1),
    )


def _template() -> Any:
    """Return the template of the page."""
    jinja2 = import_optional("jinja2", "the page of a study")
    settings = {
        "autoescape": True,
        "trim_blocks": True,
        "lstrip_blocks": True,
        "undefined": jinja2.StrictUndefined,
    }
    return jinja2.Environment(**settings).from_string(read_asset("study.html"))


class Table(NamedTuple):
    """A section with a table; without rows there is none."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


class Case(NamedTuple):
    """A run in a list of the largest metrics."""

    number: int
    file: str  # of its recording, from the page's folder; empty without one
    value: str


def _metrics(summary: dict[str, Any]) -> Table:
    """Return the spreads by variant."""
    keys = ("runs", "least", "median", "greatest")
    rows = [
        (name, variant, *(_format(spread[key]) for key in keys))
        for name, by_variant in summary["metrics"].items()
        for variant, spread in by_variant.items()
        if "median" in spread
    ]
    return Table("Metrics", ("metric", "variant", *keys), rows)


def _differences(summary: dict[str, Any]) -> Iterator[Table]:
    """Yield the tables of the differences between variants, of the summary of a study."""
    first, *others = summary["failures"]  # variants
    if others:
        yield _metric_differences(summary, first, others)
        yield _failure_differences(summary, first)


def _metric_differences(summary: dict[str, Any], first: str, others: Sequence[str]) -> Table:
    """Return the differences of the metrics of other variants from those of the first one."""
    rows = []
    for name, by_variant in summary["metrics"].items():
        for other in others:
            each = by_variant[f"{other} - {first}"]
            interval = f"{_format(each['low'])} … {_format(each['high'])}"
            share = "" if np.isnan(each["share"]) else f"{each['share']:.0%}"
            tests = (share, _format(each["effect_size"]), _format(each["p_value"]))
            rows.append((name, other, str(each["pairs"]), _format(each["mean"]), interval, *tests))
    head = (
        "metric",
        "variant",
        "pairs",
        "mean",
        "95 % interval",
        "smaller in",
        "effect size",
        "p (Wilcoxon)",
    )
    return Table(f"Differences from {first}, on the same samples", head, rows)


def _failure_differences(summary: dict[str, Any], first: str) -> Table:
    """Return on how many samples only one of two variants fails, or both."""
    fails = [
        (
            other,
            *(str(each[key]) for key in ("first_only", "second_only", "both")),
            _format(each["p_value"]),
        )
        for other, each in summary["failure_differences"].items()
        if each["first_only"] + each["second_only"] + each["both"]
    ]
    head = ("variant", f"only {first} fails", "only the variant fails", "both", "p (McNemar)")
    return Table("Which of them fail", head, fails)


def _sensitivities(summary: dict[str, Any], design: str) -> Iterator[Table]:
    """Yield the table of how metrics depend on the parameters, of designs of sensitivity."""
    if not summary["sensitivities"]:
        return
    rows = [
        (name, variant, row["parameter"], *(_format(row[key]) for key in SENSITIVITY_COLUMNS))
        for name, by_variant in summary["sensitivities"].items()
        for variant, own in by_variant.items()
        for row in own
    ]
    head = ("metric", "variant", "parameter", *COLUMN_HEADINGS[design])
    yield Table(f"Sensitivity to the parameters ({design.capitalize()})", head, rows)


def _figure(draw: Any, height: float) -> str:
    """Return a drawing as SVG, empty without matplotlib."""
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError:
        return ""
    figure, text = Figure(figsize=(_WIDTH, height), layout="constrained"), io.StringIO()
    draw(figure.subplots())
    with rc_context({"svg.hashsalt": "crane_sim"}):  # the same results are the same page
        figure.savefig(text, format="svg", dpi=110, transparent=True, metadata={"Date": None})
    svg = re.sub(
        r'(?s)^.*?(<svg )[^>]*?(viewBox="[^"]*")[^>]*>',
        r'\1\2 xmlns:xlink="http://www.w3.org/1999/xlink">',
        text.getvalue(),
    )
    prefix = f"d{crc32(svg.encode())}"  # identifiers of several drawings in one page
    return re.sub(r'(id="|href="#|url\(#)', rf"\g<1>{prefix}", svg)


def _distributions(result: StudyResult, names: Sequence[str]) -> list[str]:
    """Return the metrics' cumulative distributions: without the metric, a run is below no value."""
    drawings = []
    for name in names:
        spread = {variant: result.metric(name, variant) for variant in result.study.variant_changes}

        def draw(
            axes: Any, spread: dict[str, npt.NDArray[np.float64]] = spread, name: str = name
        ) -> None:
            for color, (variant, values) in zip(COLORS * 9, spread.items(), strict=False):
                ordered = np.sort(values[np.isfinite(values)])
                share = np.arange(1, len(ordered) + 1) / max(len(values), 1)
                axes.step(ordered, share, where="post", color=color, label=variant)
            axes.set(xlabel=name, ylabel="share of all runs", ylim=(0, 1.02))
            axes.legend(frameon=False)

        drawings.append(_figure(draw, 2.6))
    return [drawing for drawing in drawings if drawing]


def _scatters(result: StudyResult, names: Sequence[str]) -> list[str]:
    """Return the metrics against the parameters that are numbers."""
    variant = result.column("variant")
    drawings = []
    for key in result.study.parameters:
        if result.types[PARAMETER + key] not in ("double", "int64"):
            continue
        values = np.array(result.column(PARAMETER + key), float)

        def draw(axes: Any, name: str, key: str = key, values: Any = values) -> None:
            for color, each in zip(COLORS * 9, result.study.variant_changes, strict=False):
                x, y = values[variant == each], result.metric(name, each)
                every = max(1, len(x) // MAX_SCATTER_POINTS)
                axes.plot(
                    x[::every],
                    y[::every],
                    ".",
                    color=color,
                    markersize=3,
                    label=each,
                    rasterized=True,
                )
            axes.set(xlabel=key, ylabel=name)
            axes.legend(frameon=False)

        drawings += [_figure(lambda axes, name=name: draw(axes, name), 2.8) for name in names]
    return [drawing for drawing in drawings if drawing]


def _worst(
    result: StudyResult, names: Sequence[str], folder: Path
) -> Iterator[tuple[str, str, list[Case]]]:
    """Yield (metric, variant, the runs with the largest values)."""
    case, variant = result.column("case"), result.column("variant")
    for name in names:
        for each in result.study.variant_changes:
            values, numbers = result.metric(name, each), case[variant == each]
            order = np.argsort(-np.nan_to_num(values, nan=-np.inf))[:WORST_COUNT]
            known = [i for i in order if not np.isnan(values[i])]
            yield (
                name,
                each,
                [_case(result, int(numbers[i]), float(values[i]), folder) for i in known],
            )


def _case(result: StudyResult, number: int, value: float, folder: Path) -> Case:
    file = result.folder / "recordings" / f"{number:06d}.rrd"
    return Case(number, relpath(file, folder) if file.exists() else "", _format(value))


def _format(value: float | int | None) -> str:
    return "" if value is None or np.isnan(value) else f"{value:.4g}"
