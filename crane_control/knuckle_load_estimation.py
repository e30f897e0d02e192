"""The energy law for the knuckle crane with a load of unknown mass, which it weighs on the rope.

The payload feels m (z'' + g) = -T n_z: n the unit vector from tip to payload, z its height, T the tension, which the
winch's effort tells. Two equal low-pass filters of rate λ, a of z'' + g and p of -T n_z, begin as if the believed mass
m0 had hung at rest for ever; the law carries the estimate m̂ = p / a in place of m0:

    a' = λ (z'' + g - a),  p' = λ (-T n_z - p),  a(0) = g,  p(0) = m0 g,  m̂ = p / a.

No acceleration is measured: over a period, the mean of z'' is the change of z' by the time.

Proof that W never rises (force-driven rope, no friction on the payload, base at rest, all but m nominal, continuous),
with V of the plain law for the true m, B = lB²/kdβ + lJ²/kdγ + 1/kdd and W = V + ½ (B/λ) (p - m a)²:
1. (p - m a)' = -λ (p - m a): equal filters of equal inputs, so what tells them apart fades whatever the crane does.
   It is (m0 - m) g at the start and always (m̂ - m) a, hence m̂ tends to m.
2. The law carries (m̂ - m) g too much: V' = -Σ kd q'² + (m̂ - m) g b·q', b = (lB cos β, lJ cos γ, -1) for boom, jib and
   rope. By Young's inequality, joint by joint, V' ≤ ¼ B g² (m̂ - m)².
3. W' ≤ B (m̂ - m)² (¼ g² - a²), which is not positive while a > ½ g. Where it stays zero, m̂ = m and q' = 0, and the
   crane rests on its target, as under the plain law.
While a ≤ ½ g the payload hardly weighs on the rope, since it falls or is thrown, and the estimate stays as it is. A
rope cannot push: it is weighed by what the rope can do, and V' needs a winch that is asked for tension only.
"""

from collections.abc import Mapping
from math import exp
from typing import Any, NamedTuple

import numpy as np

from crane_control import knuckle_energy
from crane_control.knuckle_energy import Action, EnergyLaw, Settings, Winch, act, compute_lyapunov
from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.laws import read_settings
from crane_sim.models.cables.rope import span
from crane_sim.models.effects import add_spring
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.supports import forward_kinematics
from crane_sim.numerics.jit import entry, kernel, routine
from crane_sim.scenes.scene import Scene

LIGHT = 0.5  # of g: what feels less is not weighed, by step 3 of the proof


class MassEstimator(NamedTuple):
    """State of the estimator between commands."""

    filters: Any  # (2,): a [m/s²], p [N]
    last: Any  # (3,) of the last command: t [s], z' [m/s], -n_z
    winch: Any  # (1,) N, effort that the winch can have applied since
    mass: Any  # (1,) kg, m̂


class WeighingEnergyLaw(NamedTuple):
    """The law, the crane that it believes in, and the estimator of its payload."""

    action: Action  # for the believed mass
    nominal: Crane
    rate: float  # 1/s
    estimator: MassEstimator

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the efforts (nu,) demanded at joint positions q (nq,) and velocities v (nq,)."""
        return compute_efforts(self, t, q, v)

    def fresh(self) -> "WeighingEnergyLaw":
        """Return the law with an estimator at its initial state."""
        return self._replace(estimator=make_estimator(self.nominal))

    def lyapunov_of(self, mass: float, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> float:
        """Return W [J] of the proof for the true mass [kg], at t [s], joint positions q (nq,), velocities v (nq,)."""
        believed, winch = self.nominal, self.action.winch
        boom, jib = believed.support.boom, believed.support.jib
        assert winch is not None  # or there would be nothing to weigh with
        value, _ = compute_lyapunov(
            EnergyLaw(self.action, believed._replace(load=believed.load._replace(mass=mass))), t, q, v
        )
        damped = boom.length**2 / self.action.kd[1] + jib.length**2 / self.action.kd[2] + 1.0 / winch.kd
        unbalanced = (believed.load.mass - mass) * believed.gravity * exp(-self.rate * t)
        return value + 0.5 * damped / self.rate * unbalanced**2


def make_estimator(nominal: Crane) -> MassEstimator:
    """Return the estimator of a law whose believed payload has hung at rest."""
    m, g = nominal.load.mass, nominal.gravity
    return MassEstimator(np.array([g, m * g]), np.array([0.0, 0.0, 1.0]), np.array([-m * g]), np.array([m]))


@routine
def update_estimate(law, t, q, v):
    """Filter acceleration and pull since the last command, and return the estimated mass [kg]."""
    p, (filters, last, winch, mass) = law.nominal, law.estimator
    x = system.state(p, t, q, v)
    line = span(forward_kinematics(p.support, x[0]), x[1])
    elapsed, climb, up = t - last[0], x[1][5], -line.n[2]
    if elapsed > 0.0:
        share = 1.0 - exp(-law.rate * elapsed)
        pull = -add_spring(p.cable.spring, winch[0], line.length)
        filters[0] += share * ((climb - last[1]) / elapsed + p.gravity - filters[0])
        filters[1] += share * (0.5 * (last[2] + up) * pull - filters[1])
    if filters[0] > LIGHT * p.gravity:
        mass[0] = max(filters[1] / filters[0], 0.0)
    last[0], last[1], last[2] = t, climb, up
    return mass[0]


@kernel
def with_payload(action, p, mass):
    """Return the action for a payload of another mass [kg]."""
    more, winch = (mass - p.load.mass) * p.gravity, action.winch
    moments = action.moments[0] + more * p.support.boom.length, action.moments[1] + more * p.support.jib.length
    rope = Winch(winch.kp, winch.kd, winch.target, winch.weight + more)
    return Action(action.kp, action.kd, action.target, moments, rope, action.reach)


@system.command.register(WeighingEnergyLaw)
def _(law, t, q, v):
    efforts = act(with_payload(law.action, law.nominal, update_estimate(law, t, q, v)), q, v)
    law.estimator.winch[0] = min(efforts[3], 0.0)  # a rope cannot push
    return efforts


@entry
def compute_efforts(law, t, q, v):
    """Compiled `command` for calls from Python."""
    return system.command(law, t, q, v)


def build(settings: Mapping[str, Any], nominal: Scene) -> EnergyLaw | WeighingEnergyLaw:
    """Return the energy law for what it believes of the scene, one that weighs the load if `adaptation` is given.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    law, options = knuckle_energy.build(settings, nominal), read_settings(Settings, settings).adaptation
    if options is None:
        return law
    if law.action.winch is None:
        raise SceneError("control.adaptation: weighs the load by the winch's force; possible: rope.drive = 'force'")
    if law.nominal.gravity == 0.0:
        raise SceneError("gravity = 0.0: without weight there is nothing to weigh, leave out control.adaptation")
    if not nominal.sampled:
        raise SceneError("control.period = 'continuous': a law that weighs the load has memory; give a period")
    return WeighingEnergyLaw(law.action, law.nominal, options.rate, make_estimator(law.nominal))
