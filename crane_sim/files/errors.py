"""Errors in scene files, each in one line: the culprit, its value, and what is possible."""

import difflib
import types
from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError

_KINDS = ("float", "int", "str", "bool", "tuple", "none")
"""Names of plain types in the locations of pydantic's errors, where a value may be of several types."""
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
_NO_GROUP = ("model_type", "dict_type", "model_attributes_type", "named_tuple_type", "dataclass_type", "mapping_type")


_NEAR = 0.6  # of difflib: the least likeness of a word to what was perhaps meant


class SceneError(ValueError):
    """A scene that cannot be used; the message is one line that names the key, its value and what is possible."""


def unknown_key(key: str, known: Iterable[str], what: str = "key", of: str = "") -> str:
    """Return a line on an unknown key (or whatever it is) `of` something, with the nearest known one."""
    names = list(known)
    line = f"unknown {what} {key!r}{' ' * bool(of)}{of}"
    return f"{line}{meant(key, names)} (known: {', '.join(names)})"


def nearest(word: str, words: Iterable[Any]) -> str | None:
    """Return the one of the words that is most like another one, None where none is like it."""
    return next(iter(difflib.get_close_matches(word, list(map(str, words)), n=1, cutoff=_NEAR)), None)


def meant(word: str, words: Iterable[str]) -> str:
    """Return the question for the nearest of the words, with a comma before it; nothing where none is near."""
    near = nearest(word, words)
    return f", did you mean {near!r}?" if near else ""


def missing_key(key: str, keys: Iterable[Any], choices: Iterable[str]) -> str:
    """Return a line on a key that a group lacks, or has under a name much like it, with the values it may have."""
    names, near = ", ".join(choices), nearest(key, keys)
    return (
        f"unknown key {near!r}, did you mean {key!r}? ({key}: {names})"
        if near
        else f"{key} is missing; possible: {names}"
    )


def foreign_key(error: ValidationError) -> str | None:
    """Return the key that the outermost group does not have, if that is the first mistake of a validation."""
    first = error.errors()[0]
    return str(first["loc"][0]) if first["type"] in _FOREIGN and len(first["loc"]) == 1 else None


def one_line(error: ValidationError, kind: type, group: tuple[str, ...] = ()) -> str:
    """Return the first mistake of a validation of `kind`, which stands in `group`, as one line."""
    first, message = _deepest(error.errors())
    inside = first["loc"] if first["type"] in _FOREIGN else _readable_place(first["loc"])
    where = (*group, *inside)
    if first["type"] in _FOREIGN:
        return _at(where[:-1], unknown_key(str(where[-1]), _fields(kind, inside[:-1])))
    if first["type"] == "missing" and isinstance(where[-1], int):
        return _at(where[:-1], f"has {len(first['input'])} values, too few: {shorten(first['input'])}")
    if first["type"] == "missing":
        return _missing(first, where, _fields(kind, inside[:-1]))
    if first["type"] == "too_long":
        context = first.get("ctx", {})
        return _at(where, f"has {context['actual_length']} values, at most {context['max_length']} are possible")
    if first["type"] == "value_error" and (message.startswith("unknown key") or isinstance(first["input"], dict)):
        return _at(where, message)
    if first["type"] in _NO_GROUP:
        message = no_group(_fields(kind, inside))
    return _at(where, f"= {shorten(first['input'])}: {message}", joint=" ")


def _missing(first: Any, where: Sequence[int | str], fields: Sequence[str]) -> str:
    """Return the line on a key of a group that is missing, or stands there under a name much like it."""
    keys = getattr(first["input"], "kwargs", first["input"])
    spare = [key for key in keys if key not in fields] if isinstance(keys, Mapping) else []
    near = nearest(str(where[-1]), spare)
    return _at(where[:-1], unknown_key(near, fields)) if near else _at(where, "is missing")


def about_keys(error: ValidationError) -> bool:
    """Return whether the error is one of keys, whose message needs the type of their group."""
    return error.errors()[0]["type"] in (*_FOREIGN, *_NO_GROUP)


def no_group(keys: Iterable[str] = ()) -> str:
    """Return the words for a value that stands where a group of keys must."""
    return "must be a group of keys" + (f": {', '.join(keys)}" if keys else "")


def _readable_place(where: Sequence[int | str]) -> tuple[int | str, ...]:
    """Return the place without the names of the kinds that were tried there, where a value may be of several."""
    return tuple(part for part in where if isinstance(part, int) or not ("[" in part or part in _KINDS))


def _deepest(errors: Sequence[Any]) -> tuple[Any, str]:
    """Return the first mistake and its words; of a value that may be of several kinds, what each of them asks.

    The kind that the value comes nearest to is the one that was followed furthest, or was refused for its size.
    """
    place = _readable_place(errors[0]["loc"])
    same = [e for e in errors if _readable_place(e["loc"])[: len(place)] == place]
    same = [e for e in same if len(_readable_place(e["loc"])) == max(len(_readable_place(e["loc"])) for e in same)]
    same = [e for e in same if not e["type"].endswith(("_type", "_parsing", "literal_error"))] or same
    if len(same[0]["loc"]) == len(_readable_place(same[0]["loc"])):
        same = same[:1]
    words = [_expected_words(e) for e in same]
    return same[0], " or ".join([words[0], *(word.removeprefix("must be ") for word in words[1:])])


def _expected_words(error: Any) -> str:
    """Return what a mistake asks for."""
    if error["type"] == "too_short":
        count = error["ctx"]["min_length"]
        what = "point" if error["loc"][-1:] == ("points",) else "value"
        return f"needs at least {'one' if count == 1 else count} {what}{'' if count == 1 else 's'}"
    message = error["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    for pydantic, ours in _PHRASES.items():
        message = message.replace(pydantic, ours)
    return message


def _at(where: Sequence[int | str], message: str, joint: str = ": ") -> str:
    path = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in where).lstrip(".")
    return f"{path}{joint}{message}" if path else message


def one_word(name: Any) -> str:
    """Return a name as it is, or shortened where it would not stand well in a line."""
    return name if isinstance(name, str) and name.isprintable() and len(name) <= 60 else shorten(name)


def shorten(value: Any) -> str:
    """Return a value as a short text for a message."""
    try:
        text = repr(value)
    except (ValueError, RecursionError) as error:  # an integer of thousands of digits; groups in groups in groups
        return f"{type(value).__name__} ({error})"
    return text if len(text) <= 60 else text[:57] + "..."


def _fields(kind: Any, where: Sequence[int | str]) -> Sequence[str]:
    """Return the names of the fields of the group at `where` inside `kind`; none where the file chooses its kind."""
    for part in where:
        fields = kind.model_fields if isinstance(kind, type) and issubclass(kind, BaseModel) else {}
        if isinstance(part, int):
            kind = next(iter(get_args(kind)), None)
        elif get_origin(kind) is dict:
            kind = get_args(kind)[1]
        else:
            kind = fields[part].annotation if part in fields else getattr(kind, "__annotations__", {}).get(part)
        while get_origin(kind) in (Annotated, Union, types.UnionType):
            kind = next(k for k in get_args(kind) if k is not type(None))
    return tuple(getattr(kind, "model_fields", getattr(kind, "_fields", ())))
