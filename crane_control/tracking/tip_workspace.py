"""Workspace of a knuckle boom's tip, and the check that a start and a trajectory lie in it."""

from collections.abc import Iterator
from math import cos, sin, sqrt

import numpy as np

from crane_control.tracking.knuckle_boom import BoomServo
from crane_control.tracking.tip_servo import Servo
from crane_sim.files.errors import SceneError
from crane_sim.models.cables.rope import MotionRope
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.supports.support import structure_of
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.polynomials import evaluate
from crane_sim.trajectories.replanning import to_piecewise_polynomial
from crane_sim.trajectories.trajectory import Trajectory

MIN_ELBOW_SINE = 0.3  # of the angle between boom and jib, singular at 0: 17 degrees, 2 cm below a full reach of 2 m
MIN_RADIUS = 0.2  # m, distance from the tower's axis
PATH_SAMPLES = 2001  # instants of a trajectory at which its distance is checked


def make_boom_servo(name: str, servo: Servo, nominal: Scene, base: AnyBase | None) -> BoomServo:
    """Return the tip servo by a knuckle boom for the law called `name`.

    Setpoints of the tip's height and the rope's length are those at the start of the nominal scene. The
    nominal model has neither wind nor a force on the payload, and the base's motion only if that is measured.

    Args:
        name, nominal: of the law, its nominal scene, with a trajectory of the payload.
        servo: gains of the tip, also used for the length of a rope that is not locked.
        base: the base's motion, if that is measured.

    Raises:
        SceneError: the start or the trajectory needs a posture in which the tip cannot be moved in every direction.
    """
    model, (_, beta, gamma, length) = nominal.model, nominal.initial_q[:4]
    structure = structure_of(model.support)
    boom, jib = structure.boom.length, structure.jib.length
    height = boom * sin(beta) + jib * sin(gamma)
    min_radius, max_radius = radius_range(structure, height)
    start = ("initial.q: the tip begins", boom * cos(beta) + jib * cos(gamma))
    for what, radius in (start, *trajectory_radii(nominal.trajectory)):
        if not min_radius <= radius <= max_radius:
            raise SceneError(
                f"{what} {radius:.4g} m from the tower's axis; control.law = {name!r} drives the tip "
                f"{min_radius:.4g} to {max_radius:.4g} m from it, at the height of {height:.4g} m at which it begins"
            )
    boom_model = model._replace(cable=MotionRope(), energy_meter=None, base=base, force=None, wind=None, friction=None)
    return BoomServo(servo.kp, servo.kd, height, (min_radius, max_radius), length, model.cable, boom_model)


def radius_range(support: Knuckle, height: float) -> tuple[float, float]:
    """Return the least and the greatest distance [m] of a tip from the tower's axis that can move in every direction.

    At this height [m], in the base frame; without any such distance the greatest is smaller than the least.
    """
    boom, jib = support.boom.length, support.jib.length
    max_cosine = sqrt(1.0 - MIN_ELBOW_SINE * MIN_ELBOW_SINE)  # cosine of the angle between boom and jib
    folded, straight = (
        boom * boom + jib * jib + 2.0 * boom * jib * k - height * height for k in (-max_cosine, max_cosine)
    )
    return max(MIN_RADIUS, sqrt(max(folded, 0.0))), sqrt(max(straight, 0.0))


def trajectory_radii(trajectory: Trajectory) -> Iterator[tuple[str, float]]:
    """Yield (description of the point, distance from the tower's axis [m]) along a trajectory from its start."""
    t = np.linspace(trajectory.starts[0], trajectory.starts[-1], PATH_SAMPLES)
    for time, position in zip(t, evaluate(to_piecewise_polynomial(trajectory), t), strict=True):
        yield f"reference.path: is at t = {time:.4g} s", float(np.hypot(position[0], position[1]))
