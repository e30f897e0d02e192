"""The campaigns of cranebench on our crane: the published equations, the laws, and cranebench itself where it is."""

import re

import numpy as np
import numpy.typing as npt
import pytest

from crane_bench.speed import campaign, campaign_laws, campaign_runs
from crane_bench.speed.engine import EngineUnavailable
from crane_bench.speed.peers import cranebench_campaign
from crane_sim.files.errors import SceneError
from crane_sim.files.installation import how_to_install

Array = npt.NDArray[np.float64]
SAMPLE = campaign_runs.CampaignSample(4400.0, 10.5, 30.0, 290.0, 11.0, None)
PERIODS, INNER = 200, 5  # of 10 ms, and steps in each


def accelerations(x: Array, u: Array, force: float) -> Array:
    """Return q'' of trolley, rope length and swing: Lagrange's equations of two masses, g = 9.80665 m/s²."""
    m, _, c_swing, b_trolley, _, _ = SAMPLE
    _, length, angle, trolley_rate, length_rate, rate = x
    s, c = np.sin(angle), np.cos(angle)
    mass = np.array(
        [[1500.0 + m, m * s, m * length * c], [m * s, m + 300.0, 0.0], [m * length * c, 0.0, m * length**2]]
    )
    inertial = m * np.array(
        [
            2.0 * length_rate * rate * c - length * rate**2 * s,
            -length * rate**2 - 9.80665 * c,
            2.0 * length * length_rate * rate + 9.80665 * length * s,
        ]
    )
    damped = np.array([b_trolley * trolley_rate, 120.0 * length_rate, c_swing * rate])
    pushed = np.array([u[0] + force, u[1] + force * s, force * length * c])
    return np.asarray(np.linalg.solve(mass, pushed - damped - inertial), np.float64)


def derivative(x: Array, u: Array) -> Array:
    """Return the derivative of (q, q')."""
    return np.concatenate([x[3:], accelerations(x, u, 0.0)])


def quintic(t: float) -> tuple[float, float]:
    """Return position [m] and velocity [m/s] of 20 m in 20 s from rest to rest."""
    s = min(max(t / 20.0, 0.0), 1.0)
    return 20.0 * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5), 30.0 * s**2 - 60.0 * s**3 + 30.0 * s**4


def published_command(name: str, t: float, x: Array) -> Array:
    """Return the commands of PD, ZVD or HSMC as published, each term by itself."""
    weight, omega, z = -4400.0 * 9.80665, np.sqrt(9.80665 / 10.5), 0.02
    k, half = np.exp(-z * np.pi / np.sqrt(1.0 - z**2)), np.pi / (omega * np.sqrt(1.0 - z**2))
    taps = [(1.0, 0.0), (2.0 * k, half), (k * k, 2.0 * half)] if name == "ZVD" else [(1.0, 0.0)]
    total = sum(part for part, _ in taps)
    position, velocity = (sum(part * quintic(t - delay)[i] for part, delay in taps) / total for i in (0, 1))
    if name != "HSMC":
        pull = 6e3 * (position - x[0]) + 2.4e4 * (velocity - x[3])
        return np.array([pull, weight + 4e4 * (10.5 - x[1]) - 6e4 * x[4]])
    s = x[3] - velocity + 1.1 * (x[0] - position) + 0.4 * (x[5] + 1.3 * x[2])
    hoist = x[4] + 2.0 * (x[1] - 10.5)
    return np.array(
        [-2.2e4 * s - 6e3 * np.tanh(s / 0.06), weight - 6e4 * hoist - 1e4 * np.tanh(hoist / 0.06)],
    )


def integrate(name: str) -> tuple[Array, Array]:
    """Return states (n, 6) and commands (n, 2) every 2 ms of the classical order 4, commands held for 10 ms."""
    x, h, states, commands = np.array([0.0, 10.5, 0.0, 0.0, 0.0, 0.0]), 0.002, list[Array](), list[Array]()
    for period in range(PERIODS):
        u = published_command(name, 0.01 * period, x)
        for _ in range(INNER):
            states.append(x)
            commands.append(u)
            k1 = derivative(x, u)
            k2 = derivative(x + 0.5 * h * k1, u)
            k3 = derivative(x + 0.5 * h * k2, u)
            x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + derivative(x + h * k3, u))
    return np.array(states), np.array(commands)


def test_closed_loops_are_those_of_the_published_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Our crane under PD, ZVD and HSMC moves as the published equations do, integrated here by numpy alone."""
    monkeypatch.setitem(campaign_runs.SCENE, "duration", 0.01 * PERIODS)
    for name in ("PD", "ZVD", "HSMC"):
        _, q, v, u = campaign_runs.trajectories(campaign_runs.make_scenes([SAMPLE], name))
        states, commands = integrate(name)
        ours = np.hstack([q[0, :-1], v[0, :-1]])
        assert np.max(np.abs(ours - states)) < 1e-9  # m, rad: the same method and step, so rounding alone
        apart = np.abs(u[0, :-1] - commands)
        assert np.max(np.min([apart[1:], apart[:-1]], axis=0)) < 1e-4  # N; a time on a period's edge may be either's


def test_the_command_changes_by_no_more_than_the_drive_allows() -> None:
    """After its first command the law's next one is at most one period's change away, and a new run begins anew."""
    law = campaign_laws.make_campaign_law("PD", campaign_runs.calm_scene(SAMPLE), (290.0, 120.0))
    rest, far = (0.0, 10.5, 0.0), (-5.0, 15.0, 0.0)
    first = law(0.0, rest, (0.0, 0.0, 0.0))
    assert np.array(law(0.01, far, (0.0, 0.0, 0.0))) - first == pytest.approx((1600.0, -3200.0))  # 1.6e5, 3.2e5 N/s
    assert law.with_initial_state()(0.0, far, (0.0, 0.0, 0.0))[0] == pytest.approx(30_000.0)


def test_metrics_of_a_known_motion() -> None:
    """A constant error of 0.1 m that ends at 30 s and a swing of 2 degrees have the metrics computed by hand."""
    times = np.linspace(0.0, 40.0, 4001)
    q = np.zeros((1, 4001, 3))
    q[0, :, 0] = campaign_runs.reference_positions(times) + np.where(times < 29.995, 0.1, 0.0)
    q[0, :, 2] = np.radians(2.0) * np.where(np.arange(4001) % 2, 1.0, -1.0)
    u = np.stack([np.where(np.arange(4001) % 2, 30.0, 10.0), np.zeros(4001)], axis=1)[None]
    metrics = campaign_runs.compute_metrics(times, q, u)
    expected = {"settle_time": 30.0, "peak_swing": 2.0, "residual_swing": 2.0, "final_pos_err": 0.0}
    expected |= {"peak_input": 30.0, "chatter": 80_000.0, "effort": 20_000.0, "ise_pos": 0.29995}
    for name, value in expected.items():
        assert metrics[name] == pytest.approx([value], rel=1e-9, abs=1e-12), name


def test_without_cranebench_one_line_names_the_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Absent the package, nothing is run, and the line says what to install."""

    def fail() -> str:
        raise EngineUnavailable("cranebench is not installed: no module")

    monkeypatch.setattr(cranebench_campaign, "find_cranebench_version", fail)
    with pytest.raises(SceneError, match=re.escape(how_to_install("peers"))):
        campaign.measure_campaign(1)


@pytest.mark.long
@pytest.mark.parametrize(("wind", "bound"), [("none", 1e-5), ("kaimal", 5e-3)])
def test_samples_agree_with_cranebench(wind: str, bound: float) -> None:
    """Both packages' swing and final error of each law differ by rounding when calm, in gusts by a held force."""
    pytest.importorskip("cranebench")
    cells = campaign.measure_campaign(2, [wind])["campaigns"][wind]["cells"]
    for law, metrics in cells.items():
        for name in ("peak_swing", "rms_swing", "residual_swing", "final_pos_err"):
            assert metrics[name][3] < bound, (law, name)
