"""The energy law of the knuckle crane for an unknown payload mass, estimated from the tension.

Vertical motion of the payload: m (z'' + g) = -T n_z, with n the unit vector from tip to payload, z
its height, and T the tension, computed from the winch's effort. Two low-pass filters with the same
rate λ, a of z'' + g and f of -T n_z, begin at their steady state for the nominal mass m0 at rest.
The law compensates the weight of the estimated mass m̂ = f / a in place of that of m0:

    a' = λ (z'' + g - a),  f' = λ (-T n_z - f),  a(0) = g,  f(0) = m0 g,  m̂ = f / a.

No acceleration is measured: over a period, the mean of z'' is the change of z' divided by the time.

Symbols: β, γ elevations of boom and jib, l_B, l_J their lengths, d length of the rope; kd_β, kd_γ,
kd_d the law's gains on their rates; V the energy that the plain law shapes (`knuckle_energy`), here
for the true mass m.

Proof that W does not increase (force-driven rope, no friction on the payload, base at rest, all but
m nominal, continuous), with B = l_B²/kd_β + l_J²/kd_γ + 1/kd_d and W = V + ½ (B/λ) (f - m a)²:
1. (f - m a)' = -λ (f - m a): equal filters of equal inputs, so their difference decays for any
   motion of the crane. It is (m0 - m) g at the start and always (m̂ - m) a, hence m̂ tends to m.
2. The law overcompensates the weight by (m̂ - m) g: V' = -Σ kd q'² + (m̂ - m) g b·q', b = (l_B cos
   β, l_J cos γ, -1) for boom, jib and rope. By Young's inequality, joint by joint, V' ≤ ¼ B g² (m̂
   - m)².
3. W' ≤ B (m̂ - m)² (¼ g² - a²), which is not positive while a > ½ g. Where it stays zero, m̂ = m
   and q' = 0, and the crane is at rest at its target, as under the plain law.
While a ≤ ½ g, as in free fall, the tension is too small for an estimate, which stays as it is. A
rope transmits tension only: the estimate takes the effort limited to tension, and V' holds for a
winch whose command is a tension.
"""

from collections.abc import Mapping
from math import exp
from typing import Any, NamedTuple

import numpy as np

from crane_control import knuckle_energy
from crane_control.knuckle_energy import (
    ControlParameters,
    EnergyLaw,
    Settings,
    control_action,
)
from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.laws import read_settings
from crane_sim.models.cables.rope import rope_kinematics
from crane_sim.models.effects import add_spring
from crane_sim.models.single_rope.crane import Crane
from crane_sim.numerics.jit import routine
from crane_sim.scenes.scene import Scene

MIN_ACCELERATION = 0.5  # of g: the estimate is updated above it only, by step 3 of the proof


class MassEstimatorState(NamedTuple):
    """State of the estimator between commands."""

    filters: Any  # (2,): a [m/s²], f [N]
    previous: Any  # (3,) at the previous command: t [s], z' [m/s], -n_z
    winch_effort: Any  # (1,) N, effort applied by the winch since then
    mass: Any  # (1,) kg, m̂


class MassEstimatingEnergyLaw(NamedTuple):
    """The law, its nominal crane, and the estimator of the payload's mass."""

    parameters: ControlParameters  # for the nominal mass
    nominal: Crane
    filter_rate: float  # 1/s, λ
    estimator: MassEstimatorState

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the effort commands (nu,) at joint positions q (nq,) and velocities v (nq,)."""
        return system.compute_command(self, t, q, v)

    def with_initial_state(self) -> "MassEstimatingEnergyLaw":
        """Return the law with an estimator at its initial state."""
        return self._replace(estimator=make_estimator_state(self.nominal))


def make_estimator_state(nominal: Crane) -> MassEstimatorState:
    """Return the estimator of a law, at its steady state for the nominal payload at rest."""
    m, g = nominal.load.mass, nominal.gravity
    return MassEstimatorState(
        np.array([g, m * g]), np.array([0.0, 0.0, 1.0]), np.array([-m * g]), np.array([m])
    )


@routine
def update_estimate(law, t, q, v):
    """Filter acceleration and tension since the last command; return the estimated mass [kg]."""
    p, (filters, previous, winch_effort, mass) = law.nominal, law.estimator
    x = system.state(p, t, q, v)
    rope_state = rope_kinematics(p.support.forward_kinematics(x[0]), x[1])
    elapsed, velocity_z, up = t - previous[0], x[1][5], -rope_state.n[2]
    if elapsed > 0.0:
        gain = 1.0 - exp(-law.filter_rate * elapsed)
        tension = -add_spring(p.cable.spring, winch_effort[0], rope_state.length)
        filters[0] += gain * ((velocity_z - previous[1]) / elapsed + p.gravity - filters[0])
        filters[1] += gain * (0.5 * (previous[2] + up) * tension - filters[1])
    if filters[0] > MIN_ACCELERATION * p.gravity:
        mass[0] = max(filters[1] / filters[0], 0.0)
    previous[0], previous[1], previous[2] = t, velocity_z, up
    return mass[0]


def with_gravity_compensation_for_mass(parameters, p, mass):
    """Return the parameters with the gravity compensation for a payload of another mass [kg]."""
    extra_weight, winch = (mass - p.load.mass) * p.gravity, parameters.rope
    gravity_moments = (
        parameters.gravity_moments[0] + extra_weight * p.support.boom.length,
        parameters.gravity_moments[1] + extra_weight * p.support.jib.length,
    )
    rope = winch._replace(weight=winch.weight + extra_weight)
    return parameters._replace(gravity_moments=gravity_moments, rope=rope)


@system.command.register(MassEstimatingEnergyLaw)
def mass_estimating_command(law, t, q, v):
    """Return the efforts (4,) of the law for the mass that it estimates."""
    mass = update_estimate(law, t, q, v)
    efforts = control_action(
        with_gravity_compensation_for_mass(law.parameters, law.nominal, mass), q, v
    )
    law.estimator.winch_effort[0] = min(efforts[-1], 0.0)  # a rope transmits tension only
    return efforts


def build(settings: Mapping[str, Any], nominal: Scene) -> EnergyLaw | MassEstimatingEnergyLaw:
    """Return the energy law for its nominal scene.

    It estimates the payload's mass if `adaptation` is given.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    law, options = (
        knuckle_energy.build(settings, nominal),
        read_settings(Settings, settings).adaptation,
    )
    if options is None:
        return law
    if law.parameters.rope is None:
        raise SceneError(
            "control.adaptation: the mass is estimated from the winch's force; possible: "
            "rope.drive = 'force'"
        )
    if law.nominal.gravity == 0.0:
        raise SceneError(
            "gravity = 0.0: without weight the mass cannot be estimated, leave out "
            "control.adaptation"
        )
    if not nominal.sampled:
        raise SceneError(
            "control.period = 'continuous': a law that estimates the mass has memory; give a period"
        )
    return MassEstimatingEnergyLaw(
        law.parameters, law.nominal, options.rate, make_estimator_state(law.nominal)
    )
