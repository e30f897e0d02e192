"""A crane: support x cable x load and their effects, put together.

State x = (support state, payload state), and a third float, the energy supplied [J], when the crane is metered.
"""

from typing import NamedTuple

from crane_sim import system
from crane_sim.cables.rope import (
    ForceRope,
    LockedRope,
    RateRope,
    Span,
    held_to_rope,
    rope_limited,
    rope_tension,
    span,
    swing,
    winch_power,
)
from crane_sim.effects import (
    LinearFriction,
    PaperFriction,
    PayloadDrag,
    QuadraticFriction,
    add_drag,
    swing_moments,
)
from crane_sim.frames import frame_acceleration, inertial_velocity
from crane_sim.jit import generic, kernel
from crane_sim.loads.point import PointLoad
from crane_sim.meter import Meter
from crane_sim.supports import (
    posture,
    support_acceleration,
    tip_acceleration,
    with_couple,
)
from crane_sim.supports.knuckle import Knuckle

SwingFriction = QuadraticFriction | LinearFriction | PaperFriction


class Crane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    support: Knuckle
    cable: ForceRope | RateRope | LockedRope
    load: PointLoad
    gravity: float = 9.81  # m/s²
    swing_friction: SwingFriction | None = None
    drag: PayloadDrag | None = None
    meter: Meter | None = None

    def metered(self, held: bool) -> "Crane":
        """Return the model with a meter where held efforts do not tell all the energy supplied."""
        lossy = self.swing_friction is not None or self.drag is not None or isinstance(self.cable, RateRope)
        return self._replace(meter=Meter()) if lossy or not held else self


class Motion(NamedTuple):
    """Everything that the state and the efforts fix at one instant."""

    pose: NamedTuple
    line: Span
    support: tuple[float, float, float]  # joint accelerations of the support
    payload: tuple[float, float, float]  # second rates of change of the payload's coordinates
    tension: float


@generic
def add_swing_friction(friction, line, force, reaction, tau, support):
    """Return (force on the payload, reaction on the tip, joint efforts) with the swing joints' friction added.

    The friction is internal: what it pulls on the payload it pushes on the tip, and the couple between the two turns
    the support about the vertical (the swing angles are measured in its frame).
    """
    s1, c1, c2, w1, w2 = swing(line)
    a1, a2 = swing_moments(friction, line.n, w1, w2)
    nx, inverse = line.n[0], -1.0 / line.length
    fx = inverse * a2 * c2
    fy = inverse * (a1 * c1 - a2 * s1 * nx)
    fz = inverse * (a1 * s1 + a2 * c1 * nx)
    couple = line.length * (line.n[1] * fx - nx * fy)
    force = (force[0] + fx, force[1] + fy, force[2] + fz)
    return force, (reaction[0] - fx, reaction[1] - fy, reaction[2] - fz), with_couple(support, tau, couple)


@add_swing_friction.register(type(None))
def _(friction, line, force, reaction, tau, support):
    return force, reaction, tau


@generic
def friction_power(friction, line):
    """Return the power [W] that the swing joints' friction takes out, negative."""
    _, _, _, w1, w2 = swing(line)
    a1, a2 = swing_moments(friction, line.n, w1, w2)
    return -a1 * w1 - a2 * w2


@friction_power.register(type(None))
def _(friction, line):
    return 0.0


@kernel
def motion(p, xs, xc, tau):
    """Return the Motion of crane p at its state under joint efforts tau."""
    pose = posture(p.support, xs)
    line = span(pose, xc)
    position, velocity, w = xc[:3], xc[3:], pose.yaw_rate
    force = (0.0, 0.0, -p.load.mass * p.gravity)
    force = add_drag(p.drag, force, inertial_velocity(position, velocity, w))
    force, reaction, tau = add_swing_friction(p.swing_friction, line, force, (0.0, 0.0, 0.0), tau, p.support)
    tension = rope_tension(p.cable, p, pose, line, tau, force, reaction)
    nx, ny, nz = tension * line.n[0], tension * line.n[1], tension * line.n[2]
    tip = (reaction[0] + nx, reaction[1] + ny, reaction[2] + nz)
    qdd = support_acceleration(p.support, pose, p.gravity, tau, tip)
    _, w_dot = tip_acceleration(p.support, pose, qdd)
    inverse = 1.0 / p.load.mass
    inertial = ((force[0] - nx) * inverse, (force[1] - ny) * inverse, (force[2] - nz) * inverse)
    return Motion(pose, line, qdd, frame_acceleration(inertial, position, velocity, w, w_dot), tension)


@system.rhs.register(Crane)
def _(p, t, x, u):
    xs, xc = x[0], x[1]
    now = motion(p, xs, xc, system.effort(u, p, t, x))
    return with_meter(p.meter, ((*xs[3:], *now.support), (*xc[3:], *now.payload)), p, t, x, u)


@generic
def with_meter(meter, derivative, p, t, x, u):
    """Return the state's derivative, with the supplied power appended where the crane is metered."""
    return derivative


@with_meter.register(Meter)
def _(meter, derivative, p, t, x, u):
    return (derivative[0], derivative[1], system.power(p, t, x, u))


@generic
def metered_state(meter, x):
    """Return the initial state, with no energy supplied yet where the crane is metered."""
    return x


@metered_state.register(Meter)
def _(meter, x):
    return (x[0], x[1], 0.0)


@generic
def metered_like(meter, x, projected):
    """Return the projected state with the meter's reading of x kept."""
    return projected


@metered_like.register(Meter)
def _(meter, x, projected):
    return (projected[0], projected[1], x[2])


@system.power.register(Crane)
def _(p, t, x, u):
    tau = system.effort(u, p, t, x)
    now = motion(p, x[0], x[1], tau)
    w = now.pose.yaw_rate
    vx, vy, vz = inertial_velocity(x[1][:3], x[1][3:], w)
    fx, fy, fz = add_drag(p.drag, (0.0, 0.0, 0.0), (vx, vy, vz))
    joints = tau[0] * w + tau[1] * x[0][4] + tau[2] * x[0][5] + winch_power(p.cable, tau, now.line, now.tension)
    return joints + fx * vx + fy * vy + fz * vz + friction_power(p.swing_friction, now.line)


@system.project.register(Crane)
def _(p, x):
    return metered_like(p.meter, x, (x[0], held_to_rope(p.cable, posture(p.support, x[0]), x[1])))


@system.tension.register(Crane)
def _(p, t, x, u):
    return motion(p, x[0], x[1], system.effort(u, p, t, x)).tension


@system.limited.register(Crane)
def _(p, u):
    return rope_limited(p.cable, u)
