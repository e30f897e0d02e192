"""Energy-based law for the overhead crane: swing damping by a trolley of small apparent mass.

Damping of the trolley alone hardly damps the swing below a heavy trolley, on which the rope's force
has little effect. So the law shapes kinetic energy too: with the force T sin α of the rope on the
trolley, computed from measured joints,

    F = M/μ f + (M/μ - 1) T sin α,   f = kp e / √(1 + (e/r)²) - kd x',   F_hoist = kp_h e_h - kd_h l' - m g,

with the errors e of the trolley's position x and e_h of the rope's length l, the swing angle α from
the vertical and the mass m of the payload. Then the trolley of mass M moves as one of the apparent
mass μ under the force f.

Proof that V never rises (planar crane, a rigid taut rope, nominal parameters, continuous law), V =
energy of payload and drum with m g l for zero level + ½ μ x'² + kp e² / (1 + √(1 + (e/r)²)) + ½
kp_h e_h²:
1. M x'' = F + T sin α gives μ x'' = f + T sin α. The rope's power is -T (x' sin α + l') on the
   payload, T l' on the drum.
2. So (energy of payload and drum + ½ μ x'²)' = f x' + F_hoist l'.
3. The derivatives of V's two spring terms cancel the position terms of f and F_hoist, and m g l
   balances the payload's weight on the hoist: V' = -kd x'² - kd_h l'².
   Friction, on which the law does not act, takes μ/M R x' on the rail and R_h l' on the hoist, and
   makes the tension another one than the computed T: by D = (R sin α / M + R_h / J) / (1/m +
   sin²α/M + 1/J), J the hoist's reflected mass (without a hoist 1/J is 0), which takes (1 - μ/M) D
   x' sin α. A hoist that sticks bears R_h = F_hoist + tension.
V is positive about the target. Where V' stays zero, trolley and rope rest, hence α'' = 0: the
target, or upside down.

Default gains: linearised, trolley and swing have s⁴ + δ s³ + (1 + κ + m/μ) s² + δ s + κ in units of
ω = √(g/l), with δ = kd / (μ ω), κ = kp / (μ ω²). μ = m/4, kp = m ω²/4, kd = m ω put all four poles
at -ω; the hoist's two are there too. The saturation r of the position error (setting `reach`)
limits the speed to about r ω / 4.
"""  # noqa: E501

from collections.abc import Mapping
from math import copysign, cos, inf, sin, sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from crane_control.reduced_state import nominal_coordinate
from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_settings
from crane_sim.models.overhead.rod import RodCrane
from crane_sim.models.supports.friction import Friction, friction_force
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.rails import ForceAxis
from crane_sim.numerics.jit import entry_point
from crane_sim.scenes.scene import Scene

Gains = Annotated[tuple[NonNegative, ...], Field(min_length=1, max_length=2)]


class FixedLength(NamedTuple):
    """A rope of fixed length."""

    length: float  # m

    def state(self, q, v):
        """Return (length [m], its rate [m/s], number of joints up to the swing) of the rope."""
        return self.length, 0.0, 2

    def control(self, q, v, weight):
        """Return (hoist's efforts, inverse mass [1/kg], bias [m/s²], terms in (V, dV/dt))."""
        return (), 0.0, 0.0, (0.0, 0.0)

    def friction_force(self, length_rate, efforts, tension, share):
        """Return the hoist's friction [N] against `length_rate`; at rest, what it bears.

        The rope's tension is `tension` without it, and rises by `share` of it.
        """
        return 0.0


class HoistControl(NamedTuple):
    """Control of a force-driven hoist that winds the rope, with the methods of `FixedLength`."""

    kp: float  # N/m
    kd: float  # N s/m
    target: float  # m
    reflected_mass: float  # kg, of drum and drive, at the rope
    friction: Friction | None = None  # which the law does not act on

    def state(self, q, v):
        """Return (length, its rate, number of joints up to the swing)."""
        return q[1], v[1], 3

    def control(self, q, v, weight):
        """Return (efforts, inverse mass, bias acceleration, terms in (V, dV/dt)) of the hoist."""
        error, length_rate = self.target - q[1], v[1]
        force = self.kp * error - self.kd * length_rate - weight
        value = (
            0.5 * self.kp * error * error + 0.5 * self.reflected_mass * length_rate * length_rate
        )
        terms = value, -self.kd * length_rate * length_rate
        return (force,), 1.0 / self.reflected_mass, force / self.reflected_mass, terms

    def friction_force(self, length_rate, efforts, tension, share):
        """Return the friction on the hoist."""
        if length_rate != 0.0:
            return friction_force(self.friction, length_rate)
        return friction_at_rest(self.friction, (efforts[0] + tension) / (1.0 - share))


class OverheadEnergyLaw(NamedTuple):
    """The law and its nominal crane."""

    kp: float  # N/m
    kd: float  # N s/m
    target: float  # m
    error_saturation: float  # m, r: kp r bounds the proportional force on the trolley
    apparent_mass: float  # kg
    trolley_mass: float  # kg
    payload_mass: float  # kg
    gravity: float  # m/s²
    rope: FixedLength | HoistControl
    friction: Friction | None = None  # of the trolley, which the law does not act on

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the effort commands (nu,) at joint positions q (nq,) and velocities v (nq,)."""
        return system.compute_command(self, t, np.array(q), np.array(v))

    def lyapunov(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, float]:
        """Return (V [J], dV/dt [W]) as `laws.EnergyShaping` says, the same at all times."""
        return compute_lyapunov(self, np.array(q), np.array(v))


def trolley_force(law, q, v):
    """Return f [N], the force on the apparent mass."""
    error = law.target - q[0]
    return law.kp * error / sqrt(1.0 + (error / law.error_saturation) ** 2) - law.kd * v[0]


def computed_tension(law, q, v, force):
    """Return (tension T [N], sin α, efforts of the hoist, its inverse mass [1/kg]).

    T is that under the law without friction.
    """
    length, _, n = law.rope.state(q, v)
    swing, swing_rate = nominal_coordinate(q, n - 1, n), nominal_coordinate(v, n - 1, n)
    s, m, mu = sin(swing), law.payload_mass, law.apparent_mass
    efforts, inverse_mass, hoist_acc, _ = law.rope.control(q, v, m * law.gravity)
    relative_acc = (
        length * swing_rate * swing_rate + law.gravity * cos(swing) - s * force / mu - hoist_acc
    )
    return relative_acc / (1.0 / m + s * s / mu + inverse_mass), s, efforts, inverse_mass


def control_action(law, q, v):
    """Return the efforts (nu,) of the law."""
    force = trolley_force(law, q, v)
    tension, s, efforts, _ = computed_tension(law, q, v, force)
    ratio = law.trolley_mass / law.apparent_mass
    return (ratio * force + (ratio - 1.0) * tension * s, *efforts)


@system.command.register(OverheadEnergyLaw)
def overhead_energy_command(law, t, q, v):
    """Return the efforts (nu,) of the law."""
    return control_action(law, q, v)


@system.effort.register(OverheadEnergyLaw)
def overhead_energy_effort(u, p, t, x):
    """Return the efforts (nu,) of the law, evaluated by the equations of the crane p."""
    return control_action(u, *system.joints(p, x))


def friction_at_rest(friction, force):
    """Return the friction [N] against a force on a joint at rest: as large where it sticks."""
    if friction is None:
        return 0.0
    sliding = friction.dry(0.0)
    return force if abs(force) <= friction.static else copysign(sliding, force)


def compute_friction_loss(law, q, v):
    """Return the power [W] by which friction on rail and hoist lowers V at q, v (nq,)."""
    tension, s, efforts, inverse_mass = computed_tension(law, q, v, trolley_force(law, q, v))
    ratio, (_, length_rate, _) = law.apparent_mass / law.trolley_mass, law.rope.state(q, v)
    on_rail = friction_force(law.friction, v[0])
    total = 1.0 / law.payload_mass + s * s / law.trolley_mass + inverse_mass
    change = s * on_rail / (law.trolley_mass * total)  # of the tension, by friction on the rail
    share = inverse_mass / total
    on_hoist = law.rope.friction_force(length_rate, efforts, tension + change, share)
    change += share * on_hoist
    return ratio * on_rail * v[0] + on_hoist * length_rate + (1.0 - ratio) * change * v[0] * s


@entry_point
def compute_lyapunov(law, q, v):
    """Compiled `lyapunov`."""
    length, length_rate, n = law.rope.state(q, v)
    swing, swing_rate = nominal_coordinate(q, n - 1, n), nominal_coordinate(v, n - 1, n)
    _, _, _, (value, value_rate) = law.rope.control(q, v, 0.0)
    error, s, c = law.target - q[0], sin(swing), cos(swing)
    across, up = (
        v[0] + length_rate * s + length * c * swing_rate,
        -length_rate * c + length * s * swing_rate,
    )
    value = value + 0.5 * law.payload_mass * (
        across * across + up * up + 2.0 * law.gravity * length * (1.0 - c)
    )
    value = value + 0.5 * law.apparent_mass * v[0] * v[0]
    value = value + law.kp * error * error / (1.0 + sqrt(1.0 + (error / law.error_saturation) ** 2))
    return value, value_rate - law.kd * v[0] * v[0] - compute_friction_loss(law, q, v)


class Settings(NamedTuple):
    """Gains of trolley and hoist; the law goes to `reference.q` on one link in the plane.

    In the formulas m is the payload's mass and l the length.
    """

    kp: Gains | None = None  # N/m, of trolley and hoist; left out: m ω²/4 and (m + J) ω², ω² = g /
    # l, J the hoist's reflected mass
    kd: Gains | None = None  # N s/m, likewise; left out: m ω and 2 (m + J) ω
    apparent_mass: Positive | None = None  # kg, mass that the trolley seems to have; left out: a
    # quarter of the payload's; the trolley's own: no kinetic shaping
    reach: Positive = inf  # m, r at which the trolley's position error saturates: its proportional
    # force tends to kp r for large errors; left out: it is linear in the error


def build(settings: Mapping[str, Any], nominal: Scene) -> OverheadEnergyLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    options, target, model = read_settings(Settings, settings), _read_target(nominal), nominal.model
    m = model.cable.payload
    has_hoist = len(target) == 2
    length = target[1] if has_hoist else model.cable.length
    omega = sqrt(model.gravity / length)
    hoisted_mass = m + model.hoist.reflected_mass if has_hoist else 0.0
    kp = _gains("kp", options.kp, (0.25 * m * omega**2, hoisted_mass * omega**2), len(target))
    kd = _gains("kd", options.kd, (m * omega, 2.0 * hoisted_mass * omega), len(target))
    hoist = model.hoist
    rope = (
        HoistControl(kp[1], kd[1], length, hoist.reflected_mass, hoist.friction)
        if has_hoist
        else FixedLength(length)
    )
    masses = options.apparent_mass or 0.25 * m, model.trolley.mass, m
    trolley_control = kp[0], kd[0], target[0], options.reach
    return OverheadEnergyLaw(*trolley_control, *masses, model.gravity, rope, model.trolley.friction)


def _read_target(nominal: Scene) -> tuple[float, ...]:
    """Return the target of a scene that the law fits; raises SceneError."""
    target, model = nominal.reference, nominal.model
    if target is None:
        raise SceneError("reference: is missing, the energy law needs a target")
    if not isinstance(model, RodCrane) or model.cable.nodes.shape[1] > 1:
        raise SceneError(
            "cable: the energy law needs a nominal cable of one rigid link in the plane; see "
            "control.nominal"
        )
    if not isinstance(model.trolley, ForceAxis) or not isinstance(model.hoist, ForceHoist | None):
        raise SceneError(
            "trolley, hoist: the energy law drives both by force (hoist: with inertia, or absent)"
        )
    if model.gravity == 0.0:
        raise SceneError(
            "gravity = 0.0: without weight nothing pulls the payload below the trolley"
        )
    if len(target) == 2 and target[1] <= 0.0:
        raise SceneError(
            f"reference.q[1] = {target[1]}: must be greater than 0, it is a rope's length"
        )
    return target


def _gains(
    name: str, gains: tuple[float, ...] | None, default: tuple[float, float], nu: int
) -> tuple[float, float]:
    if gains is None:
        return default
    if len(gains) != nu:
        raise SceneError(
            f"control.{name}: has {len(gains)} values, {nu} are needed, one of each actuated joint"
        )
    return gains[0], gains[-1]
