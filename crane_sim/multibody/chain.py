"""A chain of rigid links with lumped masses: tensions and accelerations of the links' directions.

n_k are unit vectors down the links. With absolute accelerations a of the nodes (gravity upwards in them) and absolute
rates n_k' the links keep their lengths l_k where n_k · (a_k - a_k-1) = l_k'' - l_k |n_k'|². Node k has the mass m_k and
the forces T_k+1 n_k+1 - T_k n_k, the upper end of the first link the mobility W of the support's tip along it, so

    (W + 1/m_1 + H) T_1 - n_1·n_2 T_2 / m_1 = n_1 · (b_1 - b_0) + l_1 |n_1'|² - h,     l_1'' = h + H T_1,
    -n_k-1·n_k T_k-1 / m_k-1 + (1/m_k-1 + 1/m_k) T_k - n_k·n_k+1 T_k+1 / m_k = n_k · (b_k - b_k-1) + l_k |n_k'|²,

b the accelerations without tensions: positive definite and tridiagonal, with a condition that a heavy load does not
spoil, and without an angle that could be singular.
"""

from typing import Any, NamedTuple

from crane_sim.multibody.vectors import Vector, add, dot, scale, subtract


class Link(NamedTuple):
    """A link, and the node at its lower end."""

    unit: Vector  # down the link
    rate: Vector  # 1/s, absolute, across it
    length: Any  # m
    inverse_mass: Any  # 1/kg, of the node below: its mobility along the link


class Winch(NamedTuple):
    """How the first length answers to the tension: l_1'' = acceleration + inverse_mass T_1."""

    rate: Any = 0.0  # m/s, of the length
    acceleration: Any = 0.0  # m/s², h
    inverse_mass: Any = 0.0  # 1/kg, H
    tension: Any = None  # N, T_1 of a winch without inertia, whose effort it balances; None: it follows


class Tensions(NamedTuple):
    """What the links carry, and how the first length changes."""

    values: tuple[Any, ...]  # N, from the top
    length_acceleration: Any  # m/s²


def solve_tensions(links: tuple[Link, ...], winch: Winch, tip_mobility: Any, free: tuple[Vector, ...]) -> Tensions:
    """Return the tensions of N links.

    Args:
        links: from the top.
        winch: of the first link.
        tip_mobility: W [1/kg].
        free: accelerations b of the tip and all nodes without tensions, (N + 1) vectors [m/s²].
    """
    needed = [_needed_acceleration(link, subtract(free[k + 1], free[k])) for k, link in enumerate(links)]
    diagonal = [tip_mobility + links[0].inverse_mass]
    diagonal += [above.inverse_mass + link.inverse_mass for above, link in zip(links, links[1:], strict=False)]
    coupling = [-dot(a.unit, b.unit) * a.inverse_mass for a, b in zip(links, links[1:], strict=False)]
    if winch.tension is not None:
        return _solve_below(winch.tension, diagonal, coupling, needed)
    diagonal[0] = diagonal[0] + winch.inverse_mass
    needed[0] = needed[0] - winch.acceleration
    values = _solve_tridiagonal(diagonal, coupling, needed)
    return Tensions(values, winch.acceleration + winch.inverse_mass * values[0])


def _solve_below(tension: Any, diagonal: list[Any], coupling: list[Any], needed: list[Any]) -> Tensions:
    """Return the tensions below a first one that is given, whose equation gives the length's acceleration."""
    if len(diagonal) == 1:
        return Tensions((tension,), needed[0] - diagonal[0] * tension)
    second = needed[1] - coupling[0] * tension
    below = _solve_tridiagonal(diagonal[1:], coupling[1:], [second, *needed[2:]])
    return Tensions((tension, *below), needed[0] - diagonal[0] * tension - coupling[0] * below[0])


def _needed_acceleration(link: Link, relative: Vector) -> Any:
    return link.length * dot(link.rate, link.rate) + dot(link.unit, relative)


def _solve_tridiagonal(diagonal: list[Any], coupling: list[Any], right: list[Any]) -> tuple[Any, ...]:
    """Return the solution of a symmetric tridiagonal system: elimination downwards, substitution upwards."""
    ratios: list[Any] = []
    x: list[Any] = []
    for k, (pivot, entry) in enumerate(zip(diagonal, right, strict=True)):
        upper = coupling[k - 1] if k > 0 else 0.0
        inverse = 1.0 / (pivot - upper * ratios[k - 1] if k > 0 else pivot)
        x.append((entry - upper * x[k - 1] if k > 0 else entry) * inverse)
        ratios.append(coupling[k] * inverse if k + 1 < len(diagonal) else 0.0)
    for k in reversed(range(len(x) - 1)):
        x[k] = x[k] - ratios[k] * x[k + 1]
    return tuple(x)


def direction_accelerations(
    links: tuple[Link, ...], winch: Winch, tensions: tuple[Any, ...], ends: tuple[Vector, ...]
) -> tuple[Vector, ...]:
    """Return the absolute second derivatives of the links' directions (N) [1/s²].

    The pulls of neighbouring links are projected across a link one by one, which avoids cancellation below a heavy
    load.

    Args:
        links, winch: as of `solve_tensions`.
        tensions: (N,) [N].
        ends: accelerations of tip and nodes (N + 1) [m/s²] without the pulls of links on nodes; of the tip with the
            pull on it, of the load with what the pull does across its link.
    """
    accelerations = []
    for k, link in enumerate(links):
        total = across(link.unit, subtract(ends[k + 1], ends[k]))
        if k > 0:
            total = add(total, _pull(link, links[k - 1], links[k - 1].inverse_mass * tensions[k - 1]))
        if k + 1 < len(links):
            total = add(total, _pull(link, links[k + 1], link.inverse_mass * tensions[k + 1]))
        rate = winch.rate if k == 0 else 0.0
        inverse = 1.0 / link.length
        turning = add(scale(dot(link.rate, link.rate), link.unit), scale(2.0 * rate * inverse, link.rate))
        accelerations.append(subtract(scale(inverse, total), turning))
    return tuple(accelerations)


def across(unit: Vector, a: Vector) -> Vector:
    """Return the part of a vector across a unit vector."""
    return subtract(a, scale(dot(unit, a), unit))


def _pull(link: Link, neighbour: Link, acceleration: Any) -> Vector:
    """Return the part across a link of an acceleration along its neighbour: exact where both nearly agree."""
    return scale(acceleration, across(link.unit, subtract(neighbour.unit, link.unit)))
