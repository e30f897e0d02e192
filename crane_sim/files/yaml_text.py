"""Texts in YAML from anywhere: what they expand to is bounded before it is built."""

from itertools import chain
from math import inf
from pathlib import Path
from stat import S_ISDIR, S_ISREG
from typing import Any

import yaml

from crane_sim.files.errors import shorten

YAML_ERRORS = (OSError, ValueError, AttributeError, LookupError, RecursionError, yaml.YAMLError)
"""Errors of reading YAML: its own, and those of its converters of dates and numbers, which check
little."""
LARGEST_FILE = 1_000_000  # bytes, which take some seconds to read; measured tables are CSV files
MOST_VALUES = 1_000_000  # keys and values, those of an alias counted wherever it stands
DEEPEST = 100  # groups and lists in each other


def check_regular(path: Path) -> None:
    """Raise OSError for a path that is no file or folder: pipes and devices may have no end."""
    mode = path.stat().st_mode
    if not (S_ISREG(mode) or S_ISDIR(mode)):
        raise OSError("is no regular file")


def read_yaml(path: Path, several: bool = False) -> Any:
    """Return the value of a YAML file; arguments of `parse_yaml`.

    Raises:
        YAML_ERRORS: there is none, it is too large, or as of `parse_yaml`.
    """
    check_regular(path)
    if (size := path.stat().st_size) > LARGEST_FILE:
        raise ValueError(f"has {size / 1e6:.3g} MB, at most {LARGEST_FILE / 1e6:g} MB are possible")
    return parse_yaml(path.read_text(), several)


def parse_yaml(text: str, several: bool = False) -> Any:
    """Return the value of a YAML text; where it may have `several` documents, of the first one.

    Raises:
        YAML_ERRORS: it is no YAML, has a key of a group twice, or expands to too much.
    """
    loader = _BoundedLoader(text)
    try:
        if several:
            return loader.get_data() if loader.check_data() else None
        return loader.get_single_data()
    finally:
        loader.dispose()


class _BoundedLoader(yaml.SafeLoader):
    """A YAML loader that rejects texts that expand to too much.

    It also rejects duplicate keys of a group, of which YAML would keep the last one silently.
    """

    def compose_document(self) -> Any:
        """Return the node of a document, whose aliases are not expanded yet."""
        node = super().compose_document()
        _measure(node, {})
        return node

    def compose_mapping_node(self, anchor: Any) -> Any:
        """Return the node of a group as in the file, before `<<` merges groups into it."""
        node = super().compose_mapping_node(anchor)
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        if len(set(keys)) < len(keys):
            key = next(key for key in keys if keys.count(key) > 1)
            raise yaml.constructor.ConstructorError(
                None, None, f"key {shorten(key)} stands twice", node.start_mark
            )
        return node


def _measure(node: Any, measured: dict[int, tuple[float, float]]) -> tuple[float, float]:
    """Return (values, depth) of a node with its aliases expanded.

    `measured` has those of groups and lists, by id.

    Raises:
        ConstructorError: there are too many, or it is too deep, as one that contains itself.
    """
    if not isinstance(node, yaml.CollectionNode):
        return 1, 0
    if id(node) not in measured:
        measured[id(node)] = inf, inf  # until its own are known
        inner = (
            node.value if isinstance(node, yaml.SequenceNode) else chain.from_iterable(node.value)
        )
        sizes = [_measure(each, measured) for each in inner]
        values, depth = (
            1 + sum(size for size, _ in sizes),
            1 + max((below for _, below in sizes), default=0),
        )
        if values > MOST_VALUES or depth > DEEPEST:
            line = (
                f"has more than {MOST_VALUES} values, or {DEEPEST} groups in each other, with "
                "aliases expanded"
            )
            raise yaml.constructor.ConstructorError(None, None, line, node.start_mark)
        measured[id(node)] = values, depth
    return measured[id(node)]
