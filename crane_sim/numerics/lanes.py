"""Many cranes side by side: trees of numbers as trees of columns, and states as columns of one buffer.

A loop over the lanes of a buffer, whose body is branch-free and calls nothing, becomes vector instructions: one crane
in each lane, with the very arithmetic of one crane alone.
"""

from collections.abc import Iterator
from typing import Any

from numba.core import cgutils, types
from numba.np.arrayobj import populate_array as _populate_array

from crane_sim.numerics.jit import lower_to
from crane_sim.numerics.states import leaves

populate_array: Any = _populate_array
LANES = 16
"""Cranes that move in step: two of the widest vectors, and few enough to stay in the first cache."""


def _rebuilt(like: Any, parts: list[Any]) -> Any:
    return type(like)(*parts) if hasattr(like, "_fields") else tuple(parts)


def _fill(like: Any, floats: Iterator[float]) -> Any:
    return _rebuilt(like, [_fill(part, floats) for part in like]) if isinstance(like, tuple) else next(floats)


def _is_tuple(kind: Any) -> bool:
    return isinstance(kind, types.BaseTuple)


def _entry_type(kind: Any) -> Any:
    """Return the type of one crane's tree, of a tree of columns of type `kind`."""
    if isinstance(kind, types.Array):
        return kind.dtype if kind.ndim == 1 else types.Array(kind.dtype, kind.ndim - 1, "C")
    if not _is_tuple(kind):
        return kind
    named = isinstance(kind, types.NamedTuple | types.NamedUniTuple)
    return types.BaseTuple.from_types([_entry_type(part) for part in kind], kind.instance_class if named else None)


def _locate(context: Any, builder: Any, kind: Any, value: Any, i: Any) -> tuple[Any, Any, list[Any], list[Any]]:
    """Return (array, address of its entry i, shape of an entry, strides of an entry) of a column."""
    column: Any = context.make_array(kind)(context, builder, value)
    (_, *shape), (_, *strides) = (cgutils.unpack_tuple(builder, sizes) for sizes in (column.shape, column.strides))
    for size in shape:
        i = builder.mul(i, size)
    return column, builder.gep(column.data, [i], inbounds=True), shape, strides


def _entry(context: Any, builder: Any, kind: Any, value: Any, i: Any) -> Any:
    """Return entry i of a tree of columns; entries that are arrays are views, kept alive by their columns."""
    if _is_tuple(kind):
        parts = [_entry(context, builder, part, builder.extract_value(value, j), i) for j, part in enumerate(kind)]
        return context.make_tuple(builder, _entry_type(kind), parts)
    if not isinstance(kind, types.Array):
        return value
    column, address, shape, strides = _locate(context, builder, kind, value, i)
    if kind.ndim == 1:
        return context.unpack_value(builder, kind.dtype, address)
    view = context.make_array(_entry_type(kind))(context, builder)
    populate_array(view, data=address, shape=shape, strides=strides, itemsize=column.itemsize, meminfo=None)
    return view._getvalue()


def _put_entry(context: Any, builder: Any, kind: Any, value: Any, i: Any, entry_kind: Any, entry: Any) -> None:
    """Write an entry of type `entry_kind` into entry i of a tree of columns; arrays may be views of their columns."""
    if _is_tuple(kind):
        for j, (part, own) in enumerate(zip(kind, entry_kind, strict=True)):
            parts = builder.extract_value(value, j), i, own, builder.extract_value(entry, j)
            _put_entry(context, builder, part, *parts)
        return
    if not isinstance(kind, types.Array):
        return
    _, address, shape, _ = _locate(context, builder, kind, value, i)
    if kind.ndim == 1:
        context.pack_value(builder, kind.dtype, context.cast(builder, entry, entry_kind, kind.dtype), address)
        return
    source, count = context.make_array(entry_kind)(context, builder, entry), context.get_constant(types.intp, 1)
    for size in shape:
        count = builder.mul(count, size)
    cgutils.raw_memmove(builder, address, source.data, count, source.itemsize)


def _put(typing_context, columns, i, tree):
    def generate(context, builder, signature, args):
        _put_entry(context, builder, columns, args[0], args[1], tree, args[2])
        return context.get_dummy_value()

    return types.none(columns, types.intp, tree), generate


def _pick(typing_context, columns, i):
    def generate(context, builder, signature, args):
        return _entry(context, builder, columns, *args)

    return _entry_type(columns)(columns, types.intp), generate


def _addresses(context: Any, builder: Any, buffer: Any, value: Any, j: Any) -> Iterator[Any]:
    """Yield the addresses of lane j in a buffer, row by row.

    The distance of rows is a constant, so the compiler sees that no lane touches another one.
    """
    data: Any = context.make_array(buffer)(context, builder, value).data
    row = 0
    while True:
        yield builder.gep(data, [builder.add(context.get_constant(types.intp, row * LANES), j)], inbounds=True)
        row += 1


def _lane(typing_context, like, buffer, j):
    def generate(context, builder, signature, args):
        addresses = _addresses(context, builder, buffer, args[1], args[2])

        def read(kind):
            if _is_tuple(kind):
                return context.make_tuple(builder, kind, [read(part) for part in kind])
            return builder.load(next(addresses))

        return read(like)

    return like(like, buffer, types.intp), generate


def _put_lane(typing_context, buffer, j, x):
    def generate(context, builder, signature, args):
        addresses = _addresses(context, builder, buffer, *args[:2])

        def write(kind, value):
            if _is_tuple(kind):
                for i, part in enumerate(kind):
                    write(part, builder.extract_value(value, i))
            else:
                builder.store(value, next(addresses))

        write(x, args[2])
        return context.get_dummy_value()

    return types.none(buffer, types.intp, x), generate


def _use_wide_vectors(typing_context):
    def generate(context, builder, signature, args):
        # llvmlite lists no such attribute; without it LLVM halves its vectors on processors that once clocked down
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.none(), generate


@lower_to(_pick)
def take_entry(columns: Any, i: int) -> Any:
    """Return crane i: entry i of every array of a tree of columns; types of NamedTuples are kept."""
    if not isinstance(columns, tuple):
        return None if columns is None else columns[i]
    return _rebuilt(columns, [take_entry(part, i) for part in columns])


@lower_to(_put)
def put_entry(columns: Any, i: int, tree: Any) -> None:
    """Write the numbers of crane i into entry i of every array of a tree of columns."""
    if isinstance(columns, tuple):
        for part, entry in zip(columns, tree, strict=True):
            put_entry(part, i, entry)
    elif columns is not None:
        columns[i] = tree


@lower_to(_lane)
def lane(like: Any, buffer: Any, j: int) -> Any:
    """Return lane j of a buffer (floats, LANES) as a state of the same type as `like`."""
    return _fill(like, iter(buffer[:, j].tolist()))


@lower_to(_put_lane)
def put_lane(buffer: Any, j: int, x: Any) -> None:
    """Write the floats of the state x into lane j of a buffer (floats, LANES)."""
    buffer[:, j] = leaves(x)


@lower_to(_use_wide_vectors)
def use_wide_vectors() -> None:
    """Have the function that calls this compiled for the widest vectors of the processor."""
