"""A tree of joints and bodies by Lagrange's equations, from positions alone, in 60 digits.

Velocities, accelerations and derivatives of the energies are central differences of positions and
orientations, so nothing of the recursion that is tested stands here again. The base moves as
polynomials of time.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import mpmath as mp

from crane_sim.models.moving_base import BaseKinematics
from crane_sim.multibody.tree import Joint, Tree

# of differences: errors of 1e-24, and three nested ones leave 20 of 60 digits
STEP = mp.mpf(10) ** -12
GRAVITY = 9.81


class MovingBase(NamedTuple):
    """Coefficients of polynomials of time: origin [m], and angles about z, y, x [rad]."""

    origin: tuple[tuple[float, float, float], ...]
    angles: tuple[tuple[float, float, float], ...]

    def pose(self, t: Any) -> tuple[Any, Any]:
        """Return (orientation (3, 3), origin (3, 1)) at time t."""
        place = mp.matrix([polynomial(c, t) for c in self.origin])
        z, y, x = (polynomial(c, t) for c in self.angles)
        return turn(2, z) * turn(1, y) * turn(0, x), place

    def motion(self) -> BaseKinematics:
        """Return the motion at t = 0, in the axes of the base."""
        back = self.pose(mp.mpf(0))[0].T
        imposed = -(second_derivative(lambda t: self.pose(t)[1]) + mp.matrix([0, 0, GRAVITY]))
        up = mp.matrix([0, 0, GRAVITY])
        w, alpha = (
            spin(lambda t: self.pose(t)[0], mp.mpf(0)),
            derivative(lambda t: spin(lambda s: self.pose(s)[0], t)),
        )
        velocity = derivative(lambda t: self.pose(t)[1])
        return BaseKinematics(
            *(floats(x) for x in (back * velocity, back * imposed + up, back * w, back * alpha))
        )


def polynomial(coefficients: tuple[float, ...], t: Any) -> Any:
    """Return c0 + c1 t + c2 t²."""
    return coefficients[0] + t * (coefficients[1] + t * coefficients[2])


def turn(axis: int, angle: Any) -> Any:
    """Return the rotation (3, 3) about an axis."""
    m, (i, j) = mp.eye(3), ((axis + 1) % 3, (axis + 2) % 3)
    m[i, i] = m[j, j] = mp.cos(angle)
    m[j, i], m[i, j] = mp.sin(angle), -mp.sin(angle)
    return m


def derivative(f: Callable[[Any], Any], t: Any = 0) -> Any:
    """Return the derivative of f at t."""
    return (f(t + STEP) - f(t - STEP)) / (2 * STEP)


def second_derivative(f: Callable[[Any], Any]) -> Any:
    """Return the second derivative of f at 0."""
    return (f(STEP) - 2 * f(mp.mpf(0)) + f(-STEP)) / STEP**2


def spin(orientation: Callable[[Any], Any], t: Any) -> Any:
    """Return the angular velocity (3, 1), in the world, of an orientation given over time."""
    w = derivative(orientation, t) * orientation(t).T
    return mp.matrix([w[2, 1], w[0, 2], w[1, 0]])


def floats(a: Any) -> Any:
    """Return a vector as floats."""
    return tuple(float(x) for x in a)


class BodyPose(NamedTuple):
    """A body in the world."""

    mass: Any
    centre: Any  # (3, 1)
    axes: Any  # (3, 3)
    inertia: Any  # (3, 3) in the body's axes


def body_poses(tree: Tree, base: MovingBase, t: Any, q: list[Any]) -> list[BodyPose]:
    """Return all bodies at time t and positions q."""
    links: list[tuple[Any, Any]] = []
    poses = []
    for joint, position in zip(tree.joints, q, strict=True):
        below = base.pose(t) if joint.parent < 0 else links[joint.parent]
        links.append(link_pose(joint, position, *below))
        axes, origin = links[-1]
        for body in joint.bodies:
            poses.append(
                BodyPose(
                    body.mass, origin + axes * mp.matrix(body.centre), axes, mp.matrix(body.inertia)
                )
            )
    return poses


def link_pose(joint: Joint, position: Any, axes: Any, origin: Any) -> tuple[Any, Any]:
    """Return (orientation, origin) of the link that a joint moves, from those of the link below."""
    moved = -position if joint.reverse else position
    origin = origin + axes * mp.matrix(joint.offset)
    if not joint.slides:
        return axes * turn(joint.axis, moved), origin
    return axes, origin + axes[:, joint.axis] * moved


def lagrange_efforts(
    tree: Tree, base: MovingBase, q: Any, v: Any, a: Any, motors: Any
) -> list[float]:
    """Return the efforts (n,) of d/dt dL/dv - dL/dq = τ at t = 0 for accelerations a.

    Those of motors are included.
    """

    def path(t: Any) -> tuple[list[Any], list[Any]]:
        positions = [x + t * (y + t * z / 2) for x, y, z in zip(q, v, a, strict=True)]
        return positions, [y + t * z for y, z in zip(v, a, strict=True)]

    def momentum(t: Any, i: int) -> Any:
        x, y = path(t)
        return derivative(lambda s: lagrangian(tree, base, t, x, moved(y, i, s)))

    efforts = []
    for i, motor in enumerate(motors):
        force = derivative(
            lambda s, i=i: lagrangian(tree, base, mp.mpf(0), moved(list(q), i, s), list(v))
        )
        efforts.append(float(derivative(lambda t, i=i: momentum(t, i)) - force + motor * a[i]))
    return efforts


def moved(x: list[Any], i: int, change: Any) -> list[Any]:
    """Return x with entry i changed."""
    return [entry + change if k == i else entry for k, entry in enumerate(x)]


def lagrangian(tree: Tree, base: MovingBase, t: Any, q: list[Any], v: list[Any]) -> Any:
    """Return kinetic less potential energy [J].

    Motors, which turn with their joint alone, are left out.
    """

    def poses(s: Any) -> list[BodyPose]:
        return body_poses(tree, base, t + s, [x + s * y for x, y in zip(q, v, strict=True)])

    total, (behind, now, ahead) = mp.mpf(0), (poses(-STEP), poses(mp.mpf(0)), poses(STEP))
    for before, body, after in zip(behind, now, ahead, strict=True):
        velocity = (after.centre - before.centre) / (2 * STEP)
        rate = (after.axes - before.axes) / (2 * STEP) * body.axes.T
        w = body.axes.T * mp.matrix([rate[2, 1], rate[0, 2], rate[1, 0]])
        total += (
            body.mass * (dot(velocity, velocity) / 2 - GRAVITY * body.centre[2])
            + dot(w, body.inertia * w) / 2
        )
    return total


def dot(a: Any, b: Any) -> Any:
    """Return the scalar product."""
    return (a.T * b)[0]


def reaction(tree: Tree, base: MovingBase, q: Any, v: Any, a: Any) -> tuple[Any, Any]:
    """Return (force, moment about the origin of the base) that moves all bodies.

    Both are in the base's axes, gravity included.
    """

    def poses(t: Any) -> list[BodyPose]:
        return body_poses(
            tree, base, t, [x + t * (y + t * z / 2) for x, y, z in zip(q, v, a, strict=True)]
        )

    axes, origin = base.pose(mp.mpf(0))
    force, moment = mp.zeros(3, 1), mp.zeros(3, 1)
    for i, body in enumerate(poses(mp.mpf(0))):
        acceleration = second_derivative(lambda t, i=i: poses(t)[i].centre) + mp.matrix(
            [0, 0, GRAVITY]
        )
        push = body.mass * acceleration
        force += push
        moment += cross(body.centre - origin, push) + derivative(
            lambda t, i=i: angular_momentum(poses, i, t)
        )
    return axes.T * force, axes.T * moment


def angular_momentum(poses: Callable[[Any], list[BodyPose]], i: int, t: Any) -> Any:
    """Return the angular momentum of body i about its centre of mass."""
    body = poses(t)[i]
    return body.axes * body.inertia * body.axes.T * spin(lambda s: poses(s)[i].axes, t)


def cross(a: Any, b: Any) -> Any:
    """Return the vector product."""
    return mp.matrix(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
