"""Sensors and actuators: each effect against its formula, or against a computation of its own."""

from math import cos, erfc, exp, floor, sqrt
from typing import Any

import numpy as np
import pytest
from hardware_scenes import PERIOD, history, rod
from random_reference import normal, uniform
from scipy.integrate import solve_ivp

from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate


def test_noise_is_drawn_by_seed_signal_and_step() -> None:
    """Every noise is the number of seed, signal and step, by Python's whole numbers."""
    scene = rod(seed=2**63 - 5, sensors={"all": {"noise": [0.1, 0.2]}})
    true, measured, _ = history(scene, 50)
    for j, deviation in enumerate((0.1, 0.1, 0.2, 0.2)):
        expected = [deviation * normal(2**63 - 5, 3 * j, k) for k in range(50)]
        # a sum with a coordinate of size 1 keeps 16 digits of it, logarithm and cosine are within a
        # few ulp
        assert measured[:, j] - true[:, j] == pytest.approx(expected, abs=1e-14)


def test_noise_is_normal_unbiased_and_repeats() -> None:
    """Noise has the scene's deviation and bias, is normal, and is the same every time."""
    scene = rod(seed=3, sensors={"all": {"noise": 0.01, "bias": [0.5, -0.25]}})
    true, measured, _ = history(scene, 3000)
    noise = (measured - true - [0.5, 0.5, -0.25, -0.25]) / 0.01
    n = noise.size
    assert abs(noise.mean()) < 5.0 / sqrt(n)  # five standard errors: one seed in two million fails
    assert abs(noise.var() - 1.0) < 5.0 * sqrt(2.0 / n)
    for size in (0.5, 1.0, 2.0, 3.0):
        share = erfc(size / sqrt(2.0))
        assert abs((abs(noise) > size).mean() - share) < 5.0 * sqrt(share * (1.0 - share) / n)
    neighbours = [
        noise[:-1, 0] * noise[1:, 0],
        noise[:, 0] * noise[:, 1],
        noise[:, 0] * noise[:, 2],
    ]
    assert all(abs(product.mean()) < 5.0 / sqrt(len(product)) for product in neighbours)
    assert np.array_equal(history(scene, 300)[1], measured[:300])
    assert not np.any(
        history(rod(seed=4, sensors={"all": {"noise": 0.01}}), 20)[1] == measured[:20]
    )


def test_digits_and_delay_are_exact() -> None:
    """A sensor shows the nearest multiple of its step, delayed by whole periods, to the bit."""
    sensors = {"trolley": {"quantisation": [0.003, 0.01]}, "swing_1": {"delay": 0.04}}
    true, measured, _ = history(rod(sensors=sensors), 60)
    for j, step in ((0, 0.003), (2, 0.01)):
        assert measured[:, j].tolist() == [step * floor(x / step + 0.5) for x in true[:, j]]
    late = np.maximum(np.arange(60) - 4, 0)
    assert np.array_equal(measured[:, [1, 3]], true[late][:, [1, 3]])


def test_rate_and_dropout() -> None:
    """Samples are taken at their rate and lost by chance; the last one stays, losses count.

    The summary has the counts.
    """
    scene = rod(
        seed=11, duration=50.0, sensors={"trolley": {"rate": 25.0, "dropout": 0.3, "delay": 0.02}}
    )
    plant, lost, held, measured = Plant(scene), 0, [], []
    last = 0.0
    for k in range(4000):
        if k % 4 == 0:
            gone = k > 0 and uniform(11, 2, k) < 0.3
            lost, last = lost + gone, last if gone else plant.q[0]
        held.append(last)
        measured.append(plant.seen[0][0])
        plant.advance((0.0,))
    assert measured[2:] == held[:-2] and measured[:2] == held[:1] * 2
    assert abs(lost / 999 - 0.3) < 5.0 * sqrt(0.3 * 0.7 / 999)
    # the velocity's samples are lost, too
    speeds = sum(uniform(11, 3 * 2 + 2, k) < 0.3 for k in range(4, 4001, 4))
    assert plant.summary()["lost_samples"] == lost + speeds + (uniform(11, 2, 4000) < 0.3)


def test_what_is_not_whole_periods_is_said() -> None:
    """Delays and rates that are not whole periods are rounded; the scene's notes say so once."""
    scene = rod(sensors={"all": {"delay": 0.024}, "trolley": {"rate": 30.0}})
    assert scene.notes["rounded"] == [
        "sensors.all.delay: 0.024 s is taken as 0.02 s",
        "sensors.trolley.rate: 0.0333333 s is taken as 0.03 s",
    ]


def follow(actuator: dict[str, Any], demands: list[float], times: Any) -> tuple[Any, Any]:
    """Return (efforts at the times (m,), the whole run) under demands given every period."""
    scene = rod(duration=len(demands) * PERIOD, actuators={"trolley": actuator})
    run = simulate(scene, law=lambda t, q, v: (demands[round(t / PERIOD)],), sample_times=times)
    return run.u[:, 0], run


TIMES = np.linspace(0.0, 0.1, 201)[1:-1]  # s, also within periods


def test_a_lag_is_an_exponential() -> None:
    """An effort behind a lag is exponential between its demands, also within periods."""
    effort, run = follow({"lag": 0.03, "initial_demand": 2.0}, [2.0] * 2 + [10.0] * 8, TIMES)
    expected = [2.0 if t < 0.02 else 10.0 - 8.0 * exp(-(t - 0.02) / 0.03) for t in TIMES]
    # rounding of some exponentials, one for each period
    assert effort == pytest.approx(expected, rel=1e-13)
    # of the method's step: 1.2e-8 with the same efforts and no lag
    assert run.summary["energy_audit_error"] < 1e-7


def test_a_rate_limit_is_a_ramp() -> None:
    """An effort of limited rate is a ramp that ends at the demand, within a period."""
    effort, run = follow({"rate_limit": 300.0}, [0.0] + [10.0] * 5 + [8.0] * 4, TIMES)
    up = np.clip(300.0 * (TIMES - 0.01), 0.0, 10.0)
    down = 10.0 - np.clip(300.0 * (TIMES - 0.06), 0.0, 2.0)
    assert effort == pytest.approx(np.minimum(up, down), rel=1e-12)
    assert run.summary["energy_audit_error"] < 1e-7


def test_lag_and_rate_limit_together() -> None:
    """With both, the effort solves u' = (demand - u) / lag within the rate limit.

    An integrator finds the same.
    """
    effort, _ = follow({"rate_limit": 150.0, "lag": 0.02}, [0.0] + [10.0] * 9, TIMES)
    solution = solve_ivp(
        lambda t, u: np.clip((10.0 - u) / 0.02, -150.0, 150.0),
        (0.01, 0.1),
        [0.0],
        t_eval=TIMES[TIMES > 0.01],
        rtol=1e-11,
        atol=1e-12,
        max_step=1e-4,  # the slope's kink is no step's end: an error of its square
    )
    assert effort[TIMES > 0.01] == pytest.approx(solution.y[0], abs=1e-7)


def test_limit_deadband_and_delay() -> None:
    """A demand comes late, does nothing in the dead band, and is limited.

    The summary counts the limited ones.
    """
    actuator = {"limit": [-3.0, 4.0], "deadband": 1.0, "delay": 0.03}
    scene = rod(actuators={"trolley": actuator})
    demands = [6.0 * cos(0.37 * k) for k in range(100)]
    _, _, applied = history(scene, 100, lambda t: demands[round(t / PERIOD)])
    late = [demands[k - 3] if k >= 3 else 0.0 for k in range(100)]
    assert applied.tolist() == [0.0 if abs(d) < 1.0 else min(max(d, -3.0), 4.0) for d in late]
    plant = Plant(scene)
    for demand in demands:
        plant.advance((demand,))
    assert plant.saturated == sum(not -3.0 <= d <= 4.0 for d in late)


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ({"sensors": {"troley": {}}}, "sensors: unknown joint 'troley', did you mean 'trolley'?"),
        (
            {"sensors": {"all": {"noisy": 1.0}}},
            "sensors.all: unknown key 'noisy', did you mean 'noise'?",
        ),
        (
            {"sensors": {"all": {"noise": -1.0}}},
            "sensors.all.noise[0] = -1.0: must be greater than or equal to 0",
        ),
        (
            {"sensors": {"all": {"dropout": 1.5}}},
            "sensors.all.dropout = 1.5: must be less than or equal to 1",
        ),
        (
            {"sensors": {"all": {"delay": 1e6}}},
            "sensors.all.delay: 1e+06 s is more than 100000 periods of 0.01 s",
        ),
        ({"actuators": {"swing_1": {}}}, "actuators: unknown joint 'swing_1'"),
        (
            {"actuators": {"all": {"limit": [2.0, 1.0]}}},
            "limit = [2.0, 1.0]: must be [low, high] with low < high",
        ),
        ({"actuators": {"all": {"lag": "slow"}}}, "actuators.all.lag = 'slow'"),
        (
            {"brake": {"capacity": [1.0, 2.0]}},
            "brake.capacity: has 2 values, the actuated joints are trolley",
        ),
        (
            {"faults": {"Bad name": {"kind": "payload", "mass": 1.0}}},
            "'Bad name': a fault's name is of small letters",
        ),
        (
            {"faults": {"a": {"kind": "stick"}}},
            "faults.a: kind 'stick' is unknown; possible: sensor_stuck",
        ),
        (
            {"faults": {"a": {"kind": "stuck", "joint": "swing_1"}}},
            "faults.a.joint: unknown joint 'swing_1'",
        ),
        (
            {"faults": {"a": {"kind": "stuck", "joint": "trolley", "until": 1.0}}},
            "faults.a: until = 1: needs an at",
        ),
        (
            {"faults": {"a": {"kind": "payload", "mass": 0.0}}},
            "faults.a.mass = 0.0: must be greater than 0",
        ),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value[:24],
)
def test_mistakes_are_reported_in_one_line(groups: dict[str, Any], message: str) -> None:
    """A mistake in a group of hardware is a single-line error with the key."""
    with pytest.raises(ValueError) as caught:
        rod(**groups)
    assert message in str(caught.value) and "\n" not in str(caught.value)
