"""Arrays of traced functions: memory at an address, with the type and shape of NumPy's arrays."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from crane_sim.tracing.arithmetic import choose, combine, convert, is_natural, largest, smallest
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.trace_error import TraceError

_KINDS = {
    "f8": Kind.REAL,
    "i8": Kind.INTEGER,
    "i4": Kind.INTEGER,
    "u8": Kind.WORD,
    "b1": Kind.BOOLEAN,
}


def code_of(dtype: np.dtype) -> str:
    """Return the code of a type of elements, as `llvm` has it."""
    return dtype.str[1:]


@dataclass(slots=True, eq=False)
class ArraySymbol:
    """An array in memory; sizes and strides are integers, or symbols of the kind INTEGER."""

    address: Value
    offset: int  # bytes from the address to the first element
    dtype: np.dtype
    shape: tuple[Any, ...]
    strides: tuple[Any, ...]  # bytes

    @property
    def graph(self) -> Graph:
        """The trace that it belongs to."""
        return self.address.graph

    def __bool__(self) -> bool:
        raise TraceError("an array as a condition")


@dataclass(slots=True, eq=False)
class RecordSymbol:
    """A record, an element of a structured array."""

    address: Value
    offset: int  # bytes
    dtype: np.dtype


def contiguous_strides(shape: tuple[Any, ...], itemsize: int) -> tuple[Any, ...]:
    """Return the strides [bytes] of an array whose last index varies fastest."""
    strides, size = [], itemsize
    for length in reversed(shape):
        strides.append(size)
        size = combine("multiply", size, length)
    return tuple(reversed(strides))


def is_contiguous(array: ArraySymbol) -> bool:
    """Return whether an array is known to be contiguous, the last index varying fastest."""
    dense = contiguous_strides(array.shape, array.dtype.itemsize)
    return all(_known_equal(a, b) for a, b in zip(array.strides, dense, strict=True))


def _known_equal(a: Any, b: Any) -> bool:
    if isinstance(a, Value) and isinstance(b, Value):
        return a.number == b.number
    return type(a) is type(b) and a == b


def allocate(graph: Graph, shape: tuple[Any, ...], dtype: np.dtype) -> ArraySymbol:
    """Return a new array of undefined elements."""
    size = dtype.itemsize
    for length in shape:
        size = combine("multiply", size, length)
    graph.has_allocations = True
    (address,) = graph.append(
        "allocate", (convert(graph, size, Kind.INTEGER).number,), (Kind.ARRAY,)
    )
    return ArraySymbol(address, 0, dtype, shape, contiguous_strides(shape, dtype.itemsize))


def get_item(array: ArraySymbol, index: Any) -> Any:
    """Return an element, a record, or a view of some elements."""
    part = locate(array, index)
    if part.shape:
        return part
    if part.dtype.names:
        return RecordSymbol(part.address, part.offset, part.dtype)
    return read(part.address, part.offset, part.dtype)


def set_item(array: ArraySymbol, index: Any, value: Any) -> None:
    """Store a number, or the elements of an array or a tuple, in an element or in a view."""
    assign(locate(array, index), value)


def assign(part: ArraySymbol, value: Any) -> None:
    """Store a number in every element, or the elements of an array of the same shape."""
    if not part.shape:
        write(part.address, part.offset, part.dtype, value)
        return
    if isinstance(value, tuple):
        for i, x in enumerate(value):
            set_item(part, i, x)
        return

    def store(i: Any) -> None:
        set_item(part, i, get_item(value, i) if isinstance(value, ArraySymbol) else value)

    for_each(part.graph, part.shape[0], store)


def for_each(graph: Graph, count: Any, body: Any) -> None:
    """Run body(i) for i = 0 .. count - 1, as a loop."""
    first = graph.constant(0, Kind.INTEGER)

    def proceed(i: Value) -> tuple[Value]:
        return (combine("less", i, count),)

    def turn(i: Value) -> tuple[Value]:
        body(i)
        return (combine("add", i, 1),)

    blocks = graph.trace_block(proceed, (Kind.INTEGER,)), graph.trace_block(turn, (Kind.INTEGER,))
    graph.append("loop", (first.number,), (Kind.INTEGER,), blocks)


def locate(array: ArraySymbol, index: Any) -> ArraySymbol:
    """Return the view of an array at an index, a slice or a tuple of them; no shape: an element."""
    indices = index if isinstance(index, tuple) else (index,)
    if len(indices) > len(array.shape):
        raise TraceError(f"{len(indices)} indices of an array with {len(array.shape)}")
    total, shape, strides = 0, [], []
    for i, length, stride in zip(indices, array.shape, array.strides, strict=False):
        if isinstance(i, slice):
            first, count, step = _elements_of(i, length)
            shape.append(count)
            strides.append(combine("multiply", stride, step))
        else:
            first = from_start(i, length)
        total = combine("add", total, combine("multiply", first, stride))
    rest = len(indices)
    address, offset = _move(array, total)
    return replace(
        array,
        address=address,
        offset=offset,
        shape=(*shape, *array.shape[rest:]),
        strides=(*strides, *array.strides[rest:]),
    )


def _elements_of(part: slice, length: Any) -> tuple[Any, Any, int]:
    """Return (first index, number of elements, step) of a slice, cut to the array as in Python.

    One whose bounds are known lies in an array whose length is not, so its number of elements is
    known as well.
    """
    step = 1 if part.step is None else part.step
    bounds = part.start, part.stop
    if isinstance(step, Value):
        raise TraceError("a slice whose step is not known")
    if not any(isinstance(x, Value) for x in (*bounds, length)):
        known = range(length)[part]
        return known.start if len(known) else 0, len(known), step
    start = 0 if part.start is None else part.start
    if step == 1 and all(isinstance(x, int) and x >= 0 for x in (start, part.stop)):
        return start, max(part.stop - start, 0), 1
    first, last = _cut_bounds(bounds, length, step)
    return first, _count(first, last, step), step


def _cut_bounds(bounds: tuple[Any, Any], length: Any, step: int) -> tuple[Any, Any]:
    low, high = (0, length) if step > 0 else (-1, combine("subtract", length, 1))
    ends = (low, high) if step > 0 else (high, low)
    return tuple(end if x is None else largest(smallest(from_start(x, length), high), low)
                 for x, end in zip(bounds, ends, strict=True))  # type: ignore[return-value]  # fmt: skip


def _count(first: Any, last: Any, step: int) -> Any:
    span = combine("subtract", last, first) if step > 0 else combine("subtract", first, last)
    if abs(step) > 1:
        span = combine("floor_divide", combine("add", span, abs(step) - 1), abs(step))
    count = largest(span, 0)
    if isinstance(count, Value):
        count.graph.least[count.number] = 0
    return count


def from_start(i: Any, length: Any) -> Any:
    """Return an index from the start: a negative one counts from the end.

    Raises:
        TraceError: it is no integer.
    """
    if isinstance(i, Value):
        i = convert(i.graph, i, Kind.INTEGER) if i.kind is Kind.BOOLEAN else i
        if i.kind is Kind.REAL:
            raise TraceError("an index that is a real")
        return (
            i
            if is_natural(i) or i.kind is Kind.WORD
            else choose(combine("less", i, 0), combine("add", i, length), i)
        )
    if not hasattr(i, "__index__"):
        raise TraceError(f"{i!r} as an index is not traced")
    return combine("add", length, i) if i < 0 else int(i)


def _move(array: ArraySymbol, distance: Any) -> tuple[Value, int]:
    if not isinstance(distance, Value):
        return array.address, array.offset + distance
    arguments = array.address.number, distance.number
    return array.graph.append("move", arguments, (Kind.ARRAY,), 0)[0], array.offset


def read(address: Value, offset: int, dtype: np.dtype) -> Value:
    """Return the number at an offset [bytes] from an address."""
    code = code_of(dtype)
    return address.graph.append("read", (address.number,), (_KINDS[code],), (offset, code))[0]


def write(address: Value, offset: int, dtype: np.dtype, number: Any) -> None:
    """Store a number at an offset [bytes] from an address."""
    code, graph = code_of(dtype), address.graph
    value = convert(graph, number, _KINDS[code])
    graph.append("write", (value.number, address.number), (), (offset, code))


def size_of(array: ArraySymbol) -> Any:
    """Return the number of elements."""
    size: Any = 1
    for length in array.shape:
        size = combine("multiply", size, length)
    return size


def get_field(owner: ArraySymbol | RecordSymbol, name: str) -> Any:
    """Return a field of a record, or the array of that field of all records."""
    dtype, offset = _field(owner, name)
    if isinstance(owner, RecordSymbol):
        return read(owner.address, owner.offset + offset, dtype)
    return replace(owner, offset=owner.offset + offset, dtype=dtype)


def set_field(owner: ArraySymbol | RecordSymbol, name: str, value: Any) -> None:
    """Store a number in a field of a record, or elements in that of all records."""
    if isinstance(owner, ArraySymbol):
        assign(get_field(owner, name), value)
        return
    dtype, offset = _field(owner, name)
    write(owner.address, owner.offset + offset, dtype, value)


def _field(owner: ArraySymbol | RecordSymbol, name: str) -> tuple[np.dtype, int]:
    fields: Any = owner.dtype.fields
    if fields is None or name not in fields:
        raise TraceError(f"a record has no field {name}")
    return fields[name][0], fields[name][1]


def copy_of(array: ArraySymbol) -> ArraySymbol:
    """Return a new array with the same elements."""
    copy = allocate(array.graph, array.shape, array.dtype)
    assign(copy, array)
    return copy


def elementwise(function: Any, *operands: Any) -> ArraySymbol:
    """Return the new array of a function of arrays' elements, and of numbers, the same for each."""
    model = next(x for x in operands if isinstance(x, ArraySymbol))
    out = allocate(model.graph, model.shape, np.dtype("f8"))

    def fill(to: ArraySymbol, parts: tuple[Any, ...]) -> None:
        def turn(i: Any) -> None:
            inner = tuple(get_item(x, i) if isinstance(x, ArraySymbol) else x for x in parts)
            if len(to.shape) == 1:
                set_item(to, i, function(*inner))
            else:
                fill(get_item(to, i), inner)

        for_each(to.graph, to.shape[0], turn)

    fill(out, operands)
    return out


def extreme(array: ArraySymbol, name: str) -> Value:
    """Return the smallest ("min") or largest element of an array (n,), nan where it has one."""
    better = "less" if name == "min" else "greater"

    def turn(best: Any, x: Any) -> Any:
        return choose(
            combine("either", combine(better, x, best), combine("unequal", x, x)), x, best
        )

    return _reduce(array, turn, get_item(array, 0))


def total(array: ArraySymbol) -> Value:
    """Return the sum of the elements of an array (n,), from the first on."""
    return _reduce(array, lambda sum_, x: combine("add", sum_, x), array.graph.constant(0.0))


def _reduce(array: ArraySymbol, function: Any, start: Value) -> Value:
    slot = array.graph.new_slot(1)
    write(slot, 0, array.dtype, start)

    def turn(i: Any) -> None:
        write(slot, 0, array.dtype, function(read(slot, 0, array.dtype), get_item(array, i)))

    for_each(array.graph, array.shape[0], turn)
    return read(slot, 0, array.dtype)
