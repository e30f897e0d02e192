"""Identity of a study: all that its numbers depend on, so that rows of two studies never mix."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.files.functions import hash_source
from crane_sim.recording.provenance import of_this_process
from crane_sim.simulation import (
    batch_metrics,
    derived,
    energy_balance,
    flat_summary,
    metrics,
    rollout,
    settling,
    totals,
)
from crane_sim.study.schema import Study, Values, scene_document

MODULES = (batch_metrics, derived, energy_balance, flat_summary, metrics, rollout, settling, totals)
"""Modules of `crane_sim.simulation` that compute the metrics of a run."""


@cache
def versions() -> dict[str, str]:
    """Return versions of packages, system and processor, and the hash of the metrics' source."""
    source = b"".join(Path(str(module.__file__)).read_bytes() for module in MODULES)
    return of_this_process() | {"metrics_sha256": hashlib.sha256(source).hexdigest()}


def deciding_versions() -> dict[str, str]:
    """Return the versions that a study's processes have to share.

    The processor may differ, as in a cluster.
    """
    return {key: value for key, value in versions().items() if key not in ("cpu", "system")}


def identity_of(study: Study) -> dict[str, Any]:
    """Return all that makes a study's numbers.

    These are the study, the document of its scene in JSON, versions, and functions of the user's
    own.
    """
    document = scene_document(study)
    identity = {
        "study": study.model_dump(mode="json"),
        "scene": json.dumps(document, default=str),
        "versions": deciding_versions(),
    }
    functions = hash_functions(study, document)
    return identity | {"functions": functions} if functions else identity


def block_needs(identity: dict[str, Any]) -> tuple[str, dict[str, str], dict[str, str]]:
    """Return the scene, versions and functions that all processes of a study have to share."""
    return identity["scene"], identity["versions"], identity.get("functions", {})


def hash_of(identity: dict[str, Any]) -> str:
    """Return the hash of a study: folders with another one hold other numbers."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True, default=str).encode()).hexdigest()


def differing_keys(mine: Mapping[str, str], other: Mapping[str, str]) -> str:
    """Return the keys at which two identities differ, in one line; empty where they do not."""
    return ", ".join(
        key for key in sorted(mine.keys() | other.keys()) if mine.get(key) != other.get(key)
    )


def read_identity(file: Path) -> dict[str, Any]:
    """Return what the file of a folder says of its study or search, groups by name.

    Raises:
        SceneError: the file is damaged, or cannot be read.
    """
    try:
        known = json.loads(file.read_text())
    except OSError as error:
        raise SceneError(f"{file}: {error.strerror}") from None
    except ValueError:  # no JSON, or no text
        known = None
    groups = ("study", "versions", "functions")
    if not isinstance(known, dict) or not all(
        isinstance(known.get(name, {}), dict) for name in groups
    ):
        raise SceneError(f"{file}: is damaged; name another folder, or remove this one")
    return known


def hash_functions(study: Study, document: Mapping[str, Any]) -> dict[str, str]:
    """Return the SHA-256 of the sources of the user's functions that a study or its scene names.

    They are by file or module. One that is not there has none: what names it is refused where it is
    used.
    """
    values = {
        key: each.values for key, each in study.parameters.items() if isinstance(each, Values)
    }
    searched = {} if study.tune is None else study.tune.changes
    laws = _find_laws([document, study.changes, study.variants, values, searched])
    hashes = {
        name.rpartition(":")[0]: hash_source(name) for name in sorted({study.metrics, *laws} - {""})
    }
    return {place: each for place, each in hashes.items() if each is not None}


def _find_laws(value: Any, key: str = "") -> Iterator[str]:
    """Yield the functions that keys named `law` have, at any depth of a value."""
    if isinstance(value, Mapping):
        for name, part in value.items():
            yield from _find_laws(part, str(name))
    elif isinstance(value, list | tuple):
        for part in value:
            yield from _find_laws(part, key)
    elif isinstance(value, str) and key.rpartition(".")[2] == "law" and ":" in value:
        yield value
