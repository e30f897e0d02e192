"""Signs and origins: the axes of each crane, and the positive direction of each joint.

They stand in `signs.yaml`. The page of the scene format prints them; `test_scene_format.py` holds
each of them against the model.
"""

from importlib.resources import files
from typing import NamedTuple

from crane_sim.files.yaml_text import parse_yaml


class Sign(NamedTuple):
    """A joint's coordinate in words."""

    crane: str
    joint: str  # its name, k for a number
    unit: str
    zero: str  # where it is zero
    positive: str  # where it grows to


_TEXT = parse_yaml(
    files("crane_bench.documentation").joinpath("signs.yaml").read_text(encoding="utf-8")
)
SIGNS = [
    Sign(crane, *joint) for crane, words in _TEXT["cranes"].items() for joint in words["joints"]
]
"""Every joint, and the motions of a base."""


def section() -> list[str]:
    """Return the lines of the page's section."""
    lines = ["## Signs and origins", "", _TEXT["world"], ""]
    for crane, words in _TEXT["cranes"].items():
        lines += [
            f"### Joints: {words['title']}" if crane != "base" else f"### {words['title']}",
            "",
        ]
        lines += [words["origin"], ""] if "origin" in words else []
        lines += ["| joint | unit | zero | positive |", "|---|---|---|---|"]
        lines += [
            f"| `{s.joint}` | {s.unit} | {s.zero} | {s.positive} |"
            for s in SIGNS
            if s.crane == crane
        ]
        lines += ["", words["note"], ""] if "note" in words else [""]
    return lines
