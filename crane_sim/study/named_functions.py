"""Functions of one's own that a study names, its metrics and laws: what their files hold decides its numbers, too."""

from collections.abc import Iterator, Mapping
from typing import Any

from crane_sim.files.functions import hash_source
from crane_sim.study.schema import Study, Values


def hash_functions(study: Study, document: Mapping[str, Any]) -> dict[str, str]:
    """Return the SHA-256 of the sources of the functions that a study names, by file or module.

    A law or module that is not there has none: what names it is refused where it is used.

    Args:
        study: the study.
        document: of its scene.
    """
    names = sorted({study.metrics, *_laws_of(study, document)} - {""})
    hashes = {name.rpartition(":")[0]: hash_source(name) for name in names}
    return {place: each for place, each in hashes.items() if each is not None}


def _laws_of(study: Study, document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the laws of one's own that a study, its variants and its scene name."""
    values = {key: each.values for key, each in study.parameters.items() if isinstance(each, Values)}
    searched = {} if study.tune is None else study.tune.changes
    yield from _find_laws([document, study.changes, study.variants, values, searched])


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
