"""Where a knuckle boom can carry the suspension point, and what is refused since it leads elsewhere."""

from collections.abc import Iterator
from math import cos, sin, sqrt

import numpy as np

from crane_control.tracking.drives import Servo
from crane_control.tracking.knuckle_boom import Boom
from crane_sim.files.errors import SceneError
from crane_sim.models.cables.rope import RateRope
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.scenes.scene import Scene
from crane_sim.trajectories.base_motion import Base, SplineBase
from crane_sim.trajectories.path import Path
from crane_sim.trajectories.polynomials import values
from crane_sim.trajectories.replanning import pieces_of

KNEE = 0.3  # least sine of the angle between boom and jib: 17 degrees, 2 cm from a reach of 2 m
ASIDE = 0.2  # m, least distance from the tower's axis
LOOKS = 2001  # at a path, of where it leads


def boom_of(name: str, servo: Servo, nominal: Scene, base: Base | SplineBase | None) -> Boom:
    """Return the boom that carries the suspension point for the law called `name`.

    It keeps the height of its tip, and the rope its length, as the nominal scene begins. The law does not count on
    what pushes the payload, nor on the base's motion unless that is measured.

    Args:
        name, nominal: of the law, the scene that it believes in, with a path of the payload.
        servo: gains of the tip, which hold the length of a rope that is not locked, too.
        base: the base's motion, if that is measured.

    Raises:
        SceneError: the start or the path needs a posture in which the tip cannot be moved in every direction.
    """
    model, (_, beta, gamma, length) = nominal.model, nominal.initial_q[:4]
    boom, jib = model.support.boom.length, model.support.jib.length
    height = boom * sin(beta) + jib * sin(gamma)
    least, greatest = reach(model.support, height)
    start = ("initial.q: the tip begins", boom * cos(beta) + jib * cos(gamma))
    for what, radius in (start, *radii(nominal.path)):
        if not least <= radius <= greatest:
            raise SceneError(
                f"{what} {radius:.4g} m from the tower's axis; control.law = {name!r} drives the tip {least:.4g} to "
                f"{greatest:.4g} m from it, at the height of {height:.4g} m at which it begins"
            )
    believed = model._replace(cable=RateRope(), meter=None, base=base, force=None)
    return Boom(servo.kp, servo.kd, height, (least, greatest), length, model.cable, believed)


def reach(support: Knuckle, height: float) -> tuple[float, float]:
    """Return the least and the greatest distance [m] from the tower's axis at which the tip moves freely.

    At this height [m], in the base frame; without any such distance the greatest is smaller than the least.
    """
    boom, jib = support.boom.length, support.jib.length
    most = sqrt(1.0 - KNEE * KNEE)  # cosine of the angle between boom and jib
    folded, straight = (boom * boom + jib * jib + 2.0 * boom * jib * k - height * height for k in (-most, most))
    return max(ASIDE, sqrt(max(folded, 0.0))), sqrt(max(straight, 0.0))


def radii(path: Path) -> Iterator[tuple[str, float]]:
    """Yield (what is there, distance from the tower's axis [m]) along a path, from its beginning on."""
    t = np.linspace(path.starts[0], path.starts[-1], LOOKS)
    for when, place in zip(t, values(pieces_of(path), t), strict=True):
        yield f"reference.path: is at t = {when:.4g} s", float(np.hypot(place[0], place[1]))
