"""Input shaping: a reference that excites no swing of a known frequency.

A shaped reference is the sum of copies of the reference, each delayed and with its weight, such
that the swings that the copies excite cancel. ZV leaves none at the frequency itself; ZVD leaves a
residue there whose derivative with respect to the frequency vanishes too, at twice the delay
(Singer and Seering, Preshaping command inputs to reduce system vibration, ASME J. Dyn. Syst. Meas.
Control 112, 1990; Singhose, Command shaping for flexible systems, Int. J. Precis. Eng. Manuf. 10,
2009).
"""

from math import exp, pi, sqrt
from typing import Annotated, Literal, NamedTuple

from pydantic import Field

from crane_sim.files.types import NonNegative, Positive
from crane_sim.trajectories.polynomials import PiecewisePolynomial, delay_by, weighted_sum


class Shaping(NamedTuple):
    """Input shaping: delayed copies of the path that excite no swing of a known frequency.

    The motion ends later by the delay.
    """

    kind: Literal["zv", "zvd"]  # `zv`: no swing at the frequency; `zvd`: little beside it as well,
    # at twice the delay
    frequency: Positive | Literal["auto"] = "auto"  # rad/s, of the undamped swing; `auto`: small
    # swings of a point load on the scene's whole rope
    damping: Annotated[NonNegative, Field(lt=1.0)] = 0.0  # -, ratio of the swing


def impulses(
    kind: Literal["zv", "zvd"], frequency: float, damping: float
) -> tuple[list[float], list[float]]:
    """Return (weights, delays [s]) of a shaper's impulses; the weights add up to one.

    Args:
        kind: which shaper.
        frequency: rad/s, undamped.
        damping: damping ratio, below 1.
    """
    root = sqrt(1.0 - damping * damping)
    half, decay = (
        pi / (frequency * root),
        exp(-damping * pi / root),
    )  # s, half a swing, and the ratio of amplitudes over it
    sizes = [1.0, decay] if kind == "zv" else [1.0, 2.0 * decay, decay * decay]
    return [size / sum(sizes) for size in sizes], [half * k for k in range(len(sizes))]


def apply_input_shaper(
    polynomials: PiecewisePolynomial, kind: Literal["zv", "zvd"], frequency: float, damping: float
) -> PiecewisePolynomial:
    """Return the reference shaped for a swing, at rest later by the last delay.

    Arguments as of `impulses`.
    """
    weights, delays = impulses(kind, frequency, damping)
    return weighted_sum(weights, [delay_by(polynomials, delay) for delay in delays])
