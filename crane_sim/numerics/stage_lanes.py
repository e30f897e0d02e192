"""Eight stages of a step side by side: a row of a buffer holds one entry of the state at all of them, a stage a lane.

The buffer is on the stack of the function that asks for it, which must not return it. Sums have an order of their own,
the same in Python and in compiled code.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import populate_array as _populate_array

from crane_sim.numerics.arrays import broadcast, fused
from crane_sim.numerics.elementary import fma
from crane_sim.numerics.jit import lower_to
from crane_sim.numerics.lanes import LANES
from crane_sim.numerics.states import dimension

populate_array: Any = _populate_array
STAGES = 8  # a vector of the widest processors
_VECTOR = ir.VectorType(ir.DoubleType(), STAGES)
_INDEX = ir.IntType(64)


def stage_rows(x: Any) -> Any:
    """Return an undefined buffer (floats of x, LANES)."""
    return np.empty((dimension(x), LANES))


def _mixed(matrix: Any, row: Any) -> Iterator[float]:
    """Yield the entries of M s, each the sum of one over the even and one over the odd stages."""
    stages = row[:STAGES].tolist()
    for column in matrix.T.tolist():
        even, odd = column[0] * stages[0], column[1] * stages[1]
        for j in range(2, STAGES, 2):
            even, odd = fma(column[j], stages[j], even), fma(column[j + 1], stages[j + 1], odd)
        yield even + odd


def _folded(values: list[float]) -> float:
    """Return the sum by halves: of the first four and the last four, and so on."""
    while len(values) > 1:
        half = len(values) // 2
        values = [a + b for a, b in zip(values[:half], values[half:], strict=True)]
    return values[0]


def _data(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return context.make_array(kind)(context, builder, value).data


def _row(context: Any, builder: Any, kind: Any, value: Any, i: Any) -> Any:
    """Return a pointer to the first float of row i of a buffer."""
    return builder.gep(_data(context, builder, kind, value), [builder.mul(i, i.type(LANES))])


def _load(builder: Any, pointer: Any) -> Any:
    return builder.load(builder.bitcast(pointer, _VECTOR.as_pointer()), align=8)


def _store(builder: Any, value: Any, pointer: Any) -> None:
    builder.store(value, builder.bitcast(pointer, _VECTOR.as_pointer()), align=8)


def _product(builder: Any, columns: Any, stages: Any) -> Any:
    """Return M s as a vector; each stage is loaded into all lanes, which costs no shuffle."""
    totals: list[Any] = [None, None]
    for j in range(STAGES):
        column = _load(builder, builder.gep(columns, [_INDEX(j * STAGES)]))
        stage = broadcast(builder, builder.load(builder.gep(stages, [_INDEX(j)])), STAGES)
        before = totals[j % 2]
        totals[j % 2] = builder.fmul(column, stage) if before is None else fused(builder, column, stage, before)
    return builder.fadd(*totals)


def _fold(builder: Any, vector: Any) -> Any:
    """Return the sum of a vector's floats, in the order of `_folded`."""
    for width in (4, 2, 1):
        picks = [ir.Constant(ir.VectorType(ir.IntType(32), width), [first + j for j in range(width)])
                 for first in (0, width)]  # fmt: skip
        halves = [builder.shuffle_vector(vector, vector, pick) for pick in picks]
        vector = builder.fadd(*halves)
    return builder.extract_element(vector, ir.IntType(32)(0))


def _float_count(kind: Any) -> int:
    parts: Any = kind if isinstance(kind, types.BaseTuple) else ()
    return sum(map(_float_count, parts)) if isinstance(kind, types.BaseTuple) else 1


@type_callable(stage_rows)
def _type_stage_rows(context: Any) -> Any:
    """Return the typing of `stage_rows`: a function that numba lets return an array would have to count references."""
    return lambda x: types.Array(types.float64, 2, "C")


@lower_builtin(stage_rows, types.Any)
def _lower_stage_rows(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    rows, size = _float_count(signature.args[0]), context.get_constant
    data = cgutils.alloca_once(builder, ir.DoubleType(), size=_INDEX(rows * LANES))
    data.align = 64
    shape = [size(types.intp, rows), size(types.intp, LANES)]
    strides = [size(types.intp, 8 * LANES), size(types.intp, 8)]
    buffer: Any = context.make_array(signature.return_type)(context, builder)
    populate_array(buffer, data, shape, strides, size(types.intp, 8), meminfo=None)
    return buffer._getvalue()


def _mix(typing_context, matrix, source, i, to, k, scale):
    def generate(context, builder, signature, args):
        stages = _row(context, builder, source, args[1], args[2])
        product = _product(builder, _data(context, builder, matrix, args[0]), stages)
        total = builder.fmul(broadcast(builder, args[5], STAGES), product)
        _store(builder, total, _row(context, builder, to, args[3], args[4]))
        return context.get_dummy_value()

    return types.none(matrix, source, types.intp, to, types.intp, types.float64), generate


def _reach(typing_context, matrix, source, i, to, k, path):
    kind = path[3]

    def generate(context, builder, signature, args):
        stages = _row(context, builder, source, args[1], args[2])
        product = _product(builder, _data(context, builder, matrix, args[0]), stages)
        *numbers, nodes = cgutils.unpack_tuple(builder, args[5])
        base, move, scale = (broadcast(builder, number, STAGES) for number in numbers)
        base = fused(builder, _load(builder, _data(context, builder, kind, nodes)), move, base)
        _store(builder, fused(builder, scale, product, base), _row(context, builder, to, args[3], args[4]))
        return context.get_dummy_value()

    way = types.Tuple((types.float64,) * 3 + (kind,))
    return types.none(matrix, source, types.intp, to, types.intp, way), generate


def _take(typing_context, source, to, i):
    def generate(context, builder, signature, args):
        new = _load(builder, _row(context, builder, source, args[0], args[2]))
        kept = _row(context, builder, to, args[1], args[2])
        change = builder.fsub(new, _load(builder, kept))
        _store(builder, new, kept)
        return _fold(builder, builder.fmul(change, change))

    return types.float64(source, to, types.intp), generate


def _weigh(typing_context, weights, source, i):
    def generate(context, builder, signature, args):
        stages = _load(builder, _row(context, builder, source, args[1], args[2]))
        return _fold(builder, builder.fmul(_load(builder, _data(context, builder, weights, args[0])), stages))

    return types.float64(weights, source, types.intp), generate


def _opaque_count(typing_context):
    def generate(context, builder, signature, args):
        return builder.asm(ir.FunctionType(_INDEX, [_INDEX]), "", "=r,0", [_INDEX(STAGES)], False)

    return types.intp(), generate


@lower_to(_mix)
def mix_stages(matrix: Any, source: Any, i: int, to: Any, k: int, scale: float) -> None:
    """Write scale M s into row k of `to`, s being row i of `source`; `matrix` (8, 8) has the columns of M as rows."""
    for j, total in enumerate(_mixed(matrix, source[i])):
        to[k, j] = scale * total


@lower_to(_reach)
def reach_stages(matrix: Any, source: Any, i: int, to: Any, k: int, path: tuple[float, float, float, Any]) -> None:
    """Write x + nodes move + scale M s into row k of `to`, path = (x, move, scale, nodes (8,)), see `mix_stages`."""
    x, move, scale, nodes = path
    for j, total in enumerate(_mixed(matrix, source[i])):
        to[k, j] = fma(scale, total, fma(nodes[j], move, x))


@lower_to(_take)
def take_row(source: Any, to: Any, i: int) -> float:
    """Copy the stages of row i from `source` to `to`; return the sum of the squares of what changes there."""
    changes = [a - b for a, b in zip(source[i, :STAGES].tolist(), to[i, :STAGES].tolist(), strict=True)]
    to[i, :STAGES] = source[i, :STAGES]
    return _folded([change * change for change in changes])


@lower_to(_weigh)
def weigh_stages(weights: Any, source: Any, i: int) -> float:
    """Return the sum of weights (8,) times the stages of row i."""
    return _folded([w * s for w, s in zip(weights.tolist(), source[i, :STAGES].tolist(), strict=True)])


@lower_to(_opaque_count)
def stage_count() -> int:
    """Return the number of stages; a function, as the compiler would unroll a loop over a constant."""
    return STAGES
