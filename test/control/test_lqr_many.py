"""Laws of many scenes, designed together, are those of one."""

from typing import Any

import numpy as np
import pytest

from crane_control import lqr
from crane_sim import load_scene
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene, load_scenes
from crane_sim.simulation.columns import stack_columns

LQR: dict[str, Any] = {"control.law": "lqr"}
SCENES: dict[str, tuple[str, dict[str, Any], str, list[Any]]] = {
    "trolley": ("overhead_energy", LQR, "cable.node_masses.0", [5.0, 9.0, -1.0, 20.0]),
    "sphere": ("knuckle_lqr", {}, "payload.mass", [0.8, 1.0, 1.2]),
    "no damping": ("overhead_energy", LQR, "control.r", [[1.0], [2.0, 3.0], [1e300]]),
}


@pytest.mark.parametrize("kind", SCENES)
def test_laws_of_many_scenes_are_those_of_one(kind: str) -> None:
    """Scenes loaded together have models, laws, notes or errors of those loaded one by one.

    They are equal bit for bit.
    """
    name, always, key, values = SCENES[kind]
    changes = [always | {key: value} for value in values]
    for each, loaded in zip(changes, load_scenes(name, changes), strict=True):
        try:
            alone = load_scene(name, each)
        except SceneError as error:
            assert isinstance(loaded, SceneError) and str(loaded) == str(error)
            continue
        assert not isinstance(loaded, SceneError), loaded
        assert (loaded.notes, loaded.document) == (alone.notes, alone.document)
        for tree in ("model", "law"):
            for leaf in leaves(stack_columns([getattr(loaded, tree), getattr(alone, tree)])):
                np.testing.assert_array_equal(leaf[0], leaf[1])


def test_a_design_of_many_that_fails_spares_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the design for all scenes at once raises, each scene has its law.

    It raises what no scene of its own does.
    """
    build = lqr.build_many

    def fail_for_several(settings: Any, scenes: Any) -> Any:
        if len(scenes) > 1:
            raise np.linalg.LinAlgError("singular matrix")
        return build(settings, scenes)

    monkeypatch.setattr(lqr, "build_many", fail_for_several)
    first, second = load_scenes(
        "overhead_energy", [LQR | {"control.r": r} for r in ([1.0], [1e300])]
    )
    assert isinstance(first, Scene) and first.law is not None and isinstance(second, SceneError)


def leaves(tree: Any) -> list[np.ndarray]:
    """Return the arrays of a tree of columns."""
    if isinstance(tree, tuple):
        return [leaf for part in tree for leaf in leaves(part)]
    return [] if tree is None else [tree]
