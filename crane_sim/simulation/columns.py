"""Many scenes of one kind as columns: trees of NamedTuples of arrays, one entry for each scene."""

from collections.abc import Hashable, Iterable, Sequence
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.laws import with_initial_state
from crane_sim.scenes.scene import Scene
from crane_sim.stepping.batch import Driven
from crane_sim.stepping.periods import Sampled
from crane_sim.tracing.trees import rebuilt

ONE_KIND = "a batch takes one kind of model, method and law"


def make_driven(scene: Scene) -> Driven:
    """Return method, model and source of a scene, its law with its initial state."""
    return Driven(
        scene.method,
        scene.model,
        Sampled(with_initial_state(scene.law)) if scene.sampled else scene.source,
    )


def stack_columns(trees: Sequence[Any], path: str = "") -> Any:
    """Return the tree whose numbers are arrays over all trees; None and NamedTuple types stay.

    Raises:
        SceneError: the trees are not of one type; it names the first one that differs from tree 0,
            and where.
    """
    first = trees[0]
    if not _are_alike(trees):
        raise _difference_error(trees, path[:-1])
    if first is None:
        return None
    if not isinstance(first, tuple):
        return (
            np.array(trees).view(type(first)) if isinstance(first, np.recarray) else np.array(trees)
        )
    names = getattr(first, "_fields", range(len(first)))
    parts = [
        stack_columns(part, f"{path}{name}.")
        for name, part in zip(names, zip(*trees, strict=True), strict=True)
    ]
    return rebuilt(first, parts)


def group_indices(keys: Iterable[Hashable]) -> list[list[int]]:
    """Return the indices of equal keys, group by group, ordered by first occurrence."""
    groups: dict[Hashable, list[int]] = {}
    for i, key in enumerate(keys):
        groups.setdefault(key, []).append(i)
    return list(groups.values())


def _are_alike(trees: Sequence[Any]) -> bool:
    """Return whether the roots of trees are of one compiled type."""
    types = set(map(type, trees))
    if len(types) > 1:
        return types <= {int, float, bool}
    (kind,) = types
    sizes = (
        [tree.shape for tree in trees]
        if issubclass(kind, np.ndarray)
        else map(len, trees)
        if kind is tuple
        else ()
    )
    return len(set(sizes)) <= 1


def _difference_error(trees: Sequence[Any], path: str) -> SceneError:
    """Return an error that names the first tree that is not like tree 0."""
    i = next(i for i, tree in enumerate(trees) if not _are_alike((trees[0], tree)))
    form, expected = _form(trees[i]), _form(trees[0])
    return SceneError(
        f"crane {i}: {path or 'its model'} is {form}, that of crane 0 is {expected}: {ONE_KIND}"
    )


def _form(tree: Any) -> str:
    """Return in words what decides on the compiled type of a tree's root."""
    if isinstance(tree, np.ndarray):
        return f"an array of {' x '.join(map(str, tree.shape))}"
    if type(tree) is tuple:
        return f"{len(tree)} values"
    return (
        "a number"
        if isinstance(tree, int | float)
        else "none"
        if tree is None
        else type(tree).__name__
    )


def kind_of(tree: Any) -> Any:
    """Return what decides on a tree's compiled type: trees of one kind can be columns of one."""
    if isinstance(tree, tuple):
        return type(tree), *[float if type(part) is float else kind_of(part) for part in tree]
    return tree.shape if isinstance(tree, np.ndarray) else None if tree is None else float
