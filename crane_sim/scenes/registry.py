"""The kinds of crane, and the schema of the scene files of each."""

from collections.abc import Mapping, Sequence
from typing import Any

from crane_sim.files.errors import SceneError, fields_at
from crane_sim.scenes.schema.bridge import BridgeFile
from crane_sim.scenes.schema.gantry import GantryFile
from crane_sim.scenes.schema.knuckle import KnuckleFile
from crane_sim.scenes.schema.knuckle_falls import KnuckleFallsFile
from crane_sim.scenes.schema.mobile import MobileFile
from crane_sim.scenes.schema.mobile_falls import MobileFallsFile
from crane_sim.scenes.schema.overhead import OverheadFile
from crane_sim.scenes.schema.pendulum import PendulumFile
from crane_sim.scenes.schema.pendulum_falls import PendulumFallsFile
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.schema.tower import TowerFile
from crane_sim.scenes.schema.tower_falls import TowerFallsFile

SCHEMAS: dict[str, type[SceneFile]] = {
    "knuckle": KnuckleFile,
    "tower": TowerFile,
    "mobile": MobileFile,
    "bridge": BridgeFile,
    "gantry": GantryFile,
    "overhead": OverheadFile,
    "pendulum": PendulumFile,
}
"""The kinds of crane, and the schema of their scene files."""

FALLS_SCHEMAS: dict[str, type[SceneFile]] = {
    "knuckle": KnuckleFallsFile,
    "tower": TowerFallsFile,
    "mobile": MobileFallsFile,
    "pendulum": PendulumFallsFile,
}
"""The same of those files that have `falls` in place of a rope."""

REEVED = ("knuckle", "tower", "mobile", "bridge")
"""Cranes whose rope can run over sheaves."""
HOISTED = ("knuckle", "tower", "mobile", "gantry")
"""Cranes that wind up falls by a winch, whose ropes can run over sheaves."""

MOST_PLACES = 2
"""Groups that a line on a key names, which other groups have."""

ALL_SCHEMAS = SCHEMAS | {f"{crane} with falls": schema for crane, schema in FALLS_SCHEMAS.items()}
"""All schemas, by what a crane is called."""


def schema_of(document: Mapping[str, Any]) -> type[SceneFile] | None:
    """Return the schema of a document, None for an unknown crane; with `falls` that of the crane with falls."""
    crane = str(document.get("crane"))
    return (FALLS_SCHEMAS if document.get("falls") is not None and crane in FALLS_SCHEMAS else SCHEMAS).get(crane)


def check_cable(document: Mapping[str, Any]) -> None:
    """Raise SceneError for keys of a rope beside `falls`, and for keys of falls without them."""
    crane, on_falls = str(document["crane"]), document.get("falls") is not None
    _check_reeving(document, crane, on_falls)
    if crane == "bridge" and on_falls:
        raise SceneError("falls: belongs to crane: gantry, whose winch is `hoist`; here is crane: bridge")
    if crane not in FALLS_SCHEMAS:
        return
    schemas = SCHEMAS[crane].model_fields, FALLS_SCHEMAS[crane].model_fields
    known, others = schemas if not on_falls else schemas[::-1]
    for key in (key for key, value in document.items() if value is not None and key in others.keys() - known.keys()):
        why, what = ("stands beside falls", "one of both") if on_falls else ("belongs to falls, here are none", key)
        raise SceneError(f"{key}: {why}; leave out {what}")


def _check_reeving(document: Mapping[str, Any], crane: str, on_falls: bool) -> None:
    """Raise SceneError for sheaves where no rope can be reeved."""
    own = "hoist" if crane in HOISTED and (on_falls or crane == "gantry") else "rope" if crane in REEVED else ""
    for group in ("rope", "hoist", "falls", "cable"):
        value = document.get(group)
        if not isinstance(value, Mapping) or value.get("reeving") is None or group == own:
            continue
        if own:
            raise SceneError(f"{group}.reeving: of crane: {crane}{' on falls' * on_falls} it is {own}.reeving")
        raise SceneError(
            f"{group}.reeving: belongs to rope.reeving of crane: {', '.join(REEVED)}, whose rope a winch moves, and to "
            f"hoist.reeving of falls below crane: {', '.join(HOISTED)}; here is crane: {crane}"
        )


def key_of_other_cranes(path: Sequence[str], crane: str) -> str:
    """Return a line on an unknown key that other cranes have there, empty where none does."""
    found, ropes = _cranes(path) if path else "", ", whose ropes are `falls`" if crane == "gantry" else ""
    return f"{'.'.join(path)}: belongs to crane: {found}; here is crane: {crane}{ropes}" if found else ""


def places_of(path: Sequence[str]) -> str:
    """Return the end of a line on an unknown key: where cranes have it in a group, empty where none does."""
    if len(path) != 1:
        return ""
    groups = dict.fromkeys(group for schema in ALL_SCHEMAS.values() for group in schema.model_fields)
    elsewhere = ((f"{group}.{path[-1]}", _cranes((group, path[-1]))) for group in groups)
    lines = [f"{key!r} of crane: {cranes}" for key, cranes in elsewhere if cranes]
    return f"; possible: {'; '.join(lines[:MOST_PLACES])}" if lines else ""


def _cranes(path: Sequence[str]) -> str:
    """Return the cranes whose schema has a key at a path, in words; empty where none has."""
    *group, key = path
    cranes = [crane for crane, schema in SCHEMAS.items() if key in fields_at(schema, group)]
    falls = [
        crane for crane, schema in FALLS_SCHEMAS.items() if key in fields_at(schema, group) and crane not in cranes
    ]
    return (
        ", ".join(cranes)
        + (", with falls to " if cranes and falls else "with falls to " if falls else "")
        + ", ".join(falls)
    )
