"""A tree of joints and rigid bodies: the equations M(q) v̇ + c(q, v) + g ∂V/∂q = τ + Σ Jᵀ f.

Composite rigid bodies give M, the recursion of Newton and Euler gives c (Featherstone, Rigid Body
Dynamics Algorithms, 2008, chapters 5 and 6), both about the base's origin and relative to the base;
what a moving base imposes is an effort (`imposed_efforts`). Components are along the base's axes
or, where the first joint turns about their z, along axes that turn with it: a boom then stays in
one plane, and most components are the integer 0, which costs nothing in code.

Coordinates q are what drives move. The position of a joint is a sum of coordinates, mostly one
alone: an elevation that is measured from the horizontal is that of the link below plus the joint's
own turn.
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
    to_turned_axes,
    turned_inertia,
)
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.states import replace_entry

X, Y, Z = 0, 1, 2
"""Axes of a link."""


class Body(NamedTuple):
    """A rigid body, in the axes of its link."""

    mass: Any  # kg
    centre: Vector = ZERO  # m, of mass, from the link's origin
    inertia: Matrix = (ZERO, ZERO, ZERO)  # kg m², about the centre of mass


class Joint(NamedTuple):
    """A joint and the link that it moves, whose axes are those of the link below at position 0."""

    axis: int  # X, Y or Z of the link below
    position: tuple[tuple[int, int], ...]  # (number of a coordinate, factor): their sum
    slides: bool = False  # along the axis; else it turns about it, right-handed
    reverse: bool = False  # the position counts in the other sense
    parent: int = -1  # number of the joint that moves the link below, -1: it is the base
    offset: Vector = ZERO  # m, of the link's origin at position 0, in the axes of the link below
    bodies: tuple[Body, ...] = ()


class Point(NamedTuple):
    """A point of a link."""

    joint: int  # that moves the link, -1: it is the base
    offset: Vector = ZERO  # m, in the link's axes


class Tree(NamedTuple):
    """Joints, each after its parent, and the point that the rope is attached to."""

    joints: tuple[Joint, ...]
    tip: Point


class Link(NamedTuple):
    """Motion of a link relative to the base, without accelerations of coordinates."""

    axes: Matrix
    origin: Vector  # m, from the base's origin
    velocity: Vector  # m/s, of the origin
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
    bias: Wrench  # that moves it without accelerations of coordinates


class Screw(NamedTuple):
    """A joint's unit velocity: of the body at the base's origin."""

    linear: Vector
    angular: Vector


class Kinematics(NamedTuple):
    """Places and motion of a tree's links, with components in turned axes.

    `turn` is (sine, cosine) of the angle that the components' axes turn by.
    """

    turn: tuple[Any, Any]
    links: tuple[Link, ...]
    screws: tuple[Screw, ...]


class Inertia(NamedTuple):
    """Inertia and bias of a tree at one instant."""

    matrix: linear.Matrix  # (n, n) of coordinates, lower triangle
    bias_efforts: tuple[Any, ...]  # c (n,)
    weights: tuple[Any, ...]  # kg or kg m, (n,): ∂V/∂q of the potential V g
    momenta: tuple[Wrench, ...]  # of each joint's composite at its unit velocity
    bias: Wrench  # of the whole tree
    first_moment: Vector  # kg m, of the whole tree


def compute_kinematics(tree: Tree, q: tuple[Any, ...], v: tuple[Any, ...]) -> Kinematics:
    """Return the kinematics at coordinates q (n,) [m or rad] and rates v (n,)."""
    slews = _slews(tree)
    turn = sincos(_sum_of(q, tree.joints[0].position)) if slews else (0, 1)
    root, links = Link(IDENTITY, ZERO, ZERO, ZERO, ZERO, ZERO, (ZERO, ZERO, ZERO)), ()
    for joint in tree.joints:
        below = links[joint.parent] if joint.parent >= 0 else root
        links = (*links, _move_link(joint, below, q, v, slews and joint.parent < 0))
    screws = tuple(_screw(tree, links, i) for i in range(len(links)))
    return Kinematics(turn, links, screws)


def compute_inertia(tree: Tree, kinematics: Kinematics, n: int) -> Inertia:
    """Return inertia and bias of a tree with n coordinates."""
    composites = _compose(tree, kinematics.links)
    momenta = tuple(_momentum(c, s) for c, s in zip(composites, kinematics.screws, strict=True))
    joints = [(c.bias, s) for c, s in zip(composites, kinematics.screws, strict=True)]
    bias_efforts = to_coordinates(tree, tuple(_power(screw, bias) for bias, screw in joints), n)
    roots = [c for c, joint in zip(composites, tree.joints, strict=True) if joint.parent < 0]
    return Inertia(
        matrix=_matrix_of_coordinates(tree, _matrix_of_joints(tree, kinematics.screws, momenta), n),
        bias_efforts=bias_efforts,
        weights=to_coordinates(tree, tuple(momentum.force[Z] for momentum in momenta), n),
        momenta=momenta,
        bias=_total([c.bias for c in roots]),
        first_moment=_sum_vectors([c.first_moment for c in roots]),
    )


def to_coordinates(tree: Tree, efforts: tuple[Any, ...], n: int) -> tuple[Any, ...]:
    """Return the efforts on n coordinates of efforts on the tree's joints."""
    total = (0,) * n
    for joint, effort in zip(tree.joints, efforts, strict=True):
        for i, factor in joint.position:
            total = replace_entry(total, i, total[i] + factor * effort)
    return total


def efforts_of(
    tree: Tree, kinematics: Kinematics, n: int, joint: int, wrench: Wrench
) -> tuple[Any, ...]:
    """Return the efforts Jᵀ f (n,) of a wrench on the link of a joint, in the components' axes."""
    below = _ancestors(tree, joint)
    powers = [
        _power(screw, wrench) if i in below else 0 for i, screw in enumerate(kinematics.screws)
    ]
    return to_coordinates(tree, tuple(powers), n)


def wrench_at(place: Vector, force: Vector) -> Wrench:
    """Return the wrench of a force [N] at a place [m]."""
    return Wrench(force, cross(place, force))


def point_position(kinematics: Kinematics, point: Point) -> Vector:
    """Return the place [m] of a point, from the base's origin."""
    if point.joint < 0:
        return point.offset
    link = kinematics.links[point.joint]
    return add(link.origin, combine(link.axes, point.offset))


def point_velocity(kinematics: Kinematics, point: Point) -> Vector:
    """Return the velocity [m/s] of a point relative to the base."""
    link = kinematics.links[point.joint]
    return add(link.velocity, cross(link.angular_velocity, combine(link.axes, point.offset)))


def point_acceleration(
    tree: Tree, kinematics: Kinematics, point: Point, qdd: tuple[Any, ...]
) -> Vector:
    """Return the acceleration [m/s²] of a point relative to the base at qdd (n,).

    qdd are the accelerations of the coordinates.
    """
    link = kinematics.links[point.joint]
    total = add(link.acceleration, multiply(link.gradient, combine(link.axes, point.offset)))
    return add(total, velocity_at_rates(tree, kinematics, point, qdd))


def velocity_at_rates(
    tree: Tree, kinematics: Kinematics, point: Point, rates: tuple[Any, ...]
) -> Vector:
    """Return J v [m/s]: the velocity of a point relative to the base at rates (n,)."""
    total, place = ZERO, point_position(kinematics, point)
    for i in _ancestors(tree, point.joint):
        screw = kinematics.screws[i]
        rate = _sum_of(rates, tree.joints[i].position)
        total = add(total, scale(rate, add(screw.linear, cross(screw.angular, place))))
    return total


def body_motions(
    tree: Tree, kinematics: Kinematics
) -> tuple[tuple[int, Body, Vector, Vector, Matrix, Vector], ...]:
    """Return (joint, body, place, velocity, inertia, angular velocity) of all bodies.

    Place [m] and velocity [m/s] are those of the centre; the inertia is in kg m².
    """
    motions = ()
    for i, (joint, link) in enumerate(zip(tree.joints, kinematics.links, strict=True)):
        for body in joint.bodies:
            r = combine(link.axes, body.centre)
            velocity = add(link.velocity, cross(link.angular_velocity, r))
            inertia = turned_inertia(link.axes, body.inertia)
            motions = (
                *motions,
                (i, body, add(link.origin, r), velocity, inertia, link.angular_velocity),
            )
    return motions


def tree_reaction(tree: Tree, inertia: Inertia, qdd: tuple[Any, ...], gravity: Any) -> Wrench:
    """Return the wrench of a base at rest on the tree, without other forces, at qdd (n,).

    qdd are the accelerations of the coordinates.
    """
    total = inertia.bias
    for momentum, joint in zip(inertia.momenta, tree.joints, strict=True):
        rate = _sum_of(qdd, joint.position)
        total = _total([total, Wrench(scale(rate, momentum.force), scale(rate, momentum.moment))])
    x, y, _ = scale(gravity, inertia.first_moment)
    mass = sum(body.mass for joint in tree.joints for body in joint.bodies)
    return Wrench(add(total.force, (0, 0, gravity * mass)), add(total.moment, (y, -x, 0)))


def to_tree_axes(turn: tuple[Any, Any], a: Vector) -> Vector:
    """Return a vector of the base's axes in the components' axes."""
    return to_turned_axes(a, *turn)


def to_base_axes(turn: tuple[Any, Any], a: Vector) -> Vector:
    """Return a vector of the components' axes in the base's."""
    s, c = turn
    return to_turned_axes(a, -s, c)


def _slews(tree: Tree) -> bool:
    first = tree.joints[0]
    return (
        first.axis == Z
        and not first.slides
        and not first.reverse
        and all(j.parent >= 0 for j in tree.joints[1:])
    )


def _sum_of(q: tuple[Any, ...], position: tuple[tuple[int, int], ...]) -> Any:
    return sum(factor * q[i] for i, factor in position)


def _move_link(
    joint: Joint, below: Link, q: tuple[Any, ...], v: tuple[Any, ...], turns_axes: bool
) -> Link:
    carried, axis = _carry(below, joint.offset), _axis(joint, below.axes)
    rate = _sum_of(v, joint.position)
    if joint.slides:
        return _slide(carried, axis, _sum_of(q, joint.position), rate)
    axes = IDENTITY if turns_axes else _turn_axes(joint, below.axes, _sum_of(q, joint.position))
    return _turn(carried, axes, axis, rate)


def _axis(joint: Joint, axes: Matrix) -> Vector:
    return scale(-1, axes[joint.axis]) if joint.reverse else axes[joint.axis]


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
    s, c = (0, 1) if isinstance(angle, int) else sincos(angle)
    s = -s if joint.reverse else s
    i, j = (joint.axis + 1) % 3, (joint.axis + 2) % 3
    first = add(scale(c, axes[i]), scale(s, axes[j]))
    second = add(scale(c, axes[j]), scale(-s, axes[i]))
    return replace_entry(replace_entry(axes, i, first), j, second)


def _turn(link: Link, axes: Matrix, axis: Vector, v: Any) -> Link:
    rate = scale(v, axis)
    w = add(link.angular_velocity, rate)
    alpha = add(link.angular_acceleration, cross(link.angular_velocity, rate))
    return link._replace(
        axes=axes,
        angular_velocity=w,
        angular_acceleration=alpha,
        gradient=acceleration_gradient(w, alpha),
    )


def _screw(tree: Tree, links: tuple[Link, ...], i: int) -> Screw:
    joint, link = tree.joints[i], links[i]
    below = links[joint.parent].axes if joint.parent >= 0 else IDENTITY
    axis = _axis(joint, below)
    return Screw(axis, ZERO) if joint.slides else Screw(cross(link.origin, axis), axis)


def _compose(tree: Tree, links: tuple[Link, ...]) -> tuple[Composite, ...]:
    composites = tuple(
        _link_composite(joint, link) for joint, link in zip(tree.joints, links, strict=True)
    )
    for i in reversed(range(len(links))):
        parent = tree.joints[i].parent
        if parent >= 0:
            whole = _join(composites[parent], composites[i])
            composites = (*composites[:parent], whole, *composites[parent + 1 :])
    return composites


def _link_composite(joint: Joint, link: Link) -> Composite:
    total = Composite(0, ZERO, (ZERO, ZERO, ZERO), Wrench(ZERO, ZERO))
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
    return Composite(
        body.mass, scale(body.mass, centre), inertia, Wrench(force, add(spin, cross(centre, force)))
    )


def _join(a: Composite, b: Composite) -> Composite:
    inertia = add_matrices(a.inertia, b.inertia)
    return Composite(
        a.mass + b.mass, add(a.first_moment, b.first_moment), inertia, _total([a.bias, b.bias])
    )


def _momentum(composite: Composite, screw: Screw) -> Wrench:
    """Return the momenta of a composite at a joint's unit velocity.

    They are momentum and angular momentum about the base's origin.
    """
    h = composite.first_moment
    linear_part = add(scale(composite.mass, screw.linear), cross(screw.angular, h))
    return Wrench(
        linear_part, add(multiply(composite.inertia, screw.angular), cross(h, screw.linear))
    )


def _matrix_of_joints(
    tree: Tree, screws: tuple[Screw, ...], momenta: tuple[Wrench, ...]
) -> linear.Matrix:
    """Return the lower triangle of the mass matrix of the joints."""
    rows = ()
    for i, momentum in enumerate(momenta):
        below = _ancestors(tree, i)
        rows = (
            *rows,
            tuple(_power(screws[k], momentum) if k in below else 0 for k in range(i + 1)),
        )
    return rows


def _matrix_of_coordinates(tree: Tree, matrix: linear.Matrix, n: int) -> linear.Matrix:
    """Return the lower triangle of AᵀMA.

    M is the mass matrix of the joints, A their positions by coordinates.
    """
    rows = ()
    for k in range(n):
        full = tuple(
            sum(f * _entry(matrix, j, i) for i, f in _uses(tree, k)) for j in range(len(matrix))
        )
        rows = (
            *rows,
            tuple(sum(f * full[j] for j, f in _uses(tree, other)) for other in range(k + 1)),
        )
    return rows


def _uses(tree: Tree, k: int) -> tuple[tuple[int, int], ...]:
    """Return (number of a joint, factor) of those that coordinate k moves."""
    return tuple(
        (i, f) for i, joint in enumerate(tree.joints) for number, f in joint.position if number == k
    )


def _entry(matrix: linear.Matrix, i: int, k: int) -> Any:
    return matrix[i][k] if k <= i else matrix[k][i]


def _ancestors(tree: Tree, i: int) -> tuple[int, ...]:
    """Return the numbers of the joints that move link i: those below, and joint i."""
    return () if i < 0 else (*_ancestors(tree, tree.joints[i].parent), i)


def _power(screw: Screw, wrench: Wrench) -> Any:
    return dot(screw.linear, wrench.force) + dot(screw.angular, wrench.moment)


def _sum_vectors(vectors: list[Vector]) -> Vector:
    total = ZERO
    for vector in vectors:
        total = add(total, vector)
    return total


def _total(wrenches: list[Wrench]) -> Wrench:
    return Wrench(
        _sum_vectors([w.force for w in wrenches]), _sum_vectors([w.moment for w in wrenches])
    )
