"""Scene files mutilated at random: the places of a document, what can be done to them, and the values put there."""

import copy
from collections.abc import Callable, Iterator
from typing import Any

from hypothesis import strategies as st
from numba.core import event

from crane_sim.files.catalogue import scene_files
from crane_sim.files.document import read

NAMES = sorted(scene_files())
DOCUMENTS = [read(name) for name in NAMES]
TEXTS = [scene_files()[name].read_text() for name in NAMES]

NUMBERS = st.sampled_from([0, 1, -1, 2, 3, 0.5, -0.5, 1e-3, 1e3, 1e-300, 5e-324, 1e18, 1e300, -1e300, 2**63, 10**400])
ODD = st.sampled_from([float("nan"), float("inf"), float("-inf"), True, False, None, "", "45 deg", "e", "nan", "1e999"])
TEXT = st.text(max_size=12)
JUNK = st.recursive(
    NUMBERS | ODD | TEXT | st.integers() | st.floats() | st.dates() | st.binary(max_size=4),
    lambda inner: st.lists(inner, max_size=7) | st.dictionaries(TEXT | st.integers() | st.none(), inner, max_size=4),
    max_leaves=12,
)


def nested(depth: int) -> Any:
    """Return lists and groups in each other, `depth` levels of them."""
    value: Any = 1.0
    for level in range(depth):
        value = [value] if level % 2 else {"kind": value}
    return value


def places(node: Any) -> Iterator[tuple[Any, Any]]:
    """Yield (container, key) of every entry of a document, the inner ones too."""
    keys = list(node) if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    for key in keys:
        yield node, key
        yield from places(node[key])


def deleted(box: Any, key: Any, _: Any) -> None:
    """Leave an entry out."""
    del box[key]


def replaced(box: Any, key: Any, value: Any) -> None:
    """Put something else in its place."""
    box[key] = value


def doubled(box: Any, key: Any, _: Any) -> None:
    """Give a list an entry more, a group a key that nobody knows."""
    if isinstance(box, list):
        box.insert(key, copy.deepcopy(box[key]))
    else:
        box[f"{key}s"] = copy.deepcopy(box[key])


def negated(box: Any, key: Any, _: Any) -> None:
    """Turn the sign of a number, the sense of a switch."""
    box[key] = -box[key] if type(box[key]) in (int, float) else not box[key]


def scaled(box: Any, key: Any, value: Any) -> None:
    """Multiply a number, or put another one in its place."""
    both = type(box[key]) is float and type(value) is float
    box[key] = box[key] * value if both else value


def wrapped(box: Any, key: Any, _: Any) -> None:
    """Make a list of it."""
    box[key] = [box[key]]


def quoted(box: Any, key: Any, _: Any) -> None:
    """Make text of it."""
    box[key] = str(box[key]) if type(box[key]) in (float, bool) else "text"


def repeated(box: Any, key: Any, _: Any) -> None:
    """Make a long list of it."""
    box[key] = (box[key] * 50)[:2000] if isinstance(box[key], list) else [box[key]] * 1001


def buried(box: Any, key: Any, _: Any) -> None:
    """Put it at the bottom of a deep shaft."""
    box[key] = nested(3000)


def transplanted(box: Any, key: Any, value: Any) -> None:
    """Put there what stands in some other scene under the same key, where one has it."""
    others = [there[name] for document in DOCUMENTS for there, name in places(document) if name == key]
    if others:
        box[key] = copy.deepcopy(others[len(str(type(value))) * 7 % len(others)])


MUTATIONS: list[Callable[[Any, Any, Any], None]] = [
    *(deleted, replaced, replaced, replaced, scaled, doubled, negated),
    *(wrapped, quoted, repeated, buried, transplanted),
]
MUTATION = st.tuples(st.sampled_from(MUTATIONS), st.integers(0, 10**6), NUMBERS | ODD | JUNK)


def mutilated(document: dict[str, Any], mutations: list[tuple[Callable[..., None], int, Any]]) -> dict[str, Any]:
    """Return a copy with every mutation done, each at the place that its number picks; a shaft, if any, comes last."""
    document = copy.deepcopy(document)
    others, shafts = ([m for m in mutations if (m[0] is buried) == deep] for deep in (False, True))
    for mutate, number, value in others + shafts[:1]:  # nothing of ours walks down a shaft
        found = list(places(document))
        if found:
            mutate(*found[number % len(found)], value)
    return document


class Compilations(event.Listener):
    """Counts what numba compiles."""

    number = 0

    def on_start(self, event: Any) -> None:
        """Count."""
        self.number += 1

    def on_end(self, event: Any) -> None:
        """Do nothing."""
