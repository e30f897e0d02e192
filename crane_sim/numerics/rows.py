"""Functions of floats applied to rows of arrays, element by element, in vectors of the processor.

Left to itself the compiler gives short rows scalar code: it unrolls its vector loops fourfold, behind tests of whether
rows overlap, and what is left over is done one by one. The function is written once: Python calls it with floats, and
compiled code has the instructions that it asks of `Lanes`, so both have the same bits.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.extending import overload

from crane_sim.numerics.arrays import WIDTHS, broadcast, fused, in_blocks, part_of_row
from crane_sim.numerics.elementary import sincos, sincos_of_residue
from crane_sim.numerics.jit import LEAN, intrinsic


class Lanes:
    """Floats in the lanes of a vector, or a single one, as an LLVM value of code under construction."""

    def __init__(self, builder: Any, value: Any) -> None:
        """Take a builder and a value of it."""
        self.builder, self.value = builder, value

    def of(self, x: Any) -> Any:
        """Return the LLVM value of x, a float in every lane or other lanes."""
        if isinstance(x, Lanes):
            return x.value
        kind = self.value.type
        return ir.Constant(kind, [float(x)] * kind.count if isinstance(kind, ir.VectorType) else float(x))

    def __add__(self, x: Any) -> "Lanes":
        return Lanes(self.builder, self.builder.fadd(self.value, self.of(x)))

    def __sub__(self, x: Any) -> "Lanes":
        return Lanes(self.builder, self.builder.fsub(self.value, self.of(x)))

    def __rsub__(self, x: Any) -> "Lanes":
        return Lanes(self.builder, self.builder.fsub(self.of(x), self.value))

    def __mul__(self, x: Any) -> "Lanes":
        return Lanes(self.builder, self.builder.fmul(self.value, self.of(x)))

    def __truediv__(self, x: Any) -> "Lanes":
        return Lanes(self.builder, self.builder.fdiv(self.value, self.of(x)))

    def __neg__(self) -> "Lanes":
        return Lanes(self.builder, self.builder.fneg(self.value))

    __radd__, __rmul__ = __add__, __mul__

    def fma(self, b: Any, c: Any) -> "Lanes":
        """Return self b + c, rounded once."""
        return Lanes(self.builder, fused(self.builder, self.value, self.of(b), self.of(c)))


def sincos_in_lanes(angle: Any) -> tuple[Any, Any]:
    """Return what `sincos` does, of a float or of lanes."""
    if not isinstance(angle, Lanes):
        return sincos(angle)
    k, s, c = getattr(sincos_of_residue, "py_func", sincos_of_residue)(angle)
    builder, kind = angle.builder, angle.value.type
    whole: Any = ir.IntType(64) if not isinstance(kind, ir.VectorType) else ir.VectorType(ir.IntType(64), kind.count)

    def number(i: int) -> Any:
        return ir.Constant(whole, [i] * whole.count if isinstance(whole, ir.VectorType) else i)

    def has(value: Any, bit: int) -> Any:
        return builder.icmp_signed("!=", builder.and_(value, number(bit)), number(0))

    quarter = builder.fptosi(k.value, whole)
    odd, below = has(quarter, 1), has(quarter, 2)
    left = has(builder.add(quarter, number(1)), 2)
    sine, cosine = builder.select(odd, c.value, s.value), builder.select(odd, s.value, c.value)
    sine, cosine = (
        builder.select(below, builder.fneg(sine), sine),
        builder.select(left, builder.fneg(cosine), cosine),
    )
    return Lanes(builder, sine), Lanes(builder, cosine)


def elementwise(f: Callable[..., tuple[Any, ...]]) -> Callable[..., None]:
    """Return a function (n, outputs, inputs) that fills the first n of each output row with f of those of the inputs.

    f takes a float from each input, a row or a float, and returns one for each output, by +, -, *, /, `fma` and
    `sincos_in_lanes`. Rows that are written are none of those that are read.
    """

    def fill(n: int, outputs: tuple[Any, ...], inputs: tuple[Any, ...]) -> None:
        for k in range(n):
            for row, value in zip(outputs, f(*(x if isinstance(x, float) else x[k] for x in inputs)), strict=True):
                row[k] = value

    @intrinsic
    def fill_blocks(typing_context, n, outputs, inputs):
        def generate(context, builder, signature, args):
            targets, sources = _parts(context, builder, outputs, args[1]), _parts(context, builder, inputs, args[2])
            _build(builder, f, args[0], targets, sources)
            return context.get_dummy_value()

        return types.none(types.intp, outputs, inputs), generate

    def choose(n, outputs, inputs):
        return lambda n, outputs, inputs: fill_blocks(n, outputs, inputs)

    overload(fill, jit_options=LEAN)(choose)
    return fill


def _parts(context: Any, builder: Any, kinds: Any, values: Any) -> list[Any]:
    """Return the addresses of rows, and floats, of a tuple of both."""
    parts = []
    for i, kind in enumerate(kinds):
        value = builder.extract_value(values, i)
        parts.append(context.make_array(kind)(context, builder, value).data if isinstance(kind, types.Array) else value)
    return parts


def _build(builder: Any, f: Any, n: Any, targets: list[Any], sources: list[Any]) -> None:
    """Build the loop over blocks that fills the first n of the rows at `targets`."""

    def load(source: Any, width: int, at: Any) -> Lanes:
        if not isinstance(source.type, ir.PointerType):
            return Lanes(builder, broadcast(builder, source, width))
        return Lanes(builder, builder.load(part_of_row(builder, source, at, width), align=8))

    def block(width: int, at: Any) -> None:
        values = [load(source, width, at) for source in sources]
        for row, value in zip(targets, f(*values), strict=True):
            builder.store(values[0].of(value), part_of_row(builder, row, at, width), align=8)

    in_blocks(builder, n, block, WIDTHS[1:])  # long functions: each width is a copy to compile
