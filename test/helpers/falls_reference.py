"""A load on falls below a bridge or a tower crane, as point masses.

The coordinates are the joints of the support, length, centre and angles.
"""

from typing import Any

from point_masses import body_points, on_base, plus
from test_falls import SUPPORTS as ALL
from test_falls import moved, places_of
from test_falls import strain_energy as strain_energy_of
from test_suspended import INERTIA, SEA, turn

SUPPORTS = {name: ALL[name] for name in ("bridge", "tower")}


def places(name: str, sea: bool) -> Any:
    """Return the places of all points as a function of (t, q)."""
    shape = body_points(10.0, INERTIA)

    def at(t: Any, q: Any) -> Any:
        points = [(m, plus(tuple(q[3:6]), turn(q[6:], r))) for m, r in shape] + [
            *places_of(name, q)[0]
        ]
        return [(m, on_base(SEA, t, r)) for m, r in points] if sea else points

    return at


def strain_energy(name: str) -> Any:
    """Return the energy of the falls as a function of (t, q)."""
    return strain_energy_of(
        lambda _, q: places_of(name, q)[1:], lambda q: q[2], lambda q: (tuple(q[3:6]), q[6:])
    )


def mapped(q: Any, v: Any, a: Any) -> Any:
    """Return the crane's joint coordinates with their first and second derivatives."""
    return moved(q, v, a, 6)
