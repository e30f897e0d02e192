"""The page on the format of scene files: every key, its type, unit, default and meaning.

It is written from the schemas.
"""

import inspect
import re
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from crane_bench.documentation import signs
from crane_bench.documentation.fields import REQUIRED, Choice, Field, fields, in_words, subgroup
from crane_sim.files.catalogue import scene_files
from crane_sim.files.output import write_output
from crane_sim.files.yaml_text import DEEPEST, LARGEST_FILE, MOST_VALUES
from crane_sim.laws import law_names, law_of
from crane_sim.scenes.registry import ALL_SCHEMAS, FALLS_SCHEMAS
from crane_sim.scenes.schema.hardware import HardwareGroups

COMMAND = "crane describe --save docs"
HEAD = f"""# The format of scene files

Written by `{COMMAND}` from the classes that read the files.

A scene is a YAML file with the groups of keys below; `crane check FILE` reads one, `crane run FILE` runs it, and
`--set group.key=value` changes a key for one run. A group that is absent is not modelled: no state, no parameter, no
cost. A key that is `null` is as good as absent. Unknown keys, keys that stand twice and values out of range are
refused in one line that names the key, its value and what is possible. A YAML file has at
most {LARGEST_FILE / 1e6:g} MB and {MOST_VALUES:,} keys and values (those of an alias count wherever it stands), with
groups nested {DEEPEST} deep; measured motions and tables are CSV files of any size.

An editor completes and explains keys by the JSON schema `config/scene.schema.json` (`crane describe --schema` prints
it), such as with a first line `# yaml-language-server: $schema=PATH/config/scene.schema.json`.

In the tables `required` has no default, `–` means that a key may be left out, and `-` is a number without a unit.
*joint's unit* and *effort's unit* are those of the joint, *parameter's unit* that of the key that is drawn,
*input's unit* that of what an input drives, *state's unit* that of each component of the integrated state,
*coordinate's unit* that of what a path is of: m, or rad of joints that turn. Places and paths are in the axes of the
base. A file that a scene names is looked for beside the scene.

**Where a model stops being valid** (a slack rigid link, a limit of travel, a hoisted link that is wound up) the run
ends with the time, the cause and what to change, and exit code 1; the recording up to there is whole. Scenes
`overhead_slack` and `overhead_limits` show it. A fixed step that the stiffest motion cannot bear is refused with the
largest safe one.
"""  # noqa: E501
TITLES = {
    "knuckle": "Knuckle crane",
    "tower": "Tower crane",
    "mobile": "Mobile crane",
    "bridge": "Bridge crane with hook and sling",
    "gantry": "Gantry crane",
    "overhead": "Overhead crane",
    "pendulum": "Pendulum",
}
TITLES |= {f"{crane} with falls": f"{TITLES[crane]} with falls" for crane in FALLS_SCHEMAS}
EXAMPLES = {
    "knuckle": "knuckle_setpoint",
    "tower": "tower_gust",
    "mobile": "mobile_lift",
    "bridge": "bridge_hook_and_sling",
    "gantry": "port_sts_container",
    "overhead": "overhead_hoist_energy",
    "pendulum": "pendulum_offshore",
    "tower with falls": "tower_set_down",
}
"""An example scene of the catalogue for each kind of crane; the others with falls are written as
the tower's."""
NAMED = 3  # cranes at most in a heading
HEADS = "| key | value | unit | default | |\n|---|---|---|---|---|"


class Section(NamedTuple):
    """A group, or a Choice, the keys that lead to it, and the cranes whose files have them."""

    group: Any
    keys: list[str]
    cranes: list[str]

    @property
    def title(self) -> str:
        """The keys as a heading, with the cranes' names where not all cranes have them.

        Of many cranes only the first one is named.
        """
        keys = ", ".join(f"`{key}`" for key in self.keys)
        names = [TITLES[crane] for crane in self.cranes]
        cranes = " and ".join(
            names if len(names) <= NAMED else (names[0], f"{len(names) - 1} others")
        )
        return keys if len(self.cranes) == len(ALL_SCHEMAS) else f"{cranes}: {keys}"


def scene_format() -> str:
    """Return the page in Markdown."""
    schemas = {crane: list(fields(schema)) for crane, schema in ALL_SCHEMAS.items()}
    common = [
        field for field in schemas["knuckle"] if all(field in own for own in schemas.values())
    ]
    # these are inherited, hence first
    common.sort(key=lambda field: field.key in HardwareGroups.model_fields)
    sections = sections_of(schemas)
    links = {_identity(section.group): section.title for section in sections}
    shared = [section for section in sections if len(section.cranes) == len(ALL_SCHEMAS)]
    lines = [
        HEAD,
        *signs.section(),
        "## Every crane\n",
        _write_fields(common, links),
        "",
        *_write_sections(shared, links),
    ]
    for crane, schema in ALL_SCHEMAS.items():
        own = [
            section for section in sections if section not in shared and section.cranes[0] == crane
        ]
        keys = [field for field in schemas[crane] if field not in common]
        lines += [f"## {TITLES[crane]}\n", _docstring(schema), "", *_example(EXAMPLES.get(crane))]
        lines += [_write_fields(keys, links), "", *_write_sections(own, links)]
    return re.sub(r"\n{3,}", "\n\n", "\n".join([*lines, *_laws()])).rstrip() + "\n"


def save_scene_format(folder: str) -> None:
    """Write the page into a folder.

    Raises:
        SceneError: the folder cannot be written.
    """
    write_output(
        "--save", Path(folder, "scene_format.md"), lambda path: path.write_text(scene_format())
    )


def _identity(group: Any) -> Any:
    return (group.key, *group.kinds.values()) if isinstance(group, Choice) else group


def sections_of(schemas: dict[str, list[Field]]) -> list[Section]:
    """Return a section for each group that the keys of some cranes lead to, outer ones first."""
    sections: dict[Any, Section] = {}

    def visit(keys: list[Field], path: str, crane: str) -> None:
        for field in keys:
            group, name = subgroup(field.annotation), f"{path}{field.key}"
            if group is None:
                continue
            section = sections.setdefault(_identity(group), Section(group, [], []))
            section.keys.extend([name] if name not in section.keys else [])
            section.cranes.extend([crane] if crane not in section.cranes else [])
            for kind in group.kinds.values() if isinstance(group, Choice) else (group,):
                visit(list(fields(kind)), f"{name}.", crane)

    for crane, keys in schemas.items():
        visit(keys, "", crane)
    return list(sections.values())


def _example(name: str | None) -> list[str]:
    if name is None:
        return []
    return [
        f"`{name}` of the catalogue:",
        "",
        "```yaml",
        scene_files()[name].read_text().rstrip(),
        "```",
        "",
    ]


def _write_sections(sections: list[Section], links: dict[Any, str]) -> Iterator[str]:
    for section in sections:
        yield f"### {section.title}\n"
        if NAMED < len(section.cranes) < len(ALL_SCHEMAS):
            yield f"Of: {', '.join(TITLES[crane] for crane in section.cranes)}.\n"
        if isinstance(section.group, Choice):
            yield (
                f"`{section.group.key}` is one of "
                f"{', '.join(f'`{name}`' for name in section.group.kinds)}.\n"
            )
            for name, kind in section.group.kinds.items():
                yield f"**`{section.group.key}: {name}`** {_docstring(kind)}\n"
                yield _write_fields(list(fields(kind)), links) + "\n"
        else:
            yield f"{_docstring(section.group)}\n"
            yield _write_fields(list(fields(section.group)), links) + "\n"


def _docstring(group: Any) -> str:
    """Return the docstring of a class."""
    return inspect.cleandoc(group.__doc__ or "")


def _write_fields(keys: list[Field], links: dict[Any, str]) -> str:
    return "\n".join([HEADS, *(_write_field(field, links) for field in keys)]) if keys else ""


def _write_field(field: Field, links: dict[Any, str]) -> str:
    group, words = subgroup(field.annotation), in_words(field.annotation)
    title = links.get(_identity(group)) if group is not None else None
    if title is not None:
        words = re.sub("groups?", lambda word: f"[{word[0]}](#{anchor(title)})", words, count=1)
    text = field.text.replace("|", "\\|")
    return (
        f"| `{field.key}` | {words} | {field.unit} | {default_in_words(field.default)} | {text} |"
    )


def anchor(title: str) -> str:
    """Return the anchor that a heading has in rendered Markdown."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def default_in_words(value: Any) -> str:
    """Return a default as a file would have it."""
    if value is REQUIRED:
        return "required"
    if value is None or value in ({}, (), "", inf):
        return "–"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"{value:g}"
    if isinstance(value, str):
        return f"`{value}`"
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return f"[{', '.join(map(default_in_words, value))}]"
    return _group_in_words(value)


def _group_in_words(value: Any) -> str:
    """Return the keys that a group has when it is left out."""
    own = [(field.key, field.default) for field in fields(type(value))]
    defaults = [
        f"{key}: {default_in_words(default)}"
        for key, default in own
        if default not in (None, REQUIRED)
    ]
    name = {"DOP853": "method: dop853", "Constant": "kind: constant"}.get(type(value).__name__)
    words = ", ".join([*([name] if name else []), *(text.replace("`", "") for text in defaults)])
    return f"`{{{words}}}`" if words else "–"


def _laws() -> Iterator[str]:
    """Yield the lines on the installed laws and their settings."""
    yield "## Laws\n"
    yield (
        "The keys of `control` beside `law`, `period` and `nominal` are those of the law; `null` "
        "may be a choice.\n"
    )
    described: dict[Any, str] = {}
    for name in law_names():
        law = law_of(name)
        yield f"### `control` with `law: {name}`\n\n{law.about}\n"
        for where, kind in law.settings.items():
            yield from _law_settings(name, where, kind, described)


def _law_settings(law: str, where: str, kind: Any, described: dict[Any, str]) -> Iterator[str]:
    if kind in described:
        yield f"**`{where}`**: as with `law: {described[kind]}`.\n"
        return
    described[kind] = law
    yield f"**`{where}`** {_docstring(kind)}\n"
    yield _write_fields(list(fields(kind)), {}) + "\n"
    for field in fields(kind):
        group = subgroup(field.annotation)
        if group is not None and not isinstance(group, Choice):
            yield from _law_settings(law, f"{where}.{field.key}", group, described)
