"""Every traced construct of Python computes, compiled, what it does in Python, to the bit."""

import itertools
import math
from collections.abc import Callable
from math import copysign, inf, nan
from typing import Any, NamedTuple

import numpy as np
from random_programs import bits, compiled, run

from crane_sim.numerics.elementary import fma, sincos
from crane_sim.numerics.jit import generic, routine
from crane_sim.tracing.arithmetic import number_kind
from crane_sim.tracing.calls import Calls
from crane_sim.tracing.frame import Frame
from crane_sim.tracing.graph import Graph
from crane_sim.tracing.interpreter import run as run_statements
from crane_sim.tracing.scopes import source_of

REALS = (0.0, -0.0, 1.0, -2.5, 3.75, 1e300, inf, -inf, nan)
INTEGERS = (-7, -2, -1, 0, 1, 2, 3, 5)
RECORD = np.dtype([("x", "f8"), ("n", "i8"), ("on", "?")])


def check(function: Callable[..., Any], *choices: tuple[Any, ...]) -> None:
    """Assert that a compiled function returns and writes the bits of Python for all arguments.

    These are all combinations of the choices.

    Where Python raises an error there is nothing to compare: compiled code raises none.
    """
    code, compared = compiled(function), 0
    for given in itertools.product(*choices):
        try:
            with np.errstate(all="ignore"):
                expected = run(function, list(given))
        except (ArithmeticError, ValueError):
            continue
        assert run(code, list(given)) == expected, given
        compared += 1
    assert compared


# branches and returns


def _early_returns(x: float, y: float) -> float:
    if x < 0.0:
        if y < 0.0:
            return -1.0
        x = -x
    elif x == 0.0:
        return y
    else:
        if y > x:
            return y - x
        elif y == x:
            y = 2.0 * y
    return x + y


def _many_partial_returns(x: float, n: int) -> float:
    for k in (
        1.0,
        2.0,
        3.0,
        4.0,
        5.0,
        6.0,
        7.0,
        8.0,
        9.0,
        10.0,
        11.0,
        12.0,
        13.0,
        14.0,
        15.0,
        16.0,
        17.0,
        18.0,
    ):
        if x > k:
            if n == 3:
                return k
            x -= 0.5 * k
    return x


def _results_of_two_kinds(x: float, n: int) -> Any:
    for i in range(n):
        if x < i:
            return i
    if x > 3.0:
        return x + 0.5
    return x * 2.0


def _nothing_or_a_number(x: float, out: Any) -> None:
    if x > 0.0:
        out[0] = x
        return
    out[1] = x


def test_early_returns() -> None:
    """Returns in branches of branches end a function; the others go on behind them."""
    check(_early_returns, REALS, REALS)
    check(_many_partial_returns, (0.0, 2.5, 7.0, 100.0), (3, 4))
    check(_nothing_or_a_number, (-1.0, 0.0, 2.0), (np.zeros(2),))


def test_code_is_as_long_as_its_source() -> None:
    """What follows conditional returns is traced once: each adds the same amount of code."""

    def length(count: int) -> int:
        block = trace_of(many_partial_returns_of(count), 1.0, 3)
        return sum(1 for _ in instructions_of(block))

    first, second, third = (length(count) for count in (4, 8, 12))
    assert third - second == second - first


def many_partial_returns_of(count: int) -> Any:
    """Return a function with `count` conditional returns on one of two sides."""
    values = tuple(float(k) for k in range(count))

    def function(x: float, n: int) -> float:
        for k in values:
            if x > k:
                if n == 3:
                    return k
                x -= 0.5 * k
        return x

    return function


def trace_of(function: Any, *arguments: Any) -> Any:
    """Return the block of a function, traced for such arguments."""
    graph, source = Graph(), source_of(function)

    def values(*symbols: Any) -> tuple[Any, ...]:
        frame = Frame(graph, Calls(), source, source.bind(list(symbols), {}), {})
        return (run_statements(frame, source.body).value,)

    return graph.trace_block(values, tuple(number_kind(x) for x in arguments))


def instructions_of(block: Any) -> Any:
    """Yield all instructions of a block."""
    for instruction in block.instructions:
        yield instruction
        if instruction.operation in ("branch", "loop"):
            for inner in instruction.literal:
                yield from instructions_of(inner)


def _conditional_expressions(x: float, y: float, n: int) -> Any:
    z = x if x > y else (y if n else n)
    return z, (1.0 if x == y else n) * 2.0, "a" if x is None else x


def test_conditional_expressions() -> None:
    """Only the side that is taken is evaluated, and its number becomes what both have in common."""
    check(_conditional_expressions, REALS, (0.5, -1.0), (-1, 2))


def _short_circuits(a: Any, i: int, x: float) -> Any:
    inside = 0 <= i < len(a) and a[i] > x
    outside = i < 0 or i >= len(a) or a[i] < x
    count = 0
    while i < len(a) and i >= 0 and a[i] > x:
        count += 1
        i += 1
    return inside, outside, count, (x and 2.0), (i or 7), not (x and i)


def poisoned(a: Any, i: int) -> Any:
    """Index far outside of the array where the left side does not hold."""
    far = 1 << 40
    if (i > 3 and a[i * far] > 0.0) or (i < -3 and a[far] > 0.0):
        return 1
    if not (i <= 3 or a[i * far] > 0.0):
        return 2
    return 3 if i < 5 < a[0] < a[(i - i) * 0] or i > 5 > a[far] else 4


def test_short_circuits() -> None:
    """`and`, `or` and chains evaluate their right side only where it decides.

    An index outside is never read.
    """
    check(_short_circuits, (np.array([3.0, -1.0, 2.0]),), (-1, 0, 1, 2, 3, 9), (0.0, -2.0, 5.0))
    check(poisoned, (np.array([3.0, 1.0]),), (-2, 0, 1, 3))


def _chains(x: float, y: float, i: int) -> Any:
    return x < y < i, x <= i == i >= y, x != y != x, (i in (1, 2, x)), (i not in (0, 3))


def test_chained_comparisons() -> None:
    """Each number of a chain is compared with its neighbours; NaN with nothing."""
    check(_chains, REALS, REALS, (-1, 0, 1))


# loops


def _ranges(first: int, last: int, step: int) -> Any:
    total, count, k = 0, 0, -99
    for k in range(first, last, 2):
        total += k * k
    for k in range(last, first, -3):
        total = 2 * total + k
        count += 1
    for i in range(first, last, step):
        total += 5 * i
        k = i
    for i in range(100, 0, -7):
        total -= i
    for _ in range(first):
        count += 1
    return total, count, k


def test_ranges() -> None:
    """Bounds and steps are symbols of either sign; the variable keeps its last value."""
    check(_ranges, (-3, 0, 5), (-4, 0, 6, 7), (-2, -1, 1, 3))


def _leaves_loops(a: Any, limit: float, n: int) -> Any:
    total, last = 0.0, -1
    for i in range(n):
        if a[i % 4] > limit:
            continue
        if i == 5:
            break
        last = i
        total += a[i % 4]
    while True:
        total += 1.0
        if total > limit:
            if n > 3:
                return total, last
            break
        if total == 2.0:
            continue
        total = 1.5 * abs(total)
    for x in a:
        for y in (1.0, limit, 3.0):
            if x * y > 5.0:
                return x * y, last
            if y > 2.0:
                break
            total += y
        else_value = total
        if else_value > 100.0:
            break
    return total, last


def _nested_returns(n: int, x: float) -> Any:
    i = 0
    while i < n:
        j = 0
        while j < n:
            if i * j == 6:
                return i, x + j
            if j > i:
                break
            j += 1
        i += 1
        for k in range(3):
            if k == i:
                continue
            x += k
    return -1, x


def _breaks_of_known_loops(n: int, x: float) -> Any:
    total = 0.0
    for value in (1.0, 2.0, 3.0, 4.0):
        if value == n:
            break
        if value == x:
            continue
        total += value
    for value in (5, 6):
        total += value
        if value > n:
            return total, n
    return total, -n


def _endless(n: int) -> int:
    while True:
        n += 3
        if n % 7 == 2:
            return n


def test_loops_are_left() -> None:
    """`break`, `continue` and `return` in all kinds of loops and in loops of loops."""
    check(_leaves_loops, (np.array([1.0, 2.0, 0.5, -4.0]),), (-5.0, 0.75, 2.0, 30.0), (0, 2, 9))
    check(_nested_returns, (0, 2, 5, 9), (0.25,))
    check(_breaks_of_known_loops, (1, 3, 4, 5, 9), (2.0, 7.0))
    check(_endless, INTEGERS)


def _first_assigned_in_a_loop(n: int, x: float) -> Any:
    for i in range(n):
        y, z = x * i, (i, x)
    return y + z[0] + i


def _promoted(n: int, x: float) -> Any:
    total, most, flag = 0, 0, False
    for i in range(n):
        total += x
        if i > most:
            most = i + x
        flag = i
    return total, most, flag


def test_variables_of_loops() -> None:
    """A loop's variables can be read behind it; an integer that becomes a real is one before."""
    check(_first_assigned_in_a_loop, (1, 2, 5), (0.5, -2.0))
    code = compiled(_promoted)
    for n, x in itertools.product((0, 1, 4), (0.5, -3.0)):
        assert code(n, x) == _promoted(n, x)  # an integer that is a real now is the same number


def _loops_over(a: Any, m: Any, points: Any) -> Any:
    total = 0.0
    for x in a:
        total = 0.5 * total + x
    for row in m:
        for x in row:
            total = total * 0.5 - x
    for i, (x, y) in enumerate(points):
        total += i * x - y
    for x, (y, z) in zip((1.0, 2.0), points, strict=True):
        total += x * y * z
    return (
        total,
        sum(x * y for x, y in points),
        [x for x in range(4) if x % 2],
        max(x for x, _ in points),
    )


def test_loops_over_arrays_and_tuples() -> None:
    """Arrays, rows of arrays, tuples of tuples, `enumerate`, `zip` and comprehensions."""
    points = ((1.0, 2.0), (-3.0, 0.5))
    code = compiled(_loops_over)
    a, m = np.array([1.0, -2.0, 4.0]), np.arange(6.0).reshape(3, 2)
    for array in (a, a[::2], a[::-1]):
        for matrix in (m, m.T, m[1:]):
            assert bits(code(array, matrix, points)) == bits(_loops_over(array, matrix, points))


# numbers


def _real_arithmetic(x: float, y: float) -> Any:
    return (
        x + y,
        x - y,
        x * y,
        -x,
        +x,
        x // y,
        x % y,
        x / y,
        abs(x),
        min(x, y),
        max(y, x),
        copysign(x, y),
    )


def _integer_arithmetic(i: int, j: int) -> Any:
    return (
        i + j,
        i - j,
        i * j,
        -i,
        ~i,
        i & j,
        i | j,
        i ^ j,
        i << 2,
        i >> 1,
        abs(i),
        min(i, j),
        max(i, j),
        i / j,
    )


def _integer_division(i: int, j: int) -> Any:
    return i // j, i % j, i // 3, i % -3, i // -1, i % 1


def _mixed_arithmetic(i: int, x: float, f: bool) -> Any:
    return (
        i + x,
        x - i,
        i * x,
        i / 4,
        f + f,
        f * i,
        f + x,
        i // x,
        i % x,
        f and i < x,
        -f,
        f | (i > 0),
        x**2 * i,
    )


def _functions_of_numbers(x: float, i: int, f: bool) -> Any:
    return (
        round(x),
        int(x),
        float(i),
        int(f),
        bool(x),
        bool(i),
        np.sign(x),
        math.floor(x),
        math.ceil(x),
        abs(f),
        round(i),
    )


def _powers(x: float, i: int) -> Any:
    return x**1, i**2, i**3, i**0, abs(x) ** 0.5, x**-1.0, i**-1, 2.0**i


def test_reals() -> None:
    """Arithmetic of reals with signed zeros, infinities and NaNs; `//` and `%` round down."""
    check(_real_arithmetic, REALS, (*REALS, 0.7, -0.7))


def test_integers() -> None:
    """Arithmetic and bits of integers of either sign; division rounds down, by 0 it is 0."""
    check(_integer_arithmetic, INTEGERS, INTEGERS)
    check(_integer_division, INTEGERS, INTEGERS)
    code = compiled(_integer_division)
    assert code(5, 0)[:2] == (0, 0)
    assert code(-(2**63), -1)[1] == 0  # processors trap here


def test_numbers_of_several_kinds() -> None:
    """Integers and conditions become what they meet."""
    check(_mixed_arithmetic, INTEGERS, (0.5, -2.0, inf), (False, True))


def test_functions_of_numbers() -> None:
    """Rounding half to even, conversions, signs."""
    check(_functions_of_numbers, (0.5, 1.5, -2.5, 0.0, -0.0, 3.2, -3.7), (-2, 0, 3), (False, True))
    check(lambda x: (np.sign(x), math.isnan(x), math.isfinite(x)), REALS)


def test_powers() -> None:
    """A known whole exponent is products, any other one the C library's."""
    check(_powers, (0.5, -2.0, 3.0), (-3, 1, 2))


def _words(w: Any, v: Any) -> Any:
    w ^= w >> np.uint64(12)
    w ^= w << np.uint64(25)
    low = w & np.uint64(255)
    return (
        w,
        w * v,
        w // v,
        w % v,
        w < v,
        max(w, v),
        float(w),
        w > np.uint64(7),
        int(low),
        w + v,
        np.uint64(3) * low,
    )


def test_words() -> None:
    """Words of 64 bits wrap around, shift in zeros, and compare and divide without a sign."""
    numbers = tuple(np.uint64(x) for x in (1, 7, 2**63, 2**64 - 1))
    check(_words, numbers, numbers)


# arrays


def _elements(a: Any, m: Any, i: int, j: int) -> Any:
    a[i] += 1.5
    a[-1] -= a[i]
    m[i, j] = a[0] * 2
    m[i][j] *= 0.5
    m[-1, 0] += m[0][-1]
    return a[i], m[i, j], m[j - 1][0], len(a), m.shape, m.size, a.ndim


def test_elements() -> None:
    """Elements of arrays of one and two indices, contiguous or not; -1 counts from the end."""
    wide = np.arange(24.0).reshape(4, 6)
    arrays = (np.arange(4.0), np.arange(8.0)[::2], np.arange(4.0)[::-1], wide[:, 1], np.arange(5.0))
    matrices = (
        wide[:, :3].copy(),
        wide[:, 1:4],
        wide[::-1, ::2],
        wide.T[:4],
        np.asfortranarray(wide[:, :3]),
    )
    code = compiled(_elements)
    for a, m, i, j in itertools.product(arrays, matrices, (-4, -1, 0, 2), (-2, 0, 1)):
        (a1, m1), (a2, m2) = [(strided_copy(a), strided_copy(m)) for _ in range(2)]
        assert bits(code(a1, m1, i, j)) == bits(_elements(a2, m2, i, j))
        assert bits([a1, m1]) == bits([a2, m2])


def strided_copy(array: np.ndarray) -> np.ndarray:
    """Return a copy with the strides of an array."""
    base = array if array.base is None else array.base
    copy = base.copy("K")
    offset = array.__array_interface__["data"][0] - base.__array_interface__["data"][0]
    return (
        np.ndarray(array.shape, array.dtype, copy, offset, array.strides)
        if offset >= 0
        else array.copy()
    )


def _slices(a: Any, i: int, j: int) -> Any:
    middle, tail, back = a[i:j], a[i:], a[::-1]
    total = 0.0
    for x in middle:
        total = 2.0 * total + x
    for x in tail[1:]:
        total = 0.5 * total + x
    return (
        total,
        len(middle),
        len(tail),
        back[0],
        back[len(a) - 1],
        a[1:3][0],
        len(a[::2]),
        len(a[j:i:-1]),
        len(a[:i]),
    )


def _writes_through_views(a: Any, m: Any, i: int) -> Any:
    view = a[i:]
    view[0] = 7.0
    m[:, 1] = a[:3]
    m[i % 3] = 2.5
    m[0, :] = (1.0, i)
    row = m[1]
    row[0] = view[-1]
    a[:2] = a[2:4]
    return row[0] + m[1, 0]


def test_slices_and_views() -> None:
    """Slices are cut to the array, and share its memory."""
    check(
        _slices,
        (np.arange(1.0, 7.0), np.arange(1.0, 13.0)[::2]),
        (-9, -4, -1, 0, 2, 5, 6, 9),
        (-8, -1, 0, 3, 6, 8),
    )
    check(_writes_through_views, (np.arange(5.0),), (np.zeros((3, 2)),), (-3, 0, 1, 2))


def _records(table: Any, i: int) -> Any:
    table[i].x += 0.5
    table.n[i] = 3 * table[i].n - 1
    row = table[i]
    row.on = row.x > 1.0
    table[-1].x = table.x[0]
    total = 0
    for one in table:
        if one.on:
            total += one.n
    return row.x, row.n, row.on, total


def test_records() -> None:
    """Fields of _records and of arrays of _records are read and written."""
    table = np.zeros(3, RECORD).view(np.recarray)
    table.x, table.n = (0.25, 1.0, 2.0), (4, -5, 6)
    code = compiled(_records)
    for i in (-3, -1, 0, 1, 2):
        one, other = table.copy(), table.copy()
        assert bits(code(one, i)) == bits(_records(other, i))
        assert one.tobytes() == other.tobytes()


def _aliases(a: Any, b: Any) -> Any:
    a[0] = 5.0
    first = b[0]
    b[1] = first + a[1]
    return a[1] * b[0]


def test_arrays_that_share_memory() -> None:
    """What is written to one array is read from another one that shares its memory."""
    code = compiled(_aliases)
    for first, second in ((0, 0), (0, 1), (1, 0)):
        one, other = np.arange(1.0, 4.0), np.arange(1.0, 4.0)
        assert code(one[first:], one[second:]) == _aliases(other[first:], other[second:])
        assert one.tobytes() == other.tobytes()


def _returned_arrays(a: Any, n: int) -> Any:
    out = np.zeros((n, 2))
    for i in range(n):
        out[i, 0] = a[i % len(a)]
        out[i, 1] = -i
    whole = np.empty(3, np.int64)
    whole[:] = n
    return out, whole, a + 2.0 * a, np.arange(n), (a - 1.0).copy()


def test_returned_arrays() -> None:
    """Arrays that the code makes are returned as arrays of Python's own."""
    check(_returned_arrays, (np.arange(3.0), np.arange(6.0)[::2]), (0, 1, 4))


# functions


class Point(NamedTuple):
    """Two numbers, and what may be missing."""

    x: float
    y: Any
    extra: Any = None


def _moved(point: Any, by: float) -> Any:
    if point.extra is None:
        return point._replace(x=point.x + by)
    return Point(point.x - by, point.y, point.extra)


def _uses_tuples(point: Any, n: int) -> Any:
    for _ in range(n):
        point = _moved(point, 0.5)
    x, y, *rest = point
    other = Point(*(2.0, 3.0)) if x > 1.0 else Point(x=1, y=2.0)
    return point, other, len(point), rest[0] is None, (point + (1,))[-1], point[:2][n % 2]


def test_named_tuples() -> None:
    """Fields that are None leave nothing; tuples are made, changed, unpacked and indexed."""
    code = compiled(_uses_tuples)
    for point, n in itertools.product((Point(1.0, 2.0), Point(0.25, -1.0, 3.0)), (0, 1, 3)):
        result, expected = code(point, n), _uses_tuples(point, n)
        assert result == expected and type(result[0]) is Point


def scaled_by(factor: float) -> Any:
    """Return a closure."""
    return lambda x, offset=0.5, *more, sign=1.0: sign * factor * x + offset + len(more)


TWICE, THRICE = scaled_by(2.0), scaled_by(3.0)
PAIR = (lambda x: x + 1.0), (lambda x: (lambda y: y * x)(2.0))


@generic
def _name_of(x: Any) -> Any:
    return 0


@_name_of.register(float)
def _name_of_float(x: Any) -> Any:
    return 1


@_name_of.register(Point)
def _name_of_point(x: Any) -> Any:
    return 2 + _name_of(x.x)


@routine
def _apart(x: float, n: int, a: Any) -> Any:
    a[n] = x
    return (x, n) if n > 1 else (0.0, -n)


def _calls(x: float, n: int, a: Any) -> Any:
    arguments = (x, 1.5)
    first = (
        TWICE(x) + THRICE(*arguments) + TWICE(x, sign=-1.0) + THRICE(x, 1.0, 2, 3, **{"sign": x})
    )
    return (
        first,
        PAIR[0](x),
        _name_of(x),
        _name_of(Point(x, n)),
        _name_of(n),
        _apart(x, n, a),
        _apart(1.0, 0, a),
        a[n],
    )


def test_calls() -> None:
    """Closures, default, keyword and starred arguments, lambdas, generics and routines."""
    check(_calls, (1.0, -0.5), (0, 1, 2), (np.zeros(3),))


def test_two_lambdas_of_one_line() -> None:
    """Each is traced from its own part of the line."""
    check(lambda x: PAIR[1](x) if False else PAIR[0](x), (1.0, 3.0))


def without_an_integer(x: float) -> int:
    """Return a number; no argument reaches those that have no integer."""
    if x > 1e300:
        return int(math.nan) + round(math.inf) + math.floor(math.nan)
    return 3


def test_known_numbers_without_an_integer_may_be_in_code_that_never_runs() -> None:
    """Tracing computes with what is known, on both sides of a branch, and fails on neither."""
    check(without_an_integer, (0.0, -1.5))


def signed_zeros(x):
    """Return what depends on the signs of zeros beside the integers 0 and 1."""
    return (
        copysign(5.0, 0 - x),
        copysign(5.0, x + 0),
        copysign(5.0, 0 * x),
        math.atan2(0 - x, -1.0),
        sum([x]),
    )


def test_integers_are_numbers_in_functions_of_users() -> None:
    """0 and 1 are structure only in the packages' functions: users' laws have Python's bits."""
    check(signed_zeros, REALS)


def short_with_known_numbers(x):
    """Return functions of known reals that raise errors in Python, on a side that does not run."""
    return fma_of(1.5, 2.0, 3.0) + (x if x > 0.0 else root_of(-1.0) + min(exp_of(1000.0), x))


def fma_of(a, b, c):
    """Return a b + c, rounded once."""
    return fma(a, b, c)


def root_of(x):
    """Return the square root."""
    return math.sqrt(x)


def exp_of(x):
    """Return e to the power of x."""
    return math.exp(x)


def test_short_functions_of_known_numbers_raise_no_error() -> None:
    """Where Python would raise one, compiled code has the C library's number."""
    assert compiled(short_with_known_numbers)(2.0) == 8.0
    assert math.isnan(compiled(short_with_known_numbers)(-2.0))


CURVES = ([1.0, 2.0, 4.0], ([3.0, 5.0, 6.0], 7.0))


def lists_inside_tuples(x, i):
    """Return elements of lists in tuples, in short and long functions, branches and loops."""
    chosen = CURVES[0] if x > 0.0 else CURVES[1][0]
    total = 0.0
    for part in CURVES[:1]:
        total += element_of(part, i) * x
    return (
        short_element((CURVES[0], x), i),
        element_of(CURVES[1][0], i % 2),
        total,
        element_of(chosen, i % 2),
    )


def short_element(parts, i):
    """Return an element of a list inside a tuple."""
    return parts[0][i] * parts[1]


@routine
def element_of(items, i):
    """Return an element."""
    return items[i]


def test_lists_inside_tuples_are_tuples() -> None:
    """An unknown index of a known list gives one of its elements, wherever the list is from."""
    check(lists_inside_tuples, (-1.5, 2.0), (0, 1, 2))


def sine_and_cosine_of(x):
    """Return the sine and the cosine of an angle."""
    return sincos(x)


def test_small_angles_have_the_bits_of_their_reduction() -> None:
    """Code that does not reduce small angles has the bits of Python, near the limit too."""
    around = [sign * (0.78 + k * 1e-16) for sign in (-1.0, 1.0) for k in range(-5, 6)]
    check(
        sine_and_cosine_of,
        (*around, 0.0, -0.0, 5e-324, -1e-310, 1e-9, -0.3, math.pi / 4.0, 0.8, -2.0, 1e5, nan),
    )
