"""Wind in the world: a mean by height, and gusts, smooth polynomials of time on their own grid.

The mean U(z) = U(z_r) r(z), r of the power law (z / z_r)^α or the logarithmic one ln(z / z₀) /
ln(z_r / z₀), with the reference height z_r; below the height z_min the mean is that at z_min (EN
1991-1-4, 4.3.2). Gusts u along the mean, v to its left and w upwards are the same at all points.
`crane_sim.trajectories.turbulence` draws them.
"""

from math import floor, log
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from crane_sim.files.types import NonNegative, Positive

Height = Annotated[Positive, Field(ge=1e-6, le=1e4)]


class PowerLaw(NamedTuple):
    """The mean grows with height like height^exponent."""

    exponent: Annotated[NonNegative, Field(le=2.0)]  # -, some 0.1 over water, 0.14 over grass, 0.3
    # in towns
    lowest: Height = 1.0  # m, height above the ground below which the mean does not change


class LogarithmicLaw(NamedTuple):
    """The mean grows with height like ln(height / roughness)."""

    roughness: Height  # m, some 0.0002 of open water, 0.03 of grass, 1 of towns
    lowest: Height = 1.0  # m, height above the ground below which the mean does not change; more
    # than the roughness

    def find_error(self) -> str:
        """Return what is wrong with the law as a whole, in one line; empty when nothing is."""
        if self.roughness < self.lowest:
            return ""
        return (
            f"lowest = {self.lowest:g}: must be greater than roughness = {self.roughness:g}, where "
            "the mean is zero"
        )


class Gust(NamedTuple):
    """A component of the gusts: quintic Hermite interpolation, periodic, continuous curvature."""

    rate: float  # 1/s, nodes per second
    nodes: Any  # (n, 3) m/s, value g, its derivatives as g' h and g'' h² / 2, h = 1 / rate; the
    # first one at t = 0


class Kink(NamedTuple):
    """Marks that the payload may pass the profile's lowest height, where the mean has a kink."""


class Wind(NamedTuple):
    """Wind; what is None is not modelled."""

    speed: float  # m/s, mean at the reference height
    height: float  # m, reference height above the ground
    profile: PowerLaw | LogarithmicLaw | None  # None: the mean is the same at all heights
    direction: tuple[float, float]  # unit vector along x and y of the world: where the mean blows
    # to
    origin_height: float  # m, of the world's origin above the ground
    density: float  # kg/m³, of the air
    gusts: tuple[Gust | None, Gust | None, Gust | None]  # u, v, w
    kink: Kink | None = None  # that of the profile


def speed_ratio(profile, z, reference):
    """Return the mean at height z [m] over that at the reference height [m]."""
    if profile is None:
        return 1.0
    if isinstance(profile, PowerLaw):
        return (max(z, profile.lowest) / reference) ** profile.exponent
    return log(max(z, profile.lowest) / profile.roughness) / log(reference / profile.roughness)


def gust_at(gust, t):
    """Return the gust's velocity [m/s] at time t [s]; none where it is absent."""
    if gust is None:
        return 0.0
    s, nodes = t * gust.rate, gust.nodes
    k = floor(s)
    s = s - k
    i = k % nodes.shape[0]
    j = (i + 1) % nodes.shape[0]
    g0, g1, g2 = nodes[i, 0], nodes[i, 1], nodes[i, 2]
    a = nodes[j, 0] - g0 - g1 - g2
    b = nodes[j, 1] - g1 - 2.0 * g2
    c = nodes[j, 2] - g2
    cubic, quartic, quintic = (
        10.0 * a - 4.0 * b + c,
        7.0 * b - 15.0 * a - 2.0 * c,
        6.0 * a - 3.0 * b + c,
    )
    return g0 + s * (g1 + s * (g2 + s * (cubic + s * (quartic + s * quintic))))
