"""Arithmetic on states that are arrays, which `states` compiles for them, and rows of results."""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import overload

from crane_sim.numerics.jit import OPTIONS, intrinsic, lean_routine, routine


@routine
def add_arrays(x, y):
    """Return x + y."""
    return add_scaled_arrays(x, 1.0, y)


@routine
def scale_array(a, x):
    """Return a x."""
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = a * x[i]
    return out


@routine
def add_scaled_arrays(x, a, y):
    """Return x + a y."""
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = x[i] + a * y[i]
    return out


WIDTHS = (16, 8, 4, 2, 1)
"""Floats that are added up together, as vectors of the processor; the first width serves most of a row."""


@intrinsic
def accumulate(typing_context, h, weights, count, ks, x, out):
    """Write x plus the sum of h weights[j] ks[j] over the first `count` rows, at least one, into `out`.

    The rows are added from left to right, x last; x may be None. The loop over the row is the outer one, so that sums
    stay in registers, which no compiler would do without knowing that `out` is not one of the rows.
    """

    def generate(context, builder, signature, args):
        rows, to = (context.make_array(kind)(context, builder, args[i]) for kind, i in ((ks, 3), (out, 5)))
        stride, n = builder.extract_value(rows.shape, 1), builder.extract_value(to.shape, 0)
        start = context.make_array(x)(context, builder, args[4]).data if isinstance(x, types.Array) else None
        factors = _address(context, builder, weights, args[1])

        def block(width, at):
            def term(j):
                factor = builder.fmul(args[0], builder.load(builder.gep(factors, [j])))
                row = builder.load(
                    part_of_row(builder, rows.data, builder.add(builder.mul(j, stride), at), width), align=8
                )
                return broadcast(builder, factor, width), row

            total = _sum(builder, term, args[2])
            if start is not None:
                total = builder.fadd(builder.load(part_of_row(builder, start, at, width), align=8), total)
            builder.store(total, part_of_row(builder, to.data, at, width), align=8)

        in_blocks(builder, n, block)
        return context.get_dummy_value()

    return types.none(h, weights, types.intp, ks, x, out), generate


def _sum(builder: Any, term: Any, count: Any) -> Any:
    """Return the sum of the products term(0) ... term(count - 1), from left to right; count is at least one."""
    total = cgutils.alloca_once_value(builder, builder.fmul(*term(count.type(0))))
    with cgutils.for_range(builder, count, start=count.type(1), intp=count.type) as loop:
        factor, row = term(loop.index)
        builder.store(fused(builder, factor, row, builder.load(total)), total)
    return builder.load(total)


def fused(builder: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, floats or vectors of them, each rounded once."""
    if not isinstance(a.type, ir.VectorType):
        return builder.fma(a, b, c)
    name = f"llvm.fma.v{a.type.count}f64"
    return builder.call(
        cgutils.get_or_insert_function(builder.module, ir.FunctionType(a.type, [a.type] * 3), name), [a, b, c]
    )


def part_of_row(builder: Any, first: Any, index: Any, width: int) -> Any:
    """Return a pointer to `width` floats, as a vector, at offset `index` from the float at `first`."""
    kind = first.type.pointee if width == 1 else ir.VectorType(first.type.pointee, width)
    return builder.bitcast(builder.gep(first, [index]), kind.as_pointer())


def _address(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Return a pointer to the floats of an array, or of a tuple."""
    if isinstance(kind, types.Array):
        return context.make_array(kind)(context, builder, value).data
    first = cgutils.alloca_once(builder, ir.DoubleType(), size=len(kind))
    for j in range(len(kind)):
        builder.store(builder.extract_value(value, j), builder.gep(first, [ir.IntType(64)(j)]))
    return first


def broadcast(builder: Any, value: Any, width: int) -> Any:
    """Return a vector that holds the float `value` in every lane."""
    if width == 1:
        return value
    kind, index_type = ir.VectorType(value.type, width), ir.IntType(32)
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), value, index_type(0))
    return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(index_type, width), [0] * width))


def in_blocks(builder: Any, n: Any, block: Any, widths: tuple[int, ...] = WIDTHS) -> None:
    """Build calls of block(width, first index) that cover n floats: as many of the widest as fit, then one of each."""
    size, at = n.type, n.type(0)
    whole = builder.and_(n, size(-widths[0]))
    with cgutils.for_range_slice(builder, at, whole, size(widths[0]), intp=size) as (index, _):
        block(widths[0], index)
    for width in widths[1:]:
        remainder = builder.and_(n, size(width))
        with builder.if_then(builder.icmp_unsigned("!=", remainder, size(0))):
            block(width, whole)
        whole = builder.add(whole, remainder)


@lean_routine
def move_rows(x, h, weights, ks, out):
    """Write x plus the sum of h weights[j] ks[j] into `out`."""
    accumulate(h, weights, len(weights), ks, x, out)


@lean_routine
def array_square(e, x, y, rtol, atol):
    """Return the sum of squares of e / (atol + rtol max(|x|, |y|)), component by component."""
    total = 0.0
    for i in range(len(e)):
        ratio = e[i] / (atol + rtol * max(abs(x[i]), abs(y[i])))
        total += ratio * ratio
    return total


@lean_routine
def rows_square(h, weights, ks, x, y, rtol, atol):
    """Return the `array_square` of the sum of h weights[j] ks[j], which takes the row after those for itself.

    Squares first, then their sum: the divisions become vectors, and only the additions wait for each other.
    """
    count, total = len(weights), 0.0
    squares = ks[count]
    accumulate(h, weights, count, ks, None, squares)
    for i in range(len(x)):
        ratio = squares[i] / (atol + rtol * max(abs(x[i]), abs(y[i])))
        squares[i] = ratio * ratio
    for i in range(len(x)):
        total += squares[i]
    return total


@intrinsic
def dense(typing_context, row):
    """Return the row with 0 in place of None, as a tuple of one type."""
    kind = types.UniTuple(types.float64, len(row))

    def generate(context, builder, signature, args):
        zero = context.get_constant(types.float64, 0.0)
        is_float = [isinstance(entry, types.Float) for entry in row]
        entries = [builder.extract_value(args[0], j) if is_value else zero for j, is_value in enumerate(is_float)]
        return context.make_tuple(builder, kind, entries)

    return kind(row), generate


def store(rows: Any, i: int, first: int, values: tuple[float, ...]) -> None:
    """Copy the values, any number of them, into row i from column `first` on."""
    rows[i, first : first + len(values)] = values


def copy_into(out: Any, values: tuple[float, ...]) -> None:
    """Copy the values into an array of the same length, which may be 0."""
    out[:] = values


@overload(copy_into, jit_options=OPTIONS)
def _copy_into(out, values):
    def each(out, values):
        for j in range(len(values)):
            out[j] = values[j]

    return each if len(values) else lambda out, values: None


@overload(store, jit_options=OPTIONS)
def _store(rows, i, first, values):
    def each(rows, i, first, values):
        for j in range(len(values)):
            rows[i, first + j] = values[j]

    return each if len(values) else lambda rows, i, first, values: None
