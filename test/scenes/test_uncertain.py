"""The group `uncertain`: quantiles, draws by seed and key; only the plant has drawn values."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.stats
import yaml

import crane_sim
from crane_sim.description import urdf
from crane_sim.scenes.scene import load_scene
from crane_sim.scenes.schema.uncertain import LogNormal, Normal, Triangular, Uniform, probability_of

SCENE = "overhead_energy"  # trolley.mass 20, cable.node_masses [10]
UNIFORM = {"distribution": "uniform", "low": 15.0, "high": 25.0}
FACTOR = {"distribution": "normal", "deviation": 0.1, "low": 0.5, "relative": True}
BOTH = {"trolley.mass": UNIFORM, "cable.node_masses.0": FACTOR}
PROBABILITIES = np.linspace(0.001, 0.999, 37)


def uncertain_scene(group: Any, **changes: Any) -> crane_sim.Scene:
    """Return a scene of 1 s with uncertain parameters."""
    return load_scene(SCENE, {"uncertain": group, "duration": 1.0} | changes)


def drawn_values(group: Mapping[str, Any], **changes: Any) -> dict[str, float]:
    """Return the values that the scene draws, by key."""
    return uncertain_scene(group, **changes).notes["drawn"]


@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Uniform(2.0, 5.0), scipy.stats.uniform(2.0, 3.0)),
        (Triangular(2.0, 5.0), scipy.stats.triang(1.0 / 3.0, 2.0, 3.0)),
        (Triangular(2.0, 5.0, 5.0), scipy.stats.triang(1.0, 2.0, 3.0)),
        (Normal(0.5), scipy.stats.norm(3.0, 0.5)),
        (Normal(0.5, 4.0, 3.8, 5.0), scipy.stats.truncnorm(-0.4, 2.0, 4.0, 0.5)),
        (LogNormal(0.3), scipy.stats.lognorm(0.3, scale=3.0)),
    ],
)
def test_quantiles(distribution: Any, reference: Any) -> None:
    """Quantiles are those of SciPy's distributions, where the scene has the value 3."""
    values = [distribution.quantile(p, 3.0) for p in PROBABILITIES]
    # the tolerance is for SciPy's truncated normal distribution
    assert values == pytest.approx(reference.ppf(PROBABILITIES), rel=1e-12)


def test_a_lognormal_draw_beyond_all_numbers_is_refused() -> None:
    """A deviation by which a value overflows is named; with an upper limit the value is drawn."""
    with pytest.raises(
        ValueError, match="deviation = 1000: draws a value beyond the largest number"
    ):
        LogNormal(1000.0).quantile(0.9, 3.0)
    assert LogNormal(1000.0, high=4.0).quantile(0.9, 3.0) <= 4.0


def test_limits_of_a_lognormal_distribution() -> None:
    """A limited lognormal value is the exponential of a normal one within their logarithms."""
    values = [LogNormal(0.3, 3.0, 2.0, 4.0).quantile(p, 0.0) for p in PROBABILITIES]
    logarithms = [
        Normal(0.3, np.log(3.0), np.log(2.0), np.log(4.0)).quantile(p, 0.0) for p in PROBABILITIES
    ]
    assert values == pytest.approx(np.exp(logarithms), rel=1e-14)  # two roundings
    assert min(values) > 2.0 and max(values) < 4.0


def test_probabilities_are_uniform_and_independent() -> None:
    """Two keys over 4000 seeds pass a Kolmogorov-Smirnov test and are not correlated.

    Each is at a level of 1e-3.
    """
    pairs = np.array(
        [[probability_of(seed, key) for key in ("payload.mass", "rope.x")] for seed in range(4000)]
    )
    assert all(scipy.stats.kstest(column, "uniform").pvalue > 1e-3 for column in pairs.T)
    assert abs(np.corrcoef(pairs.T)[0, 1]) < 3.29 / np.sqrt(len(pairs))


def test_a_draw_depends_on_seed_and_key_alone() -> None:
    """The same seed draws the same, another one something else, whatever else is uncertain."""
    both = drawn_values(BOTH)
    assert (
        both == drawn_values(BOTH)
        and both["trolley.mass"] == drawn_values({"trolley.mass": UNIFORM})["trolley.mass"]
    )
    assert all(value != both[key] for key, value in drawn_values(BOTH, seed=1).items())


def test_a_seed_is_a_number() -> None:
    """3 and 3.0 are the same seed, and one that is no seed is refused as in every scene."""
    assert drawn_values(BOTH, seed=3) == drawn_values(BOTH, seed=3.0)
    with pytest.raises(
        crane_sim.SceneError, match=r"seed = -1: must be greater than or equal to 0"
    ):
        uncertain_scene(BOTH, seed=-1)


def test_a_run_is_that_of_the_drawn_values() -> None:
    """The plant, its URDF and summary have the drawn values, the law's model the file's."""
    scene = uncertain_scene(BOTH)
    masses = scene.notes["drawn"]
    certain = load_scene(
        SCENE,
        {
            "trolley.mass": masses["trolley.mass"],
            "cable.node_masses": [masses["cable.node_masses.0"]],
            "duration": 1.0,
            "control.nominal": {"trolley": {"mass": 20.0}, "cable": {"node_masses": [10.0]}},
        },
    )
    assert scene.law == certain.law and urdf(scene) == urdf(certain)
    run, same = crane_sim.simulate(scene), crane_sim.simulate(certain)
    assert (
        run.summary["drawn"] == masses
        and run.summary["state_sha256"] == same.summary["state_sha256"]
    )


def test_no_deviation_is_no_uncertainty() -> None:
    """A deviation that is less than rounding leaves every bit of the run as it is."""
    still = crane_sim.simulate(
        uncertain_scene({"trolley.mass": {"distribution": "normal", "deviation": 1e-300}})
    )
    assert (
        still.summary["state_sha256"]
        == crane_sim.simulate(SCENE, duration=1.0).summary["state_sha256"]
    )


def test_a_batch_draws_for_every_seed() -> None:
    """A batch over seeds ends as single runs with the same draws.

    1e-12: the batch's loops round in another order.
    """
    scene = uncertain_scene(BOTH)
    batch = crane_sim.simulate_batch(scene, {"seed": [0, 1, 2]})
    single = [crane_sim.simulate(load_scene(scene, {"seed": seed})).q[-1] for seed in range(3)]
    np.testing.assert_allclose(batch.q, single, rtol=1e-12, atol=1e-12)


def test_groups_that_an_anchor_shares_are_drawn_apart(tmp_path: Path) -> None:
    """An anchor is an abbreviation: what one of its groups draws or is given, others do not."""
    file = tmp_path / "anchor.yaml"
    scene = load_scene("overhead_spatial").to_dict()
    axis = {"drive": "force", "mass": 100.0}
    file.write_text(
        yaml.safe_dump(
            scene | {"trolley": axis, "bridge": axis, "uncertain": {"trolley.mass": UNIFORM}}
        )
    )
    assert "*id001" in file.read_text()
    drawn = load_scene(file)
    masses = drawn.model.support.structure
    assert masses.trolley.mass == drawn.notes["drawn"]["trolley.mass"] < 26.0 < masses.bridge.mass
    given = load_scene(file, {"trolley.mass": 60.0, "uncertain": None})
    assert (
        given.model.support.structure.trolley.mass == 60.0
        and given.document["bridge"]["mass"] == 100.0
    )


def test_numpy_s_numbers_and_tuples_are_numbers_and_lists(tmp_path: Path) -> None:
    """A scene whose values were NumPy's or tuples can be written, drawn from and read again."""
    values = {
        "trolley.mass": np.float64(21.0),
        "cable.lengths": (np.float32(2.0),),
        "cable.node_masses": np.array([9.0]),
    }
    scene = uncertain_scene({"cable.lengths.0": FACTOR}, **values)
    scene.dump(tmp_path / "scene.yaml")
    again = load_scene(tmp_path / "scene.yaml")
    assert again.document == scene.document and again.notes["drawn"] == scene.notes["drawn"]
    assert scene.document["trolley"]["mass"] == 21.0 and scene.document["cable"]["node_masses"] == [
        9.0
    ]


def test_angles_may_be_text() -> None:
    """Numbers of a distribution may be angles with a unit, as the parameters that they are of."""
    degrees = drawn_values(
        {"initial.angles.0": {"distribution": "uniform", "low": "5 deg", "high": "10 deg"}}
    )
    radians = drawn_values(
        {"initial.angles.0": {"distribution": "uniform", "low": np.pi / 36.0, "high": np.pi / 18.0}}
    )
    # π / 36 rounded
    assert degrees["initial.angles.0"] == pytest.approx(radians["initial.angles.0"], rel=1e-15)


def test_a_list_has_one_factor() -> None:
    """A relative distribution scales all numbers of a list alike."""
    (value,) = drawn_values({"cable.node_masses": FACTOR}).values()
    factor = Normal(0.1, 1.0, low=0.5).quantile(probability_of(0, "cable.node_masses"), 0.0)
    assert value == [10.0 * factor] and factor != 1.0


@pytest.mark.parametrize(
    ("group", "message"),
    [
        (
            {"trolley.mass": UNIFORM | {"low": 30.0}},
            "uncertain.trolley.mass: low = 30 must be less than high = 25",
        ),
        (
            {"trolley.mas": UNIFORM},
            "uncertain.trolley.mas: the scene has no trolley.mas of its own; give it a value",
        ),
        (
            {"trolley.mass": {"distribution": "gauss"}},
            "uncertain.trolley.mass: distribution 'gauss' is unknown; possible: uniform, normal, "
            "lognormal, triangular",
        ),
        (
            {"trolley.mass": UNIFORM | {"low": -5.0, "high": -4.0}},
            "must be greater than or equal to 0 (drawn by uncertain.trolley.mass)",
        ),
        (
            {"trolley.mass": {"distribution": "normal", "deviation": 1.0, "low": 60.0}},
            "uncertain.trolley.mass: low .. high is out of reach of a mean of 20 and a deviation "
            "of 1",
        ),
        (
            {"trolley.mass": {"distribution": "triangular", "low": 0.0, "high": 1.0}},
            "uncertain.trolley.mass: the mode, the scene's own 20, must be within low .. high",
        ),
        (
            {"trolley.mass": {"distribution": "triangular", "low": 0.0, "high": 1.0, "mode": 2.0}},
            "mode = 2 must be",
        ),
        (
            {"trolley.mass": 7},
            "uncertain.trolley.mass = 7: must be a group of keys, with distribution: uniform",
        ),
        (7, "uncertain = 7: must be a group of keys"),
        ({"seed": UNIFORM}, "uncertain.seed: is no parameter of the crane"),
        (
            {"trolley": UNIFORM},
            "uncertain.trolley: is {'drive': 'force', 'mass': 20.0} in the scene, not a number",
        ),
        (
            {"cable.lengths": UNIFORM},
            "uncertain.cable.lengths: has 1 values: relative: true scales them all",
        ),
        (
            {"trolley.drive": UNIFORM},
            "uncertain.trolley.drive: is 'force' in the scene, not a number",
        ),
        (
            {"trolley.mass": {"distribution": "lognormal", "deviation": 0.1, "low": 1e6}},
            "uncertain.trolley.mass: low .. high is out of reach of a median of 20 and a deviation "
            "of 0.1 of the log",
        ),
        (
            {"cable.node_masses.0": FACTOR, "cable.node_masses": FACTOR},
            "uncertain.cable.node_masses.0: is a part of uncertain.cable.node_masses; leave out "
            "one of the two",
        ),
        (
            {"cable.node_masses.0": FACTOR, "cable.node_masses.00": FACTOR},
            "uncertain.cable.node_masses.00: is a part of",
        ),
        (
            {"cable.node_masses": FACTOR, "cable.node_masses.00": FACTOR},
            "uncertain.cable.node_masses.00: is a part of",
        ),
        (
            {"cable.lengths.1": UNIFORM},
            "uncertain.cable.lengths.1: the scene has no cable.lengths.1 of its own",
        ),
    ],
)
def test_wrong_groups_are_refused(group: Any, message: str) -> None:
    """A distribution that contradicts itself or the scene is refused in one line that names it."""
    with pytest.raises(crane_sim.SceneError) as error:
        uncertain_scene(group)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_other_mistakes_are_not_blamed_on_a_draw() -> None:
    """A value that was not drawn is named alone, with and without uncertain parameters."""
    for changes in ({}, {"uncertain": {"trolley.mass": UNIFORM}}):
        with pytest.raises(crane_sim.SceneError) as error:
            load_scene(SCENE, {"cable.lengths": [-1.0]} | changes)
        assert "cable.lengths" in str(error.value) and "drawn" not in str(error.value)
