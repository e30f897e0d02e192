"""The document of a scene: read from a file, changed by dotted keys, or made nominal for a law."""

import copy
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from crane_sim.files.catalogue import scene_files
from crane_sim.files.errors import SceneError, did_you_mean, join_lines, one_word, shorten
from crane_sim.files.yaml_text import YAML_ERRORS, read_yaml

REAL = (
    *("control", "brake", "sensors", "imu", "camera", "actuators", "faults"),
    *("backlash", "flexibility", "uncertain"),
)
"""Groups that the nominal scene omits, unless `control.nominal` has them.

A load on falls keeps `flexibility`: its place is among the joints, and below a bent structure is
another one.
"""


def read(source: str | Path) -> dict[str, Any]:
    """Return the document of a catalogue name or a file.

    Raises:
        SceneError: there is no such scene, or it cannot be read.
    """
    if not isinstance(source, str | Path):
        raise SceneError(f"scene {shorten(source)}: must be a name, a file or a dict")
    path = scene_files().get(str(source), Path(source))
    if not os.path.exists(path):  # unlike Path.exists, no error for a name that no file can have
        raise SceneError(_unknown_scene(str(source)))
    document = read_groups(path, "scene file")
    _resolve_paths(document, path.resolve().parent)
    return document


def read_groups(path: Path, what: str) -> dict[str, Any]:
    """Return the groups of a YAML file, `what` in errors; without a `name` it is the file's.

    Raises:
        SceneError: it cannot be read, has a key twice, or holds something else.
    """
    try:
        document = read_yaml(path)
    except YAML_ERRORS as error:
        raise SceneError(f"{what} {path}: cannot be read: {_cause(error)}") from None
    if not isinstance(document, dict):
        raise SceneError(f"{what} {path}: holds {type(document).__name__}, not groups of keys")
    document.setdefault("name", path.stem)
    return document


def _cause(error: Exception) -> str:
    """Return the cause of a read error in one line, with line and column if known."""
    if isinstance(error, OSError):
        return error.strerror or str(error)
    if isinstance(error, yaml.MarkedYAMLError) and error.problem_mark is not None:
        mark = error.problem_mark
        return f"line {mark.line + 1}, column {mark.column + 1}: {join_lines(error.problem)}"
    return join_lines(error)


def _unknown_scene(source: str) -> str:
    """Return the line on a source that is neither a name of the catalogue nor a file."""
    is_path = os.sep in source or source.endswith((".yaml", ".yml"))
    name = Path(source).stem if is_path else source
    what = (
        f"scene file {one_word(source)}: there is no such file"
        if is_path
        else f"unknown scene {one_word(source)!r}"
    )
    return f"{what}{did_you_mean(name, scene_files())} (`crane scenes` lists the catalogue)"


def _resolve_paths(document: dict[str, Any], folder: Path) -> None:
    """Make paths of files in a scene, relative to its folder, absolute: it is read elsewhere."""
    reference, control = document.get("reference"), document.get("control")
    for group in (
        document.get("base_motion"),
        reference.get("path") if isinstance(reference, dict) else None,
    ):
        if isinstance(group, dict) and isinstance(group.get("file"), str):
            group["file"] = str(folder / group["file"])
    if not isinstance(control, dict):
        return
    if isinstance(control.get("law"), str):
        control["law"] = function_from(control["law"], folder)
    if isinstance(nominal := control.get("nominal"), dict):
        _resolve_paths(nominal, folder)


def function_from(name: str, folder: Path) -> str:
    """Return the name of a law or function; the path of FILE.py:FUNCTION is made absolute.

    It is relative to a folder.
    """
    file, colon, function = name.rpartition(":")
    return f"{folder / file}{colon}{function}" if file.endswith(".py") else name


def plain_copy(value: Any, copies: dict[int, tuple[Any, Any]] | None = None) -> Any:
    """Return a copy of groups, lists and numbers as YAML has them, of Python's own types.

    `copies`, by identity, are (value, copy) of what was met before: what is shared stays shared.
    Other values stay.
    """
    copies = {} if copies is None else copies
    if id(value) in copies:
        return copies[id(value)][1]
    if isinstance(value, Mapping):
        group: dict[Any, Any] = {}
        copies[id(value)] = value, group
        group.update((key, plain_copy(each, copies)) for key, each in value.items())
        return group
    if type(value) in (list, tuple):
        values: list[Any] = []
        copies[id(value)] = value, values
        values.extend(plain_copy(each, copies) for each in value)
        return values
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def set_value(document: dict[str, Any], key: str, value: Any) -> None:
    """Set the value at a dotted key, such as "payload.mass" or "links.0.length"; null means absent.

    The groups on its way are copied: those that share them, such as by an anchor of the file, keep
    their values.

    Raises:
        SceneError: a part of the key is not a group, or not an index of its list.
    """
    *groups, last = str(key).split(".")
    group: Any = document
    for name in groups:
        place: Any = _index(group, name, key) if isinstance(group, list) else name
        inner = group[place] if isinstance(group, list) else group.get(name, {})
        if not isinstance(inner, dict | list):
            raise SceneError(f"{key}: {shorten(name)} is not a group of keys")
        group[place] = copy.copy(inner)
        group = group[place]
    place = _index(group, last, key) if isinstance(group, list) else last
    group[place] = value


def with_values(document: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document with other values by dotted key; unchanged groups are shared with it.

    Raises:
        SceneError: as of `set_value`.
    """
    changed = dict(document)
    for key, value in changes.items():
        set_value(changed, key, plain_copy(value))
    return changed


def _index(values: list[Any], name: str, key: str) -> int:
    """Return a part of a dotted key as an index of a list."""
    if not name.isdecimal() or int(name) >= len(values):
        raise SceneError(f"{key}: {shorten(name)} is no index of a list of {len(values)}")
    return int(name)


def get_value(document: Any, key: str) -> tuple[bool, Any]:
    """Return (whether there is a value at a dotted key, the value)."""
    for name in key.split("."):
        if isinstance(document, list) and name.isdecimal() and int(name) < len(document):
            document = document[int(name)]
        elif isinstance(document, dict) and document.get(name) is not None:
            document = document[name]
        else:
            return False, None
    return True, document


def without_nulls(group: Mapping[str, Any]) -> dict[str, Any]:
    """Return a group without null keys, which mean absent, also in its subgroups.

    Groups within `control` are left to the law: there null may be a choice.
    """
    deeper = {key: value for key, value in group.items() if isinstance(value, dict | Mapping)}
    groups = {key: without_nulls(value) for key, value in deeper.items() if key != "control"}
    if "control" in deeper:
        groups["control"] = {
            key: value for key, value in deeper["control"].items() if value is not None
        }
    return {key: groups.get(key, value) for key, value in group.items() if value is not None}


def nominal(document: dict[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document of the law's nominal scene: without its law, with `nominal` merged in."""

    def merge(base: Any, over: Any) -> Any:
        if not (isinstance(base, dict) and isinstance(over, dict)):
            return over
        return {**base, **{key: merge(base.get(key), value) for key, value in over.items()}}

    omitted = set(REAL) - ({"flexibility"} if document.get("falls") is not None else set())
    return merge(
        {key: value for key, value in document.items() if key not in omitted}, dict(overrides)
    )
