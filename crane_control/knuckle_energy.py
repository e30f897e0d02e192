"""Energy-based law for the knuckle crane (Ambrosino et al., eq. 15-18, with the signs corrected).

Proportional-derivative action on the actuated joints, plus gravity compensation of the crane and
its hanging payload. It shapes the energy V = kinetic energy + m g d (1 - cos θ1 cos θ2) + ½ Σ kp e²
+ energy of the springs, where e is the error of an actuated joint. V's derivative is -Σ kd q'² less
what friction and drag dissipate.

The position error of the slew may saturate at r (`reach`), which limits the swing that a far target
excites: kp e / √(1 + (e/r)²) in place of kp e, and kp e² / (1 + √(1 + (e/r)²)) in place of ½ kp e²
in V.
"""

from collections.abc import Mapping
from math import cos, sqrt
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_settings
from crane_sim.models.cables.rope import MotionRope, add_rope_energy, rope_kinematics
from crane_sim.models.single_rope.crane import Crane
from crane_sim.numerics.jit import entry_point
from crane_sim.scenes.scene import Scene

Gains = Annotated[tuple[NonNegative, ...], Field(min_length=3, max_length=4)]


class RopeControl(NamedTuple):
    """Gains, target and gravity compensation of the law for a force-driven rope."""

    kp: float  # N/m
    kd: float  # N s/m
    target: float  # m
    weight: float  # N, of the payload, which the winch compensates


class ControlParameters(NamedTuple):
    """Gains, targets and gravity compensation of the law, for slew, boom and jib."""

    kp: tuple[float, float, float]  # N m/rad
    kd: tuple[float, float, float]  # N m s/rad
    target: tuple[float, float, float]  # rad
    gravity_moments: tuple[float, float]  # N m, of all weights on boom and jib when they are
    # horizontal
    rope: RopeControl | None  # None: no force drives the rope
    error_saturation: float | None  # rad, r of the slew's position error; None: it does not
    # saturate


class EnergyLaw(NamedTuple):
    """The law and its nominal crane."""

    parameters: ControlParameters
    nominal: Crane

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the effort commands (nu,) at joint positions q (nq,) and velocities v (nq,)."""
        return compute_control_action(self.parameters, q, v)

    def lyapunov(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, float]:
        """Return (V [J], dV/dt [W]) as `laws.EnergyShaping` says.

        dV/dt includes the power of base and forces.
        """
        return compute_lyapunov(self, float(t), q, v)


def saturated_spring(error_saturation, error):
    """Return (force, energy) of a spring, each divided by its stiffness.

    It is linear where error_saturation is None.
    """
    if error_saturation is None:
        return error, 0.5 * error**2
    root = sqrt(1.0 + (error / error_saturation) ** 2)
    return error / root, error * error / (1.0 + root)


def control_action(parameters, q, v):
    """Return the efforts (nu,) of the law."""
    kp, kd, target, winch = parameters.kp, parameters.kd, parameters.target, parameters.rope
    slew = kp[0] * saturated_spring(parameters.error_saturation, target[0] - q[0])[0] - kd[0] * v[0]
    boom = kp[1] * (target[1] - q[1]) - kd[1] * v[1] + parameters.gravity_moments[0] * cos(q[1])
    jib = kp[2] * (target[2] - q[2]) - kd[2] * v[2] + parameters.gravity_moments[1] * cos(q[2])
    if winch is None:
        return slew, boom, jib
    return slew, boom, jib, winch.kp * (winch.target - q[3]) - winch.kd * v[3] - winch.weight


@system.command.register(EnergyLaw)
def energy_command(law, t, q, v):
    """Return the efforts (nu,) of the law."""
    return control_action(law.parameters, q, v)


@system.demand.register(EnergyLaw)
def energy_demand(u, p, t, x):
    """Return the efforts (nu,) of the law, evaluated by the equations of the crane p."""
    q, v = system.actuated_joints(p, x)
    return control_action(u.parameters, q, v)


@system.effort.register(EnergyLaw)
def energy_effort(u, p, t, x):
    """Return the demand of the law within what the actuators give."""
    return system.saturate(p, energy_demand(u, p, t, x))


@entry_point
def compute_control_action(parameters, q, v):
    """Compiled `control_action` for calls from Python."""
    return control_action(parameters, q, v)


@entry_point
def compute_lyapunov(law, t, q, v):
    """Return (V, dV/dt) of the shaped energy at time t [s]."""
    p, parameters, winch = law.nominal, law.parameters, law.parameters.rope
    x = system.state(p, t, q, v)
    pose = p.support.forward_kinematics(x[0])
    rope_state = rope_kinematics(pose, x[1])
    value, value_rate = 0.0, 0.0
    if winch is not None:
        value, value_rate = 0.5 * winch.kp * (winch.target - q[3]) ** 2, -winch.kd * v[3] * v[3]
    value = (
        value
        + system.kinetic(p, x)
        + p.load.mass * p.gravity * (rope_state.length + rope_state.n[2] * rope_state.length)
    )
    springs = p.support.potential(pose, 0.0)  # no gravity: its moments are compensated
    value = add_rope_energy(p.cable, value + springs, rope_state.length)
    value = (
        value
        + parameters.kp[0]
        * saturated_spring(parameters.error_saturation, parameters.target[0] - q[0])[1]
    )
    for i in range(1, 3):
        value = value + 0.5 * parameters.kp[i] * (parameters.target[i] - q[i]) ** 2
    for i in range(3):
        value_rate = value_rate - parameters.kd[i] * v[i] * v[i]
    return value, value_rate + system.power(p, t, x, (0.0, 0.0, 0.0, 0.0))


class MassEstimation(NamedTuple):
    """Estimation of the payload's mass during motion."""

    rate: Positive = 2.0  # 1/s, λ of the low-pass filters: the mass estimate settles at this rate


class Settings(NamedTuple):
    """Gains by joint; the law goes to `reference.q`."""

    kp: Gains = (30.0, 10.0, 10.0, 1.0)  # N m/rad, of slew, boom, jib; of the rope N/m
    kd: Gains = (50.0, 30.0, 50.0, 10.0)  # N m s/rad, likewise; of the rope N s/m
    reach: Positive | None = None  # rad, r at which the slew's position error saturates: its
    # proportional torque tends to kp r for large errors; left out: it is linear in the error
    adaptation: MassEstimation | None = None  # mass estimation: the law compensates the weight of
    # the mass that it estimates for the payload (`knuckle_unknown_load`); left out: that of the
    # nominal `payload.mass`


def build(settings: Mapping[str, Any], nominal: Scene) -> EnergyLaw:
    """Return the plain law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    options = read_settings(Settings, settings)

    if nominal.reference is None:
        raise SceneError("reference: is missing, the energy law needs a target")
    if isinstance(nominal.model.cable, MotionRope):
        raise SceneError(
            "rope.drive = 'rate': the energy law commands a rope force; possible: force, locked"
        )
    nu = len(nominal.actuated)
    for name, gains in (("kp", options.kp), ("kd", options.kd)):
        if len(gains) < nu:
            raise SceneError(
                f"control.{name}: has {len(gains)} values, {nu} joints are actuated: "
                f"{nominal.actuated}"
            )
    return EnergyLaw(_parameters_of(options, nominal.reference, nominal.model, nu), nominal.model)


def _parameters_of(
    options: Settings, target: tuple[float, ...], model: Crane, nu: int
) -> ControlParameters:
    boom, jib, g, m = model.support.boom, model.support.jib, model.gravity, model.load.mass
    gravity_moments = (
        g * boom.length * (m + 0.5 * boom.mass + jib.mass),
        g * jib.length * (m + 0.5 * jib.mass),
    )
    winch = RopeControl(options.kp[3], options.kd[3], target[3], m * g) if nu == 4 else None
    own: tuple[Any, Any, Any] = (options.kp[:3], options.kd[:3], target[:3])  # without the winch
    return ControlParameters(*own, gravity_moments, winch, options.reach)
