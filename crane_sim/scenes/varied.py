"""Scenes of one document that differ in numbers only, made at once: on columns in place of these numbers.

The schema of the document says that its code takes columns (`SceneFile.takes_columns`). Values are validated by the
types of their fields, all of a key together; what one crane decides otherwise than the first one, or what cannot be
decided for all, leaves scenes to be made one by one.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from types import NoneType, UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, BeforeValidator, ValidationError

from crane_sim.files.document import with_values
from crane_sim.files.errors import SceneError
from crane_sim.files.types import as_list, type_adapter
from crane_sim.laws import make_law_of_columns
from crane_sim.numerics.column import Column, NotVectorisable, arrays_of, entry_of
from crane_sim.scenes.many import DocumentsByLaw
from crane_sim.scenes.registry import schema_of
from crane_sim.scenes.scene import (
    Scene,
    SceneSource,
    document_of,
    draft_file,
    finish_scene,
    has_own_nominal,
    law_parts,
    load_scene,
    note_left_out,
    read_file,
)
from crane_sim.scenes.schema.integrator import Auto
from crane_sim.tracing.trees import rebuilt


class SceneColumns(NamedTuple):
    """n scenes that differ in numbers only."""

    scene: Scene  # with a `Column` for each number that varies
    covered: npt.NDArray[np.bool_]  # (n,), which of them columns cover; the others are to be made one by one

    def at(self, i: int) -> Scene:
        """Return scene i, without its document's own values of what varies."""
        fields = {name: entry_of(getattr(self.scene, name), i) for name in Scene.__dataclass_fields__}
        return Scene(**fields)

    def arrays(self, tree: Any) -> Any:
        """Return a tree of the scene's parts with arrays (m, ...) of those m scenes that are covered."""
        arrays = arrays_of(tree, len(self.covered))
        return arrays if self.covered.all() else _select(arrays, self.covered)


def _select(tree: Any, chosen: npt.NDArray[np.bool_]) -> Any:
    if isinstance(tree, tuple):
        parts = [_select(part, chosen) for part in tree]
        return rebuilt(tree, parts)
    return None if tree is None else tree[chosen]


def load_columns(
    source: SceneSource, always: Mapping[str, Any], varied: Mapping[str, Sequence[Any]]
) -> SceneColumns | None:
    """Return n scenes of one document at once; None where they have to be made one by one.

    Args:
        source: what `load_scene` reads.
        always: changes of all scenes by dotted key.
        varied: n values of further keys.
    """
    switched = DocumentsByLaw(document_of(source))
    law = always.get("control.law")
    if "control.law" in varied or switched.mixes_laws(law):
        return None
    document, ignored = switched[law]
    try:
        with np.errstate(all="ignore"):
            found = _make_columns(document, always, varied)
    except (NotVectorisable, SceneError):  # the latter of the first crane: one by one, each has its own
        return None
    except (TypeError, ValueError, ArithmeticError):  # within an array, numpy's own functions do not refuse a column
        _make_first_alone(document, always, varied)
        return None
    return found._replace(scene=note_left_out(found.scene, ignored, switched.control))


def _make_first_alone(
    document: Mapping[str, Any], always: Mapping[str, Any], varied: Mapping[str, Sequence[Any]]
) -> None:
    """Make the first scene without columns: an error that it raises, too, is one of the program."""
    with suppress(SceneError):
        load_scene(dict(document), {**always, **{key: values[0] for key, values in varied.items()}})


def _make_columns(
    document: Mapping[str, Any], always: Mapping[str, Any], varied: Mapping[str, Sequence[Any]]
) -> SceneColumns:
    """Return the scenes of a document that is for their law."""
    schema = schema_of(document)
    if schema is None or not schema.takes_columns or document.get("uncertain") is not None:
        raise NotVectorisable("a document that takes no columns")
    columns, covered = _validate(schema, varied)
    first = int(np.argmax(covered))
    changed = with_values(dict(document), {**always, **{key: values[first] for key, values in varied.items()}})
    file, _ = read_file(changed)
    if isinstance(file.integrator, Auto):
        raise NotVectorisable("a method that is chosen by numbers")
    for key, column in columns.items():
        file = _replace_number(file, key.split("."), column)
    draft, law = draft_file(file, dict(file.notes), changed), None
    if file.control is not None:
        if has_own_nominal(draft):
            raise NotVectorisable("a nominal scene that is read from its document")
        law = make_law_of_columns(file.control.law, *law_parts(draft), covered)
    scene = finish_scene(draft, law)
    if any(isinstance(note, Column) for note in scene.notes.values()):
        raise NotVectorisable("a note that is another one for each scene")
    return SceneColumns(scene, covered)


def _validate(schema: type[BaseModel], varied: Mapping[str, Sequence[Any]]) -> tuple[dict[str, Column], Any]:
    """Return (columns by key, which scenes have values that are all possible); the others have those of one that has.

    Raises:
        NotVectorisable: a key is not that of a number that stands alone.
    """
    kinds = {key: _number_type(schema, key.split(".")) for key in varied}
    values, sound = dict[str, Any](), np.ones(len(next(iter(varied.values()))), bool)
    for key, given in varied.items():
        values[key], wrong = _validate_values(kinds[key], given)
        sound[wrong] = False
    first = int(np.argmax(sound))
    columns = {}
    for key, found in values.items():
        array = np.array([found[i] if ok else found[first] for i, ok in enumerate(sound)])
        if array.ndim != 1 or array.dtype not in (np.float64, np.int64):
            raise NotVectorisable(f"{key}: no numbers")
        columns[key] = Column(array, sound)
    return columns, sound


def _validate_values(kind: Any, given: Sequence[Any]) -> tuple[list[Any], list[int]]:
    """Return (values of a type, None where one is not possible; the indices of those)."""
    adapter = type_adapter(list[kind])
    try:
        return adapter.validate_python(list(given)), []
    except ValidationError as error:
        wrong = sorted({int(each["loc"][0]) for each in error.errors(include_url=False, include_context=False)})
    bad = set(wrong)
    found = iter(adapter.validate_python([value for i, value in enumerate(given) if i not in bad]))
    return [None if i in bad else next(found) for i in range(len(given))], wrong


def _number_type(kind: Any, names: Sequence[str]) -> Any:
    """Return the type of the number at the names of a key within a type; raises NotVectorisable where there is none."""
    kind, metadata = (get_args(kind)[0], get_args(kind)[1:]) if get_origin(kind) is Annotated else (kind, ())
    if get_origin(kind) in (Union, UnionType):
        kinds = [each for each in get_args(kind) if each is not NoneType]
        if len(kinds) != 1 or metadata:
            raise NotVectorisable("one of several types")
        return _number_type(kinds[0], names)
    if not names:
        if kind not in (float, int):
            raise NotVectorisable("no number")
        return Annotated[kind, *metadata] if metadata else kind
    if not all(each == BeforeValidator(as_list) or _limits_length(each) for each in metadata):
        raise NotVectorisable("validated as a whole")
    name, *others = names
    if get_origin(kind) is tuple and name.isdecimal():
        parts = get_args(kind)
        if parts[-1] is not Ellipsis and int(name) >= len(parts):
            raise NotVectorisable("no such entry")
        return _number_type(parts[0] if parts[-1] is Ellipsis else parts[int(name)], others)
    if not (isinstance(kind, type) and issubclass(kind, BaseModel)) or _checks_whole(kind) or _lacks(kind, name):
        raise NotVectorisable("validated as a whole")
    field = kind.model_fields[name]
    return _number_type(Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation, others)


def _lacks(kind: type[BaseModel], name: str) -> bool:
    """Return whether a group has no field of this name: its keys are another one's to validate, or it is refused."""
    return name not in kind.model_fields


def _limits_length(constraint: Any) -> bool:
    return hasattr(constraint, "min_length") or hasattr(constraint, "max_length")


def _checks_whole(kind: type[BaseModel]) -> bool:
    """Return whether a group has validators of its own, beside those of its fields' types."""
    own = kind.__pydantic_decorators__
    return bool(own.model_validators or own.root_validators or own.field_validators or own.validators)


def _replace_number(part: Any, names: Sequence[str], number: Any) -> Any:
    """Return a group, or a tuple, with another number at the names of a key."""
    if not names:
        return number
    name, *others = names
    if isinstance(part, tuple):
        i = int(name)
        return (*part[:i], _replace_number(part[i], others, number), *part[i + 1 :])
    changed = part.model_copy(update={name: _replace_number(getattr(part, name), others, number)})
    for derived in changed.__dict__.keys() - type(changed).model_fields.keys():
        del changed.__dict__[derived]  # what has been computed from the other number
    return changed
