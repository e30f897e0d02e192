"""Names that studies had in the release before: still understood in this one, in files of studies and in folders."""

import warnings
from collections.abc import Mapping
from typing import Any

KEYS = {"figures": "metrics"}
"""Present names of a study's keys by their former ones."""
SOURCES: dict[str, str] = {
    "0d40eddf1d5e4fb62bd721cdd0bd8d6e1e262486ed52ed5a800340c170a1157d": (
        "c5c8d9b6bf0fbd20564a8ddd19159f611832f1be9b01443cd929f1f0c5c6879e"
    ),
}
"""Hashes of the source of the metrics under former names, by the hash of the same code under its present names."""
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


def former_identity(identity: Mapping[str, Any]) -> dict[str, Any]:
    """Return the identity that the release before gave a study, see `store.identity_of`."""
    former = {present: key for key, present in KEYS.items()}
    study = {former.get(key, key): value for key, value in identity["study"].items()}
    versions = dict(identity["versions"])
    source = versions["metrics_sha256"]
    return {**identity, "study": study, "versions": versions | {"metrics_sha256": SOURCES.get(source, source)}}
