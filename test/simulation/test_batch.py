"""Many cranes at once: the bits of single runs, independent of the source; one-line errors."""

from typing import Any

import numpy as np
import pytest

from crane_sim import SceneError, SimulationError, load_scene, simulate, simulate_batch
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.batch_metrics import has_compiled_metrics, run_all
from crane_sim.simulation.flat_summary import flatten

N = 19  # one whole block of lanes and a part of one
TIMES = (0.0, 0.0123, 0.1, 0.25)  # at the start, within a step, between two periods, at the end
# does not divide the period: steps are shortened
FIXED = {"integrator": {"method": "rk4", "step": 0.004}}
SPANS = {"integrator": {"method": "rk8", "step": 0.035}}  # three periods each, and one at the end
MASSES = {"payload.mass": np.linspace(5.0, 20.0, N)}

MASS = "cable.node_masses.0"
KINDS: dict[str, tuple[str, dict[str, Any], dict[str, Any], int]] = {
    "rod in lanes": (
        "overhead_swing",
        FIXED,
        MASSES | {"initial.angles": [[k / N] for k in range(N)]},
        16,
    ),
    "law in lanes": (
        "overhead_energy",
        FIXED,
        MASSES | {"control.kp": np.linspace(1.0, 9.0, N)[:, None].tolist()},
        16,
    ),
    "several periods a step": ("overhead_swing", SPANS, MASSES, 16),
    "knuckle in lanes": ("knuckle_springs", FIXED, {"payload.mass": np.linspace(0.5, 2.0, N)}, 16),
    "friction, error control": ("overhead_coulomb", {}, MASSES, 1),
    "chain": (
        "overhead_chain",
        {"integrator.rtol": 1e-6},
        {"payload.mass": [50.0, 100.0, 200.0]},
        1,
    ),
}
LONG = ("knuckle in lanes", "chain")  # to compile: up to three minutes


@pytest.mark.long(cases=["friction, error control"])
@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.slow if kind in LONG else ()) for kind in KINDS]
)
def test_a_batch_is_its_cranes_one_by_one(kind: str) -> None:
    """Every crane of a batch ends, and is sampled, bit for bit as in `simulate`."""
    name, overrides, parameters, lanes = KINDS[kind]
    document = load_scene(name, overrides | {"duration": TIMES[-1]}).to_dict()
    batch = simulate_batch(document, parameters, sample_times=TIMES, threads=2)
    assert batch.lanes == lanes
    assert not any(batch.errors)
    n = len(batch.q)
    for i in (0, n // 2, n - 1):
        own = {key: np.asarray(values)[i].tolist() for key, values in parameters.items()}
        alone = simulate(load_scene(document, own), sample_times=TIMES)
        np.testing.assert_array_equal(batch.sampled_q[i], alone.q)
        np.testing.assert_array_equal(batch.sampled_v[i], alone.v)
        np.testing.assert_array_equal(batch.sampled_payload[i], alone.payload)
        for ours, theirs in (
            (batch.q, alone.q),
            (batch.v, alone.v),
            (batch.payload, alone.payload),
        ):
            np.testing.assert_array_equal(ours[i], theirs[-1])
        assert (batch.evaluations[i], batch.steps[i]) == (
            alone.stats["rhs_evaluations"],
            alone.stats["steps"],
        )
    assert len(np.unique(batch.payload, axis=0)) == n
    assert np.all(batch.t == TIMES[-1])


def test_metrics_and_events_are_those_of_single_runs() -> None:
    """A batch asked for them has every metric of `simulate`, NaN if missing, and events."""
    document = load_scene(
        "overhead_coulomb", {"duration": 0.4, "trolley.limits": [-9.0, 9.0]}
    ).to_dict()
    limits = [[-9.0, 9.0], [-9.0, 0.005]]
    batch = simulate_batch(document, {"trolley.limits": limits}, metrics=True)
    whole = simulate(load_scene(document)).summary
    assert batch.metrics is not None and batch.events is not None
    assert batch.metrics["state_sha256"][0] == whole["state_sha256"]
    assert batch.metrics["peak_swing_deg"][0] == whole["peak_swing_deg"]
    assert batch.metrics["steps"].tolist() == [40, round(batch.t[1] / 0.01)] and batch.t[1] < 0.4
    assert [type(events) for events in batch.events] == [tuple, tuple] and len(batch.events[0]) > 0


COMPILED: dict[str, tuple[str, dict[str, Any], dict[str, list[Any]]]] = {
    "law": ("overhead_energy", {"control.law": "lqr"}, {"cable.lengths.0": [1.5, 2.0, 3.0]}),
    "open loop, metered": ("knuckle_springs", {}, {"payload.mass": [0.5, 1.0, 2.0]}),
    "path of the payload": ("offshore_resonant", {}, {"payload.mass": [0.5, 1.0, 2.0]}),
    "path of the joints": ("overhead_shaped", {}, {"cable.lengths.0": [1.5, 2.0, 3.0]}),
}


@pytest.mark.parametrize("kind", COMPILED)
def test_compiled_metrics_are_those_of_single_runs(kind: str) -> None:
    """Runs with compiled metrics have all metrics of `simulate`, and its error, to the last bit."""
    name, overrides, parameters = COMPILED[kind]
    document = load_scene(name, overrides | {"duration": 0.3}).to_dict()
    ((key, values),) = parameters.items()
    check_metrics([load_scene(document, {key: value}) for value in values])


@pytest.mark.long
def test_compiled_metrics_of_a_failed_run_are_its_own() -> None:
    """A run that overflows has the metrics and the error of `simulate`; its neighbour continues."""
    document = load_scene("overhead_swing", FIXED | {"duration": 0.3}).to_dict()
    check_metrics(
        [
            load_scene(document, {"inputs.trolley": {"kind": "constant", "value": x}})
            for x in (0.0, 1e200)
        ]
    )


def test_compiled_metrics_of_a_rod_are_those_of_single_runs() -> None:
    """A rod that pushes its trolley has, in a batch, the metrics of `simulate`.

    It swings above its trolley.
    """
    start = {"angles": [2.2], "rates": [1.5]}
    scenes = [
        load_scene("overhead_energy", {"duration": 0.37, "initial": start, MASS: m})
        for m in (5.0, 10.0)
    ]
    check_metrics(scenes)
    assert all(end.metrics["negative_tension_steps"] > 0 for end in run_all(scenes))


@pytest.mark.long
def test_metrics_of_other_cranes_compile() -> None:
    """Metrics of a crane without commands are compiled, too, and are those of its run."""
    check_metrics([load_scene("pendulum_free", {"duration": 0.1})])


def check_metrics(scenes: list[Scene]) -> None:
    """Check that scenes run together have the metrics, errors and events of `simulate`."""
    assert all(map(has_compiled_metrics, scenes))
    for scene, ended in zip(scenes, run_all(scenes), strict=True):
        try:
            run, error = simulate(scene), None
        except SimulationError as failure:
            run, error = failure.run, str(failure)
        assert (ended.metrics, ended.error, ended.events) == (flatten(run.summary), error, ())


def test_cranes_of_different_kinds_run_in_groups() -> None:
    """Methods and models may differ: each crane ends as alone, in the order of the parameters.

    So it does, with the same samples, where metrics are asked for.
    """
    methods = [
        {"method": "rk4", "step": 0.01},
        {"method": "dop853"},
        {"method": "rk4", "step": 0.005},
    ]
    friction = [None, {"trolley": {"coulomb": 1.0, "static": 2.0}}, None]
    document = load_scene("overhead_swing", {"duration": 0.1}).to_dict()
    parameters = {"integrator": methods, "friction": friction}
    batch, measured = (
        simulate_batch(document, parameters, sample_times=[0.05], metrics=m) for m in (False, True)
    )
    for i, (method, group) in enumerate(zip(methods, friction, strict=True)):
        alone = simulate(
            load_scene(document, {"integrator": method, "friction": group}), sample_times=[0.05]
        )
        for each in (batch, measured):
            np.testing.assert_array_equal(each.sampled_q[i], alone.q)
            assert each.steps[i] == alone.stats["steps"]


FORCES = [{"kind": "constant", "value": value} for value in (*range(N - 1), 1e200)]
FAILURES: dict[str, tuple[str, dict[str, Any], str, list[Any], int]] = {
    "overflow in a lane": ("overhead_swing", FIXED, "inputs.trolley", FORCES, N - 1),
    "end of the rail": (
        "overhead_coulomb",
        {},
        "trolley.limits",
        [[-9.0, 9.0], [-9.0, 0.005], [-9.0, 9.0]],
        1,
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("kind", FAILURES)
def test_a_crane_that_fails_fails_alone(kind: str) -> None:
    """A crane that fails has the error and the state of `simulate`; the others continue."""
    name, overrides, key, values, bad = FAILURES[kind]
    document = load_scene(name, overrides | {"duration": TIMES[-1]}).to_dict()
    batch = simulate_batch(document, {key: values}, sample_times=TIMES)
    with pytest.raises(SimulationError) as failure:
        simulate(load_scene(document, {key: values[bad]}))
    assert (
        [error for error in batch.errors if error is not None]
        == [batch.errors[bad]]
        == [str(failure.value)]
    )
    np.testing.assert_array_equal(batch.q[bad], failure.value.run.q[-1])
    assert batch.t[bad] == failure.value.run.t[-1] < TIMES[-1]
    np.testing.assert_array_equal(
        np.isnan(batch.sampled_q[bad, :, 0]), np.array(TIMES) > batch.t[bad]
    )
    alone = simulate(load_scene(document, {key: values[bad - 1]}))
    np.testing.assert_array_equal(batch.q[bad - 1], alone.q[-1])


REJECTED: dict[str, tuple[str, dict[str, Any], str]] = {
    "nothing varies": ("overhead_swing", {}, "parameters: are empty"),
    "one value": (
        "overhead_swing",
        {"payload.mass": 3.0},
        "'payload.mass' = 3.0: must be an array",
    ),
    "lengths": (
        "overhead_swing",
        {"payload.mass": [1.0, 2.0], "trolley.mass": [1.0]},
        "'trolley.mass' has 1 entries",
    ),
    "no crane": ("overhead_swing", {"payload.mass": []}, "'payload.mass' is empty"),
    "a bad value": (
        "overhead_swing",
        {"payload.mass": [1.0, -2.0]},
        "crane 1: scene overhead_swing: payload.mass",
    ),
    "two times": (
        "overhead_swing",
        {"duration": [1.0, 2.0]},
        "crane 1: duration = 2.0, that of crane 0 is 1.0",
    ),
    "two sizes": (
        "overhead_chain",
        {"cable.links": [10, 12]},
        "crane 1: its joints are",
    ),
}


@pytest.mark.parametrize("kind", REJECTED)
def test_mistakes_name_the_culprit(kind: str) -> None:
    """An impossible batch is rejected before any run, in one line naming parameter or crane."""
    name, parameters, message = REJECTED[kind]
    with pytest.raises(SceneError) as caught:
        simulate_batch(name, parameters)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_law_without_compiled_form_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that is not compiled is rejected with its name: in a batch it could not run."""

    class Still:
        def __call__(
            self, t: float, q: tuple[float, ...], v: tuple[float, ...]
        ) -> tuple[float, ...]:
            return (0.0,)

    monkeypatch.setattr(
        "crane_sim.scenes.scene.make_laws",
        lambda name, settings, nominals: [Still()] * len(nominals),
    )
    with pytest.raises(SceneError, match="control.law = 'energy': has no compiled form"):
        simulate_batch("overhead_energy", MASSES)
