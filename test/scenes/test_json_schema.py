"""The JSON schema of scene files, for editors, has the keys of the classes that read them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from crane_bench.documentation.json_schema import COMMAND, FILE, json_schema, json_schema_text
from crane_sim.files.catalogue import scene_files

ROOT = Path(__file__).parents[2]
SCHEMA = json_schema()


def kinds(part: Any) -> Iterator[Any]:
    """Yield the schemas that a value may fit, references followed."""
    if "$ref" in part:
        part = SCHEMA["$defs"][part["$ref"].rpartition("/")[2]]
    inner = [*part.get("anyOf", ()), *part.get("oneOf", ())]
    for each in inner:
        yield from kinds(each)
    if not inner:
        yield part


def entry(group: Any, key: str) -> Any:
    """Return the schema of a key of a group; where it has no such key, one that nothing fits."""
    further = group.get("additionalProperties", False)
    others = further if isinstance(further, dict) else {} if further else {"enum": []}
    return group.get("properties", {}).get(key, others)


def fits(part: Any, value: Any) -> bool:
    """Return whether the keys of a value, and its choices in words, are those of a schema."""
    if isinstance(value, dict):
        groups = [each for each in kinds(part) if each.get("type", "object") == "object"]
        return any(
            not each or all(fits(entry(each, k), v) for k, v in value.items()) for each in groups
        )
    if isinstance(value, list):
        lists = [each for each in kinds(part) if each.get("type", "array") == "array"]
        return any(all(fits(each.get("items", {}), v) for v in value) for each in lists)
    return any(value in each.get("enum", [each.get("const", value)]) for each in kinds(part))


def of_crane(document: Any) -> Any:
    """Return the schema of a document's crane."""
    cases = {case["if"]["properties"]["crane"]["const"]: case["then"] for case in SCHEMA["allOf"]}
    own = cases[document["crane"]]
    return own if "if" not in own else own["then" if "falls" in document else "else"]


def test_the_schema_is_what_the_command_writes() -> None:
    """The schema in the tree is the one that its command writes now."""
    assert (ROOT / "config" / FILE).read_text() == json_schema_text(), f"out of date: ./{COMMAND}"


@pytest.mark.parametrize("name", scene_files())
def test_scenes_of_the_catalogue_fit_the_schema(name: str) -> None:
    """Every key of the catalogue is in the schema at its place; a misspelt one is not."""
    document = yaml.safe_load(scene_files()[name].read_text())
    assert fits(of_crane(document), document)
    assert not fits(of_crane(document), document | {"payloda": 1})
