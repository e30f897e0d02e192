"""Mobile crane: a boom that slews, luffs and telescopes.

In the slewing frame (e_r, e_t, e_z) the boom's foot pin is at (a, 0, h); β is the boom's elevation
and ℓ its length. The base section (mass m₁, centre at c₁ from the foot, inertia I₁ across) keeps
its place on the boom. The telescoped section (m₂, I₂) moves out with the tip, its centre at s₂ = ℓ
- d₂. With r_i = a + s_i cos β, s₁ = c₁,

    J(β, ℓ) = J₀ + Σ (m_i r_i² + I_i cos²β),  B(ℓ) = Σ (m_i s_i² + I_i),
    J α'' + 2 α' (J_β β' + J_ℓ ℓ') = τ_α + r f_t,                       J_β = ½ ∂J/∂β,  J_ℓ = ½ ∂J/∂ℓ = m₂ r₂ cos β
    B β'' + 2 m₂ s₂ ℓ' β' - J_β α'² + g cos β Σ m_i s_i = τ_β + ℓ (f_z cos β - f_r sin β)
    m₂ (ℓ'' - s₂ β'²) - J_ℓ α'² + m₂ g sin β = F + f_r cos β + f_z sin β

under the efforts τ_α, τ_β, F and the force f of the cable on the tip. Both sections are thin: they
have no inertia about the boom.
"""  # noqa: E501

from typing import NamedTuple

from crane_sim.files.types import AngleRange, LengthRange, NonNegative, Positive, Real
from crane_sim.models.supports.support import Mechanism, Pressed
from crane_sim.models.wind_load import BoomWindage
from crane_sim.multibody.tree import Body, Joint, Point, Tree, X, Y, Z
from crane_sim.multibody.vectors import diagonal


class Superstructure(NamedTuple):
    """What slews besides the boom: cab, winches, counterweight."""

    inertia: Positive  # kg m², about the slewing axis, without boom and payload
    foot: tuple[Real, Real] = (0.0, 0.0)  # m, the boom's foot pin: ahead of the slewing axis, above
    # the model's origin
    limits: AngleRange | None = None  # rad, of the slew angle; a run ends where one is reached


class BaseSection(NamedTuple):
    """The base section of the boom, with the luffing cylinder's part of the mass."""

    mass: NonNegative  # kg, of the section
    centre: NonNegative  # m, of its mass from the foot pin
    inertia: Positive  # kg m², about a transverse axis through the centre of mass
    limits: AngleRange | None = None  # rad, of the boom's elevation; a run ends where one is
    # reached
    windage: BoomWindage | None = None  # of the whole boom: width and drag in the `wind`

    def body(self) -> Body:
        """Return the section in the axes of the boom; it has no inertia about the boom."""
        return Body(self.mass, (self.centre, 0, 0), diagonal(0, self.inertia, self.inertia))


class TelescopedSection(NamedTuple):
    """The section that is telescoped out, with the tip's sheaves."""

    mass: Positive  # kg, of the section
    centre: NonNegative  # m, of its mass from the tip
    inertia: NonNegative  # kg m², about a transverse axis through the centre of mass
    limits: LengthRange | None = None  # m, of the boom's length; a run ends where one is reached

    def body(self) -> Body:
        """Return the section in axes at the tip; it has no inertia about the boom."""
        return Body(self.mass, (-self.centre, 0, 0), diagonal(0, self.inertia, self.inertia))


class TelescopicBoom(NamedTuple):
    """Parameters of the support."""

    superstructure: Superstructure
    base_section: BaseSection
    telescope: TelescopedSection

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (
            ("slew", "superstructure.limits"),
            ("boom", "boom.limits"),
            ("telescope", "telescope.limits"),
        )[i]

    def mechanism(self) -> Mechanism:
        """Return the joints and bodies: slew, elevation, and the telescoped section."""
        first, windage = self.base_section, self.base_section.windage
        slew = Joint(Z, ((0, 1),), bodies=(self.slewing_body(),))
        luff = Joint(
            Y, ((1, 1),), reverse=True, parent=0, offset=self.pin(), bodies=(first.body(),)
        )
        slide = Joint(X, ((2, 1),), slides=True, parent=1, bodies=(self.telescope.body(),))
        return Mechanism(
            Tree((slew, luff, slide), Point(2)),
            limits=(self.superstructure.limits, first.limits, self.telescope.limits),
            actuated=(0, 1, 2),
            outline=(Point(-1), Point(1)),
            pressed=() if windage is None else (Pressed(1, windage, length=2),),
        )

    def slewing_body(self) -> Body:
        """Return what slews besides the boom."""
        return Body(0, inertia=diagonal(0, 0, self.superstructure.inertia))

    def pin(self) -> tuple[float, int, float]:
        """Return the boom's foot pin [m]."""
        return self.superstructure.foot[0], 0, self.superstructure.foot[1]
