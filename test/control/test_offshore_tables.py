"""The offshore paper's tables, and the law that does better, in whole runs."""

import pytest

from crane_bench.reproduce import offshore
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.rollout import simulate

TABLES = [  # MSE [m²] and MAE [m] as printed, and how far ours may be from them
    (2.04e-3, 0.10, 3.39e-2, 0.10),
    (1.35e-5, 0.10, 3.20e-3, 0.20),
    (1.14e-2, 0.10, 9.47e-2, 0.05),
    (1.50e-3, 0.05, 3.52e-2, 0.05),
    (1.93e-2, 0.15, 1.24e-1, 0.15),
    (3.66e-3, 0.15, 5.16e-2, 0.15),
]
COLUMNS = list(
    zip((experiment for pair in offshore.PAIRS for experiment in pair), TABLES, strict=True)
)


@pytest.mark.long(
    cases=[
        "Table 9, with learning-2",
        "Table 7, with learning-2",
        "Table 9, without learning-2",
        "Table 7, without learning-2",
        "Table 5, angular-2",
    ]
)
@pytest.mark.parametrize("seeds", [2, pytest.param(offshore.SEEDS, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("experiment", "printed"), COLUMNS, ids=[f"{e.table}, {e.name}" for e, _ in COLUMNS]
)
def test_the_papers_tables(
    experiment: offshore.Experiment, printed: tuple[float, ...], seeds: int
) -> None:
    """Tables 5, 7 and 9 come out within what their unprinted parameters leave open.

    There is one servo for all of them.
    """
    actual = offshore.measure_errors(experiment, seeds)
    for row, value, tolerance in zip(actual, printed[::2], printed[1::2], strict=True):
        assert row.paper == value and row.runs == (seeds if experiment.seeded else 1)
        assert (
            value * (1.0 - tolerance)
            <= row.lowest
            <= row.ours
            <= row.highest
            <= value * (1.0 + tolerance)
        )
        assert row.verdict == f"within {tolerance:.0%}"


def test_the_verdict_is_on_all_seeds() -> None:
    """A number is the median between extremes, and one seed too far off misses the tolerance."""
    far = offshore.compare_with_paper("MSE", offshore.Printed(2.0, 0.1), [2.1, 2.3, 2.0], "")
    assert (far.ours, far.lowest, far.highest, far.runs, far.verdict) == (
        2.1,
        2.0,
        2.3,
        3,
        "not within 10%",
    )
    assert far.difference == pytest.approx(0.05)
    assert (
        offshore.compare_with_paper("MSE", offshore.Printed(2.0, 0.1), [2.1, 1.9, 2.0], "").verdict
        == "within 10%"
    )


@pytest.mark.long
def test_what_the_tables_rest_on() -> None:
    """Variants of the experiments confirm what the tables rest on.

    They are feedforward, the printed sway of 0.5 m, a constant feature only, and initial damping.
    """
    forward, printed_sway, constant, damped = (
        next(offshore.measure_errors(experiment, 1)).ours for experiment in offshore.OTHERWISE
    )
    # the Cartesian law is at 0.007 of it
    without, with_learning = offshore.PAIRS[1]  # Table 7
    assert forward < 0.1 * offshore.PAIRS[0][0].printed.mse.value
    assert printed_sway > 10.0 * without.printed.mse.value  # "far off"
    # the tolerance of the table
    assert constant == pytest.approx(with_learning.printed.mse.value, rel=0.05)
    assert damped < with_learning.printed.mse.value


@pytest.mark.long
def test_the_harmonic_observer_beats_learning_at_resonance() -> None:
    """Its error is a twentieth of the adaptive law's, and its tip is accelerated no harder."""
    learnt, observed = (simulate("offshore_resonant", law).summary for law in (None, "harmonic"))
    assert 20.0 * observed["tracking_mse"] < learnt["tracking_mse"]
    assert observed["peak_tip_acceleration"] <= learnt["peak_tip_acceleration"]


@pytest.mark.parametrize("part", [0.95, 1.05])
def test_the_harmonic_law_finds_out_how_long_the_rope_is(part: float) -> None:
    """With a rope 5 % off the payload still follows its path within a millimetre.

    It is shorter or longer than believed.
    """
    changes = {
        "rope.length": part * 1.255,
        "control.nominal": {"rope": {"length": 1.255}},
        "duration": 40.0,
    }
    actual = simulate(load_scene("offshore_obstacle", changes | {"control.law": "harmonic"}))
    assert actual.summary["tracking_peak"] < 1e-3
