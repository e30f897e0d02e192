"""Scenes that differ in numbers only, made at once: each equals the scene that is made alone, bit for bit."""

from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from crane_sim.files.catalogue import scene_files
from crane_sim.files.document import get_value
from crane_sim.files.errors import SceneError
from crane_sim.scenes.many import load_scenes
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.scenes.varied import load_columns

KEYS = (
    "trolley.mass", "cable.lengths.0", "cable.node_masses.0", "payload.mass", "gravity", "initial.angles.0",
    "initial.x", "initial.v", "friction.trolley.viscous", "hoist.inertia", "cable.stiffness.0",
)  # fmt: skip
FACTORS = (0.97, 1.0, 1.1, 1.3)
DIFFERENT = ("document", "file")
"""Fields that scenes made at once have in common."""
GUSTS = {"speed": 5.0, "height": 40.0, "origin_height": 50.0, "gusts": {"spectrum": "von_karman", "intensity": 0.15}}
SAIL = {"mass": 10.0, "windage": {"area": 1.0, "drag_coefficient": 1.2}}


def is_same(a: Any, b: Any) -> bool:
    """Return whether two parts of scenes are of the same types and bits."""
    if isinstance(a, tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(is_same, a, b))
    if isinstance(a, np.ndarray):
        return (a.dtype, a.shape, a.tobytes()) == (b.dtype, b.shape, b.tobytes())
    return type(a) is type(b) and a == b


def differences(made: Scene, alone: Scene | SceneError) -> list[str]:
    """Return the fields in which a scene differs from the one that is made alone."""
    names = [each.name for each in fields(Scene) if each.name not in DIFFERENT]
    return [name for name in names if not is_same(getattr(made, name), getattr(alone, name))]


def values_of(document: dict[str, Any], key: str) -> list[float] | None:
    """Return values about a document's own of a key, None where it is no number."""
    _, own = get_value(document, key)
    return [factor * own for factor in FACTORS] if isinstance(own, int | float) else None


@pytest.mark.parametrize("name", ["overhead_swing", "overhead_chain", "overhead_spring", "overhead_coulomb"])
def test_cranes_whose_fixed_step_is_judged_are_made_at_once_or_one_by_one(name: str) -> None:
    """Numbers that the fastest motion depends on, with a step that it bounds: as alone, or left to be made alone."""
    event = {"events": [{"at": 0.5, "set": {"payload": {"mass": 5.0}}}]}
    fixed = event | {"control": None, "integrator": {"method": "rk4", "step": 1e-5}, "payload": {"mass": 10.0}}
    document = load_scene(name).to_dict() | fixed
    for key in (*KEYS, "events.0.set.payload.mass"):
        if (values := values_of(document, key)) is not None:
            found = load_columns(document, {}, {key: values})
            alone = load_scenes(document, [{key: value} for value in values])
            chosen = np.flatnonzero(found.covered) if found is not None else ()
            assert all(found is not None and differences(found.at(int(i)), alone[i]) == [] for i in chosen)


def test_overhead_cranes_of_the_catalogue_are_made_at_once_as_alone() -> None:
    """Models and initial states of every overhead scene without its law, one key after the other; most are made."""
    made = asked = 0
    for name in (name for name in scene_files() if name.startswith("overhead_")):
        document = load_scene(name).to_dict() | {"control": None, "integrator": {"method": "dop853"}}
        for key in KEYS:
            if (values := values_of(document, key)) is None:
                continue
            found = load_columns(document, {}, {key: values, "seed": [*range(len(values))]})
            changes = [{key: value, "seed": i} for i, value in enumerate(values)]
            alone = load_scenes(document, changes)
            asked, made = asked + 1, made + (found is not None)
            chosen = np.flatnonzero(found.covered) if found is not None else ()
            for i in chosen:
                assert found is not None
                assert differences(found.at(int(i)), alone[i]) == [], (name, key, i)
    assert made > 0.6 * asked  # prescribed motions, text and elastic cables that need an automatic method are not


def check_all_are_as_alone(document: dict[str, Any], varied: dict[str, list[float]]) -> None:
    """Check that three scenes are all made at once, and equal those that are made alone."""
    found = load_columns(document, {}, varied)
    assert found is not None
    assert found.covered.all()
    for i in range(3):
        alone = load_scene(document, {key: values[i] for key, values in varied.items()})
        assert differences(found.at(i), alone) == []


@pytest.mark.parametrize("nodes", [[10.0], [2.0, 10.0]])
def test_regulators_are_designed_at_once_as_alone(nodes: list[float]) -> None:
    """LQR laws of cranes made at once have the gains, targets and poles of those made alone."""
    document = load_scene("overhead_energy").to_dict() | {"control": {"law": "lqr"}}
    document["cable"] = {"lengths": [1.2] * len(nodes), "node_masses": nodes}
    document["initial"] = {"angles": [0.1] * len(nodes)}
    varied = {"trolley.mass": [18.0, 20.0, 30.0], "cable.lengths.0": [1.0, 2.0, 3.0]}
    check_all_are_as_alone(document, varied)


def test_regulators_of_elastic_cables_are_designed_at_once_as_alone() -> None:
    """LQR laws of cranes on springs, each about where its own payload hangs, are those of cranes made alone."""
    document = load_scene("overhead_energy").to_dict() | {"control": {"law": "lqr"}, "initial": {"angles": [0.1]}}
    cable = {"model": "elastic", "lengths": [2.0], "node_masses": [10.0], "stiffness": [1e5], "damping": [1e3]}
    document |= {"integrator": {"method": "dop853"}, "cable": cable}
    varied = {"cable.node_masses.0": [5.0, 10.0, 7.0], "trolley.mass": [5.0, 20.0, 8.0], "gravity": [9.81, 3.7, 9.8]}
    check_all_are_as_alone(document, varied)


def test_what_is_not_alike_is_left_out() -> None:
    """Values that are not possible, and cranes of another kind, are marked; the others are as they are alone."""
    document = load_scene("overhead_energy").to_dict() | {"control": None}
    document["cable"] = {"lengths": [1.0, 1.0], "node_masses": [1.0, 9.0]}
    masses = [-1.0, 2.0, 0.0, 3.0, "heavy", 1e99]  # without mass the two links are one
    found = load_columns(document, {}, {"cable.node_masses.0": masses})
    assert found is not None
    assert found.covered.tolist() == [False, True, False, True, False, False]
    for i in (1, 3):
        assert differences(found.at(i), load_scene(document, {"cable.node_masses.0": masses[i]})) == []


@pytest.mark.parametrize(
    ("always", "varied"),
    [
        ({}, {"control.kp": [[1.0], [2.0]]}),  # a setting of the law
        ({"control.law": "lqr"}, {"duration": [3.0, 4.0]}),  # which is rounded to periods
        ({}, {"trolley.mass": [20.0, 30.0]}),  # a law that is designed for one scene
        ({"control": None}, {"reference.q.0": [2.0, 3.0]}),  # a group that is validated as a whole
        ({"control": None, "integrator.method": "auto"}, {"trolley.mass": [20.0, 30.0]}),
        ({"control.law": "lqr", "control.nominal": {"gravity": 9.8}}, {"trolley.mass": [20.0, 30.0]}),
        ({"control.law": "lqr", "sensors": {"all": {"noise": 0.1}}}, {"trolley.mass": [20.0, 30.0]}),
        (
            {"control": None, "uncertain": {"gravity": {"distribution": "uniform", "low": 9.0, "high": 9.9}}},
            {"seed": [1]},
        ),
        ({"control": None}, {"trolley.mas": [20.0, 30.0]}),
        ({}, {"control.damping.factor": [1.0, 2.0]}),  # no key of the schema's
    ],
)
def test_what_is_made_one_by_one(always: dict[str, Any], varied: dict[str, Any]) -> None:
    """Scenes that do not differ in plain numbers of a schema are not made at once, and nothing is raised."""
    assert load_columns("overhead_energy", always, varied) is None


@pytest.mark.parametrize("take", [len, tuple, np.degrees, lambda x: np.hypot(1.0, x), lambda x: np.ones(2) @ x])
def test_code_that_takes_one_number_leaves_scenes_to_be_made_one_by_one(
    take: Callable[[Any], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law's design that does with a number what columns have not is no error: its scenes are made one by one."""
    monkeypatch.setattr("crane_control.lqr.build_columns", lambda settings, scene, covered: take(scene.initial_v[0]))
    assert load_columns("overhead_energy", {"control.law": "lqr"}, {"initial.v": [0.1, 0.2]}) is None


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"integrator": {"method": "rk8", "step": 0.01}}, "trolley.mass"),
        ({"integrator": {"method": "rk8", "step": 0.01}}, "cable.lengths.0"),
        ({"integrator": {"method": "rk4", "step": 0.01}}, "cable.node_masses.0"),
        ({"wind": GUSTS, "payload": SAIL, "cable.node_masses": [0.0]}, "wind.gusts.intensity"),
    ],
)
def test_arrays_of_columns_leave_scenes_to_be_made_one_by_one(changes: dict[str, Any], key: str) -> None:
    """Code that puts a number into an array raises numpy's own errors for a column: no scene is refused for them."""
    document = load_scene("overhead_energy").to_dict() | {"control": None}
    scene = load_scene(document, changes)
    _, own = get_value(scene.to_dict(), key)
    assert load_columns(scene.to_dict(), {}, {key: [own, 1.01 * own]}) is None


def test_an_error_of_the_program_is_no_reason_for_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors other than those that say why columns do not fit are raised: they are not taken for a slow scene."""
    for error in (AttributeError, KeyError, TypeError, ValueError):

        def fail(*_: Any, error: type[Exception] = error) -> Any:
            raise error

        for module in ("varied", "scene"):
            monkeypatch.setattr(f"crane_sim.scenes.{module}.finish_scene", fail)
        with pytest.raises(error):
            load_columns("overhead_energy", {"control": None}, {"trolley.mass": [20.0, 30.0]})


def numbers_in(group: Any, *names: str) -> Iterator[tuple[str, float]]:
    """Yield (dotted key, value) of all numbers of a document."""
    if isinstance(group, int | float) and not isinstance(group, bool):
        yield ".".join(names), group
    entries = group.items() if isinstance(group, dict) else enumerate(group) if isinstance(group, list) else ()
    for name, value in entries:
        yield from numbers_in(value, *names, str(name))


@pytest.mark.long
def test_every_number_of_the_catalogue_is_taken_or_refused() -> None:
    """Whatever number of an overhead scene varies, by values that fit and values that do not, no error is raised."""
    made = 0
    for name in (name for name in scene_files() if name.startswith("overhead_")):
        document = load_scene(name).to_dict()
        for key, own in numbers_in(document):
            for values in ([own, 1.01 * own, 0.97 * own], [own, 1e200 * (own or 1.0), -own, 0.0, "x", None, 10**400]):
                for method in ({"method": "dop853"}, {"method": "rk4", "step": 1e-3}):
                    made += load_columns(document, {"integrator": method}, {key: values}) is not None
    assert made > 200
