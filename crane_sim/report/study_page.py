"""The page of a study: one HTML file with failures, metrics by variant, their differences, and the worst runs."""

import io
import json
import re
from collections.abc import Iterator, Sequence
from html import escape
from importlib.resources import files
from os.path import relpath
from pathlib import Path
from typing import Any
from urllib.parse import quote
from zlib import crc32

import numpy as np
import numpy.typing as npt

from crane_sim.files.output import write_output
from crane_sim.study.columns import PARAMETER
from crane_sim.study.result import StudyResult, read_result
from crane_sim.study.sensitivity import COLUMN_HEADINGS
from crane_sim.study.store import read_identity
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
    study, summary = result.study, summarise(result)
    style = files("crane_sim.report").joinpath("assets", "page.css").read_text(encoding="utf-8")
    scene = study.scene if isinstance(study.scene, str) else study.scene.get("name", "scene")
    drawn = f"{study.design.replace('_', ' ')} of {', '.join(study.parameters)}"
    failed = sum(summary["failures"].values())
    head = f"""<header><div><h1>{escape(study.name or "study")}</h1>
<p id="about">{summary["runs"]} runs of {escape(Path(str(scene)).stem)}: {escape(drawn)}; seed {study.seed}</p></div>
<span id="status" class="{"bad" if failed else ""}">{failed or "no"} run{"s" * (failed != 1)} failed</span></header>"""
    names = shown_metrics(result)
    parts = [
        head,
        _failures(result),
        _metrics_html(summary),
        *_differences(summary),
        _sensitivities(summary, study.design),
        *_distributions(result, names),
    ]
    parts += [*_scatters(result, names), _worst(result, names, folder or result.folder), _study(result)]
    title = f"<meta charset=utf-8><meta name=viewport content='width=device-width'><title>{escape(study.name)}</title>"
    return (
        f"<!doctype html><html lang=en><head>{title}<style>{style}</style></head><body>{''.join(parts)}</body></html>"
    )


def _section(title: str, body: str, mark: str = "") -> str:
    return f"<section{mark}><h2>{escape(title)}</h2>{body}</section>" if body else ""


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table of cells in HTML."""
    lines = ["".join(f"<td>{cell}</td>" for cell in row) for row in rows]
    heads = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    return f"<table><tr>{heads}</tr>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"


def _failures(result: StudyResult) -> str:
    lines = "".join(f"<li>{escape(line)}</li>" for line in first_errors(result, 10))
    return _section("Runs that failed", lines and f"<ul>{lines}</ul>", " id=failure")


def _metrics_html(summary: dict[str, Any]) -> str:
    """Return the section of spreads by variant."""
    keys = ("runs", "least", "median", "greatest")
    rows = [
        (escape(name), escape(variant), *(_format(spread[key]) for key in keys))
        for name, by_variant in summary["metrics"].items()
        for variant, spread in by_variant.items()
        if "median" in spread
    ]
    return _section("Metrics", _table(("metric", "variant", *keys), rows))


def _differences(summary: dict[str, Any]) -> Iterator[str]:
    """Yield the sections of the differences between variants, of the summary of a study."""
    first, *others = summary["failures"]  # variants
    if not others:
        return
    rows = []
    for name, by_variant in summary["metrics"].items():
        for other in others:
            each = by_variant[f"{other} - {first}"]
            interval = f"{_format(each['low'])} … {_format(each['high'])}"
            share = "" if np.isnan(each["share"]) else f"{each['share']:.0%}"
            tests = (share, _format(each["effect_size"]), _format(each["p_value"]))
            rows.append((escape(name), escape(other), str(each["pairs"]), _format(each["mean"]), interval, *tests))
    head = ("metric", "variant", "pairs", "mean", "95 % interval", "smaller in", "effect size", "p (Wilcoxon)")
    yield _section(f"Differences from {first}, on the same samples", _table(head, rows))
    fails = [
        (escape(other), *(str(each[key]) for key in ("first_only", "second_only", "both")), _format(each["p_value"]))
        for other, each in summary["failure_differences"].items()
        if each["first_only"] + each["second_only"] + each["both"]
    ]
    head = ("variant", f"only {first} fails", "only the variant fails", "both", "p (McNemar)")
    yield _section("Which of them fail", _table(head, fails) if fails else "")


def _sensitivities(summary: dict[str, Any], design: str) -> str:
    """Return the section of how metrics depend on the parameters, of designs of sensitivity."""
    if not summary["sensitivities"]:
        return ""
    rows = [
        (escape(name), escape(variant), escape(row["parameter"]), *(_format(row[key]) for key in SENSITIVITY_COLUMNS))
        for name, by_variant in summary["sensitivities"].items()
        for variant, own in by_variant.items()
        for row in own
    ]
    head = ("metric", "variant", "parameter", *COLUMN_HEADINGS[design])
    return _section(f"Sensitivity to the parameters ({design.capitalize()})", _table(head, rows))


def _figure(draw: Any, height: float) -> str:
    """Return a drawing in its frame, empty without matplotlib."""
    svg = _draw(draw, height)
    return f"<figure>{svg}</figure>" if svg else ""


def _draw(draw: Any, height: float) -> str:
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


def _distributions(result: StudyResult, names: Sequence[str]) -> Iterator[str]:
    """Yield the section of the metrics' cumulative distributions: without the metric, a run is below no value."""
    drawings = []
    for name in names:
        spread = {variant: result.metric(name, variant) for variant in result.study.variant_changes}

        def draw(axes: Any, spread: dict[str, npt.NDArray[np.float64]] = spread, name: str = name) -> None:
            for color, (variant, values) in zip(COLORS * 9, spread.items(), strict=False):
                ordered = np.sort(values[np.isfinite(values)])
                share = np.arange(1, len(ordered) + 1) / max(len(values), 1)
                axes.step(ordered, share, where="post", color=color, label=variant)
            axes.set(xlabel=name, ylabel="share of all runs", ylim=(0, 1.02))
            axes.legend(frameon=False)

        drawings.append(_figure(draw, 2.6))
    yield _section("Distributions", f"<div id=charts>{''.join(drawings)}</div>" if any(drawings) else "")


def _scatters(result: StudyResult, names: Sequence[str]) -> Iterator[str]:
    """Yield the section of metrics against the parameters that are numbers."""
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
                axes.plot(x[::every], y[::every], ".", color=color, markersize=3, label=each, rasterized=True)
            axes.set(xlabel=key, ylabel=name)
            axes.legend(frameon=False)

        drawings += [_figure(lambda axes, name=name: draw(axes, name), 2.8) for name in names]
    yield _section("Metrics against parameters", f"<div id=charts>{''.join(drawings)}</div>" if any(drawings) else "")


def _worst(result: StudyResult, names: Sequence[str], folder: Path) -> str:
    """Return the section of the runs with the largest metrics, with links to their recordings."""
    case, variant = result.column("case"), result.column("variant")
    rows = []
    for name in names:
        for each in result.study.variant_changes:
            values, numbers = result.metric(name, each), case[variant == each]
            order = [
                i for i in np.argsort(-np.nan_to_num(values, nan=-np.inf))[:WORST_COUNT] if not np.isnan(values[i])
            ]
            runs = [f"{_case_link(result, int(numbers[i]), folder)} ({_format(float(values[i]))})" for i in order]
            rows.append((escape(name), escape(each), ", ".join(runs)))
    return _section("Largest metrics, by case", _table(("metric", "variant", "cases"), rows))


def _case_link(result: StudyResult, case: int, folder: Path) -> str:
    file = result.folder / "recordings" / f"{case:06d}.rrd"
    return f'<a href="{quote(relpath(file, folder))}">{case}</a>' if file.exists() else str(case)


def _study(result: StudyResult) -> str:
    """Return the section with the study's file and versions."""
    known = read_identity(result.folder / "study.json")
    text = json.dumps({name: known.get(name) for name in ("study", "versions")}, indent=1)
    return _section("Study", f"<details><summary>file and versions</summary><pre>{escape(text)}</pre></details>")


def _format(value: float | int | None) -> str:
    return "" if value is None or np.isnan(value) else f"{value:.4g}"
