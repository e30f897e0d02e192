"""Deprecated names of a study: those of the previous release, which still work in files and folders of this one."""

import warnings
from collections.abc import Mapping
from typing import Any

from crane_sim.files.errors import RenameWarning

KEYS = {"figures": "metrics"}
"""New names of a study's keys by the deprecated ones."""
OWN_METRIC = {b"figure": b"own"}
"""Deprecated metadata of a column that is a metric by the study's own function."""


def rename_keys(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study's document with new names in place of deprecated ones; where it has both, both stay."""
    return {KEYS[key] if KEYS.get(key, key) not in document else key: value for key, value in document.items()}


def warn_of_deprecated_keys(document: Mapping[str, Any]) -> None:
    """Warn of every deprecated key in a study's document: the next release refuses it."""
    for deprecated, new in KEYS.items():
        if deprecated in document:
            warnings.warn(f"study: {deprecated} is now called {new}", RenameWarning, stacklevel=3)
