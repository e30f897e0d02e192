"""The scenes of a batch: one document, changed for each crane, and their numbers put into columns."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.batch_loops import Driven, Sampled
from crane_sim.explain import SceneError
from crane_sim.laws import fresh
from crane_sim.rollout import SceneSource
from crane_sim.scene import Scene, load_scene
from crane_sim.scene_document import read

ONE_KIND = "a batch takes one kind of model, method and law"


def scenes_of(scene: SceneSource, parameters: Mapping[str, Any], duration: float | None) -> list[Scene]:
    """Return one checked scene for each crane.

    Raises:
        SceneError: the parameters do not fit one another, or the scene of a crane is not possible; it names the crane.
    """
    count = _count(parameters)
    if duration is not None and "duration" in parameters:
        raise SceneError(f"duration = {duration}: is among the parameters, too; leave out one of the two")
    document = scene.to_dict() if isinstance(scene, Scene) else scene if isinstance(scene, Mapping) else read(scene)
    always = {} if duration is None else {"duration": duration}
    scenes: list[Scene] = []
    for i in range(count):
        try:
            scenes.append(load_scene(document, always | {key: _value(parameters[key][i]) for key in parameters}))
        except SceneError as error:
            raise SceneError(f"crane {i}: {error}") from None
        _check_alike(scenes[0], scenes[i], i)
    return scenes


def _value(value: Any) -> Any:
    """Return a value as a scene file would hold it: no arrays."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _count(parameters: Mapping[str, Any]) -> int:
    """Return the number of cranes."""
    if not isinstance(parameters, Mapping) or not all(isinstance(key, str) for key in parameters):
        raise SceneError(f"parameters = {parameters!r}: must map keys of the scene to values, one for each crane")
    if not parameters:
        raise SceneError("parameters: are empty; give at least one key of the scene with a value for each crane")
    counts: dict[str, int] = {}
    for key, values in parameters.items():
        listed = values.ndim if isinstance(values, np.ndarray) else isinstance(values, Sequence)
        if not listed or isinstance(values, str):
            raise SceneError(f"parameters: {key!r} = {values!r}: must be an array with one entry for each crane")
        counts[key] = len(values)
    (first, count), *_ = counts.items()
    for key, other in counts.items():
        if not other:
            raise SceneError(f"parameters: {key!r} is empty; give a value for each crane")
        if other != count:
            raise SceneError(f"parameters: {key!r} has {other} entries, {first!r} has {count}: one for each crane")
    return count


def _check_alike(first: Scene, scene: Scene, i: int) -> None:
    """Raise SceneError when crane i cannot keep the time of the first one, or its law cannot run compiled."""
    for name in ("duration", "period", "sampled"):
        here, there = getattr(scene, name), getattr(first, name)
        if here != there:
            raise SceneError(f"crane {i}: {name} = {here}, that of crane 0 is {there}: a batch keeps one time")
    if scene.hardware is not None and not scene.hardware.ideal:
        raise SceneError("sensors, actuators and faults: a batch has none; leave them out, or use simulate")
    if scene.sampled and not system.command.knows(type(scene.law)):
        raise SceneError(f"control.law = {scene.law_name!r}: has no compiled form, which a batch needs; use simulate")


def driven(scene: Scene) -> Driven:
    """Return what moves in a scene, its law with no memory of other runs."""
    return Driven(scene.method, scene.model, Sampled(fresh(scene.law)) if scene.sampled else scene.source)


def columns(trees: Sequence[Any], path: str = "") -> Any:
    """Return the tree whose numbers are arrays over all trees; None and the types of NamedTuples stay.

    Raises:
        SceneError: the trees are not of one type; it names the first one that differs from tree 0, and where.
    """
    first = trees[0]
    for i, tree in enumerate(trees):
        if (here := _form(tree)) != (there := _form(first)):
            raise SceneError(f"crane {i}: {path[:-1]} is {here}, that of crane 0 is {there}: {ONE_KIND}")
    if first is None:
        return None
    if not isinstance(first, tuple):
        return np.array(trees)
    names = getattr(first, "_fields", range(len(first)))
    parts = [columns(part, f"{path}{name}.") for name, part in zip(names, zip(*trees, strict=True), strict=True)]
    return type(first)(*parts) if hasattr(first, "_fields") else tuple(parts)


def _form(tree: Any) -> str:
    """Return in words what decides on the compiled type of a tree's root."""
    if isinstance(tree, np.ndarray):
        return f"an array of {' x '.join(map(str, tree.shape))}"
    if type(tree) is tuple:
        return f"{len(tree)} values"
    return "a number" if isinstance(tree, int | float) else "none" if tree is None else type(tree).__name__
