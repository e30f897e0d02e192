"""Riccati equations of many plants have SciPy's solutions, bit for bit; laws of many scenes are those of one."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_are, solve_discrete_are

from crane_control import lqr
from crane_control.riccati import solve_riccati
from crane_sim import load_scene
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene, load_scenes
from crane_sim.simulation.columns import stack_columns

PERIOD = 0.01  # s


def random_plants(m: int, nu: int, count: int) -> tuple[Any, ...]:
    """Return (a, b, q, r) of mechanical plants with m states and nu efforts, rates of 0.1 to 30 rad/s."""
    rng, n = np.random.default_rng(m + nu), m // 2
    a, b = np.zeros((count, m, m)), np.zeros((count, m, nu))
    a[:, :n, n:] = np.eye(n)
    a[:, n:] = rng.normal(size=(count, n, m)) * 10.0 ** rng.uniform(-1.0, 1.5, (count, 1, 1))
    b[:, n:] = rng.normal(size=(count, n, nu)) * 10.0 ** rng.uniform(-3.0, 0.0, (count, 1, 1))
    q = 10.0 ** rng.uniform(-1.0, 3.0, (count, m, 1)) * np.eye(m)
    return a, b, q, 10.0 ** rng.uniform(-6.0, 0.0, (count, nu, 1)) * np.eye(nu)


@pytest.mark.parametrize("discrete", [False, True])
@pytest.mark.parametrize(("m", "nu"), [(2, 1), (4, 1), (6, 2), (10, 4)])
def test_solutions_are_those_of_scipy(m: int, nu: int, discrete: bool) -> None:
    """Of 8 plants solved together each has SciPy's solution to the last bit: it makes the same calls of LAPACK."""
    a, b, q, r = random_plants(m, nu, 8)
    if discrete:
        whole: Any = expm(PERIOD * np.concatenate([np.concatenate([a, b], axis=2), np.zeros((8, nu, m + nu))], axis=1))
        a, b = whole[:, :m, :m], whole[:, :m, m:]
    solutions, found = solve_riccati(a, b, q, r, discrete)
    assert found.all()
    for i, x in enumerate(solutions):
        expected = (solve_discrete_are if discrete else solve_continuous_are)(a[i], b[i], q[i], r[i])
        np.testing.assert_array_equal(x, expected)


def test_a_plant_that_no_effort_reaches_is_not_solved() -> None:
    """Beside one that has a solution, one without is told apart, and does not disturb it."""
    a, b, q, r = random_plants(4, 1, 2)
    alone, _ = solve_riccati(a[:1], b[:1], q[:1], r[:1], False)
    a[1], b[1] = np.diag([1.0, 2.0, 0.0, 0.0]), 0.0
    solutions, found = solve_riccati(a, b, q, r, False)
    assert found.tolist() == [True, False]
    np.testing.assert_array_equal(solutions[0], alone[0])


SCENES: dict[str, tuple[str, dict[str, Any], dict[str, list[Any]]]] = {
    "trolley": ("overhead_energy", {"control.law": "lqr"}, {"cable.node_masses.0": [5.0, 9.0, -1.0, 20.0]}),
    "sphere": ("knuckle_lqr", {}, {"payload.mass": [0.8, 1.0, 1.2]}),
    "no damping": ("overhead_energy", {"control.law": "lqr"}, {"control.r": [[1.0], [1e300], [1e-300]]}),
    "weights": ("overhead_energy", {"control.law": "lqr"}, {"control.r": [[1.0], [2.0, 3.0], [-1.0]]}),
}


@pytest.mark.parametrize("kind", SCENES)
def test_laws_of_many_scenes_are_those_of_one(kind: str) -> None:
    """Scenes loaded together have models, laws and notes of those loaded one by one, bit for bit, or their errors."""
    name, always, varied = SCENES[kind]
    ((key, values),) = varied.items()
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
            both = stack_columns([getattr(loaded, tree), getattr(alone, tree)])
            for leaf in leaves(both):
                np.testing.assert_array_equal(leaf[0], leaf[1])


def test_a_design_of_many_that_fails_spares_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the design for all scenes at once raises what no scene of its own does, each scene has its law."""
    build = lqr.build_many

    def fail_for_several(settings: Any, scenes: Any) -> Any:
        if len(scenes) > 1:
            raise np.linalg.LinAlgError("singular matrix")
        return build(settings, scenes)

    monkeypatch.setattr(lqr, "build_many", fail_for_several)
    changes: list[dict[str, Any]] = [{"control.law": "lqr", "control.r": r} for r in ([1.0], [1e300])]
    first, second = load_scenes("overhead_energy", changes)
    assert isinstance(first, Scene) and first.law is not None and isinstance(second, SceneError)


def leaves(tree: Any) -> list[np.ndarray]:
    """Return the arrays of a tree of columns."""
    if isinstance(tree, tuple):
        return [leaf for part in tree for leaf in leaves(part)]
    return [] if tree is None else [tree]
