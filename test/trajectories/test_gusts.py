"""Wind: standard spectra, gusts that have them, seeds, the mean by height, the grid in time."""

from math import log, pi
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import crane_sim
from crane_sim.trajectories.turbulence import (
    BEYOND,
    SPECTRA,
    band_of,
    default_cut_off,
    draw_gust,
    line_energies,
)
from crane_sim.trajectories.wind import Gust, LogarithmicLaw, PowerLaw, gust_at, speed_ratio

CASES = [(name, component) for name in SPECTRA for component in range(3)]
SPEED, LENGTH, SIGMA = 11.0, 70.0, 1.7


def printed(name: str, component: int, f: Any) -> Any:
    """Return the one-sided spectrum [m²/s] as the standards print it.

    IEC (B.14); MIL by Ω [rad/m], its area in f.
    """
    if name == "kaimal":
        return (
            SIGMA**2
            / f
            * (4.0 * f * LENGTH / SPEED)
            / (1.0 + 6.0 * f * LENGTH / SPEED) ** (5.0 / 3.0)
        )
    omega = 2.0 * pi * f / SPEED
    by_omega = {
        ("dryden", True): 2.0 / (1.0 + (LENGTH * omega) ** 2),
        ("dryden", False): 2.0
        * (1.0 + 12.0 * (LENGTH * omega) ** 2)
        / (1.0 + 4.0 * (LENGTH * omega) ** 2) ** 2,
        ("von_karman", True): 2.0 / (1.0 + (1.339 * LENGTH * omega) ** 2) ** (5.0 / 6.0),
        ("von_karman", False): 2.0
        * (1.0 + 8.0 / 3.0 * (2.678 * LENGTH * omega) ** 2)
        / (1.0 + (2.678 * LENGTH * omega) ** 2) ** (11.0 / 6.0),
    }
    return SIGMA**2 * LENGTH / pi * by_omega[name, component == 0] * 2.0 * pi / SPEED


def energy(name: str, component: int, low: float, high: float) -> float:
    """Return the integral of the printed spectrum from low to high [Hz]."""
    return quad(
        lambda s: np.exp(s) * printed(name, component, np.exp(s)), log(low), log(high), epsrel=1e-12
    )[0]


def gust_of(name: str, component: int, seed: int = 4) -> tuple[Gust, float]:
    """Return gusts with the default cut-off, and their period [s]."""
    scale = LENGTH / SPEED
    band = band_of(scale, default_cut_off(SPECTRA[name], component) / scale, 60.0)
    energies = line_energies(SPECTRA[name], component, scale, band)
    return draw_gust(energies, SIGMA, band, np.random.default_rng(seed)), band.period


@pytest.mark.parametrize(("name", "component"), CASES)
def test_spectra_are_those_of_the_standards(name: str, component: int) -> None:
    """Each spectrum is what its standard prints, and `below` is its integral, 1 in all."""
    spectrum, f = SPECTRA[name], np.geomspace(1e-4, 1e3, 40)
    actual = SIGMA**2 * LENGTH / SPEED * spectrum.density(f * LENGTH / SPEED, component)
    # 1.339 has four digits
    assert np.allclose(actual, printed(name, component, f), rtol=3e-5, atol=0.0)
    # x^(-2/3) is beyond
    assert float(spectrum.below(np.array(1e12), component)) == pytest.approx(1.0, abs=3e-8)
    for x in (0.003, 0.2, 5.0, 400.0):
        area = quad(
            lambda y: float(spectrum.density(np.array(y), component)),
            0.0,
            x,
            epsrel=1e-12,
            limit=200,
        )[0]
        assert float(spectrum.below(np.array(x), component)) == pytest.approx(area, rel=1e-9)


@pytest.mark.parametrize(("name", "component"), CASES)
def test_gusts_have_the_variance_and_the_spectrum(name: str, component: int) -> None:
    """The variance is σ² exactly, and each decade's energy the printed spectrum's within 1 %."""
    gust, period = gust_of(name, component)
    g = gust.nodes[:, 0]
    # rounding of some 1e5 values
    assert np.var(g) == pytest.approx(SIGMA**2, rel=1e-13) and abs(np.mean(g)) < 1e-13
    lines = 2.0 * np.abs(np.fft.rfft(g) / len(g)) ** 2
    last = int(np.flatnonzero(lines > 1e-20)[-1])
    ends = [0, *(n for n in (12, 120, 1200, 12_000) if n < last), last]
    for low, high in zip(
        ends, ends[1:], strict=False
    ):  # lines low + 1 .. high, whose bins meet half a line beyond
        below = (low + 0.5) / period if low else 1e-12
        expected = energy(name, component, below, (high + 0.5) / period)
        assert lines[low + 1 : high + 1].sum() == pytest.approx(expected, rel=0.01)
        # all are larger by the one part that is beyond; 1.339 has four digits
        assert lines[low + 1 : high + 1].sum() == pytest.approx(expected / (1.0 - BEYOND), rel=1e-4)


def test_interpolation_keeps_the_spectrum() -> None:
    """Between nodes the function has the lines' energies within 1e-6.

    No more than 1e-7 of the energy is in others.
    """
    gust, period = gust_of("dryden", 0)
    n = len(gust.nodes)
    fine = np.array([gust_at(gust, (k + 0.5) / gust.rate) for k in range(n)])
    assert np.allclose(
        [gust_at(gust, k / gust.rate) for k in range(0, n, 97)],
        gust.nodes[::97, 0],
        rtol=0,
        atol=1e-12,
    )
    both = np.stack([gust.nodes[:, 0], fine], axis=1).ravel()
    exact = 2.0 * np.abs(np.fft.rfft(gust.nodes[:, 0]) / n) ** 2
    lines = 2.0 * np.abs(np.fft.rfft(both) / len(both)) ** 2
    last = int(np.flatnonzero(exact > 1e-20)[-1])
    assert np.sum(np.abs(lines[: last + 1] - exact[: last + 1])) < 1e-6 * SIGMA**2
    # 3e-4 of amplitudes near the cut-off, squared
    assert np.sum(lines[last + 1 :]) < 1e-7 * SIGMA**2


def test_gusts_are_smooth_and_periodic() -> None:
    """At nodes value, slope and curvature are continuous, from the last node to the first, too."""
    gust, period = gust_of("dryden", 1)
    h, n = 1e-3 / gust.rate, len(gust.nodes)
    for k in (0, 5, n - 1):
        before, after = (
            [gust_at(gust, k / gust.rate + s * i * h) for i in range(4)] for s in (-1.0, 1.0)
        )
        slopes = [(-11 * g[0] + 18 * g[1] - 9 * g[2] + 2 * g[3]) / 6.0 for g in (before, after)]
        bends = [2 * g[0] - 5 * g[1] + 4 * g[2] - g[3] for g in (before, after)]
        assert -slopes[0] == pytest.approx(slopes[1], rel=1e-8) and bends[0] == pytest.approx(
            bends[1], rel=1e-3
        )
        assert gust_at(gust, k / gust.rate + period) == pytest.approx(after[0], rel=1e-9)


def scene_of(gusts: Any = None, **groups: Any) -> crane_sim.Scene:
    """Return a pendulum in wind, with a seed of 7."""
    wind = {"speed": 12.0, "direction": 0.6, "gusts": gusts}
    document = {
        "crane": "pendulum",
        "duration": 0.5,
        "seed": 7,
        "rope": {"length": 2.0},
        "payload": {"mass": 40.0, "windage": {"area": 1.5, "drag_coefficient": 1.2}},
        "initial": {"direction": [0.6, 0.0, -0.8]},
        "wind": wind,
    }
    return crane_sim.load_scene(document | groups)


GUSTS = {"spectrum": "kaimal", "intensity": 0.2, "cut_off": 1.0}


def nodes_of(scene: crane_sim.Scene) -> list[Any]:
    """Return the nodes of the three components."""
    return [gust.nodes for gust in scene.model.wind.gusts]


def test_a_seed_is_a_wind() -> None:
    """The same seed, by default the scene's, gives the same gusts; others and components differ.

    Gusts may have a seed of their own.
    """
    own, same, other = (nodes_of(scene_of(GUSTS | more)) for more in ({}, {"seed": 7}, {"seed": 8}))
    # half a second, or 45
    assert all(map(np.array_equal, own, nodes_of(scene_of(GUSTS, duration=45.0))))
    assert all(np.array_equal(a, b) for a, b in zip(own, same, strict=True))
    assert not any(np.allclose(a, b) for a, b in zip(own, other, strict=True))
    phases = [np.angle(np.fft.rfft(nodes[:, 0])[1:9]) for nodes in own]
    assert not np.allclose(phases[0], phases[1]) and not np.allclose(phases[1], phases[2])


def test_no_step_size_changes_the_wind() -> None:
    """The gusts are the same arrays for every step; solutions converge with order 4 to one run."""
    steps = [0.01, 0.005, 0.0025]  # a period is 10 ms
    exact = crane_sim.simulate(
        scene_of(GUSTS, integrator={"method": "dop853", "rtol": 1e-12, "atol": 1e-13})
    )
    errors = []
    for h in steps:
        run = crane_sim.simulate(scene_of(GUSTS, integrator={"method": "rk4", "step": h}))
        assert all(map(np.array_equal, nodes_of(run.scene), nodes_of(exact.scene)))
        errors.append(float(np.max(np.abs(run.q[-1] - exact.q[-1]))))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.5) and errors[-1] < 1e-10  # of steps of 1 / 400 of the cut-off's cycle


def test_the_summary_has_what_was_drawn() -> None:
    """The summary has the seed and realised deviations in the standard's ratio.

    It warns of what a low cut-off moves.
    """
    scene = scene_of(GUSTS, duration=0.1)
    drawn = scene.notes["wind"]["gusts"]
    assert drawn["seed"] == 7
    assert drawn["deviations"] == pytest.approx([2.4, 1.92, 1.2], rel=1e-12)  # rounding
    assert drawn["lengths"] == pytest.approx([56.7, 18.9, 4.62])  # 8.1, 2.7, 0.66 of 0.7 · 10 m
    assert min(drawn["repeat_after"]) > 1.0
    share = 100.0 * (1.0 + 6.0 * 56.7 / 12.0) ** (-2.0 / 3.0)
    assert f"{share:.3g} % of the variance along the mean is beyond" in scene.notes["warnings"][0]
    assert "warnings" not in scene_of(GUSTS | {"cut_off": None}).notes


@pytest.mark.parametrize(
    "law", [PowerLaw(0.2, 1.5), LogarithmicLaw(0.03, 1.5)], ids=["power", "logarithmic"]
)
def test_the_mean_by_height(law: Any) -> None:
    """The mean follows its law, is 1 at the reference height, and holds below the lowest one."""
    for z in (2.0, 10.0, 80.0):
        expected = (
            (z / 10.0) ** 0.2 if isinstance(law, PowerLaw) else log(z / 0.03) / log(10.0 / 0.03)
        )
        assert speed_ratio(law, z, 10.0) == pytest.approx(expected, rel=1e-14)
    assert speed_ratio(law, -3.0, 10.0) == speed_ratio(law, 1.5, 10.0)
