"""The law called `cartesian`: the payload of a driven suspension point follows a path (Smith & Egeland, eq. 64-74)."""

from collections.abc import Callable, Mapping
from math import sqrt
from typing import Any, NamedTuple

from crane_control.tracking.drives import Servo, estimate_cable, suspension_effort
from crane_control.tracking.multirate import MultirateTracker, make_multirate, tip_demand
from crane_control.tracking.suspension import drive_of, pendulum_of
from crane_control.tracking.tracker import SOFT, Gains, Tracker
from crane_control.tracking.vision import Vision, camera
from crane_sim import system
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_settings
from crane_sim.numerics.jit import entry
from crane_sim.scenes.scene import Scene


class TrackingDefaults(NamedTuple):
    """How a law tracks where its scene does not say: the defaults of the papers' law."""

    stiffness: float = 1.0  # kp, in units of the pendulum's own g / L
    damping: float = SOFT  # of the payload's error, of critical
    ramp: float = 0.0  # s, in which the gains come in
    foresees: bool = False  # the law knows how the disturbance changes: velocity is fed forward


class CartesianLaw(NamedTuple):
    """The tracker, and what carries the suspension point to where the tracker wants it."""

    tracker: Tracker | MultirateTracker
    drive: Any

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the efforts (nu,) demanded at time t [s], joint positions q (nq,) and velocities v (nq,)."""
        return compute_efforts(self, t, q, v)

    def fresh(self) -> "CartesianLaw":
        """Return the law before its first state."""
        return self._replace(tracker=self.tracker.fresh())

    @property
    def slow_half(self) -> MultirateTracker | None:
        """The tracker, where it has a rate of its own."""
        return self.tracker if isinstance(self.tracker, MultirateTracker) else None

    def fast_half(self) -> "CartesianLaw":
        """Return the law whose tracker is in another process."""
        return self._replace(tracker=self.tracker._replace(tracker=None))


@system.command.register(CartesianLaw)
def _(law, t, q, v):
    cable = estimate_cable(law.drive, law.tracker.pendulum.length, q, v)
    demand = tip_demand(law.tracker, t, cable.tip, cable.y, cable.dy)
    return suspension_effort(law.drive, t, demand, cable)


@entry
def compute_efforts(law, t, q, v):
    """Compiled `command` for calls from Python."""
    return system.command(law, t, q, v)


class Forward(NamedTuple):
    """What is fed forward to the suspension point, eq. 64, and the base's motion."""

    velocity: bool | None = None  # of the demanded position; left out: where the law knows how the disturbance changes
    acceleration: bool = False  # of the reference
    base: bool = False  # the base's acceleration is measured and opposed


class Settings(NamedTuple):
    """Gains of the payload's error and what carries the suspension point.

    For the pendulum and, by joint efforts, for the knuckle boom (`knuckle_tracking`).
    """

    kp: NonNegative | None = None  # 1/s², of the payload's error; left out: as of the pendulum's own frequency
    kd: NonNegative | None = None  # 1/s, of the payload's error; left out: by the law's own damping
    servo: Servo | None = None  # of the suspension point, where its acceleration is commanded, and of the boom's tip
    feedforward: Forward = Forward()  # to the suspension point
    vision: Vision | None = None  # a camera; left out: the law sees every state
    tracker_rate: Positive | None = None  # Hz, of a tracker in a process of its own, see Two rates in `ros.md`;
    # left out: it is asked every period


SETTINGS = {"control": Settings}


def tracking_law(
    name: str,
    settings: Mapping[str, Any],
    nominal: Scene,
    learner: Callable[[Tracker, float], Any],
    manner: TrackingDefaults,
) -> CartesianLaw:
    """Return the Cartesian law called `name`.

    Args:
        name, settings, nominal: as of `make_law`.
        learner: from a tracker without one, and the lag of the suspension point [s].
        manner: the law's own.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    given = read_settings(Settings, settings)
    (pendulum, path), forward = pendulum_of(name, nominal), given.feedforward
    base = nominal.model.base if forward.base else None
    drive = drive_of(name, given.servo, nominal, base)
    velocity = manner.foresees if forward.velocity is None else forward.velocity
    hold = nominal.period if given.tracker_rate is None else 1.0 / given.tracker_rate
    lag = 0.5 * hold + (0.0 if velocity else drive.kd / drive.kp)
    kp = manner.stiffness * pendulum.gravity / pendulum.length if given.kp is None else given.kp
    kd = 2.0 * manner.damping * sqrt(kp) if given.kd is None else given.kd
    gains = Gains(kp, kd, float(velocity), float(forward.acceleration), manner.ramp)
    tracker = Tracker(pendulum, gains, path, camera(given.vision, nominal), None, base)
    tracker = tracker._replace(learner=learner(tracker, lag))
    return CartesianLaw(make_multirate(tracker, given.tracker_rate, nominal.period), drive)


def build(settings: Mapping[str, Any], nominal: Scene) -> CartesianLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    return tracking_law("cartesian", settings, nominal, lambda tracker, lag: None, TrackingDefaults())
