"""Irregular seas: wave spectra, sampled to finite sums of sinusoids, and how a vessel answers them.

Spectra: Pierson and Moskowitz, J. Geophys. Res. 69 (1964); JONSWAP, Hasselmann et al., Dtsch.
Hydrogr. Z. A8 (1973); both by significant wave height and peak period as in DNV-RP-C205, 3.5.5.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.libm import exp, exponential, geometric_sequence, power

Array = npt.NDArray[np.float64]
NARROW, WIDE = 0.07, 0.09  # widths of the JONSWAP peak below and above the peak frequency
GRAVITY = 9.81  # m/s²
BREAKING_STEEPNESS = 1.0 / 7.0
"""Height over length at which a wave breaks in deep water (Michell, Phil. Mag. 36 (1893);
DNV-RP-C205, 3.4.6)."""
# highest sampled over peak frequency; the 0.2 % of energy above is redistributed
CUTOFF_RATIO = 5.0


class Sea(NamedTuple):
    """A long-crested stationary sea."""

    significant_height: float  # m, four times the standard deviation of the elevation
    peak_period: float  # s
    gamma: float = 1.0  # peak enhancement of JONSWAP; 1 is Pierson-Moskowitz


class ResponseAmplitudeOperator(NamedTuple):
    """Response amplitude operator (RAO) of one vessel motion: amplitude per metre, phase lead.

    The amplitude is per metre of wave.
    """

    frequencies: tuple[float, ...]  # rad/s, increasing
    amplitudes: tuple[float, ...]  # m/m, or rad/m
    phases: tuple[float, ...]  # rad


class SineSum(NamedTuple):
    """Sum over n of amplitudes[n] sin(frequencies[n] t + phases[n]).

    It is an elevation, or a motion of a vessel.
    """

    amplitudes: Any  # m, or rad
    frequencies: Any  # rad/s
    phases: Any  # rad


def steepness(sea: Sea) -> float:
    """Return the significant height over the length in deep water of a wave of the peak period."""
    return 2.0 * np.pi * sea.significant_height / (GRAVITY * sea.peak_period**2)


def max_observed_steepness(peak_period: float) -> float:
    """Return the largest steepness measured in seas of a peak period [s] (DNV-RP-C205, 3.5.4)."""
    return float(np.interp(peak_period, (8.0, 15.0), (1.0 / 15.0, 1.0 / 25.0)))


def _spectral_shape(x: Array, gamma: float) -> Array:
    """Return a spectrum without units at frequencies x in units of the peak frequency."""
    width = np.where(x <= 1.0, NARROW, WIDE)
    peak = exp(-0.5 * ((x - 1.0) / width) ** 2)
    return power(x, -5.0) * exp(-1.25 * power(x, -4.0)) * exponential(gamma, peak)


@lru_cache(maxsize=8)  # many seeds of one sea share it, and it takes as long as all else of a scene
def _split_energy(gamma: float) -> tuple[Array, Array]:
    """Return (frequencies in units of the peak's, energy below each of them), without units."""
    # exp(-154) of the energy is below, 1.5e-6 of it beyond
    x = geometric_sequence(0.3, 30.0, 40001)
    shape = _spectral_shape(x, gamma)
    return x, np.append(0.0, np.cumsum(0.5 * (shape[1:] + shape[:-1]) * np.diff(x)))


def density(sea: Sea, frequencies: Array) -> Array:
    """Return the one-sided spectral density [m² s/rad] of the elevation.

    The frequencies (n,) [rad/s] are greater than 0.

    Its integral is the variance of the elevation, the square of the significant height over 16,
    whatever gamma is.
    """
    peak = 2.0 * np.pi / sea.peak_period
    total = _split_energy(sea.gamma)[1][-1]
    return (
        sea.significant_height**2
        / 16.0
        * _spectral_shape(np.asarray(frequencies) / peak, sea.gamma)
        / (total * peak)
    )


def sample_sea(sea: Sea, count: int, seed: int) -> SineSum:
    """Return `count` sinusoids of equal energy with the spectrum's variance.

    The same seed gives the same ones.

    Each frequency is drawn from its own share of the energy: no two have a common period, and the
    sum does not repeat.
    """
    rng = np.random.default_rng(seed)
    x, energy = _split_energy(sea.gamma)
    shares = (np.arange(count) + rng.random(count)) / count * np.interp(CUTOFF_RATIO, x, energy)
    frequencies = np.interp(shares, energy, x) * 2.0 * np.pi / sea.peak_period
    amplitude = sea.significant_height / 4.0 * np.sqrt(2.0 / count)
    return SineSum(np.full(count, amplitude), frequencies, rng.uniform(0.0, 2.0 * np.pi, count))


def apply_response(waves: SineSum, response: ResponseAmplitudeOperator | float) -> SineSum:
    """Return the vessel's motion, in m or rad, in waves.

    The response is a table, whose ends are held, or one number per metre.

    Amplitudes are interpolated linearly, phases the short way round.
    """
    if not isinstance(response, ResponseAmplitudeOperator):
        return waves._replace(amplitudes=waves.amplitudes * response)
    w = waves.frequencies
    amplitudes = np.interp(w, response.frequencies, response.amplitudes)
    leads = np.interp(w, response.frequencies, np.unwrap(response.phases))
    return SineSum(waves.amplitudes * amplitudes, w, waves.phases + leads)
