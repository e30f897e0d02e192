"""An absent group has no effect, in whatever way its absence is written."""

import copy
from collections.abc import Iterable, Iterator
from typing import Annotated, Any, NamedTuple, get_args, get_origin

import numpy as np
import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from crane_sim.files.catalogue import scene_files
from crane_sim.files.document import read
from crane_sim.files.errors import SceneError
from crane_sim.numerics.states import leaves
from crane_sim.scenes.registry import ALL_SCHEMAS, FALLS_SCHEMAS
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.plant import Plant
from crane_sim.stepping.periods import begin

# scenes that are run, one of each kind of crane
RUN = {"knuckle": "knuckle_setpoint", "overhead": "overhead_swing"}


class OptionalGroup(NamedTuple):
    """An optional group of a schema, and its path in a document."""

    schema: type
    key: str
    path: tuple[str | int, ...]  # of the mapping that may hold the key
    default: Any


def is_record(kind: Any) -> bool:
    """Whether a type is a record (BaseModel or NamedTuple), in a scene file a group of keys."""
    return isinstance(kind, type) and (issubclass(kind, BaseModel) or hasattr(kind, "_fields"))


def records_in(annotation: Any) -> list[type]:
    """Return the types of parameters that an annotation allows, in unions and tuples, too."""
    if is_record(annotation):
        return [annotation]
    parts = (
        get_args(annotation)[:1] if get_origin(annotation) is Annotated else get_args(annotation)
    )
    return [kind for part in parts for kind in records_in(part)]


def fields_of(schema: type) -> dict[str, tuple[Any, Any, bool]]:
    """Return (annotation, default, whether there is one) of every field of a schema."""
    if issubclass(schema, BaseModel):
        model_fields: dict[str, FieldInfo] = schema.model_fields
        return {
            name: (f.annotation, f.default, not f.is_required()) for name, f in model_fields.items()
        }
    defaults: dict[str, Any] = getattr(schema, "_field_defaults", {})
    return {
        name: (kind, defaults.get(name), name in defaults)
        for name, kind in schema.__annotations__.items()
    }


def absence(default: Any) -> Any:
    """Return the written absence of a group of this default; KeyError if the field is no group."""
    if default is None:
        return None
    if isinstance(default, BaseModel) or default == {}:
        return {}
    if default == ():
        return []
    raise KeyError(default)


def is_group(default: Any) -> bool:
    """Whether a field with this default is a group that can be absent, not a number or name."""
    return default is None or isinstance(default, BaseModel) or default in ({}, ())


def subgroups(annotation: Any, held: Any) -> list[tuple[Any, tuple[str | int, ...]]]:
    """Return (group, path relative to the key) of a document's group, list or groups by name."""
    if isinstance(held, list):
        return [(part, (i,)) for i, part in enumerate(held)]
    named = annotation if get_origin(annotation) is not Annotated else get_args(annotation)[0]
    if isinstance(held, dict) and get_origin(named) is dict:
        return [(part, (name,)) for name, part in held.items()]
    return [(held, ())]


def optional_groups(
    schema: type, document: Any, path: tuple[str | int, ...] = ()
) -> Iterator[OptionalGroup]:
    """Yield every optional group that a document may have at `path` of the schema `schema`."""
    for key, (annotation, default, optional) in fields_of(schema).items():
        if optional and is_group(default):
            yield OptionalGroup(schema, key, path, default)
        for part, at in subgroups(annotation, document.get(key)):
            for kind in records_in(annotation) if isinstance(part, dict) else []:
                yield from optional_groups(kind, part, (*path, key, *at))


def all_groups(schema: type, visited: set[type] | None = None) -> Iterator[tuple[str, str]]:
    """Yield (schema, key) of every optional group that a schema has at any depth."""
    visited = set() if visited is None else visited
    if schema in visited:
        return
    visited.add(schema)
    for key, (annotation, default, optional) in fields_of(schema).items():
        if optional and is_group(default):
            yield schema.__name__, key
        for kind in records_in(annotation):
            yield from all_groups(kind, visited)


def written_as(document: dict[str, Any], optional: OptionalGroup, **values: Any) -> dict[str, Any]:
    """Return the document with the group left out or, given a `value`, written as that."""
    changed = copy.deepcopy(document)
    group: Any = changed
    for step in optional.path:
        group = group[step]
    group.pop(optional.key, None)
    if "value" in values:
        group[optional.key] = values["value"]
    return changed


def types_and_values(part: Any) -> Any:
    """Return types and values of parameters, arrays as bytes: equal only for the same models."""
    if isinstance(part, np.ndarray):
        return type(part), part.dtype.str, part.shape, part.tobytes()
    if isinstance(part, tuple):
        return type(part), tuple(map(types_and_values, part))
    if hasattr(part, "__dict__"):
        return type(part), tuple(
            (name, types_and_values(value)) for name, value in vars(part).items()
        )
    return type(part), part.hex() if isinstance(part, float) else part


def outcome(document: dict[str, Any]) -> Any:
    """Return a document's model, law, initial state, method and legs to the bit, or its error."""
    try:
        scene = load_scene(document)
    except SceneError as error:
        return str(error)
    parts = (
        scene.model,
        scene.law,
        scene.method,
        scene.source,
        scene.initial_q,
        scene.initial_v,
        scene.reference,
    )
    parts = (*parts, scene.hardware, scene.instruments, getattr(scene.file, "legs", None))
    return (
        types_and_values(parts),
        scene.joint_names,
        scene.actuated,
        scene.sampled,
        scene.law_name,
        scene.period,
    )


def in_wind(document: dict[str, Any]) -> dict[str, Any]:
    """Return a document with every key of a wind that may be absent."""
    gusts = {
        "spectrum": "dryden",
        "deviations": [1.0, 1.0, 0.5],
        "lengths": [50.0, 25.0, 5.0],
        "cut_off": 2.0,
        "seed": 1,
    }
    wind = {
        "speed": 8.0,
        "profile": {"law": "power", "exponent": 0.2},
        "gusts": gusts,
        "origin_height": 30.0,
    }
    windage = {"windage": {"area": 0.1, "drag_coefficient": 1.2}}
    rods = ("boom", "jib") if document["crane"] == "knuckle" else ()
    bodies = {name: document[name] | windage for name in ("payload", *rods) if name in document}
    return document | {"wind": wind, "payload": {"mass": 10.0} | windage} | bodies


def on_falls(crane: str) -> dict[str, Any]:
    """Return the document of a crane with falls in place of its rope."""
    ends = [[x, y, 0.0] for x in (0.2, -0.2) for y in (0.3, -0.3)]
    load = {"mass": 100.0, "inertia": [30.0, 20.0, 40.0], "attachment": [0.0, 0.0, 0.5]}
    starts = {
        "tower": ("tower_gust", {"q": [0.2, 25.0, 8.0]}),
        "mobile": ("mobile_lift", {"q": [0.2, 1.0, 36.0, 8.0]}),
        "knuckle": ("knuckle_setpoint", {"q": [0.2, 0.6, -0.2, 2.0]}),
        "pendulum": ("pendulum_free", {"tip": [0.0, 0.0, 1.0], "length": 2.0}),
    }
    name, start = starts[crane]
    kept = ("crane", "slew", "trolley", "superstructure", "boom", "telescope", "jib", "tower")
    document = {key: value for key, value in read(name).items() if key in kept}
    falls = {"top": ends, "bottom": ends, "axial_stiffness": 1e6}
    return document | {"duration": 1.0, "falls": falls, "payload": load, "initial": start}


def catalogue(crane: str) -> list[dict[str, Any]]:
    """Return the catalogue's documents of this kind, and some with groups that these lack."""
    kind, _, falls = crane.partition(" with ")
    documents = [document for name in scene_files() if (document := read(name))["crane"] == kind]
    if kind in FALLS_SCHEMAS:
        documents = [document for document in documents if bool(falls) == ("falls" in document)]
    if falls:
        documents += [on_falls(kind)]
    documents.append(in_wind(read(RUN[crane]) if crane in RUN else documents[0]))
    if falls and kind in ("tower", "mobile"):
        jib = {"jib": {"mass": 1e4, "centre": 30.0, "inertia": 3e6}} if kind == "tower" else {}
        documents.append(on_falls(kind) | {"flexibility": {"lateral": {"stiffness": 3e8}} | jib})
    if crane == "pendulum":
        limits = {"x": [-9.0, 9.0], "y": [-9.0, 9.0], "z": [-9.0, 9.0]}
        documents.append(
            read("pendulum_free") | {"suspension": {"height": "driven", "limits": limits}}
        )
    if crane == "knuckle":
        bristles = {
            "coulomb": 1.0,
            "static": 1.0,
            "stribeck": 0.1,
            "stiffness": 1e3,
            "damping": 10.0,
        }
        for group, friction in (("friction", {"coulomb": 1.0, "static": 1.0}), ("lugre", bristles)):
            documents.append(read("knuckle_setpoint") | {group: {"slew": friction}})
    if crane == "mobile":
        mode = {"stiffness": 3e8}
        documents.append(read("mobile_lift") | {"flexibility": {"lateral": mode, "vertical": mode}})
    if crane in ("bridge", "gantry"):
        documents.append(documents[0] | {"reference": {"q": [3.0, 2.0, 5.0]}})
    if crane == "overhead":
        rail = {"coulomb": 1.0, "static": 1.0, "stribeck": 0.1, "stiffness": 1e3, "damping": 1.0}
        documents.append(read("overhead_spatial") | {"lugre": {"trolley": rail}})
    motor = {"ratio": 9.0, "torque": 1.0, "no_load_speed": 100.0}
    return [*documents, documents[0] | {"actuators": {"all": {"motor": motor}}}]


@pytest.mark.long
@pytest.mark.parametrize("crane", ALL_SCHEMAS)
def test_every_spelling_of_absence_is_the_same_model(crane: str) -> None:
    """A group left out, null or empty gives the same types, values and start in any scene."""
    visited = set()
    for document in catalogue(crane):
        absent = []  # groups that the scene has not; they are written all at once
        for optional in optional_groups(ALL_SCHEMAS[crane], document):
            without = written_as(document, optional)
            kind = optional.schema.__name__, optional.key, without == document
            if kind not in visited:  # once where the scene has the group, once where it has not
                visited.add(kind)
                if without == document:
                    absent.append(optional)
                else:
                    written = written_as(document, optional, value=absence(optional.default))
                    assert outcome(written) == outcome(without), optional
        if absent:
            assert outcome(with_absent(document, absent)) == outcome(document), absent


def with_absent(document: dict[str, Any], absent: Iterable[OptionalGroup]) -> dict[str, Any]:
    """Return the document with the absence of groups written out; others are left alone."""
    explicit = copy.deepcopy(document)
    for optional in absent:
        group: Any = explicit
        for step in optional.path:
            group = group[step]
        group.setdefault(optional.key, absence(optional.default))
    return explicit


def test_every_group_is_tried() -> None:
    """Every optional group of every schema can be held by a scene of the test above."""
    tried, known = set(), set()
    for crane, schema in ALL_SCHEMAS.items():
        known |= set(all_groups(schema))
        for document in catalogue(crane):
            tried |= {
                (optional.schema.__name__, optional.key)
                for optional in optional_groups(schema, document)
            }
    assert tried == known, "no scene of the catalogue can hold these groups"


@pytest.mark.parametrize(("crane", "name"), RUN.items())
def test_absent_groups_leave_no_trace_in_a_run(crane: str, name: str) -> None:
    """With every absent group written out, a run has as many states, the same bit for bit."""
    silent = read(name) | {"duration": 0.5}
    explicit = with_absent(silent, optional_groups(ALL_SCHEMAS[crane], silent))
    assert explicit != silent
    first, second = final(load_scene(silent)), final(load_scene(explicit))
    assert first == second


@pytest.mark.parametrize("crane", ALL_SCHEMAS)
def test_a_group_that_is_there_shows(crane: str) -> None:
    """The comparison sees groups: each in the catalogue makes a difference in one scene."""
    used, effective = set(), set()
    for document in catalogue(crane):
        # made once, and only for a scene with a group that no scene before it has shown
        whole = None
        for optional in optional_groups(ALL_SCHEMAS[crane], document):
            kind, bare = (optional.schema.__name__, optional.key), written_as(document, optional)
            if bare != document and kind not in effective:
                used.add(kind)
                whole = whole or outcome(document)
                if outcome(bare) != whole:
                    effective.add(kind)
    assert used == effective


def final(scene: Scene) -> tuple[Any, ...]:
    """Return (number of states, final positions and velocities, digest of all states) of a run."""
    plant = Plant(scene)
    for _ in range(scene.steps):
        plant.advance(scene.law(plant.t, plant.q, plant.v) if scene.sampled and scene.law else None)
    integration, _, _ = begin(scene.model, np.array(scene.initial_q), np.array(scene.initial_v))
    return len(leaves(integration.x)), plant.q, plant.v, plant.summary()["state_sha256"]
