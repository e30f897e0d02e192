"""Scene files that grow without bound, never end, or fill the screen are one-line errors."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from crane_sim import SceneError, load_scene
from crane_sim.cli.scene_options import load_scene_with_options
from crane_sim.files.yaml_text import parse_yaml
from crane_sim.study import load_study

SCENE = """crane: overhead
duration: 1.0
trolley: {drive: force, mass: 20.0}
cable: {lengths: [1.0], node_masses: [1.0]}
"""
TOO_MUCH = "has more than 1000000 values, or 100 groups in each other, with aliases expanded"


def expand(form: str, each: str) -> str:
    """Return ten anchors, each with nine times the one before: 1e9 values in 600 characters."""
    lines = ["a: &a {k: 1}"]
    for before, name in zip("abcdefghi", "bcdefghij", strict=True):
        repeated = ", ".join(each.format(i=i, alias=f"*{before}") for i in range(9))
        lines.append(f"{name}: &{name} {form.format(repeated)}")
    return "\n".join(lines)


EXPANDED = {
    "lists": expand("[{}]", "{alias}"),
    "groups": expand("{{{}}}", "x{i}: {alias}"),
    "merged": expand("{{<<: [{}]}}", "{alias}"),
}


@pytest.mark.parametrize("text", EXPANDED.values(), ids=EXPANDED)
def test_aliases_that_expand_are_refused(text: str, tmp_path: Path) -> None:
    """A billion values by lists, groups or merge keys of aliases are refused before being built."""
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE + "inputs:\n" + "\n".join(f"  {line}" for line in text.splitlines()))
    with pytest.raises(SceneError, match=f"cannot be read: line 1[12], column \\d+: {TOO_MUCH}$"):
        load_scene(file)
    with pytest.raises(SceneError, match=f"cannot be read: line 1[12], column \\d+: {TOO_MUCH}$"):
        load_study(file)
    with pytest.raises(SceneError, match="is not a value$"):
        load_scene_with_options("overhead_swing", settings=(f"inputs={text}",))


@pytest.mark.parametrize("text", ["[" * 101 + "]" * 101, "&a [*a]", "{b: &a {k: *a}}"])
def test_what_is_too_deep_is_refused(text: str, tmp_path: Path) -> None:
    """Groups in each other beyond a hundred, or in themselves, are refused."""
    file = tmp_path / "scene.yaml"
    file.write_text(f"{SCENE}inputs: {text}")
    with pytest.raises(SceneError, match=TOO_MUCH):
        load_scene(file)


def test_ordinary_aliases_are_expanded() -> None:
    """Anchors, aliases and merge keys of an ordinary file mean what they say."""
    text = "a: &a {x: 1, y: [1, 2]}\nb: {<<: *a, x: 3}\nc: *a\nd: [*a, *a]"
    a = {"x": 1, "y": [1, 2]}
    assert parse_yaml(text) == {"a": a, "b": a | {"x": 3}, "c": a, "d": [a, a]}


def test_a_large_file_is_refused(tmp_path: Path) -> None:
    """A file of some megabytes is refused before it is parsed, which would take seconds."""
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE + "#" * 4_000_000)
    with pytest.raises(
        SceneError, match=r"scene.yaml: cannot be read: has 4 MB, at most 1 MB are possible$"
    ):
        load_scene(file)


@pytest.fixture(params=["fifo", "/dev/zero"])
def endless(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Return the name of a special file: a pipe without a writer, or a device without an end."""
    if request.param == "fifo":
        os.mkfifo(tmp_path / "fifo")
        return str(tmp_path / "fifo")
    return request.param


DOORS: dict[str, Callable[[str], Any]] = {
    "scene": load_scene,
    "base_motion": lambda name: load_scene("offshore_resonant", {"base_motion": {"file": name}}),
    "study": load_study,
    "law": lambda name: load_scene("overhead_swing", {"control.law": f"{name}.py:law"}),
    "trajectory": lambda name: load_scene(
        "overhead_swing", {"reference.path": {"kind": "trajectory", "file": name}}
    ),
}


@pytest.mark.parametrize("door", DOORS.values(), ids=DOORS)
def test_only_regular_files_are_read(door: Callable[[str], Any], endless: str) -> None:
    """A pipe, or a device, is refused in place of a file, wherever a scene or study names one."""
    with pytest.raises(SceneError, match="is no regular file|there is no file|does not exist"):
        door(endless)


@pytest.mark.parametrize(
    "changes",
    [
        {"crane": "x" * 10_000},
        {"x" * 10_000: 1},
        {"friction": {"x" * 10_000: 1}},
        {"name": "x" * 10_000},
        {"control": {"law": "x" * 10_000}},
        {"control": {"law": "x" * 10_000 + ".py:law"}},
        {"control": {"law": "x" * 10_000 + ":law"}},
        {"base_motion": {"file": "x" * 10_000}},
        {"initial": {"angles": ["x" * 10_000]}},
    ],
    ids=lambda changes: next(iter(changes))[:12],
)
def test_a_long_text_is_shortened_in_its_error(changes: dict[str, Any]) -> None:
    """A line on a key or a value has no more of it than fits into a line."""
    document = parse_yaml(SCENE) | changes
    with pytest.raises(SceneError) as caught:
        load_scene(document)
    assert len(str(caught.value)) < 1200  # with all keys of a scene, and a path
