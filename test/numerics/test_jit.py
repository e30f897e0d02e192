"""What may be said of a compiled function; compiled code computes what plain Python does."""

import sys
from typing import Any, NamedTuple

import numpy as np
import pytest

import crane_sim
from crane_sim.numerics import jit
from crane_sim.numerics.states import (
    add,
    add_scaled,
    dimension,
    leaves,
    scale,
    squared_error_norm,
    weighted_sum,
)


@jit.entry_point
def compiled_algebra(x, y, h, ks):
    """Return everything that the state algebra computes."""
    row = (0.5, None, 0.25)
    total = weighted_sum(h, row, ks)
    return (
        add(x, y),
        scale(h, x),
        add_scaled(x, h, y),
        total,
        squared_error_norm(x, x, y, 1e-3, 1e-6),
        dimension(x),
        leaves(x),
    )


def test_state_algebra_is_the_same_in_python() -> None:
    """Compiled, the state algebra computes what it does in Python, to the bit, on nested tuples."""
    rng = np.random.default_rng(3)

    def state() -> tuple:
        a, b, c, d = map(float, rng.normal(size=4))
        return ((a, b), (c,), d)

    x, y, ks, h = state(), state(), (state(), state(), state()), 0.37
    assert compiled_algebra(x, y, h, ks) == compiled_algebra.py_func(x, y, h, ks)


class Part(NamedTuple):
    """A part of a model."""

    mass: float


class Pair(NamedTuple):
    """Another part with a mass."""

    mass: float
    size: float


@jit.generic
def mass_of(part, other):
    """Return the mass of a part, by default another one."""
    return other


@mass_of.register(Part, Pair)
def part_mass(part, other):
    """Return the mass of a part."""
    return part.mass


@jit.entry_point
def compiled_mass(part, other):
    """Compiled `mass_of`."""
    return mass_of(part, other)


def test_a_generic_function_chooses_by_type() -> None:
    """The first argument's type chooses the body, compiled or not; None takes the default."""
    assert compiled_mass(None, 3.0) == mass_of(None, 3.0) == 3.0
    assert compiled_mass(Part(2.0), 3.0) == mass_of(Part(2.0), 3.0) == 2.0
    assert compiled_mass(Pair(2.0, 1.0), 3.0) == mass_of(Pair(2.0, 1.0), 3.0) == 2.0
    assert (
        mass_of.has_implementation(Part)
        and mass_of.has_implementation(Pair)
        and not mass_of.has_implementation(int)
    )


@pytest.mark.parametrize("group", ["springs", "swing_friction", "payload_drag", "inputs"])
def test_a_group_set_to_none_is_one_left_out(group: str) -> None:
    """Leaving a group out and setting it to nothing give the same model, type for type."""
    left_out = crane_sim.load_scene("knuckle_setpoint")
    empty = crane_sim.load_scene("knuckle_setpoint", {group: {} if group == "springs" else None})
    assert empty.model == left_out.model and repr(empty.model) == repr(left_out.model)


@jit.routine
def changed_state(state: Any, given: Any) -> Any:
    """Return the state, a tuple that may end with an array, with an array's sum added in front."""
    return (state[0] + given.sum(), *state[1:])


@jit.entry_point
def change_repeatedly(state: Any, given: Any, times: int) -> Any:
    """Return the state after many changes."""
    for _ in range(times):
        state = changed_state(state, given)
    return state


def test_arrays_are_kept_alive() -> None:
    """An array that compiled code passes on, and returns, is neither freed nor kept."""
    given, held = np.ones(3), np.arange(4.0)
    references = sys.getrefcount(given)
    assert change_repeatedly((0.0, 1.0), given, 1000) == (3000.0, 1.0)
    total, returned = change_repeatedly((0.0, held), given, 1000)
    assert total == 3000.0 and np.array_equal(returned, [0.0, 1.0, 2.0, 3.0])
    del returned
    # an entry point keeps the arguments of its last call
    change_repeatedly((0.0, 1.0), np.zeros(3), 1)
    assert sys.getrefcount(given) == references
