"""Files of studies: what they make of parameters and variants, and how a wrong one is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crane_sim.files.document import read
from crane_sim.files.errors import SceneError
from crane_sim.study import Case, Study, cases, load_study

SCENE = "overhead_energy"
MASS = "cable.node_masses.0"
UNIFORM = {"distribution": "uniform", "low": 5.0, "high": 20.0}
TWO = {"energy": {}, "lqr": {"control.law": "lqr"}}


def study(**changes: Any) -> Study:
    """Return a study of one parameter with changes."""
    return load_study({"scene": SCENE, "parameters": {MASS: [5.0, 10.0]}} | changes)


def sampled(design: str, samples: int, **changes: Any) -> list[Case]:
    """Return the cases of a study of two parameters that are drawn."""
    parameters = {
        MASS: UNIFORM,
        "trolley.mass": {"distribution": "normal", "deviation": 0.1, "relative": True},
    }
    return list(cases(study(design=design, samples=samples, parameters=parameters, **changes)))


def test_a_grid_has_every_combination_under_every_variant() -> None:
    """Cases are the product of the values, last one fastest, each sample under all variants."""
    listed = list(
        cases(
            study(parameters={MASS: [5.0, 10.0], "trolley.mass": [15.0, 20.0, 25.0]}, variants=TWO)
        )
    )
    assert [case.number for case in listed] == list(range(12))
    assert [(case.sample, case.variant) for case in listed] == [
        (i, name) for i in range(6) for name in TWO
    ]
    values = [tuple(case.parameters.values()) for case in listed[::2]]
    assert values == [(a, b) for a in (5.0, 10.0) for b in (15.0, 20.0, 25.0)]
    assert listed[1].changes["control.law"] == "lqr" and "control.law" not in listed[0].changes


@pytest.mark.parametrize("design", ["latin_hypercube", "sobol"])
def test_samples_are_stratified(design: str) -> None:
    """In both designs one of n samples lies in each n-th of a parameter's probability.

    That is so by their definition.
    """
    n = 16
    masses = np.array([case.parameters[MASS] for case in sampled(design, n)])
    assert sorted(((masses - 5.0) / 15.0 * n).astype(int)) == list(range(n))


def test_monte_carlo_has_the_moments_of_its_distributions() -> None:
    """Mean and deviation of 4096 draws are the distribution's within four standard errors."""
    listed = sampled("monte_carlo", 4096)
    masses, trolleys = (
        np.array([case.parameters[key] for case in listed]) for key in (MASS, "trolley.mass")
    )
    assert abs(masses.mean() - 12.5) < 4.0 * (15.0 / 12**0.5) / 64.0
    # relative: factors of the scene's own 20 kg
    assert abs(trolleys.mean() - 20.0) < 4.0 * 2.0 / 64.0
    assert abs(trolleys.std() - 2.0) < 4.0 * 2.0 / (2 * 4096) ** 0.5


def test_variants_share_their_random_numbers() -> None:
    """All variants of a sample have its parameters and its seed; samples differ.

    A second list of cases is the same.
    """
    first, second = (sampled("monte_carlo", 8, variants=TWO, seed=3) for _ in range(2))
    assert first == second
    for plain, other in zip(first[::2], first[1::2], strict=True):
        assert (
            plain.parameters == other.parameters and plain.changes["seed"] == other.changes["seed"]
        )
    assert len({case.changes["seed"] for case in first}) == 8
    assert first[0].parameters != sampled("monte_carlo", 8, variants=TWO, seed=4)[0].parameters


def test_a_study_is_what_it_writes() -> None:
    """A study read back from its JSON is the same, infinite limits and value lists included."""
    parameters = {
        MASS: {"distribution": "normal", "deviation": 1.0},
        "initial.angles.0": [0.1, "20 deg"],
    }
    first = study(design="sobol", samples=4, parameters=parameters, variants=TWO)
    assert load_study(first.model_dump(mode="json")) == first


def test_parameters_vary_the_scene_with_the_changes_of_the_study() -> None:
    """A relative distribution has factors of what `changes` set.

    That holds also in a group that only the changes have.
    """
    third = {"distribution": "uniform", "low": 1.0, "high": 1.5, "relative": True}
    parameters = {MASS: third, "friction.trolley.coulomb": third, "trolley.mass": third}
    changes = {
        "cable.node_masses": [100.0],
        "friction": {"trolley": {"coulomb": 4.0}},
        "trolley.mass": 60.0,
    }
    for case in cases(study(design="sobol", samples=4, parameters=parameters, changes=changes)):
        for key, own in zip(parameters, (100.0, 4.0, 60.0), strict=True):
            assert own <= case.parameters[key] == case.changes[key] <= 1.5 * own
    assert read(SCENE)["trolley"]["mass"] == 20.0


def test_a_key_that_stands_twice_is_refused(tmp_path: Path) -> None:
    """A study's file is read as a scene's: the line names file, line and column."""
    file = tmp_path / "twice.yaml"
    file.write_text(
        "scene: overhead_energy\nparameters:\n  trolley.mass: [15.0]\n  trolley.mass: [20.0]\n"
    )
    with pytest.raises(
        SceneError, match=r"study file .*twice\.yaml: cannot be read: line 3, column 3: .*twice"
    ):
        load_study(file)
    with pytest.raises(SceneError, match="study file .*nowhere.yaml: there is no such file"):
        load_study(tmp_path / "nowhere.yaml")


@pytest.mark.parametrize(
    "values", [["mylaw.py:build", "lqr"], {"values": ["mylaw.py:build", "lqr"]}]
)
def test_laws_of_files_are_beside_the_study(tmp_path: Path, values: Any) -> None:
    """The file of a law in a study, also in what is tuned, is one of the study's folder.

    It is in the changes that are tuned, or among a parameter's values.
    """
    tune = {"gains": {"control.kp": {"low": 1, "high": 2}}, "objectives": ["x"]}
    document = {
        "scene": SCENE,
        "parameters": {MASS: [5.0]},
        "tune": tune | {"changes": {"control.law": "mylaw.py:build"}},
    }
    file, law = tmp_path / "study.yaml", f"{tmp_path / 'mylaw.py'}:build"
    file.write_text(json.dumps(document))
    tuned = load_study(file).tune
    assert tuned is not None and tuned.changes == {"control.law": law}
    file.write_text(json.dumps({"scene": SCENE, "parameters": {"control.law": values}}))
    assert load_study(file).parameters["control.law"].values == (law, "lqr")


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "unknown key": ({"sample": 4}, "did you mean 'samples'"),
    "no parameters": ({"parameters": {}}, "parameters"),
    "no scene": ({"scene": "overhead_enrgy"}, "did you mean 'overhead_energy'"),
    "unknown distribution": (
        {"parameters": {MASS: {"distribution": "gauss"}}},
        "'gauss' is unknown; possible",
    ),
    "order": (
        {"design": "sobol", "samples": 4, "parameters": {MASS: UNIFORM | {"low": 30.0}}},
        "low = 30 must be less than high = 20",
    ),
    "distribution in a grid": ({"parameters": {MASS: UNIFORM}}, "design = grid needs values"),
    "samples of a grid": ({"samples": 4}, "samples = 4: a grid has as many as its values make"),
    "no samples": ({"design": "sobol"}, "samples is missing"),
    "Sobol": (
        {"design": "sobol", "samples": 100},
        "samples = 100: a Sobol sequence is balanced at powers of two",
    ),
    "in a variant, too": (
        {"variants": {"a": {MASS: 1.0}}},
        f"variants.a.{MASS} = 1.0: sets what the parameter {MASS} sets, too",
    ),
    "in the changes, too": (
        {"changes": {MASS: 1.0}},
        f"changes.{MASS} = 1.0: sets what the parameter {MASS} sets, too",
    ),
    "below a parameter, in a variant": (
        {"parameters": {"cable": [{"lengths": [1.0]}]}, "variants": {"a": {MASS: 1.0}}},
        f"variants.a.{MASS} = 1.0: sets what the parameter cable sets, too",
    ),
    "below a parameter, in what is tuned": (
        {
            "parameters": {"cable": [{"lengths": [1.0]}]},
            "tune": {
                "gains": {"control.kp": {"low": 1, "high": 2}},
                "objectives": ["x"],
                "changes": {MASS: 1.0},
            },
        },
        f"tune.changes.{MASS} = 1.0: sets what the parameter cable sets, too",
    ),
    "below a parameter, in another one": (
        {"parameters": {MASS: [1.0], "cable": [{"lengths": [1.0]}]}},
        f"parameters.{MASS}: sets what the parameter cable sets, too",
    ),
    "two durations": (
        {"duration": 1.0, "parameters": {"duration": [1.0]}},
        "duration = 1: is in parameters, too",
    ),
    "a duration in the changes": (
        {"duration": 1.0, "changes": {"duration": 2.0}},
        "duration = 1: is in changes, too",
    ),
    "a duration in a variant": (
        {"duration": 1.0, "variants": {"a": {"duration": 2.0}}},
        "duration = 1: is in variants.a, too; give one of them",
    ),
    "a change without a place": (
        {"changes": {"cable.node_masses.3": 1.0}},
        "'3' is no index of a list of 1",
    ),
    "unknown metric of the worst runs": (
        {"duration": 0.1, "recordings": {"worst": {"metric": "peak_swing_dge"}}},
        "'peak_swing_dge' of recordings.worst.metric, did you mean 'peak_swing_deg'",
    ),
    "text as metric of the worst runs": (
        {"duration": 0.1, "recordings": {"worst": {"metric": "state_sha256"}}},
        "recordings.worst.metric = 'state_sha256': is text, not a number",
    ),
    "nothing to vary": (
        {"design": "sobol", "samples": 4, "parameters": {"payload.mas": UNIFORM}},
        "parameters.payload.mas: the scene has no payload.mas of its own",
    ),
    "no index": ({"parameters": {"cable.node_masses.3": [1.0]}}, "'3' is no index of a list of 1"),
    "no number": (
        {"design": "sobol", "samples": 4, "parameters": {"control.law": UNIFORM}},
        "parameters.control.law: is 'energy' in the scene, not a number",
    ),
    "impossible scene": ({"parameters": {MASS: [-1.0]}}, "-1.0"),
    "impossible law": (
        {"variants": {"ok": {}, "bad": {"control.law": "lqq"}}},
        "variant 'bad': scene overhead_energy: control.law",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_wrong_study_is_refused_in_one_line(name: str, tmp_path: Any) -> None:
    """The line names key and value and says what is possible; nothing is written."""
    from crane_sim import study as studies

    changes, expected = BAD[name]
    with pytest.raises(SceneError) as error:
        studies.run(
            {"scene": SCENE, "parameters": {MASS: [5.0, 10.0]}} | changes, tmp_path / "folder"
        )
    assert expected in str(error.value) and "\n" not in str(error.value)
    assert not (tmp_path / "folder").exists()
