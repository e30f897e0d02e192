"""LLVM instructions for arithmetic on states that are nested tuples, one for each float: for `state_algebra` alone."""

from collections.abc import Callable
from typing import Any

from numba.core import types

from crane_sim.jit import intrinsic


def _is_tuple(kind: Any) -> bool:
    return isinstance(kind, types.BaseTuple)


def _each(context: Any, builder: Any, kind: Any, operation: Callable[..., Any], *parts: Any) -> Any:
    """Return the state of type `kind` whose floats are the operation of the floats of `parts`."""
    if not _is_tuple(kind):
        return operation(*parts)
    found = []
    for i, inner in enumerate(kind):
        found.append(_each(context, builder, inner, operation, *(builder.extract_value(part, i) for part in parts)))
    return context.make_tuple(builder, kind, found)


@intrinsic
def add_floats(typing_context, x, y):
    """Return x + y."""

    def generate(context, builder, signature, args):
        return _each(context, builder, x, builder.fadd, *args)

    return x(x, y), generate


@intrinsic
def scale_floats(typing_context, a, x):
    """Return a x."""

    def generate(context, builder, signature, args):
        return _each(context, builder, x, lambda leaf: builder.fmul(args[0], leaf), args[1])

    return x(a, x), generate


@intrinsic
def add_scaled_floats(typing_context, x, a, y):
    """Return x + a y, each float rounded once."""

    def generate(context, builder, signature, args):
        def operation(b, c):
            return builder.fma(args[1], c, b)

        return _each(context, builder, x, operation, args[0], args[2])

    return x(x, a, y), generate


@intrinsic
def combine_floats(typing_context, h, row, ks):
    """Return the sum of h row[j] ks[j] over the entries of `row` that are not None."""
    used = [j for j, entry in enumerate(row) if isinstance(entry, types.Float)]

    def generate(context, builder, signature, args):
        factors = [builder.fmul(args[0], builder.extract_value(args[1], j)) for j in used]

        def operation(*slopes):
            total = builder.fmul(factors[0], slopes[0])
            for factor, slope in zip(factors[1:], slopes[1:], strict=True):
                total = builder.fma(factor, slope, total)
            return total

        stages = [builder.extract_value(args[2], j) for j in used]
        return _each(context, builder, ks[0], operation, *stages)

    return ks[0](h, row, ks), generate


@intrinsic
def leaves_of_floats(typing_context, x):
    """Return the floats of x as a flat tuple."""

    def count(kind: Any) -> int:
        return sum(count(part) for part in kind) if _is_tuple(kind) else 1

    kind = types.UniTuple(types.float64, count(x))

    def generate(context, builder, signature, args):
        found = []
        _each(context, builder, x, lambda leaf: found.append(leaf) or leaf, args[0])
        return context.make_tuple(builder, kind, found)

    return kind(x), generate
