"""Files of the soak tests in the documentation: `soak.md`, and `soak/PART.json` and `.png`."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from crane_bench.soak.metrics import Metric
from crane_bench.soak.page import PARTS, write_findings
from crane_bench.speed.measurement import describe_machine, machine
from crane_bench.speed.store import dump_points, round_floats
from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_text
from crane_sim.report.plotting import save_figure

_MAX_SAMPLES = 100  # of a series, saved


def save_findings(
    part: str, command: str, metrics: Sequence[Metric], data: Mapping[str, Any], folder: Path
) -> None:
    """Write the data of a soak test, and rewrite the page of all soak tests of the folder.

    Args:
        part: the test's name.
        command: the command line that repeats it.
        metrics: what was measured.
        data: the measurements, from which the page's plot is drawn.
        folder: the page's folder.

    Raises:
        SceneError: the folder cannot be written, or has other entries of these names.
    """
    kept = {name: data[name] for name in PARTS[part].data_keys}
    kept = thin_lists(kept) if PARTS[part].series else kept
    document = {
        "command": command,
        "machine": machine(),
        "metrics": [list(metric) for metric in metrics],
        "data": kept,
    }
    try:
        (folder / "soak").mkdir(parents=True, exist_ok=True)
        write_text(folder / "soak" / f"{part}.json", dump_points(round_floats(document)))
        (folder / "soak" / f"{part}.png").unlink(missing_ok=True)  # the plot of former data
    except OSError as error:
        raise SceneError(f"--save {str(folder)!r}: {error.strerror}") from None
    write_page(folder)


def read_findings(folder: Path) -> dict[str, Any]:
    """Return the data in a folder by soak test; raises SceneError where it has none."""
    documents = {part: document for part in PARTS if (document := _read_part(folder, part))}
    if not documents:
        raise SceneError(
            f"{folder}: has no data of a soak yet; run one with --save, or name another folder"
        )
    return documents


def write_page(folder: Path) -> None:
    """Write the page of all soak tests with data in the folder, and plots if possible.

    Plots need matplotlib.

    Raises:
        SceneError: as in `save_findings`, or there are no data.
    """
    documents = read_findings(folder)
    try:
        for part, document in documents.items():
            _draw_part(folder, part, document["data"])
        drawn = [part for part in documents if (folder / "soak" / f"{part}.png").is_file()]
        write_text(folder / "soak.md", write_findings(documents, drawn))
    except OSError as error:
        raise SceneError(f"--save {str(folder)!r}: {error.strerror}") from None


def _draw_part(folder: Path, part: str, data: Mapping[str, Any]) -> None:
    draw, file = PARTS[part].draw, folder / "soak" / f"{part}.png"
    if draw is None:
        return
    try:
        save_figure(draw, data, file, dpi=100)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise _unreadable(file.with_suffix(".json"), error) from None


def thin_lists(value: Any) -> Any:
    """Return a document with long lists thinned, lists of equal length at the same indices."""
    if isinstance(value, dict):
        return {key: thin_lists(entry) for key, entry in value.items()}
    if not isinstance(value, list | tuple) or len(value) <= _MAX_SAMPLES:
        return value
    return [value[round(i * (len(value) - 1) / (_MAX_SAMPLES - 1))] for i in range(_MAX_SAMPLES)]


def _read_part(folder: Path, part: str) -> dict[str, Any]:
    """Return the document of a part, empty if it was not measured."""
    file = folder / "soak" / f"{part}.json"
    try:
        document = json.loads(file.read_text())
        # its deprecated name, for one release
        name = "metrics" if "metrics" in document else "figures"
        metrics = [Metric(*metric) for metric in document[name]]
        describe_machine(document["machine"])  # fails where something is missing
        data = {key: document["data"][key] for key in PARTS[part].data_keys}
        return {
            "command": document["command"],
            "machine": document["machine"],
            "data": data,
            "metrics": metrics,
        }
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise _unreadable(file, error) from None


def _unreadable(file: Path, error: Exception) -> SceneError:
    why = f"{error} is missing" if isinstance(error, KeyError) else f"{error}"
    return SceneError(f"{file}: cannot be read as data of a soak: {why}")
