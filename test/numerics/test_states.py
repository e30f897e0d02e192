"""Arithmetic on states, in Python and in compiled code."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.jit import entry_point


class Part(NamedTuple):
    """A record with fields of several types."""

    size: float
    number: int
    values: Any = None


@entry_point
def set_size(part):
    """Return the part with another size and a number higher by one."""
    return part._replace(size=2.0)._replace(number=part.number + 1)


@entry_point
def set_values(part, values):
    """Return the part with an array of values, replaced several times."""
    part = part._replace(values=values)
    for _ in range(3):
        part = part._replace(values=part.values.copy())
    return part


def test_fields_are_replaced_by_name() -> None:
    """`_replace` gives a field the value, also one of another type than before; others stay."""
    assert set_size(Part(1.5, 3)) == Part(2.0, 4)
    values = np.array([1.0, 2.0])
    part = set_values(Part(1.5, 3), values)
    assert part[:2] == (1.5, 3) and part.values is not values and part.values.tolist() == [1.0, 2.0]
