"""The data file of the benchmark: what was measured, by part; parts measured again replace what was there."""

import json
from pathlib import Path
from typing import Any

from crane_sim.explain import SceneError

FILE = "performance.json"
DIGITS = 5


def stored(folder: Path) -> dict[str, Any]:
    """Return what the folder's data file holds, nothing when there is none.

    Raises:
        SceneError: the file is not one of the benchmark's.
    """
    try:
        found = json.loads((folder / FILE).read_text())
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise SceneError(f"{folder / FILE}: cannot be read as the benchmark's data: {error}") from None
    return dict(found)


def merged(before: dict[str, Any], part: str, found: dict[str, Any]) -> dict[str, Any]:
    """Return the data with a part measured anew; scenes that were not measured this time stay."""
    if part == "scenes" and part in before:
        found = found | {"scenes": before[part]["scenes"] | found["scenes"]}
    return before | {part: rounded(found)}


def save(data: dict[str, Any], folder: Path) -> None:
    """Write the data file, a line for each point, so that a change shows where it is."""
    text = json.dumps(data, indent=1, ensure_ascii=False)
    (folder / FILE).write_text(text + "\n")


def rounded(value: Any) -> Any:
    """Return a document with its floats rounded: more digits than a timing has would be noise."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if abs(value) < 1e300 else None
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list | tuple) else value
