"""Parameters from measured runs: sensitivities, estimates, intervals; what is not identifiable."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import crane
from interval_coverage import CASES, MASSES, NOISE, Case, errors_of, measured
from scipy.integrate import solve_ivp

import crane_sim
from crane_sim.files.errors import SceneError
from crane_sim.identification import Measurements, estimation, from_rollout, read_measurements
from crane_sim.identification.least_squares import Linear, linearise
from crane_sim.identification.measurements import measurements_of, undo_sensors
from crane_sim.identification.shooting import Shooting, Unknowns, excitation_of
from crane_sim.integrators.dop853 import A, B

SCENE = "overhead_energy"
PERIOD = 0.01  # s


def extrapolate(function: Callable[[float], Any], h: float = 0.02, rows: int = 6) -> Any:
    """Return a function's derivative at 0: central differences, extrapolated to order 12."""
    table = [(function(h / 2**i) - function(-h / 2**i)) / (2.0 * h / 2**i) for i in range(rows)]
    for j in range(1, rows):
        table = [b + (b - a) / (4.0**j - 1.0) for a, b in zip(table, table[1:], strict=False)]
    return table[0]


def pendulum_on_trolley(y: Any, force: float, trolley: Any, load: Any, length: Any) -> Any:
    """Return the complex rates of (x, angle, x', angle') (4, n) of a trolley with one link.

    They are from its Lagrangian.
    """
    _, angle, v, w = y
    s, c = np.sin(angle), np.cos(angle)
    a = (force + load * s * (length * w * w + 9.81 * c)) / (trolley + load * s * s)
    return np.array([v, w, a, -(9.81 * s + c * a) / length])


def complex_step(data: Measurements, segment: Any) -> Any:
    """Return the derivatives (K, 2, 7) by logarithms and by the initial state.

    The logarithms are those of length, load and trolley.
    """
    h, nominal = 1e-30, np.array([2.0, 10.0, 20.0])
    length, load, trolley = nominal[:, None] * np.exp(1j * h * np.eye(3, 7))
    y = np.concatenate([segment.q, segment.v])[:, None] + 1j * h * np.eye(4, 7, 3)
    rows = [y]
    for force in data.commands[: len(data.t) - 1, 0]:
        slopes: list[Any] = [pendulum_on_trolley(y, force, trolley, load, length)]
        for stage in A:
            inner = sum(a * k for a, k in zip(stage, slopes, strict=True) if a is not None)
            slopes.append(pendulum_on_trolley(y + PERIOD * inner, force, trolley, load, length))
        y = y + PERIOD * sum(b * k for b, k in zip(B, slopes, strict=True) if b is not None)
        rows.append(y)
    return np.array(rows)[:, :2].imag / h


def test_sensitivities_are_complex_steps_of_the_equations() -> None:
    """Derivatives over 3 s are the complex step of the crane's equations, to rounding.

    The equations are written anew here.

    Those by parameters have that of the differences of the model's numbers, 1e-12; those by states
    1e-13.
    """
    data = from_rollout(crane_sim.simulate(SCENE, duration=3.0), NOISE)
    shooting = Shooting(crane_sim.load_scene(SCENE), data, [*MASSES], 3.0)
    expected = complex_step(data, shooting.segments[0])
    for i, column in enumerate(
        np.concatenate(shooting.sensitivities(shooting.start), axis=2).transpose(2, 0, 1)
    ):
        rounding = 2e-12 if i < len(MASSES) else 1e-13
        assert np.abs(column - expected[:, :, i]).max() < rounding * np.abs(expected[:, :, i]).max()


def swing_below_a_motion(t: Any, start: float, duration: float) -> Any:
    """Return angles (K,) below a trolley that goes 2 m by the quintic from `start`, by pieces."""

    def rates(at: float, y: Any) -> list[float]:
        s = (at - start) / duration
        pulled = (
            2.0 * (60.0 * s - 180.0 * s * s + 120.0 * s**3) / duration**2 if 0.0 < s < 1.0 else 0.0
        )
        return [y[1], -(9.81 * np.sin(y[0]) + pulled * np.cos(y[0])) / 2.0]

    y, angles, ends = np.array([0.2, 0.0]), np.empty(len(t)), (0.0, start, start + duration, t[-1])
    for begin, end in zip(ends, ends[1:], strict=False):
        found = solve_ivp(
            rates,
            (begin, end),
            y,
            "DOP853",
            rtol=1e-13,
            atol=1e-15,
            max_step=0.05,
            dense_output=True,
        )
        inside = (t >= begin) & (t <= end)
        angles[inside], y = found.sol(t[inside])[0], found.y[:, -1]
    return angles


def test_sensitivities_by_instants_of_a_motion() -> None:
    """Derivatives by start and duration of a prescribed motion are right to 1e-7.

    The reference is an independent solution.

    Forward mode alone would miss that its kinks move within steps.
    """
    motion = {"kind": "smooth", "start": 0.52, "duration": 2.0, "from": 0.0, "to": 2.0}
    changes = {
        "duration": 3.0,
        "trolley": {"drive": "prescribed", "motion": motion},
        "initial.angles": [0.2],
    }
    run = crane_sim.simulate(
        "overhead_swing", overrides=changes, sample_times=np.arange(0.0, 3.0, 0.05)
    )
    data = Measurements(run.t, run.scene.joint_names, run.q, np.zeros(1), np.zeros((1, 0)))
    keys = ["trolley.motion.start", "trolley.motion.duration"]
    shooting = Shooting(run.scene, data, keys, 5.0, {0: (run.q[0], run.v[0])})
    by_parameter, _ = shooting.sensitivities(shooting.start)
    for i, step in enumerate(np.eye(2)):

        def angles(h: float, step: Any = step) -> Any:
            return swing_below_a_motion(run.t, *(0.52, 2.0) * np.exp(h * step))

        expected = extrapolate(angles, 2e-3, 3)  # steps so small that no kink passes a sample
        assert np.abs(by_parameter[:, 1, i] - expected).max() < 1e-7 * np.abs(expected).max()


def test_sensitivities_are_extrapolated_differences() -> None:
    """Derivatives by a drive's lag and delay and by initial states are right to 1e-8.

    The reference is Richardson's extrapolation.
    """
    scene = crane_sim.load_scene(SCENE, {"actuators": {"trolley": {"delay": 0.0237, "lag": 0.05}}})
    data = from_rollout(crane_sim.simulate(scene, duration=4.0), NOISE)
    shooting = Shooting(scene, data, ["actuators.trolley.delay", "actuators.trolley.lag"], 2.0)
    logarithms, deviations = shooting.start
    by_parameter, by_state = shooting.sensitivities(shooting.start)
    for i, step in enumerate(np.eye(len(logarithms))):
        expected = extrapolate(
            lambda h, step=step: shooting.predict(Unknowns(logarithms + h * step, deviations))
        )
        assert np.abs(by_parameter[:, :, i] - expected).max() < 1e-8 * np.abs(expected).max()
    for j, step in enumerate(np.eye(deviations.shape[1])):
        expected = extrapolate(
            lambda h, step=step: shooting.predict(Unknowns(logarithms, deviations + h * step))
        )
        assert np.abs(by_state[:, :, j] - expected).max() < 1e-8 * np.abs(expected).max()


def test_a_run_that_fails_near_the_estimates_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a run that only the intervals need comes to no end, there are no intervals.

    This is a line, no error of LAPACK.
    """

    def fail(*args: Any) -> Linear:
        linear = linearise(*args)
        return linear._replace(by_parameter=np.full_like(linear.by_parameter, np.nan))

    monkeypatch.setattr(estimation, "linearise", fail)
    with pytest.raises(
        SceneError, match="^run: near the estimates the simulation fails; give a shorter segment$"
    ):
        crane_sim.identify(SCENE, crane_sim.simulate(SCENE, duration=3.0), ["trolley.mass"])


def test_a_run_without_noise_gives_the_true_parameters() -> None:
    """From exact positions a fit ends at the truth to 1e-7: only rounding is left.

    It begins 5 to 10 % away.
    """
    run = crane_sim.simulate(SCENE, overrides=MASSES | {"duration": 15.0})
    result = crane_sim.identify(SCENE, run, [*MASSES])
    assert result.overrides() == pytest.approx(MASSES, rel=1e-7)
    assert max(result.residual.values()) < 1e-8
    assert result.scene.model.cable.length == result.overrides()["cable.lengths.0"]
    assert not result.warnings  # what is left is rounding, not a model that lacks something
    for each in result.estimates:
        assert each.high - each.low > 1e-12 * each.value  # no interval is narrower than rounding


def test_a_first_guess_far_away_is_no_obstacle() -> None:
    """Shorter segments lead to the truth from twice the cable and half the trolley.

    Over 5 s that swing is another one.
    """
    far = crane_sim.load_scene(
        SCENE, {"cable.lengths.0": 4.0, "trolley.mass": 10.0, "cable.node_masses.0": 9.0}
    )
    run = crane_sim.simulate(SCENE, overrides=MASSES | {"duration": 15.0})
    found = crane_sim.identify(
        far, run, ["cable.lengths.0", "trolley.mass"], joints=["swing_1", "trolley"]
    )
    assert found.overrides() == pytest.approx(
        {"cable.lengths.0": 2.1, "trolley.mass": 22.0}, rel=1e-6
    )


@pytest.mark.long
def test_delay_and_lag_of_a_drive_are_told_apart() -> None:
    """A drive's delay and its lag come out to 2 %, without warning.

    On the way the delay is no whole number of periods.
    """
    case = CASES["delay and lag"]
    scene = crane_sim.load_scene(case.scene, dict(case.guess))
    result = crane_sim.identify(scene, measured(case, 1), [*case.truth])
    assert result.overrides() == pytest.approx(dict(case.truth), rel=0.02)
    assert not result.warnings


def share_inside(case: Case, seeds: int) -> float:
    """Return the share of true parameters inside their 95 % intervals.

    The runs differ in their noise.
    """
    errors = [error for seed in range(seeds) for error in errors_of(case, seed).values()]
    return float(np.mean(np.abs(errors) <= 1.0))


@pytest.mark.long
@pytest.mark.parametrize("name", CASES)
def test_intervals_hold_the_truth_in_90_to_99_percent(name: str) -> None:
    """Over 50 seeds 90 to 99 % of the 95 % intervals have the true parameter inside."""
    assert 0.9 <= share_inside(CASES[name], 50) <= 0.99


def test_sensors_are_undone(tmp_path: Path) -> None:
    """Positions without delay, rate, lost samples and bias of sensors are the true ones.

    They are those at the instants of samples.
    """
    sensors = {
        "all": {"delay": 0.03, "dropout": 0.2},
        "swing_1": {"rate": 50.0, "bias": [0.01, 0.0]},
    }
    run = crane_sim.simulate(SCENE, overrides={"sensors": sensors, "duration": 2.0, "seed": 3})
    data = read_measurements(run.record(tmp_path / "run.rrd"), run.scene)
    assert 0.0 <= data.t[0] < 0.1 and data.t[-1] <= 1.96 + 1e-9
    rows = np.rint(data.t / PERIOD).astype(int)
    there = np.isfinite(data.q)
    assert np.abs(data.q - run.q[rows])[there].max() < 1e-15
    assert np.all(rows[there[:, 1]] % 2 == 0)
    # of 197 and 98, a fifth is lost
    assert 130 < there[:, 0].sum() < 180 and 60 < there[:, 1].sum() < 95


@pytest.mark.parametrize("begin", [0, 1, 2, 3])
def test_slow_sensors_are_undone_of_a_bag_that_begins_mid_run(begin: int) -> None:
    """Samples of a slow sensor are at their instants, wherever a bag begins.

    The sensor is of every third period, and one period late.
    """
    run = crane_sim.simulate(SCENE, overrides={"duration": 1.0})
    scene = crane_sim.load_scene(
        SCENE, {"sensors": {"all": {"rate": 1.0 / (3 * PERIOD), "delay": PERIOD}}}
    )
    published = np.maximum((np.arange(len(run.t)) - 1) // 3 * 3, 0)
    bag = from_rollout(run)._replace(t=run.t[begin:] - run.t[begin], q=run.q[published[begin:]])
    data = undo_sensors(bag, scene)
    rows = np.rint(data.t / PERIOD).astype(int) + begin
    assert np.all(rows % 3 == 0) and len(rows) > 30
    np.testing.assert_array_equal(data.q, run.q[rows])


def test_what_cannot_be_told_apart_is_refused() -> None:
    """In a free swing only the ratio of the masses acts: both are named.

    What nothing shows is named alone.
    """
    swing = crane_sim.load_scene("overhead_swing")
    data = from_rollout(crane_sim.simulate(swing), 1e-3)
    line = (
        r"^trolley.mass, cable.node_masses.0: not identifiable from this run, cannot be told apart"
    )
    with pytest.raises(SceneError, match=line):
        crane_sim.identify(swing, data, ["trolley.mass", "cable.node_masses.0"])
    moving = from_rollout(crane_sim.simulate(SCENE, duration=5.0), NOISE)
    with pytest.raises(
        SceneError, match=r"^brake.capacity.0: not identifiable from this run, has no influence"
    ):
        crane_sim.identify(
            crane_sim.load_scene(SCENE, {"brake.capacity": [150.0]}), moving, ["brake.capacity.0"]
        )
    resting = moving._replace(q=np.random.default_rng(0).normal(0.0, NOISE, moving.q.shape))
    with pytest.raises(SceneError, match="no motion stands out of the noise"):
        crane_sim.identify(SCENE, resting, ["trolley.mass"])


def test_residuals_that_are_no_noise_are_said() -> None:
    """A cable of another length leaves correlated residuals.

    A line says that intervals are too narrow.
    """
    found = crane_sim.identify(SCENE, measured(CASES["masses and length"], 0), ["trolley.mass"])
    assert any("residuals are correlated" in line for line in found.warnings)


@pytest.mark.long
def test_the_command_writes_a_scene_results_and_a_picture(tmp_path: Path) -> None:
    """`crane identify` of a recording writes what `crane check` takes.

    An unknown joint is one line and exit code 2.
    """
    crane_sim.simulate(SCENE, overrides=MASSES | {"duration": 5.0}).record(tmp_path / "rig.rrd")
    words = (
        "identify",
        SCENE,
        "rig.rrd",
        "--parameters",
        "cable.lengths.0,trolley.mass",
        "-o",
        "out",
    )
    done = crane(*words, "--set", "cable.node_masses.0=9", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    written = crane_sim.load_scene(tmp_path / "out" / "scene.yaml")
    assert written.model.cable.length == pytest.approx(2.1, rel=1e-6)
    assert (tmp_path / "out" / "fit.png").stat().st_size > 10_000 and (
        tmp_path / "out" / "estimate.json"
    ).is_file()
    refused = crane(*words[:-1], "other", "--joints", "jib", cwd=tmp_path)
    assert refused.returncode == 2 and "joint 'jib': is not measured" in refused.stderr
    assert refused.stderr.count("\n") == 1 and not (tmp_path / "other").exists()


@pytest.mark.parametrize(
    ("parameters", "options", "line"),
    [
        (["trolley.mas"], {}, "parameter trolley.mas: the scene has no trolley.mas of its own"),
        (["control.law"], {}, "parameter control.law: group control is not part of the crane"),
        (["trolley.mass", "trolley.mass"], {}, "must be one key of the scene or more, each once"),
        (
            ["trolley.mass"],
            {"joints": ["jib"]},
            "joint 'jib': is not measured; measured are trolley, swing_1",
        ),
        (
            ["trolley.mass"],
            {"segment": 0.1},
            "segment = 0.1 s: has fewer than 30 measured positions",
        ),
        (["trolley.mass"], {"segment": -1.0}, "segment = -1.0: must be greater than 0"),
        ("trolley.mass", {}, "parameters = 'trolley.mass': must be a list, as ['trolley.mass']"),
    ],
)
def test_bad_input_is_one_line(
    parameters: list[str] | str, options: dict[str, Any], line: str
) -> None:
    """A key, joint or length that is not possible is named in one line."""
    t = np.linspace(0.0, 0.99, 100)
    data = Measurements(
        t, ("trolley", "swing_1"), np.column_stack([t, np.sin(t)]), t, np.zeros((100, 1))
    )
    with pytest.raises(SceneError) as raised:
        crane_sim.identify(SCENE, data, parameters, **options)
    assert line in str(raised.value) and "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"joints": ("trolley", "swing1")},
            "measurements: unknown joint 'swing1', did you mean 'swing_1'?",
        ),
        ({"joints": ("trolley",)}, "measurements: q has the shape (100, 2), must have (100, 1)"),
        (
            {"commands": np.zeros(100)},
            "measurements: commands has the shape (100,), must have (100, 1)",
        ),
        (
            {"commands": np.zeros((10, 1))},
            "measurements: commands has the shape (10, 1), must have (100, 1)",
        ),
    ],
)
def test_measurements_of_ones_own_are_checked(changes: dict[str, Any], line: str) -> None:
    """A joint that the scene lacks, or an array of another shape, is named in one line.

    Nothing is left out.
    """
    t = np.linspace(0.0, 0.99, 100)
    data = Measurements(
        t, ("trolley", "swing_1"), np.column_stack([t, np.sin(t)]), t, np.zeros((100, 1))
    )
    with pytest.raises(SceneError) as raised:
        crane_sim.identify(SCENE, data._replace(**changes), ["trolley.mass"])
    assert line in str(raised.value) and "\n" not in str(raised.value)


OPEN_LOOP: dict[str, Any] = {"control": None, "reference": None, "duration": 0.5}


@pytest.mark.parametrize(
    "drive",
    [{"lag": 0.05}, {"drive": "velocity", "servo": {"gain": 500.0, "max_acceleration": 1.0}}],
)
@pytest.mark.parametrize("is_recorded", [False, True])
def test_inputs_of_drives_that_hold_them_are_commands(
    drive: dict[str, Any], is_recorded: bool, tmp_path: Path
) -> None:
    """A run in open loop has the inputs at the starts of periods as commands.

    Its drive has a lag or a servo.
    """
    sine = {"kind": "sine", "amplitude": 0.5, "frequency": 3.0}
    scene = crane_sim.load_scene(
        SCENE, OPEN_LOOP | {"inputs": {"trolley": sine}, "actuators": {"trolley": drive}}
    )
    run = crane_sim.simulate(scene)
    data = measurements_of(run.record(tmp_path / "run.rrd") if is_recorded else run, scene)
    assert data.commands[:, 0] == pytest.approx(
        0.5 * np.sin(3.0 * PERIOD * np.arange(len(data.commands))), abs=1e-14
    )
    again = Shooting(scene, data, ["cable.lengths.0"], 1.0, {0: (run.q[0], run.v[0])})
    # tolerances of both runs are below
    assert np.abs(again.predict(again.start) - data.q).max() < 1e-9


def test_what_commands_are_possible_is_said(tmp_path: Path) -> None:
    """Inputs that act between samples are refused by joint; constant ones are commands."""
    inputs: dict[str, Any] = {"trolley": {"kind": "sine", "amplitude": 20.0, "frequency": 3.0}}
    run = crane_sim.simulate(SCENE, overrides=OPEN_LOOP | {"inputs": inputs})
    with pytest.raises(
        SceneError,
        match="run: has no commands of trolley, which acted between .* possible: commands of",
    ):
        from_rollout(run)
    run = crane_sim.simulate(
        SCENE, overrides=OPEN_LOOP | {"inputs": {"trolley": {"kind": "constant", "value": 20.0}}}
    )
    assert np.all(from_rollout(run).commands == 20.0)


@pytest.mark.parametrize(("from_start", "before"), [(True, 0.0), (False, 7.0)])
def test_before_the_first_command_stands_it_or_the_initial_demand(
    from_start: bool, before: float
) -> None:
    """A delayed drive begins with its initial demand, in a log under way with its first command."""
    scene = crane_sim.load_scene(SCENE, {"actuators.trolley.delay": 0.025})
    t = PERIOD * np.arange(6)
    data = Measurements(t, ("trolley",), t[:, None], t, np.full((6, 1), 7.0), from_start)
    times, commands = excitation_of(scene, data)
    assert commands[:, 0].tolist() == np.where(times < 0.025 - 1e-9, before, 7.0).tolist()


def test_commands_in_another_unit_are_refused(tmp_path: Path) -> None:
    """A run of commanded trolley speeds is no run of a scene with commanded trolley forces."""
    drive = {
        "drive": "velocity",
        "servo": {"gain": 500.0, "integral_time": 1.0, "max_acceleration": 1.0},
    }
    overrides = {"control": None, "reference": None, "actuators": {"trolley": drive}}
    run = crane_sim.simulate(SCENE, lambda t, q, v: (0.3,), 0.2, overrides=overrides)
    file = run.record(tmp_path / "run.rrd")
    with pytest.raises(
        SceneError, match="commands of trolley are in m/s, the scene's drive takes N"
    ):
        read_measurements(file, crane_sim.load_scene(SCENE))
