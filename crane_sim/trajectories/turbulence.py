"""Spectra of atmospheric turbulence, and gusts that have them, drawn by seeded generators.

Kaimal: IEC 61400-1:2005, annex B, eq. (B.14) and table B.1, Λ₁ of eq. (5). Dryden, von Karman:
MIL-HDBK-1797, forms of the disturbance model; length scales and deviations of its low-altitude
model. The one-sided spectrum of a component of variance σ² and length scale L in a mean U is S(f) =
σ² (L / U) s(f L / U). Its integral is exactly σ²: what the standard prints as 1.339 of von Karman's
is here B(1/2, 1/3) / π.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.numerics.libm import arctan, power
from crane_sim.trajectories.wind import Gust

Array = npt.NDArray[np.float64]
BEYOND = 0.008
"""Part of the variance beyond the default cut-off: below it, a spectrum is less than 1 % above its
formula."""
LENGTHS_PER_PERIOD, MIN_LENGTHS_PER_PERIOD = 128, 8
"""Period of gusts in units of L / U, whose lines begin below the bend of the spectrum; the least
one."""
NODES_PER_CYCLE, MAX_NODES = 4, 2**20
"""Least number of nodes in a cycle of the cut-off, of which interpolation misses (π / 2)⁶ / 46080,
3e-4; of nodes."""
KARMAN = 1.3389852790652794  # B(1/2, 1/3) / π
LOWEST, HIGHEST = 3.048, 304.8  # m (10 and 1000 ft), between which the low-altitude model holds
FOOT = 0.3048  # m


class Spectrum(NamedTuple):
    """A spectrum without units, of x = f L / U.

    `component` is 0 of the gusts along the mean, 1 and 2 across it.
    """

    density: Callable[[Array, int], Array]  # s(x)
    below: Callable[[Array, int], Array]  # the part of the variance below x, the integral of s
    ratios: Callable[[float], tuple[float, ...]]  # σ of each component over the first one's at a
    # height [m]
    lengths: Callable[[float], tuple[float, ...]]  # L of each component [m] at a height [m]
    heights: tuple[float, float] = (0.0, np.inf)  # m, for which the two hold


class Band(NamedTuple):
    """Frequencies of a component's lines: 1 / period, 2 / period, ... up to the cut-off."""

    cut_off: float  # Hz
    period: float  # s
    nodes: int  # number of nodes in a period


def _kaimal_density(x: Array, component: int) -> Array:
    return 4.0 * power(1.0 + 6.0 * x, -5.0 / 3.0)


def _kaimal_below(x: Array, component: int) -> Array:
    return 1.0 - power(1.0 + 6.0 * x, -2.0 / 3.0)


def _kaimal_lengths(height: float) -> tuple[float, ...]:
    scale = 0.7 * min(height, 60.0)
    return 8.1 * scale, 2.7 * scale, 0.66 * scale


def _phase(x: Array, component: int) -> Array:
    """Return L Ω along the mean, 2 L Ω across it, Ω = 2 π f / U."""
    return (2.0 if component == 0 else 4.0) * np.pi * x


def _dryden_density(x: Array, component: int) -> Array:
    y2 = _phase(x, component) ** 2
    return 4.0 / (1.0 + y2) if component == 0 else 4.0 * (1.0 + 3.0 * y2) / (1.0 + y2) ** 2


def _dryden_below(x: Array, component: int) -> Array:
    y = _phase(x, component)
    return 2.0 / np.pi * arctan(y) - (0.0 if component == 0 else y / (1.0 + y * y) / np.pi)


def _karman_density(x: Array, component: int) -> Array:
    y2 = (KARMAN * _phase(x, component)) ** 2
    if component == 0:
        return 4.0 / power(1.0 + y2, 5.0 / 6.0)
    return 4.0 * (1.0 + 8.0 / 3.0 * y2) / power(1.0 + y2, 11.0 / 6.0)


def _karman_below(x: Array, component: int) -> Array:
    from scipy.special import betainc  # here: few scenes have one, and it takes long to import

    y2 = (KARMAN * _phase(x, component)) ** 2
    slow = betainc(0.5, 1.0 / 3.0, y2 / (1.0 + y2))
    return slow if component == 0 else (4.0 * slow - betainc(0.5, 4.0 / 3.0, y2 / (1.0 + y2))) / 3.0


def _low_altitude_ratios(height: float) -> tuple[float, ...]:
    return 1.0, 1.0, (0.177 + 0.000823 * height / FOOT) ** 0.4


def _low_altitude_lengths(height: float) -> tuple[float, ...]:
    along = height / (0.177 + 0.000823 * height / FOOT) ** 1.2
    return along, 0.5 * along, 0.5 * height


SPECTRA = {
    "kaimal": Spectrum(
        _kaimal_density, _kaimal_below, lambda height: (1.0, 0.8, 0.5), _kaimal_lengths
    ),
    "dryden": Spectrum(
        _dryden_density,
        _dryden_below,
        _low_altitude_ratios,
        _low_altitude_lengths,
        (LOWEST, HIGHEST),
    ),
    "von_karman": Spectrum(
        _karman_density,
        _karman_below,
        _low_altitude_ratios,
        _low_altitude_lengths,
        (LOWEST, HIGHEST),
    ),
}
"""Spectra by name."""


def beyond(spectrum: Spectrum, component: int, x: float) -> float:
    """Return the part of the variance beyond x = f L / U."""
    return 1.0 - float(spectrum.below(np.array(x), component))


def default_cut_off(spectrum: Spectrum, component: int) -> float:
    """Return the x = f L / U beyond which BEYOND of the variance is, by bisection."""
    low, high = 0.0, 20.0  # logarithms
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high)
            if beyond(spectrum, component, math.exp(middle)) > BEYOND
            else (low, middle)
        )
    return math.exp(low)


def band_of(scale: float, cut_off: float, duration: float) -> Band:
    """Return the band of a component of time scale L / U [s] in a run of `duration` [s].

    Raises:
        ValueError: the cut-off [Hz] is out of range; the message is what is possible.
    """
    period, longest = LENGTHS_PER_PERIOD * scale, MAX_NODES / (NODES_PER_CYCLE * cut_off)
    while period < duration and 2.0 * period <= longest:
        # so that few durations change the gusts of a seed
        period *= 2.0
    period = min(period, longest)
    low, high = (
        1.0 / (LENGTHS_PER_PERIOD * scale),
        MAX_NODES / (NODES_PER_CYCLE * MIN_LENGTHS_PER_PERIOD * scale),
    )
    if not low <= cut_off <= high:
        raise ValueError(
            f"must be {low:.3g} to {high:.3g} Hz for gusts of a time scale of {scale:.3g} s"
        )
    cycles = cut_off * period
    return Band(
        cut_off, period, 2 ** int(np.ceil(np.log2(NODES_PER_CYCLE * cycles * (1.0 - 1e-12))))
    )


def line_energies(spectrum: Spectrum, component: int, scale: float, band: Band) -> Array:
    """Return the parts (n,) of the variance, sum 1, in the lines 1 / period, 2 / period, ...

    Each is the integral of the spectrum over the line's bin, half a line to either side; the first
    bin begins at 0. All are larger by what is beyond the last one.
    """
    count = max(1, int(band.cut_off * band.period * (1.0 + 1e-12)))
    edges = np.append(0.0, (np.arange(count) + 1.5) / band.period)
    below = spectrum.below(edges * scale, component)
    return np.diff(below) / below[-1]


def draw_gust(energies: Array, deviation: float, band: Band, generator: Any) -> Gust:
    """Return a component of gusts of a standard deviation [m/s].

    Its lines have these energies and phases drawn at random.

    The mean square of its values at the nodes is the deviation's square: exact, up to rounding.
    """
    n, lines = band.nodes, 1 + np.arange(len(energies))
    phases = generator.uniform(0.0, 2.0 * np.pi, len(energies))
    sums = np.zeros(n // 2 + 1, complex)
    sums[lines] = 0.5 * n * deviation * np.sqrt(2.0 * energies) * np.exp(1j * phases)
    turns = np.zeros(n // 2 + 1, complex)
    turns[lines] = 2j * np.pi * lines / n  # i ω h
    columns = [np.fft.irfft(part, n) for part in (sums, sums * turns, 0.5 * sums * turns**2)]
    return Gust(n / band.period, np.ascontiguousarray(np.stack(columns, axis=1)))
