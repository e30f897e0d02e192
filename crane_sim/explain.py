"""Mistakes in scene files, each told in one line: the culprit, its value, and what is possible."""

import difflib
import types
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError


class SceneError(ValueError):
    """A scene that cannot be used; the message is one line for the person who wrote it."""


def unknown_key(key: str, known: Iterable[str], what: str = "key") -> str:
    """Return a line on an unknown key (or whatever it is), with the nearest known one."""
    names = list(known)
    near = difflib.get_close_matches(key, names, n=1, cutoff=0.5)
    return (
        f"unknown {what} {key!r}" + (f", did you mean {near[0]!r}?" if near else "") + f" (known: {', '.join(names)})"
    )


def one_line(error: ValidationError, kind: type, group: tuple[str, ...] = ()) -> str:
    """Return the first mistake of a validation of `kind`, which stands in `group`, as one line."""
    first = error.errors()[0]
    inside, message = first["loc"], first["msg"].removeprefix("Value error, ")
    where = (*group, *inside)
    if first["type"] in ("extra_forbidden", "unexpected_keyword_argument"):
        return _at(where[:-1], unknown_key(str(where[-1]), _fields(kind, inside[:-1])))
    if first["type"] == "missing" and isinstance(where[-1], int):
        return _at(where[:-1], f"has {len(first['input'])} values, too few: {_shorten(first['input'])}")
    if first["type"] == "missing":
        return _at(where, "is missing")
    if first["type"] == "too_long":
        context = first.get("ctx", {})
        return _at(where, f"has {context['actual_length']} values, at most {context['max_length']} are possible")
    if first["type"] == "value_error" and (message.startswith("unknown key") or isinstance(first["input"], dict)):
        return _at(where, message)
    message = message.replace("Input should be", "must be").replace("a valid number, unable to parse string as ", "")
    return _at(where, f"= {_shorten(first['input'])}: {message}", joint=" ")


def _at(where: Sequence[int | str], message: str, joint: str = ": ") -> str:
    path = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in where).lstrip(".")
    return f"{path}{joint}{message}" if path else message


def _shorten(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _fields(kind: Any, where: Sequence[int | str]) -> Sequence[str]:
    """Return the names of the fields of the group at `where` inside `kind`."""
    for part in where:
        if isinstance(part, int):
            kind = get_args(kind)[0]
        elif isinstance(kind, type) and issubclass(kind, BaseModel):
            kind = kind.model_fields[str(part)].annotation
        else:
            kind = kind.__annotations__[str(part)]
        while get_origin(kind) in (Annotated, Union, types.UnionType):
            kind = next(k for k in get_args(kind) if k is not type(None))
    return tuple(kind.model_fields) if issubclass(kind, BaseModel) else kind._fields
