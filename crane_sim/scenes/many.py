"""Many scenes from one document: read once, their laws designed together."""

import copy
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from crane_sim.files.document import SHARED, switch_law, with_values
from crane_sim.files.errors import SceneError
from crane_sim.laws import make_laws
from crane_sim.scenes.scene import (
    Draft,
    Scene,
    SceneSource,
    document_of,
    draft_scene,
    finish_scene,
    law_parts,
    load_scene,
    note_left_out,
    with_scene_name,
)


def load_scenes(source: SceneSource, changes: Sequence[Mapping[str, Any]]) -> list[Scene | SceneError]:
    """Return for each of many changes of a scene what `load_scene` returns, or the error that it raises.

    Args:
        source: what `load_scene` reads; it is read once.
        changes: values by dotted key, of each scene.

    Raises:
        SceneError: there is no such scene.
    """
    switched = _DocumentsByLaw(document_of(source))
    found: list[Any] = [_draft(switched, each) for each in changes]
    for law, numbers in _by_law(found).items():
        for i, made in zip(numbers, _finish(law, [found[i] for i in numbers]), strict=True):
            ignored = switched[changes[i].get("control.law")][1]
            found[i] = note_left_out(made, ignored, switched.control) if ignored and isinstance(made, Scene) else made
    return found


class _DocumentsByLaw(dict[Any, tuple[dict[str, Any], Sequence[str]]]):
    """A document by the law that changes switch it to, and the keys that this leaves out; made when first asked for."""

    def __init__(self, document: dict[str, Any]) -> None:
        super().__init__()
        self.document, self.control = document, document.get("control")

    def __missing__(self, law: Any) -> tuple[dict[str, Any], Sequence[str]]:
        document = copy.deepcopy(self.document)
        self[law] = document, switch_law(document, {} if law is None else {"control.law": law})
        return self[law]

    def mixes_laws(self, law: Any) -> bool:
        """Return whether settings remain that the other law may have, or not."""
        control = self.control
        if not isinstance(control, dict) or law is None or law == control.get("law"):
            return False
        return any(key in SHARED for key in control)


def _draft(switched: _DocumentsByLaw, changes: Mapping[str, Any]) -> Draft | Scene | SceneError:
    """Return the draft of a document with changes; the scene, or its error, where settings of two laws are mixed."""
    law = changes.get("control.law")
    if switched.mixes_laws(law):
        return _attempt(switched.document, load_scene, switched.document, changes)
    try:
        changed = with_values(switched[law][0], changes)
    except (SceneError, RecursionError) as error:
        return SceneError(str(error))
    return _attempt(changed, draft_scene, changed)


def _by_law(drafts: Sequence[Any]) -> dict[str | None, list[int]]:
    """Return the numbers of the drafts by the name of their law."""
    groups: dict[str | None, list[int]] = {}
    for i, draft in enumerate(drafts):
        if isinstance(draft, Draft):
            groups.setdefault(draft.file.control and draft.file.control.law, []).append(i)
    return groups


def _finish(law: str | None, drafts: Sequence[Draft]) -> list[Scene | SceneError]:
    """Return the scenes of drafts with one law, or their errors."""
    if law is None:
        return [_attempt(draft.document, finish_scene, draft, None) for draft in drafts]
    parts: list[Any] = [_attempt(draft.document, law_parts, draft) for draft in drafts]
    sound = [part for part in parts if not isinstance(part, SceneError)]
    laws = iter(make_laws(law, *map(list, zip(*sound, strict=True))) if sound else ())
    return [
        part if isinstance(part, SceneError) else _with_law(draft, next(laws))
        for draft, part in zip(drafts, parts, strict=True)
    ]


def _with_law(draft: Draft, law: Any) -> Scene | SceneError:
    if isinstance(law, SceneError):
        return with_scene_name(draft.document, law)
    return _attempt(draft.document, finish_scene, draft, law)


def _attempt(document: Mapping[str, Any], function: Callable[..., Any], *args: Any) -> Any:
    """Return what a function returns, or its error with the name of the document's scene."""
    try:
        return function(*args)
    except (SceneError, RecursionError) as error:
        return error if function is load_scene else with_scene_name(document, error)
