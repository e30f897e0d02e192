"""Energy-based law for the knuckle crane (Ambrosino et al., eq. 15-18, with the signs corrected).

Proportional-derivative action on the actuated joints, plus the efforts that carry the crane and its hanging payload.
It shapes the energy V = kinetic energy + m g d (1 - cos θ1 cos θ2) + ½ Σ kp e² + energy of the springs, e the error of
an actuated joint, whose derivative is -Σ kd q'² less what friction and drag take out.
"""

from collections.abc import Mapping
from math import cos
from typing import Annotated, Any, NamedTuple

from pydantic import Field

from crane_sim import system
from crane_sim.cables.rope import ForceRope, RateRope, add_rope_energy, span
from crane_sim.explain import SceneError
from crane_sim.jit import entry, generic
from crane_sim.laws import read_settings
from crane_sim.model import Crane
from crane_sim.quantities import NonNegative
from crane_sim.scene import Scene
from crane_sim.supports import posture, support_potential

Gains = Annotated[tuple[NonNegative, ...], Field(min_length=3, max_length=4)]


class EnergyLaw(NamedTuple):
    """Gains and target of the actuated joints (nu,), and the crane that the law believes in."""

    kp: tuple[float, ...]  # N m/rad, and N/m for the rope
    kd: tuple[float, ...]  # N m s/rad, and N s/m for the rope
    target: tuple[float, ...]  # rad, and m for the rope
    nominal: Crane

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the efforts (nu,) demanded at joint positions q (nq,) and velocities v (nq,)."""
        return demanded(self, t, q, v)

    def lyapunov(self, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, float]:
        """Return (V [J], dV/dt [W]) at joint positions q (nq,) and velocities v (nq,), if the law is continuous."""
        return shaped(self, q, v)


@generic
def with_winch(cable, law, tau, q, v):
    """Return the efforts tau with the winch's appended, where the winch takes one."""
    return tau


@with_winch.register(ForceRope)
def _(cable, law, tau, q, v):
    weight = law.nominal.load.mass * law.nominal.gravity
    return (*tau, law.kp[3] * (law.target[3] - q[3]) - law.kd[3] * v[3] - weight)


@system.command.register(EnergyLaw)
def _(law, t, q, v):
    p, kp, kd, target = law.nominal, law.kp, law.kd, law.target
    boom, jib, m = p.support.boom, p.support.jib, p.load.mass
    slew = kp[0] * (target[0] - q[0]) - kd[0] * v[0]
    luff = kp[1] * (target[1] - q[1]) - kd[1] * v[1]
    knuckle = kp[2] * (target[2] - q[2]) - kd[2] * v[2]
    luff = luff + p.gravity * boom.length * cos(q[1]) * (m + 0.5 * boom.mass + jib.mass)
    knuckle = knuckle + p.gravity * jib.length * cos(q[2]) * (m + 0.5 * jib.mass)
    return with_winch(p.cable, law, (slew, luff, knuckle), q, v)


@system.effort.register(EnergyLaw)
def _(u, p, t, x):
    q, v = system.actuated(p, x)
    return system.command(u, t, q, v)


@entry
def demanded(law, t, q, v):
    """Compiled `command` for calls from Python."""
    return system.command(law, t, q, v)


@entry
def shaped(law, q, v):
    """Return (V, dV/dt) of the shaped energy."""
    p = law.nominal
    x = system.state(p, q, v)
    pose = posture(p.support, x[0])
    line = span(pose, x[1])
    value = system.kinetic(p, x) + p.load.mass * p.gravity * (line.length + line.n[2] * line.length)
    value = add_rope_energy(p.cable, value + support_potential(p.support, pose, 0.0), line.length)
    rate = 0.0
    for i in range(len(law.target)):
        value = value + 0.5 * law.kp[i] * (law.target[i] - q[i]) ** 2
        rate = rate - law.kd[i] * v[i] * v[i]
    return value, rate + system.power(p, 0.0, x, (0.0, 0.0, 0.0, 0.0))


class Settings(NamedTuple):
    """What a scene says of this law in its `control` group."""

    kp: Gains = (30.0, 10.0, 10.0, 1.0)
    kd: Gains = (50.0, 30.0, 50.0, 10.0)


def build(settings: Mapping[str, Any], nominal: Scene) -> EnergyLaw:
    """Return the law for what it believes of the scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    given = read_settings(Settings, settings)
    if nominal.reference is None:
        raise SceneError("reference: is missing, the energy law needs a target")
    if isinstance(nominal.model.cable, RateRope):
        raise SceneError("rope.drive = 'rate': the energy law commands a rope force; possible: force, locked")
    nu = len(nominal.actuated)
    for name, gains in given._asdict().items():
        if len(gains) < nu:
            raise SceneError(f"control.{name}: has {len(gains)} values, {nu} joints are actuated: {nominal.actuated}")
    return EnergyLaw(given.kp[:nu], given.kd[:nu], nominal.reference, nominal.model)
