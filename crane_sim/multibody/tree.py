"""A tree of joints and rigid bodies on a base that may move: the equations M(q) v̇ + c(q, v) = τ + Σ Jᵀ f.

Composite rigid bodies give M, the recursion of Newton and Euler gives c (Featherstone, Rigid Body Dynamics
Algorithms, 2008, chapters 5 and 6), both about the base's origin. Gravity and the base's motion are the root's
acceleration. Components are along the base's axes, or, where the first joint slews, along axes that it turns: below
it a boom then stays in one plane, and most components are the literal 0.
"""

from typing import Any, NamedTuple

from crane_sim.multibody import linear
from crane_sim.multibody.vectors import (
    IDENTITY,
    ZERO,
    Matrix,
    Vector,
    acceleration_gradient,
    add,
    add_matrices,
    combine,
    cross,
    dot,
    multiply,
    point_inertia,
    scale,
    turned_inertia,
)
from crane_sim.tracing.elementary import sincos
from crane_sim.tracing.operations import select

X, Y, Z = 0, 1, 2
"""Axes of a link."""


class Body(NamedTuple):
    """A rigid body, in the axes of its link."""

    mass: Any  # kg
    centre: Vector = ZERO  # m, of mass, from the link's origin
    inertia: Matrix = (ZERO, ZERO, ZERO)  # kg m², about the centre of mass


class Joint(NamedTuple):
    """A joint, and the link that it moves. The link's axes are those of the link below where the position is 0."""

    axis: int  # X, Y or Z of the link below
    slides: bool = False  # along the axis; else it turns about it, right-handed
    reverse: bool = False  # the position counts in the other sense
    parent: int = -1  # number of the joint that moves the link below, -1: it is the base
    offset: Vector = ZERO  # m, of the link's origin at position 0, in the axes of the link below
    bodies: tuple[Body, ...] = ()
    rotor: Any = 0.0  # kg or kg m², of the motor, at the joint's speed


class Point(NamedTuple):
    """A point of a link, such as the tip that carries the rope."""

    joint: int  # that moves the link
    offset: Vector = ZERO  # m, in the link's axes


class Tree(NamedTuple):
    """Joints, each after its parent, and the point that the rope is attached to."""

    joints: tuple[Joint, ...]
    tip: Point


class BaseMotion(NamedTuple):
    """Motion of the base's origin, in the axes of the base."""

    acceleration: Vector  # m/s², with gravity upwards: (0, 0, g) at rest
    angular_velocity: Vector = ZERO  # rad/s
    angular_acceleration: Vector = ZERO  # rad/s²
    velocity: Vector = ZERO  # m/s


class Link(NamedTuple):
    """Motion of a link without joint accelerations."""

    axes: Matrix
    origin: Vector  # m, from the base's origin
    velocity: Vector  # m/s
    angular_velocity: Vector  # rad/s
    acceleration: Vector  # m/s², of the origin
    angular_acceleration: Vector  # rad/s²
    gradient: Matrix  # 1/s², of `acceleration_gradient`


class Wrench(NamedTuple):
    """A force and a moment about the base's origin; or momentum and angular momentum."""

    force: Vector  # N
    moment: Vector  # N m


class Composite(NamedTuple):
    """A link with all that it carries."""

    mass: Any  # kg
    first_moment: Vector  # kg m, mass times place of the centre
    inertia: Matrix  # kg m², about the base's origin
    bias: Wrench  # that moves it without joint accelerations


class Screw(NamedTuple):
    """A joint's unit velocity: of the body at the base's origin."""

    linear: Vector
    angular: Vector


class Dynamics(NamedTuple):
    """A tree at one instant.

    `turn` is (sine, cosine) of the angle about the base's z that the components' axes are turned by: the slew's.
    """

    turn: tuple[Any, Any]
    links: tuple[Link, ...]
    screws: tuple[Screw, ...]
    momenta: tuple[Wrench, ...]  # of each joint's composite at its unit velocity
    bias: Wrench  # of the whole tree
    mass_matrix: linear.Matrix  # (n, n), lower triangle
    bias_efforts: tuple[Any, ...]  # c (n,)
    factors: linear.Factors


def compute_dynamics(
    tree: Tree, q: tuple[Any, ...], v: tuple[Any, ...], base: BaseMotion, free: tuple[Any, ...] | None = None
) -> Dynamics:
    """Return the dynamics at joint positions q and velocities v, both (n,).

    Args:
        tree: joints and bodies.
        q: joint positions (n,) [m or rad].
        v: joint velocities (n,).
        base: motion of the base, gravity included.
        free: (n,) conditions, false where a joint sticks and leaves the equations; None: all joints move.
    """
    turn = sincos(q[0]) if _slews(tree) else (0.0, 1.0)
    links = _move_links(tree, q, v, turn, _root_link(base, turn))
    screws = tuple(_screw(tree, links, turn, i) for i in range(len(links)))
    composites = _compose(tree, links)
    momenta = tuple(_momentum(c, s) for c, s in zip(composites, screws, strict=True))
    matrix = _mass_matrix(tree, screws, momenta)
    bias_efforts = tuple(_power(s, c.bias) for c, s in zip(composites, screws, strict=True))
    total = _sum_of([c.bias for c, joint in zip(composites, tree.joints, strict=True) if joint.parent < 0])
    factors = linear.factor(matrix if free is None else _without_sticking(matrix, free))
    return Dynamics(turn, links, screws, momenta, total, matrix, bias_efforts, factors)


def accelerations(dynamics: Dynamics, efforts: tuple[Any, ...], free: tuple[Any, ...] | None = None) -> tuple[Any, ...]:
    """Return joint accelerations (n,) under efforts (n,) on the joints, 0 where a joint sticks.

    Efforts are those of drives and springs, and what forces on the links add: `efforts_of`.
    """
    rest = tuple(u - c for u, c in zip(efforts, dynamics.bias_efforts, strict=True))
    if free is not None:
        rest = tuple(select(moves, entry, 0.0) for moves, entry in zip(free, rest, strict=True))
    return linear.solve(dynamics.factors, rest)


def efforts_of(tree: Tree, dynamics: Dynamics, point: Point, force: Vector, moment: Vector = ZERO) -> tuple[Any, ...]:
    """Return the joint efforts Jᵀ f (n,) of a force [N] on a point of a link and a moment [N m] on it.

    Force and moment are in the components' axes.
    """
    wrench = Wrench(force, add(moment, cross(point_position(dynamics, point), force)))
    below = _ancestors(tree, point.joint)
    return tuple(_power(s, wrench) if i in below else 0.0 for i, s in enumerate(dynamics.screws))


def point_position(dynamics: Dynamics, point: Point) -> Vector:
    """Return the place [m] of a point, from the base's origin."""
    link = dynamics.links[point.joint]
    return add(link.origin, combine(link.axes, point.offset))


def point_velocity(dynamics: Dynamics, point: Point) -> Vector:
    """Return the velocity [m/s] of a point, that of the base included."""
    link = dynamics.links[point.joint]
    return add(link.velocity, cross(link.angular_velocity, combine(link.axes, point.offset)))


def point_acceleration(tree: Tree, dynamics: Dynamics, point: Point, joint_accelerations: tuple[Any, ...]) -> Vector:
    """Return the acceleration [m/s²] of a point, with that of the base and gravity upwards."""
    link = dynamics.links[point.joint]
    total = add(link.acceleration, multiply(link.gradient, combine(link.axes, point.offset)))
    place = point_position(dynamics, point)
    for i in _ancestors(tree, point.joint):
        screw = dynamics.screws[i]
        total = add(total, scale(joint_accelerations[i], add(screw.linear, cross(screw.angular, place))))
    return total


def point_mobility(tree: Tree, dynamics: Dynamics, point: Point, n: Vector, free: tuple[Any, ...] | None = None) -> Any:
    """Return the mobility nᵀ J M⁻¹ Jᵀ n [1/kg] of a point along the unit vector n."""
    levers = efforts_of(tree, dynamics, point, n)
    if free is not None:
        levers = tuple(select(moves, lever, 0.0) for moves, lever in zip(free, levers, strict=True))
    answer = linear.solve(dynamics.factors, levers)
    return linear.inner(levers, answer)


def base_reaction(dynamics: Dynamics, joint_accelerations: tuple[Any, ...]) -> Wrench:
    """Return the wrench that moves the tree: of the base and of all forces on links together."""
    moved = [_scaled(momentum, a) for momentum, a in zip(dynamics.momenta, joint_accelerations, strict=True)]
    return _sum_of([dynamics.bias, *moved])


def to_tree_axes(dynamics: Dynamics, a: Vector) -> Vector:
    """Return a vector of the base's axes in the components' axes."""
    return _turn_back(a, dynamics.turn)


def to_base_axes(dynamics: Dynamics, a: Vector) -> Vector:
    """Return a vector of the components' axes in the base's."""
    s, c = dynamics.turn
    return c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]


def slew(tree: Tree) -> int | None:
    """Return the number of the first joint below the tip that turns about its z axis, None where none does."""
    turning = [i for i in _ancestors(tree, tree.tip.joint) if tree.joints[i].axis == Z and not tree.joints[i].slides]
    return min(turning, default=None)


def _slews(tree: Tree) -> bool:
    first = tree.joints[0]
    return first.axis == Z and not first.slides and not first.reverse and all(j.parent >= 0 for j in tree.joints[1:])


def _root_link(base: BaseMotion, turn: tuple[Any, Any]) -> Link:
    """Return the base as a link, in the components' axes."""
    w, alpha = _turn_back(base.angular_velocity, turn), _turn_back(base.angular_acceleration, turn)
    axes = tuple(_turn_back(axis, turn) for axis in IDENTITY)
    acceleration, velocity = _turn_back(base.acceleration, turn), _turn_back(base.velocity, turn)
    return Link(axes, ZERO, velocity, w, acceleration, alpha, acceleration_gradient(w, alpha))  # type: ignore[arg-type]


def _turn_back(a: Vector, turn: tuple[Any, Any]) -> Vector:
    s, c = turn
    return c * a[0] + s * a[1], c * a[1] - s * a[0], a[2]


def _move_links(
    tree: Tree, q: tuple[Any, ...], v: tuple[Any, ...], turn: tuple[Any, Any], root: Link
) -> tuple[Link, ...]:
    links: list[Link] = []
    for i, joint in enumerate(tree.joints):
        below = root if joint.parent < 0 else links[joint.parent]
        carried = _carry(below, joint.offset)
        if joint.slides:
            links.append(_slide(carried, _axis(joint, below.axes), q[i], v[i]))
        else:
            axes = IDENTITY if i == 0 and _slews(tree) else _turn_axes(joint, below.axes, q[i])
            links.append(_turn(carried, axes, _axis(joint, below.axes), v[i]))
    return tuple(links)


def _axis(joint: Joint, axes: Matrix) -> Vector:
    return scale(-1.0, axes[joint.axis]) if joint.reverse else axes[joint.axis]


def _carry(link: Link, offset: Vector) -> Link:
    """Return the motion of a link about another origin of its own."""
    r = combine(link.axes, offset)
    return link._replace(
        origin=add(link.origin, r),
        velocity=add(link.velocity, cross(link.angular_velocity, r)),
        acceleration=add(link.acceleration, multiply(link.gradient, r)),
    )


def _slide(link: Link, axis: Vector, q: Any, v: Any) -> Link:
    r, w = scale(q, axis), link.angular_velocity
    coriolis = cross(w, scale(2.0 * v, axis))
    return link._replace(
        origin=add(link.origin, r),
        velocity=add(add(link.velocity, cross(w, r)), scale(v, axis)),
        acceleration=add(add(link.acceleration, multiply(link.gradient, r)), coriolis),
    )


def _turn_axes(joint: Joint, axes: Matrix, angle: Any) -> Matrix:
    """Return the axes after a turn about one of them; the other two turn in their plane."""
    s, c = sincos(angle)
    s = -s if joint.reverse else s
    turned = list(axes)
    i, j = (joint.axis + 1) % 3, (joint.axis + 2) % 3
    turned[i] = add(scale(c, axes[i]), scale(s, axes[j]))
    turned[j] = add(scale(c, axes[j]), scale(-s, axes[i]))
    return tuple(turned)  # type: ignore[return-value]


def _turn(link: Link, axes: Matrix, axis: Vector, v: Any) -> Link:
    rate = scale(v, axis)
    w = add(link.angular_velocity, rate)
    alpha = add(link.angular_acceleration, cross(link.angular_velocity, rate))
    return link._replace(
        axes=axes, angular_velocity=w, angular_acceleration=alpha, gradient=acceleration_gradient(w, alpha)
    )


def _screw(tree: Tree, links: tuple[Link, ...], turn: tuple[Any, Any], i: int) -> Screw:
    joint, link = tree.joints[i], links[i]
    below = tuple(_turn_back(axis, turn) for axis in IDENTITY) if joint.parent < 0 else links[joint.parent].axes
    axis = _axis(joint, below)  # type: ignore[arg-type]
    return Screw(axis, ZERO) if joint.slides else Screw(cross(link.origin, axis), axis)


def _compose(tree: Tree, links: tuple[Link, ...]) -> list[Composite]:
    composites = [_link_composite(joint, link) for joint, link in zip(tree.joints, links, strict=True)]
    for i in reversed(range(len(composites))):
        parent = tree.joints[i].parent
        if parent >= 0:
            composites[parent] = _join(composites[parent], composites[i])
    return composites


def _link_composite(joint: Joint, link: Link) -> Composite:
    total = Composite(0.0, ZERO, (ZERO, ZERO, ZERO), Wrench(ZERO, ZERO))
    for body in joint.bodies:
        total = _join(total, _body_composite(body, link))
    return total


def _body_composite(body: Body, link: Link) -> Composite:
    r = combine(link.axes, body.centre)
    centre = add(link.origin, r)
    own = turned_inertia(link.axes, body.inertia)
    force = scale(body.mass, add(link.acceleration, multiply(link.gradient, r)))
    w = link.angular_velocity
    spin = add(multiply(own, link.angular_acceleration), cross(w, multiply(own, w)))
    inertia = add_matrices(own, point_inertia(body.mass, centre))
    return Composite(body.mass, scale(body.mass, centre), inertia, Wrench(force, add(spin, cross(centre, force))))


def _join(a: Composite, b: Composite) -> Composite:
    inertia = add_matrices(a.inertia, b.inertia)
    return Composite(a.mass + b.mass, add(a.first_moment, b.first_moment), inertia, _sum_of([a.bias, b.bias]))


def _momentum(composite: Composite, screw: Screw) -> Wrench:
    """Return momentum and angular momentum, about the base's origin, of a composite at a joint's unit velocity."""
    h = composite.first_moment
    linear_part = add(scale(composite.mass, screw.linear), cross(screw.angular, h))
    return Wrench(linear_part, add(multiply(composite.inertia, screw.angular), cross(h, screw.linear)))


def _mass_matrix(tree: Tree, screws: tuple[Screw, ...], momenta: tuple[Wrench, ...]) -> linear.Matrix:
    rows = []
    for i, joint in enumerate(tree.joints):
        below = _ancestors(tree, i)
        row = [_power(screws[k], momenta[i]) if k in below else 0.0 for k in range(i + 1)]
        row[i] = row[i] + joint.rotor
        rows.append(tuple(row))
    return tuple(rows)


def _without_sticking(matrix: linear.Matrix, free: tuple[Any, ...]) -> linear.Matrix:
    """Return the matrix with the rows and columns of sticking joints replaced by those of the identity."""
    rows = []
    for i, row in enumerate(matrix):
        kept = [select(free[i], select(free[k], row[k], 0.0), 0.0) for k in range(i)]
        rows.append((*kept, select(free[i], row[i], 1.0)))
    return tuple(rows)


def _ancestors(tree: Tree, i: int) -> set[int]:
    """Return the numbers of the joints that move link i: joint i, and those below."""
    found = set()
    while i >= 0:
        found.add(i)
        i = tree.joints[i].parent
    return found


def _power(screw: Screw, wrench: Wrench) -> Any:
    return dot(screw.linear, wrench.force) + dot(screw.angular, wrench.moment)


def _scaled(wrench: Wrench, factor: Any) -> Wrench:
    return Wrench(scale(factor, wrench.force), scale(factor, wrench.moment))


def _sum_of(wrenches: list[Wrench]) -> Wrench:
    total = Wrench(ZERO, ZERO)
    for wrench in wrenches:
        total = Wrench(add(total.force, wrench.force), add(total.moment, wrench.moment))
    return total
