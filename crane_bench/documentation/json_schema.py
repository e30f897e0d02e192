"""The JSON schema of scene files, with which editors complete and explain keys.

It is written from the classes that read the files.

It is more lenient than these: what depends on several keys, `crane check` says.
"""

import json
import types
from math import inf
from pathlib import Path
from typing import Any, Literal, Union, get_args, get_origin

from pydantic import BeforeValidator
from pydantic.fields import FieldInfo

from crane_bench.documentation.fields import (
    REQUIRED,
    Choice,
    Field,
    choice,
    fields,
    strip_annotated,
    subgroup,
)
from crane_sim.files.output import write_output
from crane_sim.files.types import reject_bool, to_radians
from crane_sim.scenes.registry import FALLS_SCHEMAS, SCHEMAS
from crane_sim.scenes.schema.groups import InlineUnion

COMMAND = "crane describe --schema --save config"
FILE = "scene.schema.json"
PLAIN = {float: "number", int: "integer", bool: "boolean", str: "string"}
BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
SHORT = {"type": ["number", "string"]}
"""What a short form of a group may be; that of a list is its one entry."""


def json_schema() -> dict[str, Any]:
    """Return the schema: by `crane`, and `falls` where these may be in place of a rope."""
    groups = _Groups()
    cranes = []
    for crane, schema in SCHEMAS.items():
        own: dict[str, Any] = groups.reference(schema)
        if crane in FALLS_SCHEMAS:
            on_falls = groups.reference(FALLS_SCHEMAS[crane])
            own = {"if": {"required": ["falls"]}, "then": on_falls, "else": own}
        is_crane = {"properties": {"crane": {"const": crane}}, "required": ["crane"]}
        cranes.append({"if": is_crane, "then": own})
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Scene of crane_sim",
        "type": "object",
        "required": ["crane"],
        "properties": {"crane": {"enum": list(SCHEMAS)}},
        "allOf": cranes,
        "$defs": groups.definitions,
    }


def json_schema_text() -> str:
    """Return the schema as text, a definition a line."""
    schema = json_schema()
    definitions = schema.pop("$defs").items()
    rows = ",\n".join(
        f"{json.dumps(name)}: {json.dumps(part, ensure_ascii=False)}" for name, part in definitions
    )
    head = json.dumps(schema, ensure_ascii=False).removesuffix("}")
    return f'{head}, "$defs": {{\n{rows}\n}}}}\n'


def save_json_schema(folder: str) -> None:
    """Write the schema into a folder; SceneError: it cannot be written."""
    write_output("--save", Path(folder, FILE), lambda path: path.write_text(json_schema_text()))


class _Groups:
    """Definitions of groups, each once.

    Attributes:
        definitions: by name.
    """

    def __init__(self) -> None:
        self.definitions: dict[str, Any] = {}
        self._names: dict[Any, str] = {}

    def reference(self, group: Any) -> dict[str, Any]:
        """Return a reference to the definition of a group or a Choice."""
        identity = (group.key, *group.kinds.values()) if isinstance(group, Choice) else group
        if identity not in self._names:
            base = f"by_{group.key}" if isinstance(group, Choice) else group.__name__
            name = base if base not in self.definitions else f"{base}_{len(self.definitions)}"
            self._names[identity] = name
            self.definitions[name] = {}
            self.definitions[name] = (
                self._choice(group) if isinstance(group, Choice) else self._group(group)
            )
        return {"$ref": f"#/$defs/{self._names[identity]}"}

    def _choice(self, group: Choice) -> dict[str, Any]:
        """Return the definition of a group whose keys depend on one of them."""
        return {
            "oneOf": [
                self._object(fields(kind), (group.key, name)) for name, kind in group.kinds.items()
            ]
        }

    def _group(self, group: Any) -> dict[str, Any]:
        """Return the definition of a group."""
        own = fields(group)
        inline = next((each for each in own if _is_inline(each)), None)
        if inline is None:
            definition = self._object(own)
            if getattr(group, "model_config", {}).get("extra") == "allow":
                definition["additionalProperties"] = True
            return definition
        rest, union = tuple(each for each in own if each is not inline), choice(inline.annotation)
        assert union is not None
        kinds = union.kinds.items()
        return {
            "oneOf": [
                self._object((*rest, *fields(kind)), (union.key, name)) for name, kind in kinds
            ]
        }

    def _object(self, own: tuple[Field, ...], tag: tuple[str, str] | None = None) -> dict[str, Any]:
        """Return the schema of an object with these keys; one of them, the tag, is a constant."""
        properties: dict[str, Any] = {} if tag is None else {tag[0]: {"const": tag[1]}}
        required = [] if tag is None else [tag[0]]
        for each in own:
            properties[each.key] = self._field(each)
            required += [each.key] if each.default is REQUIRED else []
        return {
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": False,
        }

    def _field(self, own: Field) -> dict[str, Any]:
        """Return the schema of a key; null is as good as absent."""
        schema, text = (
            self._value(own.annotation),
            f"[{own.unit}] {own.text}" if own.unit else own.text,
        )
        if own.default is not REQUIRED:
            schema = {"anyOf": [schema, {"type": "null"}]}
        return schema | ({"description": text} if text else {})

    def _value(self, annotation: Any) -> dict[str, Any]:
        """Return the schema of a value of a type."""
        kind, metadata = strip_annotated(annotation)
        union = choice(annotation)
        if union is not None:
            return self.reference(union)
        if any(getattr(part, "func", None) is to_radians for part in metadata):
            return {"type": ["number", "string"]}
        schema = self._plain(kind, metadata)
        known = (to_radians, reject_bool)
        short = [
            part
            for part in metadata
            if isinstance(part, BeforeValidator) and part.func not in known
        ]
        if not (short and schema):
            return schema
        one = self._value(get_args(kind)[0]) if get_origin(kind) is tuple else SHORT
        return {"anyOf": [schema, one]}

    def _plain(self, kind: Any, metadata: list[Any]) -> dict[str, Any]:
        """Return the schema of a type without its validators."""
        origin = get_origin(kind)
        if origin is Literal:
            return {"enum": list(get_args(kind))}
        if origin in (Union, types.UnionType):
            return {"anyOf": [self._value(each) for each in get_args(kind)]}
        if origin is tuple:
            return self._list(get_args(kind))
        if origin is dict:
            return {"type": "object", "additionalProperties": self._value(get_args(kind)[1])}
        group = subgroup(kind)
        if group is not None:
            return self.reference(group)
        if kind not in PLAIN:
            return {}
        return {"type": PLAIN[kind]} | _bounds(metadata)

    def _list(self, kinds: tuple[Any, ...]) -> dict[str, Any]:
        """Return the schema of a list."""
        if kinds[-1] is ...:
            return {"type": "array", "items": self._value(kinds[0])}
        items = [self._value(each) for each in kinds]
        return {
            "type": "array",
            "prefixItems": items,
            "minItems": len(items),
            "maxItems": len(items),
        }


def _is_inline(own: Field) -> bool:
    return any(isinstance(part, InlineUnion) for part in strip_annotated(own.annotation)[1])


def _bounds(metadata: list[Any]) -> dict[str, float]:
    """Return the bounds of a number."""
    parts = [
        one
        for part in metadata
        for one in (part.metadata if isinstance(part, FieldInfo) else [part])
    ]
    found = {
        word: getattr(part, key)
        for part in parts
        for key, word in BOUNDS.items()
        if hasattr(part, key)
    }
    return {word: bound for word, bound in found.items() if abs(bound) < inf}
