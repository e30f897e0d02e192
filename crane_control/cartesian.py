"""The law `cartesian`: the payload of a driven suspension point follows a path.

It is by Smith & Egeland, eq. 64-74.
"""

from collections.abc import Callable, Mapping
from math import sqrt
from typing import Any, NamedTuple

from crane_control.tracking.multirate import MultirateTracker, make_multirate, tip_setpoint
from crane_control.tracking.suspension import make_tip_servo, nominal_pendulum
from crane_control.tracking.tip_servo import Servo
from crane_control.tracking.tracker import INITIAL_DAMPING, Gains, Tracker
from crane_control.tracking.vision import CameraSettings, make_camera
from crane_sim import system
from crane_sim.files.types import NonNegative, Positive
from crane_sim.laws import read_settings
from crane_sim.scenes.scene import Scene


class TrackingDefaults(NamedTuple):
    """Defaults of a law's settings, here those of the papers' law."""

    stiffness: float = 1.0  # kp, in units of g / L, the square of the pendulum's natural frequency
    damping: float = INITIAL_DAMPING  # of the payload's error, of critical
    ramp: float = 0.0  # s, in which the gains rise to their values
    velocity_feedforward: bool = False  # of the setpoint: for a law that estimates the
    # disturbance's rate


class CartesianLaw(NamedTuple):
    """The tracker, and the servo that brings the suspension point to its setpoint."""

    tracker: Tracker | MultirateTracker
    servo: Any  # of the suspension point, a `tracking.tip_servo.TipServo`

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return effort commands (nu,) at t [s], joint positions q and velocities v (nq,)."""
        return system.compute_command(self, t, q, v)

    def with_initial_state(self) -> "CartesianLaw":
        """Return the law with its initial state."""
        return self._replace(tracker=self.tracker.with_initial_state())

    @property
    def outer_loop(self) -> MultirateTracker | None:
        """The tracker, where it has a rate of its own."""
        return self.tracker if isinstance(self.tracker, MultirateTracker) else None

    def inner_loop(self) -> "CartesianLaw":
        """Return the law whose tracker is in another process."""
        return self._replace(tracker=self.tracker._replace(tracker=None))


@system.command.register(CartesianLaw)
def cartesian_command(law, t, q, v):
    """Return the efforts (nu,) that bring the suspension point to the tracker's setpoint."""
    cable = law.servo.cable_state(law.tracker.pendulum.length, q, v)
    setpoint = tip_setpoint(law.tracker, t, cable.tip, cable.payload, cable.dpayload)
    return law.servo.suspension_efforts(t, setpoint, cable)


class Forward(NamedTuple):
    """Feedforward to the suspension point, eq. 64, and of the base's motion."""

    velocity: bool | None = None  # of the setpoint; left out: where the law estimates the
    # disturbance's rate
    acceleration: bool = False  # of the reference
    base: bool = False  # the base's acceleration is measured and compensated


class Settings(NamedTuple):
    """Gains of the payload's error and what carries the suspension point.

    For the pendulum and, by joint efforts, for the knuckle boom (`knuckle_tracking`).
    """

    kp: NonNegative | None = None  # 1/s², of the payload's error; left out: from the pendulum's
    # natural frequency
    kd: NonNegative | None = None  # 1/s, of the payload's error; left out: by the law's own damping
    servo: Servo | None = None  # of the suspension point, where its acceleration is commanded, and
    # of the boom's tip
    feedforward: Forward = Forward()  # to the suspension point
    vision: CameraSettings | None = None  # a camera; left out: the law sees every state
    tracker_rate: Positive | None = None  # Hz, of a tracker in a process of its own, see Two rates
    # in `ros.md`; left out: it is sampled every period


SETTINGS = {"control": Settings}


def make_cartesian_law(
    name: str,
    settings: Mapping[str, Any],
    nominal: Scene,
    make_estimator: Callable[[Tracker, float], Any],
    defaults: TrackingDefaults,
) -> CartesianLaw:
    """Return the Cartesian law called `name`.

    Args:
        name, settings, nominal: of the law; the settings are those of its group, the scene is the
            nominal one.
        make_estimator: makes the disturbance estimator of a tracker (None: none), given the
            suspension point's lag [s].
        defaults: the law's own.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    options = read_settings(Settings, settings)
    (pendulum, trajectory), forward = nominal_pendulum(name, nominal), options.feedforward
    base = nominal.model.base if forward.base else None
    servo = make_tip_servo(name, options.servo, nominal, base)
    velocity = defaults.velocity_feedforward if forward.velocity is None else forward.velocity
    hold = nominal.period if options.tracker_rate is None else 1.0 / options.tracker_rate
    lag = 0.5 * hold + (0.0 if velocity else servo.kd / servo.kp)
    kp = (
        defaults.stiffness * pendulum.gravity / pendulum.length
        if options.kp is None
        else options.kp
    )
    kd = 2.0 * defaults.damping * sqrt(kp) if options.kd is None else options.kd
    gains = Gains(kp, kd, float(velocity), float(forward.acceleration), defaults.ramp)
    tracker = Tracker(pendulum, gains, trajectory, make_camera(options.vision, nominal), None, base)
    tracker = tracker._replace(disturbance_estimator=make_estimator(tracker, lag))
    return CartesianLaw(make_multirate(tracker, options.tracker_rate, nominal.period), servo)


def build(settings: Mapping[str, Any], nominal: Scene) -> CartesianLaw:
    """Return the law for its nominal scene.

    Raises:
        SceneError: a setting is unknown or out of range, or the law does not fit the scene.
    """
    return make_cartesian_law(
        "cartesian", settings, nominal, lambda tracker, lag: None, TrackingDefaults()
    )
