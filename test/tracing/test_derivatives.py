"""Derivatives by forward mode, compiled and in Python, against differences in 60 digits."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from exact_derivatives import exact_derivative

from crane_sim.files.errors import SceneError
from crane_sim.numerics.derivatives import DIRECTIONS, directional_derivatives
from crane_sim.numerics.elementary import fma, sincos
from crane_sim.numerics.jit import entry_point, generic, local_array, routine, simd_range

TABLE = np.array([0.0, 1.0, 4.0, 9.0])


class Spring(NamedTuple):
    """A parameter with a part that may be missing."""

    stiffness: float
    damping: float | None = None


@generic
def force_of(part, x):
    """Return the force of a part."""
    return 0.0


@force_of.register(Spring)
def _(part, x):
    return part.stiffness * x - (0.0 if part.damping is None else part.damping * x * x)


@routine
def fill_squares(xs, out):
    """Write squares into an array of the caller's."""
    for i in range(len(xs)):
        out[i] = xs[i] * xs[i]


@routine
def new_row(n):
    """Return an array that the caller fills."""
    return np.empty(n)


@routine
def first_above(xs, limit):
    """Return (the first element above a limit, its index), from inside a loop."""
    for i in range(len(xs)):
        if xs[i] > limit:
            return 2.0 * xs[i], i
    return xs[0], -1


def arithmetic(x, y, xs, spring):
    """Return sums, products, quotients and powers."""
    return (
        x + y,
        x - y,
        x * y,
        x / y,
        -x,
        x**2,
        x**1.5,
        x**y,
        2.0**y,
        fma(x, y, xs[0]),
        x % y,
        x // y,
    )


def functions(x, y, xs, spring):
    """Return functions of the processor and of the C library."""
    plain = (
        math.sqrt(x),
        math.exp(x),
        math.log(x),
        math.sin(x),
        math.cos(x),
        math.tan(x),
        math.tanh(x),
    )
    inverse = (
        math.asin(x / 3.0),
        math.acos(x / 3.0),
        math.atan(x),
        math.atan2(-y, x),
        math.atan2(x, -y),
    )
    return (
        plain,
        inverse,
        sincos(x * y),
        math.sinh(x),
        math.cosh(x),
        math.hypot(x, y),
        math.copysign(x, -y),
    )


def choices(x, y, xs, spring):
    """Return extremes, absolute values and what conditions choose."""
    side = x * x if x > y else y
    nested = (x if y > 0.0 else -y) if x > 0.0 and not y > 5.0 else 1.0
    return abs(x), abs(-y), min(x, y, xs[1]), max(x, y), side, nested, float(np.sign(x)) * x


def integers(x, y, xs, spring):
    """Return reals that integers and conditions decide, and these."""
    k = int(x + 0.5) + 1
    words = np.uint64(k) >> np.uint64(1)
    return (
        k * x,
        round(y) * y,
        math.floor(x) + y,
        k % 2 == 0,
        float(words) * x,
        TABLE[k] * x + TABLE[1],
    )


def loops(x, y, xs, spring):
    """Return results of loops: of a length that depends on numbers, over arrays, with jumps."""
    root, change = x + 1.0, 1.0
    while abs(change) > 1e-9 * root:  # Newton's method for the cube root
        change = (root * root * root - x) / (3.0 * root * root)
        root -= change
    total, late = 0.0, 0.0
    for i in range(len(xs)):
        if i == 1:
            continue
        late = xs[i] * y
        total += late * total + x
        if total > 50.0:
            break
    return root, total, late


def arrays(x, y, xs, spring):
    """Return what went through arrays: views, other element types, own arrays, callees' arrays."""
    out, matrix, counts, row = (
        new_row(len(xs)),
        np.zeros((2, len(xs))),
        np.arange(3),
        local_array((4,)),
    )
    fill_squares(xs, out)
    matrix[1] = out[::-1] * x
    part = matrix[:, 1:]
    part[0, 0] = y
    view = matrix[1] if x > y else matrix[0]
    view[0] += counts[2] * x
    for i in simd_range(4):
        row[i] = x * i
    return out, matrix.T, part, matrix.copy(), row[1] + row[3], out.sum(), out.max(), counts


def calls(x, y, xs, spring):
    """Return what other functions return: routines, generics, trees with None."""
    return (
        first_above(xs, x),
        first_above(xs, y),
        force_of(spring, x),
        force_of(None, x),
        spring._replace(stiffness=y),
    )


PROGRAMS = [arithmetic, functions, choices, integers, loops, arrays, calls]
XS = np.array([0.4, 1.1, 2.3, -0.7, 3.1])


def reals_of(tree: Any) -> list[np.ndarray]:
    """Return derivatives by real, of arrays in the order of elements, without integers."""
    if isinstance(tree, tuple):
        return [row for part in tree for row in reals_of(part)]
    if isinstance(tree, np.ndarray) and tree.shape[-1:] == (DIRECTIONS,):
        return list(tree.reshape(-1, DIRECTIONS))
    return []


def bytes_of(tree: Any) -> bytes:
    """Return the numbers of a value as floats, one behind the other."""
    return (
        b"".join(map(bytes_of, tree))
        if isinstance(tree, tuple)
        else np.array(tree, float).tobytes()
    )


def random_directions(seed: int) -> Any:
    """Return directions of x, y, xs and of the spring's damping."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(3 + len(XS), DIRECTIONS))
    return rows[0], rows[1], rows[3:].copy(), (None, rows[2])


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.__name__)
def test_derivatives_of_every_construct(program: Any) -> None:
    """Values have the function's bits, derivatives are those of differences in 60 digits.

    Tolerance: some dozen roundings; the loop of Newton's method ends at 1e-9, whose square is what
    is missing there.
    """
    compiled = entry_point(
        lambda arguments, directions: directional_derivatives(program, arguments, directions)
    )
    for seed, (x, y) in enumerate(((1.6, 0.7), (0.6, 1.9))):
        arguments, directions = (x, y, XS, Spring(3.0, 0.5)), random_directions(seed)
        value, derivative = compiled(arguments, directions)
        assert bytes_of(value) == bytes_of(program(*arguments))
        for found in (derivative, directional_derivatives(program, arguments, directions)[1]):
            exact = exact_derivative(program, arguments, directions)
            got = np.array([row[0] for row in reals_of(found)])
            scale = 1.0 + np.abs(exact)
            assert np.max(np.abs(got - exact) / scale) < 1e-13


def kinks(x):
    """Return functions with kinks, or infinite slopes, at 0."""
    return (
        math.sqrt(x * x) * x,
        abs(x) * x,
        abs(x),
        math.hypot(x, 0.0 * x),
        math.atan2(0.0 * x, x),
        x**2.0,
        min(x, 2.0),
    )


def test_derivatives_at_kinks_are_finite() -> None:
    """At 0 a length, an absolute value and an angle have slope 0, so |v| v has 0 there."""
    _, found = directional_derivatives(kinks, (0.0,), (np.ones(DIRECTIONS),))
    assert [row[0] for row in reals_of(found)] == [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def swap(xs, factor):
    """Return a linear function of xs."""
    out = np.empty_like(xs)
    out[0], out[1] = factor * xs[1], -xs[0]
    return out, factor


def test_what_does_not_move_has_no_derivative() -> None:
    """Along directions of one argument only its derivatives are computed; others are zero."""
    xs, seeds = np.array([2.0, 3.0]), np.zeros((2, DIRECTIONS))
    seeds[0, 0] = seeds[1, 1] = 1.0
    _, (rows, of_factor) = directional_derivatives(swap, (xs, 5.0), (seeds, None))
    assert rows[:, :2].tolist() == [[0.0, 5.0], [-1.0, 0.0]]
    assert not rows[:, 2:].any() and not of_factor.any()


def store(xs, out):
    """Write into an argument."""
    out[0] = xs[0]
    return xs[0]


@entry_point
def store_derivative(xs, out, seeds):
    """Differentiate what stores in an argument without directions."""
    return directional_derivatives(store, (xs, out), (seeds, None))


def test_a_store_where_nothing_moves_is_refused() -> None:
    """A derivative that would be lost is an error, and no zero."""
    with pytest.raises(SceneError, match="without directions"):
        store_derivative(np.ones(1), np.ones(1), np.ones((1, DIRECTIONS)))


def root_by_power(x):
    """Return the square root as a power."""
    return x**0.5


def test_an_infinite_slope_of_a_power_counts_as_zero() -> None:
    """As that of the square root does, along directions that move and along those that do not."""
    directions = np.zeros(DIRECTIONS)
    directions[0] = 1.0
    for x, slope in ((0.0, 0.0), (4.0, 0.25)):
        value, derivative = directional_derivatives(root_by_power, (x,), (directions,))
        assert value == x**0.5 and derivative.tolist() == [slope, *[0.0] * (DIRECTIONS - 1)]


class Law(NamedTuple):
    """A parameter with a method."""

    gain: float

    def force(self, x, exponent=2.0):
        """Return gain x^exponent."""
        return self.gain * x**exponent


def quadratic(x, gain=3.0, *, shift=1.0):
    """Return a function with defaults of both kinds."""
    return gain * x * x + shift


FIRST = np.eye(DIRECTIONS)[0]


@pytest.mark.parametrize(
    ("f", "value"), [(quadratic, 13.0), (Law(3.0).force, 12.0)], ids=["defaults", "method"]
)
def test_functions_with_defaults_and_methods_have_derivatives(f: Any, value: float) -> None:
    """Defaults and a method's object do not move: 3 x² has slope 12 at 2, compiled or not."""
    compiled = entry_point(lambda x, direction: directional_derivatives(f, (x,), (direction,)))
    for found in (compiled(2.0, FIRST), directional_derivatives(f, (2.0,), (FIRST,))):
        assert found[0] == value and found[1].tolist() == [12.0, *[0.0] * (DIRECTIONS - 1)]


def cube(x):
    """Return x³."""
    return x * x * x


def slope_of_cube(x, direction):
    """Return the derivative of x³ along a direction."""
    return directional_derivatives(cube, (x,), (direction,))[1][0]


def first_product(xs):
    """Return a product of elements."""
    return xs[0] * xs[1]


def count_times(n, x):
    """Return a product with an integer."""
    return n * x


ROWS = np.eye(3, DIRECTIONS)


@pytest.mark.parametrize(
    ("f", "arguments", "directions", "message"),
    [
        (first_product, (np.arange(6.0)[::2],), (ROWS,), "elements may be apart"),
        (first_product, (np.arange(3.0)[::-1],), (ROWS,), "elements may be apart"),
        (first_product, (np.arange(3.0),), (np.eye(6, DIRECTIONS)[::2],), "elements may be apart"),
        (first_product, (np.arange(3.0),), (np.asfortranarray(ROWS),), "elements may be apart"),
        (slope_of_cube, (2.0, FIRST), (FIRST, None), "derivatives? of (a )?derivative"),
        (
            slope_of_cube,
            (2.0, FIRST),
            (None, np.eye(DIRECTIONS)),
            "derivatives? of (a )?derivative",
        ),
        (count_times, (2, 1.5), (FIRST, FIRST), "a direction of an integer"),
    ],
)
def test_derivatives_that_would_be_wrong_are_refused(
    f: Any, arguments: Any, directions: Any, message: str
) -> None:
    """What is not computed is one line, and no number."""
    with pytest.raises(SceneError, match=message):
        directional_derivatives(f, arguments, directions)


SQUARE, TRIPLE = (lambda x: x * x), (lambda x: 3.0 * x)


def times(factor):
    """Return a function with another default each time."""

    def scale(x, factor=factor):
        return factor * x

    return scale


def test_functions_of_one_name_are_not_mistaken_for_each_other() -> None:
    """Lambdas of a module, and what a function makes, have code of their own, on disk as well."""
    functions = [SQUARE, TRIPLE, times(2.0), times(7.0)]
    values = [directional_derivatives(f, (5.0,), (FIRST,))[0] for f in functions]
    assert values == [25.0, 15.0, 10.0, 35.0]
