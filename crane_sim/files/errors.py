"""Errors in scene files, each in one line: the offending key, its value, and the possible ones."""

import difflib
import re
import types
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

_KINDS = ("float", "int", "str", "bool", "tuple", "none")
"""Names of plain types in the locations of pydantic's errors, where a value may be of several
types."""
_PHRASES = {
    ", unable to parse string as a number": "",
    ", unable to parse string as an integer": "",
    ", unable to interpret input": "",
    "a valid integer, got a number with a fractional part": "a whole number",
    "a valid integer": "a whole number",
    "a valid number": "a number",
    "a valid boolean": "true or false",
    "a valid string": "text",
    "a valid tuple": "a list",
    "a valid list": "a list",
}
"""Phrases of pydantic, and those that replace them."""
_FOREIGN = ("extra_forbidden", "unexpected_keyword_argument")
_NO_GROUP = (
    "model_type",
    "dict_type",
    "model_attributes_type",
    "named_tuple_type",
    "dataclass_type",
    "mapping_type",
)


# characters of a file's path, or of an error of another package, that a message has at most
PATH = 300
_NEAR = 0.65  # of difflib: least similarity of a word to a suggestion; "cable" and "crane" have 0.6


class RenameWarning(FutureWarning):
    """Warning of a name in a file or a command that has a new one; the next release refuses it."""


class SceneError(ValueError):
    """A scene that cannot be used; the message is one line with key, value and what is possible."""


def unknown_key(key: str, known: Iterable[str], what: str = "key", of: str = "") -> str:
    """Return a line on an unknown key, or other `what`, `of` something, with the nearest one."""
    names = list(known)
    line = f"unknown {what} {shorten(key)}{' ' * bool(of)}{of}"
    return f"{line}{did_you_mean(key, names)} (known: {', '.join(names)})"


def nearest(word: str, words: Iterable[Any]) -> str | None:
    """Return the most similar of the words, None without a similar one."""
    return next(
        iter(difflib.get_close_matches(word, list(map(str, words)), n=1, cutoff=_NEAR)), None
    )


def did_you_mean(word: str, words: Iterable[str]) -> str:
    """Return ", did you mean ...?" with the nearest of the words, or an empty text without one."""
    suggestion = nearest(word, words)
    return f", did you mean {suggestion!r}?" if suggestion else ""


def missing_key(key: str, keys: Iterable[Any], choices: Iterable[str]) -> str:
    """Return a line on a missing key, or on one with a similar name, with its possible values."""
    names, suggestion = ", ".join(choices), nearest(key, keys)
    return (
        f"unknown key {suggestion!r}, did you mean {key!r}? ({key}: {names})"
        if suggestion
        else f"{key} is missing; possible: {names}"
    )


def foreign_path(error: ValidationError) -> tuple[str, ...]:
    """Return where an unknown key stands, by group, if it is a validation's first mistake."""
    first, _ = _deepest(error.errors())
    return tuple(map(str, _readable_location(first["loc"]))) if first["type"] in _FOREIGN else ()


def one_line(error: ValidationError, kind: type, group: tuple[str, ...] = ()) -> str:
    """Return the first mistake of a validation of `kind`, which stands in `group`, as one line."""
    first, message = _deepest(error.errors())
    inside = first["loc"] if first["type"] in _FOREIGN else _readable_location(first["loc"])
    where = (*group, *inside)
    if first["type"] in _FOREIGN:
        return _at(where[:-1], unknown_key(str(where[-1]), fields_at(kind, inside[:-1])))
    if first["type"] == "missing" and isinstance(where[-1], int):
        return _at(
            where[:-1], f"has {len(first['input'])} values, too few: {shorten(first['input'])}"
        )
    if first["type"] == "missing":
        return _missing(first, where, fields_at(kind, inside[:-1]))
    if first["type"] == "too_long":
        context = first.get("ctx", {})
        return _at(
            where,
            f"has {context['actual_length']} values, at most {context['max_length']} are possible",
        )
    if first["type"] == "value_error" and (
        message.startswith("unknown key") or isinstance(first["input"], dict)
    ):
        return _at(where, message)
    if first["type"] in _NO_GROUP:
        message = no_group(fields_at(kind, inside))
    return _at(where, f"= {shorten(first['input'])}: {message}", joint=" ")


def _missing(first: Any, where: Sequence[int | str], fields: Sequence[str]) -> str:
    """Return the line on a missing key of a group, or on one with a similar name."""
    keys = getattr(first["input"], "kwargs", first["input"])
    unknown_keys = [key for key in keys if key not in fields] if isinstance(keys, Mapping) else []
    suggestion = nearest(str(where[-1]), unknown_keys)
    return (
        _at(where[:-1], unknown_key(suggestion, fields)) if suggestion else _at(where, "is missing")
    )


def about_keys(error: ValidationError) -> bool:
    """Return whether the error is one of keys, whose message needs the type of their group."""
    return error.errors()[0]["type"] in (*_FOREIGN, *_NO_GROUP)


def no_group(keys: Iterable[str] = ()) -> str:
    """Return the message for a value in place of a group of keys."""
    return "must be a group of keys" + (f": {', '.join(keys)}" if keys else "")


def _readable_location(where: Sequence[int | str]) -> tuple[int | str, ...]:
    """Return the location without pydantic's names of the kinds that a value may have."""
    return tuple(
        part for part in where if isinstance(part, int) or not ("[" in part or part in _KINDS)
    )


def _deepest(errors: Sequence[Any]) -> tuple[Any, str]:
    """Return (first mistake, its message); of a value of several kinds each one's requirement.

    The nearest kind is the one with the deepest location, or whose bounds the value violates.
    """
    location = _readable_location(errors[0]["loc"])
    same = [e for e in errors if _readable_location(e["loc"])[: len(location)] == location]
    same = [
        e
        for e in same
        if len(_readable_location(e["loc"])) == max(len(_readable_location(e["loc"])) for e in same)
    ]
    same = [
        e for e in same if not e["type"].endswith(("_type", "_parsing", "literal_error"))
    ] or same
    if len(same[0]["loc"]) == len(_readable_location(same[0]["loc"])):
        same = same[:1]
    words = [_expected_words(e) for e in same]
    return same[0], " or ".join([words[0], *(word.removeprefix("must be ") for word in words[1:])])


def _expected_words(error: Any) -> str:
    """Return the requirement that a value violates, in words."""
    if error["type"] == "too_short":
        count = error["ctx"]["min_length"]
        what = "point" if error["loc"][-1:] == ("points",) else "value"
        return f"needs at least {'one' if count == 1 else count} {what}{'' if count == 1 else 's'}"
    message = error["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    for phrase, replacement in _PHRASES.items():
        message = message.replace(phrase, replacement)
    return message


def _at(where: Sequence[int | str], message: str, joint: str = ": ") -> str:
    path = "".join(
        f"[{part}]" if isinstance(part, int) else f".{one_word(part)}" for part in where
    ).lstrip(".")
    return f"{path}{joint}{message}" if path else message


def one_word(name: Any, most: int = 60) -> str:
    """Return a name as it is, or shortened if longer than `most` characters or over a line."""
    return (
        name
        if isinstance(name, str) and name.isprintable() and len(name) <= most
        else shorten(name, most)
    )


def join_lines(error: object) -> str:
    """Return the text of an error of another package as one line."""
    return _cut(" ".join(str(error).split()), PATH)


def shorten(value: Any, most: int = 60) -> str:
    """Return a value as a text of at most `most` characters for a message, without line breaks."""
    try:
        text = re.sub(r"\s*\n\s*", " ", repr(value))
    except (ValueError, RecursionError) as error:
        # an integer of thousands of digits; groups in groups in groups
        return f"{type(value).__name__} ({error})"
    return _cut(text, most)


def _cut(text: str, most: int) -> str:
    """Return a text of at most `most` characters."""
    return text if len(text) <= most else text[: most - 3] + "..."


def fields_at(kind: Any, where: Sequence[int | str]) -> Sequence[str]:
    """Return the names of fields of the group at `where` in `kind`, none where files choose it."""
    for part in where:
        fields = kind.model_fields if isinstance(kind, type) and issubclass(kind, BaseModel) else {}
        if isinstance(part, int):
            kind = next(iter(get_args(kind)), None)
        elif get_origin(kind) is dict:
            kind = get_args(kind)[1]
        else:
            kind = (
                fields[part].annotation
                if part in fields
                else getattr(kind, "__annotations__", {}).get(part)
            )
        while get_origin(kind) in (Annotated, Union, types.UnionType):
            kind = next(k for k in get_args(kind) if k is not type(None))
    return tuple(getattr(kind, "model_fields", getattr(kind, "_fields", ())))
