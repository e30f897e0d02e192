"""Random mutations of scene files: a document's entries, changes to them, and new values."""

import copy
from collections.abc import Callable, Iterator
from typing import Any

from hypothesis import strategies as st

from crane_sim.files.catalogue import scene_files
from crane_sim.files.document import read

NAMES = sorted(scene_files())
DOCUMENTS = [read(name) for name in NAMES]
TEXTS = [scene_files()[name].read_text() for name in NAMES]

NUMBERS = st.sampled_from(
    [0, 1, -1, 2, 3, 0.5, -0.5, 1e-3, 1e3, 1e-300, 5e-324, 1e18, 1e300, -1e300, 2**63, 10**400]
)
ODD = st.sampled_from(
    [
        float("nan"),
        float("inf"),
        float("-inf"),
        True,
        False,
        None,
        "",
        "45 deg",
        "e",
        "nan",
        "1e999",
    ]
)
TEXT = st.text(max_size=12) | st.sampled_from(["k" * 3000, "no name,\nbut a line: [and another]"])
JUNK = st.recursive(
    NUMBERS | ODD | TEXT | st.integers() | st.floats() | st.dates() | st.binary(max_size=4),
    lambda inner: (
        st.lists(inner, max_size=7)
        | st.dictionaries(TEXT | st.integers() | st.none(), inner, max_size=4)
    ),
    max_leaves=12,
)


def make_nested(depth: int) -> Any:
    """Return lists and groups in each other, `depth` levels of them."""
    value: Any = 1.0
    for level in range(depth):
        value = [value] if level % 2 else {"kind": value}
    return value


def list_entries(node: Any) -> Iterator[tuple[Any, Any]]:
    """Yield (container, key) of every entry of a document, the inner ones too."""
    keys = (
        list(node) if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    )
    for key in keys:
        yield node, key
        yield from list_entries(node[key])


def delete(box: Any, key: Any, _: Any) -> None:
    """Delete an entry."""
    del box[key]


def replace(box: Any, key: Any, value: Any) -> None:
    """Replace an entry's value."""
    box[key] = value


def duplicate(box: Any, key: Any, _: Any) -> None:
    """Duplicate an entry of a list, or of a group under an unknown key."""
    if isinstance(box, list):
        box.insert(key, copy.deepcopy(box[key]))
    else:
        box[f"{key}s"] = copy.deepcopy(box[key])


def negate(box: Any, key: Any, _: Any) -> None:
    """Change the sign of a number, the value of a switch."""
    box[key] = -box[key] if type(box[key]) in (int, float) else not box[key]


def scale(box: Any, key: Any, value: Any) -> None:
    """Multiply a number, or replace it."""
    both = type(box[key]) is float and type(value) is float
    box[key] = box[key] * value if both else value


def wrap(box: Any, key: Any, _: Any) -> None:
    """Wrap the value in a list."""
    box[key] = [box[key]]


def quote(box: Any, key: Any, _: Any) -> None:
    """Make text of the value."""
    box[key] = str(box[key]) if type(box[key]) in (float, bool) else "text"


def repeat(box: Any, key: Any, _: Any) -> None:
    """Make a long list of the value."""
    box[key] = (box[key] * 50)[:2000] if isinstance(box[key], list) else [box[key]] * 1001


def nest_deeply(box: Any, key: Any, _: Any) -> None:
    """Replace the value by lists and groups thousands of levels deep."""
    box[key] = make_nested(3000)


def transplant(box: Any, key: Any, value: Any) -> None:
    """Replace the value by that of the same key of some other scene, where one has it."""
    others = [
        container[name]
        for document in DOCUMENTS
        for container, name in list_entries(document)
        if name == key
    ]
    if others:
        box[key] = copy.deepcopy(others[len(str(type(value))) * 7 % len(others)])


MUTATIONS: list[Callable[[Any, Any, Any], None]] = [
    *(delete, replace, replace, replace, scale, duplicate, negate),
    *(wrap, quote, repeat, nest_deeply, transplant),
]
MUTATION = st.tuples(st.sampled_from(MUTATIONS), st.integers(0, 10**6), NUMBERS | ODD | JUNK)


def mutate(
    document: dict[str, Any], mutations: list[tuple[Callable[..., None], int, Any]]
) -> dict[str, Any]:
    """Return a copy with every mutation applied, each at the entry of its number.

    Deep nesting comes last, and once.
    """
    document = copy.deepcopy(document)
    others, deep = (
        [m for m in mutations if (m[0] is nest_deeply) == is_deep] for is_deep in (False, True)
    )
    for mutation, number, value in others + deep[:1]:  # `list_entries` cannot recurse so deep
        entries = list(list_entries(document))
        if entries:
            mutation(*entries[number % len(entries)], value)
    return document
