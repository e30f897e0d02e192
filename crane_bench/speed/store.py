"""The data file of the benchmark: results by suite; new ones replace a suite's old results."""

import json
import re
from pathlib import Path
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_text

FILE = "performance.json"
DIGITS = 5


def read_store(folder: Path) -> dict[str, Any]:
    """Return the folder's data, an empty dict without a file.

    Raises:
        SceneError: the file is not the benchmark's.
    """
    try:
        data = json.loads((folder / FILE).read_text())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise SceneError(
            f"{folder / FILE}: cannot be read as the benchmark's data: {error}"
        ) from None
    if not isinstance(data, dict) or not all(
        isinstance(suite, dict) and "machine" in suite for suite in data.values()
    ):
        raise SceneError(
            f"{folder / FILE}: cannot be read as the benchmark's data: it has another shape"
        )
    return data


def merge_suite(data: dict[str, Any], suite: str, measured: dict[str, Any]) -> dict[str, Any]:
    """Return the data with new results of a suite; what has no new results stays.

    That holds for scenes, engines and methods.
    """
    if suite == "scenes" and suite in data:
        old = data[suite]
        kept = {name: old[name] | measured[name] for name in ("engines", "cannot", "scenes")}
        for case in old["scenes"].keys() & measured["scenes"].keys():
            kept["scenes"][case] = _join_scene(old["scenes"][case], measured["scenes"][case])
        missing = {
            name: why for name, why in measured["missing"].items() if name not in kept["engines"]
        }
        measured = measured | kept | {"missing": missing}
    return data | {suite: round_floats(measured)}


def _join_scene(old: dict[str, Any], new: dict[str, Any]) -> dict[str, Any]:
    """Return a scene's results with the points of engines and methods without new results."""
    measured = {(point[0], point[1]) for point in new["points"]}
    kept = [point for point in old["points"] if (point[0], point[1]) not in measured]
    refused = {
        name: why
        for name, why in old["refused"].items()
        if name not in {engine for engine, _ in measured}
    }
    compiling = old["compiling_s"] | new["compiling_s"]
    return new | {
        "points": new["points"] + kept,
        "refused": refused | new["refused"],
        "compiling_s": compiling,
    }


def write_store(data: dict[str, Any], folder: Path) -> None:
    """Write the data file."""
    write_text(folder / FILE, dump_points(data))


def dump_points(data: dict[str, Any]) -> str:
    """Return data in JSON, a line for each point, so that a change shows where it is."""
    spread = json.dumps(data, indent=1, ensure_ascii=False)
    return (
        re.sub(r"\[\s+([^\[\]{}]+?)\s+\]", lambda match: f"[{' '.join(match[1].split())}]", spread)
        + "\n"
    )


def round_floats(value: Any) -> Any:
    """Return a document with its floats rounded: more digits than a timing has would be noise."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if abs(value) < 1e300 else None
    if isinstance(value, dict):
        return {key: round_floats(item) for key, item in value.items()}
    return [round_floats(item) for item in value] if isinstance(value, list | tuple) else value
