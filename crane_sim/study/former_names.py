"""Names that studies had in the release before: still understood in this one, in files of studies and in folders."""

import warnings
from collections.abc import Mapping
from typing import Any

KEYS = {"figures": "metrics"}
"""Present names of a study's keys by their former ones."""
OWN_METRIC = {b"figure": b"own"}
"""Former metadata of a column that is a metric by the study's own function."""


def rename_keys(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study's document with present names in place of former ones, but where it has both."""
    return {KEYS[key] if KEYS.get(key, key) not in document else key: value for key, value in document.items()}


def warn_of_former_keys(document: Mapping[str, Any]) -> None:
    """Warn of every former name of a key in a study's document: the next release refuses it."""
    for former, present in KEYS.items():
        if former in document:
            warnings.warn(f"study: {former} is now called {present}", FutureWarning, stacklevel=3)
