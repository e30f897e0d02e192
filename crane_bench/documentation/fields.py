"""The fields of a group of a scene file, as its class declares them.

A field has a key, a type, a unit, a default and a description.

A unit and a description stand where a field is declared, in the comment behind it, `unit,
description`, and in comment lines that follow. A group is a pydantic model or a NamedTuple; its
docstring describes the group.
"""

import ast
import inspect
import io
import textwrap
import tokenize
import types
from functools import cache
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin, get_type_hints

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from crane_sim.files.types import to_radians
from crane_sim.scenes.schema.groups import WORDS, InlineUnion

UNITS = frozenset(
    """-|s|Hz|1/s|1/s²|m|m²|m/s|m/s²|m/s³|s/m|m²/s²|rad|rad/s|kg|kg/m|kg/m³|kg m²|N|N/m|N s/m|N m|N m/rad|N m s|N m s²|
    N m s/rad|joint's unit|parameter's unit|joint's unit/s|joint's unit/s²|
    joint's unit/s³|command's unit|effort's unit|effort's unit/s|effort's unit s/joint's unit|
    effort's unit s²/joint's unit|effort's unit/joint's unit|rad/joint's unit|input's unit|state's unit|
    coordinate's unit|coordinate's unit/s|coordinate's unit/s²|coordinate's unit/s³""".replace(  # noqa: E501
        "\n    ", ""
    ).split("|")
)
"""Units before the comma of a comment; `-` is a number without a unit."""


HUGE = 1e15  # larger bounds only keep numbers within the machine's range


class Field(NamedTuple):
    """A key of a group."""

    key: str
    annotation: Any  # with the metadata of `Annotated`
    unit: str  # "" where nothing is measured: text, a choice, a group
    default: Any  # REQUIRED where there is none
    text: str


class Choice(NamedTuple):
    """A group whose other keys depend on the value of one."""

    key: str
    kinds: dict[str, Any]  # NamedTuples by the value


REQUIRED = object()


@cache
def fields(group: Any) -> tuple[Field, ...]:
    """Return the keys of a pydantic model or a NamedTuple, in the order of their declaration."""
    hints, descriptions = get_type_hints(group, include_extras=True), comments(group)
    words = {field: word for word, field in WORDS.items()} if hasattr(group, "_fields") else {}
    declared, names = (
        list[Field](),
        list[str](getattr(group, "model_fields", getattr(group, "_fields", ()))),
    )
    for name in names:
        unit, text = split_comment(descriptions.get(name, ""))
        inline = next(
            (part for part in strip_annotated(hints[name])[1] if isinstance(part, InlineUnion)),
            None,
        )
        key = words.get(name, name) if inline is None else inline.choice[0]
        declared.append(Field(key, hints[name], unit, default(group, name), text))
    return tuple(declared)


def default(group: Any, name: str) -> Any:
    """Return the default of a field, REQUIRED where it has none."""
    if isinstance(group, type) and issubclass(group, BaseModel):
        field = group.model_fields[name]
        return REQUIRED if field.is_required() else field.get_default()
    return group._field_defaults.get(name, REQUIRED)


def split_comment(comment: str) -> tuple[str, str]:
    """Return (unit, description) of a comment; the unit is empty where the comment names none."""
    if comment in UNITS:
        return comment, ""
    for mark in (", ", "; "):
        head, separator, rest = comment.partition(mark)
        if separator and head in UNITS:
            return head, rest
    return "", comment


def comments(group: Any) -> dict[str, str]:
    """Return by field the descriptions, or the comments behind fields, of a class and its bases."""
    texts: dict[str, str] = {}
    for base in reversed(group.__mro__):
        declared = vars(base).get("__pydantic_fields__", {})
        texts |= {name: field.description for name, field in declared.items() if field.description}
        if base.__module__.startswith(("crane_sim", "crane_control")) or issubclass(
            base, BaseModel | tuple
        ):
            texts |= _own_comments(base)
    return texts


@cache
def _own_comments(group: type) -> dict[str, str]:
    if group in (BaseModel, tuple, object) or group.__module__ == "builtins":
        return {}
    try:
        source = textwrap.dedent(inspect.getsource(group))
    except (OSError, TypeError):  # made by `create_model`: its fields have their descriptions
        return {}
    tokens = list(tokenize.generate_tokens(io.StringIO(source).readline))
    lines = {
        token.start[0]: token.string.lstrip("# ")
        for token in tokens
        if token.type == tokenize.COMMENT
    }
    body = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.AnnAssign)]
    busy = {
        line for node in body for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    texts = {}
    for node in body:
        if isinstance(node.target, ast.Name):
            line = node.end_lineno or node.lineno
            text = [lines[inner] for inner in range(node.lineno, line) if inner in lines]
            if text and line not in lines:
                line += 1  # behind the bracket that a long default stands in
            while line in lines and (not text or line not in busy):
                text.append(lines[line])
                line += 1
            texts[node.target.id] = " ".join(text)
    return texts


def strip_annotated(annotation: Any) -> tuple[Any, list[Any]]:
    """Return (type, metadata) of an annotation, None of a union and `Annotated` taken off."""
    metadata: list[Any] = []
    while True:
        if get_origin(annotation) is Annotated:
            annotation, *more = get_args(annotation)
            metadata = [*more, *metadata]
        elif get_origin(annotation) in (Union, types.UnionType):
            kinds = [kind for kind in get_args(annotation) if kind is not type(None)]
            if len(kinds) != 1:
                return annotation, metadata
            annotation = kinds[0]
        else:
            return annotation, metadata


def choice(annotation: Any) -> Choice | None:
    """Return the choice of an annotation, None without one."""
    for part in strip_annotated(annotation)[1]:
        declared = getattr(getattr(part, "func", part), "choice", None)
        if declared is not None:
            return Choice(*declared)
    return None


def subgroup(annotation: Any) -> Any:
    """Return the group or Choice that an annotation has, alone, in a list or by name, or None."""
    union = choice(annotation)
    if union is not None:
        return union
    kind, _ = strip_annotated(annotation)
    if get_origin(kind) is tuple:
        return next(filter(None, map(subgroup, get_args(kind))), None)
    if get_origin(kind) is dict:
        return subgroup(get_args(kind)[1])
    return (
        kind
        if isinstance(kind, type) and (hasattr(kind, "_fields") or issubclass(kind, BaseModel))
        else None
    )


def in_words(annotation: Any) -> str:
    """Return the possible values of a type, in words."""
    union = choice(annotation)
    if union is not None:
        names = " \\| ".join(f"`{name}`" for name in union.kinds)
        inline = any(isinstance(part, InlineUnion) for part in strip_annotated(annotation)[1])
        return names if inline else f"group with `{union.key}`"
    kind, metadata = strip_annotated(annotation)
    if get_origin(kind) is Literal:
        return " \\| ".join(f"`{value}`" for value in get_args(kind))
    if get_origin(kind) is tuple:
        return _list_in_words(get_args(kind))
    if get_origin(kind) in (Union, types.UnionType):
        return " or ".join(
            dict.fromkeys(map(in_words, (k for k in get_args(kind) if k is not type(None))))
        )
    if get_origin(kind) is dict:
        inner = subgroup(annotation)
        return "groups by name" if inner is not None else "group of any keys"
    if subgroup(annotation) is not None:
        return "group"
    if any(getattr(part, "func", None) is to_radians for part in metadata):
        return "angle" + _format_range(metadata)
    names = {float: "number", int: "whole number", bool: "true or false", str: "text"}
    return names.get(kind, "number or text") + (
        _format_range(metadata) if kind in (float, int) else ""
    )


def _list_in_words(kinds: tuple[Any, ...]) -> str:
    if kinds[-1] is ...:
        return f"list: {in_words(kinds[0])}"
    words = [in_words(kind) for kind in kinds]
    return f"list of {len(words)}: {words[0] if len(set(words)) == 1 else ', '.join(words)}"


def _format_range(metadata: list[Any]) -> str:
    """Return the bounds of a number in words."""
    parts = [
        one
        for part in metadata
        for one in (part.metadata if isinstance(part, FieldInfo) else [part])
    ]
    signs = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
    bounds = {
        sign: getattr(part, name)
        for part in parts
        for name, sign in signs.items()
        if hasattr(part, name)
    }
    if "≥" in bounds:
        bounds.pop(">", None)
    return "".join(f" {sign} {bound:.16g}" for sign, bound in bounds.items() if abs(bound) < HUGE)
