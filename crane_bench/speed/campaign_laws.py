"""The laws of cranebench's campaigns, as one compiled form, and their published gains.

Podliesnyi, Sheremet, Vorobiov, "cranebench: a reproducible benchmark for underactuated crane control", version 0.1.2
(PyPI, BSD-3-Clause) names five: PD, LQR, ZVD, SMC, HSMC. With the deviation e = (q, q') - (q_r, q_r') of the joints
trolley, hoist, swing, all of them are

    u = u* - K e - η tanh(S e / φ),

and the command changes by a given amount per period at most. The reference of the trolley is a sum of delayed quintic
transfers, one for all but ZVD.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_continuous_are

from crane_sim import system
from crane_sim.numerics.jit import routine
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.linearisation import state_matrices

Array = npt.NDArray[np.float64]

PERIOD = 0.01  # s, between commands
DISTANCE, DURATION = 20.0, 20.0  # m, s, of the transfer
STEEPEST = PERIOD * np.array([1.6e5, 3.2e5])  # N, change of the commands of trolley and hoist in a period
PD = np.array([[6e3, 0.0, 0.0, 2.4e4, 0.0, 0.0], [0.0, 4e4, 0.0, 0.0, 6e4, 0.0]])  # N/m, N s/m
SURFACES = np.array([[1.1, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0, 1.0, 0.0]])  # 1/s, 1, of SMC
SLOPES, SWITCHED, LAYER = np.array([2.2e4, 6e4]), np.array([6e3, 1e4]), 0.06  # N s/m, N, m/s, of SMC and HSMC
SWING_SURFACE = 0.4 * np.array([0.0, 0.0, 1.3, 0.0, 0.0, 1.0])  # m/s, m, which HSMC adds to the trolley's
WEIGHTS, EFFORT_WEIGHT = np.array([60.0, 60.0, 400.0, 8.0, 8.0, 8.0]), 2e-7  # of LQR
SHAPER_DAMPING = 0.02  # -, ratio that ZVD is made for


class Transfer(NamedTuple):
    """The trolley's reference: transfers by a quintic from rest to rest, each with its part of the way and delay."""

    distance: float  # m
    duration: float  # s, of each
    parts: Any  # (n,) -
    delays: Any  # (n,) s


class CampaignLaw(NamedTuple):
    """A law of the campaign. `begun` and `last` are its state."""

    transfer: Transfer
    length: float  # m, of the rope, which is held
    effort: Any  # (2,) N, u*
    gain: Any  # (2, 6), K
    surface: Any  # (2, 6), S
    switched: Any  # (2,) N, η
    layer: float  # φ
    steepest: Any  # (2,) N, largest change of a command in a period
    begun: Any  # (1,) -, 1 after the first command
    last: Any  # (2,) N, the last command

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the commands (2,) [N] at joint positions q and velocities v (3,)."""
        return system.compute_command(self, t, np.array(q), np.array(v))

    def with_initial_state(self) -> "CampaignLaw":
        """Return the law before its first command."""
        return self._replace(begun=np.zeros(1), last=np.zeros(2))


def transfer_at(transfer, t):
    """Return (position [m], velocity [m/s]) of the reference at t [s]."""
    x, v = 0.0, 0.0
    for i in range(len(transfer.parts)):
        s = min(max((t - transfer.delays[i]) / transfer.duration, 0.0), 1.0)
        x += transfer.parts[i] * s * s * s * (10.0 + s * (6.0 * s - 15.0))
        v += transfer.parts[i] * 30.0 * s * s * (1.0 - s) * (1.0 - s)
    return transfer.distance * x, transfer.distance / transfer.duration * v


def limited_demand(law, i, e):
    """Return command i [N] for the deviation e (6,), and note it."""
    fed_back, s = 0.0, 0.0
    for j in range(6):
        fed_back += law.gain[i, j] * e[j]
        s += law.surface[i, j] * e[j]
    u = law.effort[i] - fed_back - law.switched[i] * np.tanh(s / law.layer)
    if law.begun[0] > 0.0:
        u = min(max(u, law.last[i] - law.steepest[i]), law.last[i] + law.steepest[i])
    law.last[i] = u
    return u


@system.command.register(CampaignLaw)
@routine
def commands_at(law, t, q, v):
    """Return the commands (2,) [N]; a second call at the same time and state changes nothing."""
    x, rate = transfer_at(law.transfer, t)
    e = (q[0] - x, q[1] - law.length, q[2], v[0] - rate, v[1], v[2])
    commands = limited_demand(law, 0, e), limited_demand(law, 1, e)
    law.begun[0] = 1.0
    return commands


class DampedEfforts(NamedTuple):
    """Efforts that are held, less the viscous friction of their joints: without dry friction nothing ever sticks."""

    held: tuple[float, float]  # N
    damping: tuple[float, float]  # N s/m


@system.effort.register(DampedEfforts)
def damped_efforts(u, p, t, x):
    """Return the efforts (2,) [N] in state x."""
    (_, v), held, damping = system.joints(p, x), u.held, u.damping
    return held[0] - damping[0] * v[0], held[1] - damping[1] * v[1]


class DampedLaw(NamedTuple):
    """A law that is sampled every period, and the viscous friction of trolley and hoist."""

    law: CampaignLaw
    damping: tuple[float, float]  # N s/m

    def source_at(self, p, t, x):
        """Return the source from time t [s] on, at which the crane p is in state x."""
        q, v = system.joints(p, x)
        return DampedEfforts(commands_at(self.law, t, q, v), self.damping)


def delayed_parts(length: float, gravity: float) -> tuple[Array, Array]:
    """Return (parts, delays [s]) of the zero-vibration-derivative shaper for a pendulum of this length [m].

    Singer and Seering, "Preshaping command inputs to reduce system vibration", J. Dyn. Syst. Meas. Control 112, 1990.
    """
    root = np.sqrt(1.0 - SHAPER_DAMPING**2)
    decay, half = np.exp(-SHAPER_DAMPING * np.pi / root), np.pi / (root * np.sqrt(gravity / length))
    return np.array([1.0, 2.0 * decay, decay**2]) / (1.0 + decay) ** 2, half * np.arange(3.0)


def make_campaign_law(name: str, calm: Scene, damping: tuple[float, float]) -> CampaignLaw:
    """Return one of LAWS for its crane, a scene without wind or friction; `damping` [N s/m] of trolley and hoist."""
    length, gravity = calm.initial_q[1], calm.model.gravity
    effort = np.array([0.0, -calm.file.payload_mass * gravity])
    gain, surface, switched = PD, np.zeros((2, 6)), np.zeros(2)
    parts, delays = delayed_parts(length, gravity) if name == "ZVD" else (np.ones(1), np.zeros(1))
    if name == "LQR":
        a, b = state_matrices(calm, np.array(calm.initial_q), effort)
        a[:, 3:5] -= b * np.array(damping)
        gain = b.T @ solve_continuous_are(a, b, np.diag(WEIGHTS), EFFORT_WEIGHT * np.eye(2)) / EFFORT_WEIGHT
    elif name in ("SMC", "HSMC"):
        surface, switched = SURFACES.copy(), SWITCHED
        surface[0] += SWING_SURFACE if name == "HSMC" else 0.0
        gain = SLOPES[:, None] * surface
    transfer = Transfer(DISTANCE, DURATION, parts, delays)
    law = CampaignLaw(transfer, length, effort, gain, surface, switched, LAYER, STEEPEST, np.zeros(1), np.zeros(2))
    return law.with_initial_state()


LAWS = ("PD", "LQR", "ZVD", "SMC", "HSMC")
