"""Calls of machine code from Python: memory for arguments, kept where unchanged, and results.

A call's memory has the address of what the code allocates, then the leaves of the arguments, then
those of the result, eight bytes each.
"""

import ctypes
from itertools import compress
from operator import is_not
from typing import Any, NamedTuple

import numpy as np

from crane_sim.tracing.arguments import describe, kinds_of, struct_of
from crane_sim.tracing.graph import Kind
from crane_sim.tracing.machine_code import LoadedCode
from crane_sim.tracing.results import make_builder

FIRST = 8
"""Bytes before the arguments."""

_UNKNOWN = object()
_NOTHING = bytes(8)  # the address of no memory
_NUMBER_TYPES = {Kind.REAL: float, Kind.INTEGER: int}
_REALS = {float}


class Code(NamedTuple):
    """Machine code of an entry point for one structure of arguments."""

    object_file: bytes
    results: tuple[Kind, ...]  # of the numbers and addresses that it returns
    structure: Any  # of what it returns
    allocates: bool  # memory, which is released after the call


class LoadedEntry:
    """Code in memory, and how arguments and results are passed.

    Attributes:
        keys: structure of each argument.
    """

    def __init__(self, code: Code, keys: tuple[Any, ...]) -> None:
        """Load it."""
        self.keys, self.allocates = keys, code.allocates
        kinds = [kinds_of(key) for key in keys]
        self.pack = [struct_of(tuple(each)).pack_into for each in kinds]
        self.number_types = [
            _NUMBER_TYPES.get(key) if isinstance(key, Kind) else None for key in keys
        ]
        self.vector_sizes = [len(key) - 1 if _is_vector(key) else -1 for key in keys]
        self.places = [FIRST]
        for each in kinds:
            self.places.append(self.places[-1] + 8 * len(each))
        results = struct_of(code.results)
        self.unpack, self.size = results.unpack_from, self.places[-1] + results.size
        self.build = make_builder(code.structure)
        self._library = LoadedCode(code.object_file)
        prototype = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
        self.run: Any = prototype(self._library.address("run"))
        self.release: Any = prototype(self._library.address("release"))


class Call:
    """Memory of one call at a time, with the arguments of the call before."""

    def __init__(self, entry: LoadedEntry, limit: float) -> None:
        """Begin without arguments; those above `limit` bytes of arrays are not kept."""
        count = len(entry.keys)
        self.entry, self._limit, self._indices = entry, limit, range(count)
        self._memory = bytearray(entry.size)
        self._address = ctypes.addressof(ctypes.c_char.from_buffer(self._memory))
        self._arguments: list[Any] = [_UNKNOWN] * count
        # of arrays, which may be set
        self._shapes = {i: None for i, key in enumerate(entry.keys) if _is_array(key)}
        self._arrays: dict[int, dict[int, Any]] = {}  # of each argument, by address
        # arguments whose arrays would take much memory until the next call
        self._large: list[int] = []

    def take(self, arguments: tuple[Any, ...]) -> bool:
        """Take the arguments of a call; return whether their structure is that of the code.

        An object that is the one before has its structure and its numbers: tuples do not change,
        and arrays stay where they are.
        """
        for i in compress(self._indices, map(is_not, arguments, self._arguments)):
            if not self._take(i, arguments[i]):
                return False
        for i, shape in self._shapes.items():
            if arguments[i].shape != shape and not self._describe(i, arguments[i]):
                return False
        return True

    def _take(self, i: int, argument: Any) -> bool:
        entry, place, kind = self.entry, self.entry.places[i], type(argument)
        if kind is entry.number_types[i]:
            entry.pack[i](self._memory, place, argument)
        elif (
            kind is tuple
            and len(argument) == entry.vector_sizes[i]
            and {*map(type, argument)} == _REALS
        ):
            entry.pack[i](self._memory, place, *argument)
        else:
            return self._describe(i, argument)
        self._arguments[i] = argument
        return True

    def _describe(self, i: int, argument: Any) -> bool:
        leaves, arrays = list[Any](), dict[int, Any]()
        entry = self.entry
        if describe(argument, leaves, arrays) != entry.keys[i]:
            return False
        entry.pack[i](self._memory, entry.places[i], *leaves)
        if i in self._shapes:
            self._shapes[i] = argument.shape
        self._arguments[i] = argument
        if arrays or i in self._arrays:
            self._arrays[i] = arrays
            if sum([array.nbytes for array in arrays.values()]) > self._limit:
                self._large.append(i)
        return True

    def run(self) -> Any:
        """Return the result."""
        entry, memory = self.entry, self._memory
        entry.run(self._address)
        result = entry.build(entry.unpack(memory, entry.places[-1]), self._arrays)
        if entry.allocates and memory[:FIRST] != _NOTHING:
            entry.release(self._address)
        if self._large:
            self._forget_large_arrays()
        return result

    def _forget_large_arrays(self) -> None:
        for i in self._large:
            self._arguments[i], self._arrays[i] = _UNKNOWN, {}
        self._large.clear()


def _is_array(key: Any) -> bool:
    return isinstance(key, tuple) and key[0] is np.ndarray


def _is_vector(key: Any) -> bool:
    return isinstance(key, tuple) and key[0] is tuple and all(part is Kind.REAL for part in key[1:])
