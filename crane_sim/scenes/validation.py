"""From a document to a scene's file: the schema of its crane reads it; mistakes get one line."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from crane_sim.files.document import without_nulls
from crane_sim.files.errors import SceneError, fields_at, foreign_path, nearest, one_line, shorten
from crane_sim.scenes.registry import ALL_SCHEMAS, FALLS_SCHEMAS, SCHEMAS
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.schema.uncertain import draw_parameters

MOST_PLACES = 2
"""Groups that a line on a key names, which other groups have."""


def read_file(document: dict[str, Any]) -> tuple[SceneFile, dict[str, Any]]:
    """Return (the file of a document, uncertain parameters drawn; a note on what was drawn).

    Raises:
        SceneError: one line that names the key, its value and what is possible.
    """
    certain, drawn = draw_parameters(document)
    try:
        return validate(certain), {"drawn": drawn} if drawn else {}
    except SceneError as error:
        key = next((key for key in drawn if str(error).startswith(key)), None)
        if key is None:
            raise
        raise SceneError(f"{error} (drawn by uncertain.{key})") from None


def validate(document: dict[str, Any]) -> SceneFile:
    """Return the file of a document; SceneError: as of `read_file`."""
    if "crane" not in document:
        known = {key for schema in SCHEMAS.values() for key in schema.model_fields}
        suggestion = nearest("crane", [key for key in document if key not in known])
        names = ", ".join(SCHEMAS)
        if suggestion:
            raise SceneError(f"unknown key {suggestion!r}, did you mean 'crane'? (crane: {names})")
        raise SceneError(f"crane: is missing (possible: {names})")
    schema = schema_of(document)
    try:
        return schema.model_validate(without_nulls(document))
    except ValidationError as error:
        path = foreign_path(error)
        line = key_of_other_cranes(path, document["crane"]) or one_line(error, schema) + places_of(
            path
        )
        raise SceneError(line) from None


def schema_of(document: Mapping[str, Any]) -> type[SceneFile]:
    """Return the schema of a document; with `falls` that of the crane with falls.

    Raises:
        SceneError: the crane is unknown, or has keys of a rope beside `falls`, or keys of falls
            without them.
    """
    crane = str(document["crane"])
    if crane not in SCHEMAS:
        raise SceneError(f"crane = {shorten(document['crane'])}: possible: {', '.join(SCHEMAS)}")
    if crane not in FALLS_SCHEMAS:
        return SCHEMAS[crane]
    schema, other = SCHEMAS[crane], FALLS_SCHEMAS[crane]
    on_falls = document.get("falls") is not None
    if on_falls:
        schema, other = other, schema
    foreign = other.model_fields.keys() - schema.model_fields.keys()
    for key in (key for key, value in document.items() if value is not None and key in foreign):
        why, what = (
            ("stands beside falls", "one of both")
            if on_falls
            else ("belongs to falls, here are none", key)
        )
        raise SceneError(f"{key}: {why}; leave out {what}")
    return schema


def key_of_other_cranes(path: Sequence[str], crane: str) -> str:
    """Return a line on an unknown key that other cranes have there, empty where none does."""
    found, ropes = (
        _cranes(path) if path else "",
        ", whose ropes are `falls`" if crane == "gantry" else "",
    )
    return (
        f"{'.'.join(path)}: belongs to crane: {found}; here is crane: {crane}{ropes}"
        if found
        else ""
    )


def places_of(path: Sequence[str]) -> str:
    """Return the end of a line on an unknown key: where cranes have it, empty where none does."""
    if len(path) != 1:
        return ""
    groups = dict.fromkeys(
        group for schema in ALL_SCHEMAS.values() for group in schema.model_fields
    )
    elsewhere = ((f"{group}.{path[-1]}", _cranes((group, path[-1]))) for group in groups)
    lines = [f"{key!r} of crane: {cranes}" for key, cranes in elsewhere if cranes]
    return f"; possible: {'; '.join(lines[:MOST_PLACES])}" if lines else ""


def _cranes(path: Sequence[str]) -> str:
    """Return the cranes whose schema has a key at a path, in words; empty where none has."""
    *group, key = path
    cranes = [crane for crane, schema in SCHEMAS.items() if key in fields_at(schema, group)]
    falls = [crane for crane, schema in FALLS_SCHEMAS.items() if key in fields_at(schema, group)]
    further = [crane for crane in falls if crane not in cranes]
    words = [", ".join(cranes)] if cranes else []
    return ", ".join([*words, f"with falls to {', '.join(further)}"] if further else words)
