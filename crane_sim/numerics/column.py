"""A number of many cranes in place of a float: Python code that makes one crane makes all of them.

Arithmetic is that of floats, entry by entry and in the same order, so every crane has the bits that it has alone. A
comparison has one answer, that of the first crane; cranes that would have answered otherwise are marked, and are to be
made one by one. What takes no columns, such as `float` or a text, raises NotVectorisable.
"""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim.tracing.trees import rebuilt

Array = npt.NDArray[Any]


class NotVectorisable(TypeError):
    """Code takes one crane's number only, and met a column, or a scene is of a kind whose code takes none."""


def _refuse(name: str) -> Callable[..., Any]:
    """Return a method that no column has."""

    def refused(self: "Column", *_: Any) -> Any:
        raise NotVectorisable(f"{name} takes one number, not a column")

    return refused


class Column:
    """A number, or an array of numbers, of each of n cranes."""

    __slots__ = ("covered", "values")
    __hash__: Any = _refuse("hash")
    __float__, __int__, __index__, __round__ = map(_refuse, ("float", "int", "an index", "round"))
    __str__, __format__ = _refuse("a text"), _refuse("a text")
    # no __getitem__: numpy would take a column for a sequence
    __len__, __iter__, __contains__ = map(_refuse, ("len", "an iteration", "in"))
    __pow__, __rpow__, __mod__, __rmod__, __floordiv__, __rfloordiv__ = map(_refuse, ("**", "**", "%", "%", "//", "//"))
    __matmul__, __rmatmul__, __divmod__, __rdivmod__ = map(_refuse, ("@", "@", "divmod", "divmod"))
    sin, cos, tan, arctan, arcsin, arccos, exp, log = map(
        _refuse, ("sin", "cos", "tan", "arctan", "arcsin", "arccos", "exp", "log")
    )  # what functions of numpy call: compiled code and numpy have other last digits, so that columns have none
    arctan2, hypot, degrees, radians = map(_refuse, ("arctan2", "hypot", "degrees", "radians"))

    def __init__(self, values: Array, covered: npt.NDArray[np.bool_]) -> None:
        """Take the values (n, ...), and the marks (n,) that all columns of these cranes share: which they cover."""
        self.values, self.covered = values, covered

    def _with(self, values: Array) -> "Column":
        return Column(values, self.covered)

    def _combine(self, function: Callable[..., Array], *numbers: Any) -> Any:
        if not all(isinstance(number, Column | float | int) for number in numbers):
            return NotImplemented  # an array takes the column entry by entry, each of them for all cranes
        parts = [number.values if isinstance(number, Column) else number for number in numbers]
        with np.errstate(all="ignore"):
            return self._with(function(*parts))

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        """Apply a function of numpy entry by entry, each of them for all cranes: by what columns have of its operation.

        Raises:
            NotVectorisable: they do not have it.
        """
        entries = [_as_entry(number) if isinstance(number, Column) else number for number in inputs]
        try:
            return getattr(ufunc, method)(*entries, **options)
        except NotVectorisable:
            raise
        except (AttributeError, TypeError, ValueError) as error:
            raise NotVectorisable(f"{ufunc.__name__} takes numbers, not a column") from error

    def _answer(self, function: Callable[..., Array], other: Any) -> bool:
        """Return the answer of the first crane that is covered, and unmark those that answer otherwise."""
        if not isinstance(other, Column | float | int):
            raise NotVectorisable(f"a column is compared with {type(other).__name__}")
        other = other.values if isinstance(other, Column) else other
        answers = np.broadcast_to(function(self.values, other), self.covered.shape)
        answer = bool(answers[np.argmax(self.covered)])
        self.covered &= answers == answer
        return answer

    def __add__(self, other: Any) -> Any:
        return self._combine(operator.add, self, other)

    def __radd__(self, other: Any) -> Any:
        return self._combine(operator.add, other, self)

    def __sub__(self, other: Any) -> Any:
        return self._combine(operator.sub, self, other)

    def __rsub__(self, other: Any) -> Any:
        return self._combine(operator.sub, other, self)

    def __mul__(self, other: Any) -> Any:
        return self._combine(operator.mul, self, other)

    def __rmul__(self, other: Any) -> Any:
        return self._combine(operator.mul, other, self)

    def __truediv__(self, other: Any) -> Any:
        """Return the quotient; where floats would raise ZeroDivisionError, cranes are unmarked."""
        if isinstance(other, Column | float | int):
            self.covered &= (other.values if isinstance(other, Column) else np.float64(other)) != 0.0
        return self._combine(operator.truediv, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        if isinstance(other, Column | float | int):
            self.covered &= self.values != 0.0
        return self._combine(operator.truediv, other, self)

    def __pos__(self) -> "Column":
        return self

    def __neg__(self) -> "Column":
        return self._with(-self.values)

    def __abs__(self) -> "Column":
        return self._with(np.abs(self.values))

    def sqrt(self) -> "Column":
        """Return the square roots: what `numpy.sqrt` calls."""
        self.covered &= self.values >= 0.0
        with np.errstate(all="ignore"):
            return self._with(np.sqrt(self.values))

    def __bool__(self) -> bool:
        return self._answer(operator.ne, 0.0)

    def __eq__(self, other: object) -> Any:
        return self._answer(operator.eq, other)

    def __ne__(self, other: object) -> Any:
        return self._answer(operator.ne, other)

    def __lt__(self, other: Any) -> bool:
        return self._answer(operator.lt, other)

    def __le__(self, other: Any) -> bool:
        return self._answer(operator.le, other)

    def __gt__(self, other: Any) -> bool:
        return self._answer(operator.gt, other)

    def __ge__(self, other: Any) -> bool:
        return self._answer(operator.ge, other)


def _as_entry(column: Column) -> Array:
    """Return a column as the only entry of an array () of objects."""
    entry = np.empty((), object)
    entry[()] = column
    return entry


def as_float(number: Any) -> Any:
    """Return a number as a float, a column as it is."""
    return number if isinstance(number, Column) else float(number)


def arrays_of(tree: Any, n: int) -> Any:
    """Return a tree of NamedTuples with an array (n, ...) in place of each number, column and array."""
    if tree is None:
        return None
    if isinstance(tree, Column):
        return np.ascontiguousarray(tree.values)
    if isinstance(tree, tuple):
        return rebuilt(tree, [arrays_of(part, n) for part in tree])
    if isinstance(tree, np.ndarray) and tree.dtype == object:
        entries = [arrays_of(entry, n) for entry in tree.flat]
        return np.stack(entries, axis=1).reshape(n, *tree.shape).astype(np.float64)
    array = np.asanyarray(tree)
    return np.repeat(array[None], n, axis=0).view(type(array))


def entry_of(tree: Any, i: int) -> Any:
    """Return a tree with what crane i has in place of each column; all else is as it is."""
    if isinstance(tree, Column):
        entry = tree.values[i]
        return entry.item() if entry.ndim == 0 else entry
    if isinstance(tree, tuple):
        return rebuilt(tree, [entry_of(part, i) for part in tree])
    if isinstance(tree, np.ndarray) and tree.dtype == object:
        return np.array([entry_of(entry, i) for entry in tree.flat], np.float64).reshape(tree.shape)
    return tree
