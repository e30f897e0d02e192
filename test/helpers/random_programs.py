"""Random small programs of the traced part of Python, and comparisons of results bit for bit."""

import importlib.util
import math
import random
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from crane_sim.tracing.entry_point import EntryPoint, compile_entry

_HEAD = "from math import copysign, fabs, sqrt\n\nTABLE = (0.5, -1.5, 3.0)\n"
_DEPTH = 3  # of expressions
_NUMBERS = (0.0, -0.0, 1.0, -2.5, 1e-300, 1e300, math.inf, -math.inf, math.nan)


class Program:
    """Writes a function of reals x, y, integers i, j, arrays a (5,), m (3, 2) and k (4,).

    a and m are of reals, k of integers.

    Integers stay small, so none leaves 64 bits; every variable has a value from the beginning on.
    """

    def __init__(self, seed: int) -> None:
        """Write the program of a seed."""
        self._random = random.Random(seed)
        self._lines: list[str] = []
        self._loops = 0  # around the statement that is written
        self._counters = 0
        self._arrays, self._helper = False, ""
        self._function(f"helper_{seed}", "x, y, i, j", f"{self._real(2)}", 1, 2)
        self._arrays, self._helper = True, f"helper_{seed}"
        self._function(f"program_{seed}", "x, y, i, j, a, m, k", "", 1, self._random.randint(3, 7))
        self.text = "\n".join(self._lines)

    def _function(self, name: str, parameters: str, result: str, indent: int, count: int) -> None:
        self._result = result
        self._lines += ["", "", f"def {name}({parameters}):"]
        self._lines += ["    u, v = x, 1.5", "    n, p = j, 2", "    f = x < y"]
        self._block(indent, count, 3)
        self._return(indent)

    def _return(self, indent: int) -> None:
        self._write(
            indent,
            "return "
            + (self._result and self._real(2) or f"{self._real(2)}, {self._integer(2)}, f"),
        )

    def _write(self, indent: int, line: str) -> None:
        self._lines.append("    " * indent + line)

    def _pick(self, *choices: Callable[[], str]) -> str:
        return self._random.choice(choices)()

    # expressions

    def _real(self, depth: int = _DEPTH) -> str:
        d, choose = depth - 1, self._random.choice
        simple = [
            lambda: choose("xyuv"),
            lambda: choose("xyuv"),
            lambda: repr(choose((0.0, 0.5, 1.0, -2.0, 3.25, 1e9))),
            *([self._element] * self._arrays),
        ]
        if depth <= 0:
            return self._pick(*simple)
        return self._pick(
            *simple,
            lambda: f"({self._real(d)} {choose('+-*')} {self._real(d)})",
            lambda: f"({self._real(d)} {choose('+-*')} {self._integer(d)})",
            lambda: f"({self._real(d)} / (fabs({self._real(d)}) + 0.5))",
            lambda: f"({self._real(d)} {choose(('/', '//', '%'))} {self._real(d)})",
            lambda: f"({self._integer(d)} / {self._integer(d)})",
            lambda: f"(-{self._real(d)})",
            lambda: f"abs({self._real(d)})",
            lambda: f"{choose(('min', 'max'))}({self._real(d)}, {self._real(d)})",
            lambda: f"sqrt(abs({self._real(d)}))",
            lambda: f"float({self._integer(d)})",
            lambda: f"copysign({self._real(d)}, {self._integer(d)})",
            lambda: f"({self._real(d)} if {self._condition(d)} else {self._real(d)})",
            lambda: f"TABLE[{self._integer(d)} % 3]",
            lambda: f"abs({self._real(d)}) ** 1.5",
            self._call if self._helper else simple[0],
        )

    def _call(self) -> str:
        return (
            f"{self._helper}({self._real(0)}, {self._real(1)}, {self._integer(1)}, "
            f"{self._integer(0)})"
        )

    def _element(self) -> str:
        at = self._index
        return self._pick(lambda: f"a[{at(5)}]", lambda: f"m[{at(3)}, {at(2)}]", lambda: f"m[{at(3)}][{at(2)}]",  # noqa: E501
                          lambda: f"m[:, {at(2)}][{at(3)}]", lambda: f"a[1:4][{at(3)}]")  # fmt: skip  # noqa: E501

    def _index(self, length: int) -> str:
        return self._pick(
            lambda: str(self._random.randrange(-length, length)),
            lambda: f"{self._integer(1)} % {length}",
            lambda: f"{self._integer(1)} % {length} - {length}",
        )

    def _integer(self, depth: int = _DEPTH) -> str:
        d, choose = depth - 1, self._random.choice
        simple = [
            lambda: choose("ijnp"),
            lambda: choose("ijnp"),
            lambda: str(choose((0, 1, 2, 3, 7))),
        ]
        if self._arrays:
            simple += [lambda: f"k[{self._index(4)}]", lambda: choose(("len(a)", "m.shape[1]"))]
        if depth <= 0:
            return self._pick(*simple)
        return self._pick(
            *simple,
            lambda: f"({self._integer(d)} {choose('+-')} {self._integer(d)})",
            lambda: f"({self._integer(0)} * {self._integer(0)})",
            lambda: f"({self._integer(d)} {choose(('//', '%'))} {self._integer(d)})",
            lambda: f"({self._integer(d)} {choose(('//', '%'))} {choose((-3, 2, 5))})",
            lambda: f"({self._integer(d)} {choose('&|^')} {self._integer(d)})",
            lambda: f"({self._integer(d)} {choose(('>>', '<<'))} {self._random.randint(0, 3)})",
            lambda: f"({choose('-~')}{self._integer(d)})",
            lambda: f"abs({self._integer(d)})",
            lambda: f"{choose(('min', 'max'))}({self._integer(d)}, {self._integer(d)})",
            lambda: f"{choose(('int', 'round'))}(min(max({self._real(d)}, -99.5), 99.5))",
            lambda: f"({self._integer(d)} if {self._condition(d)} else {self._integer(d)})",
            lambda: f"int({self._condition(d)})",
        )

    def _condition(self, depth: int = _DEPTH) -> str:
        d, choose = depth - 1, self._random.choice
        compare = ("<", "<=", ">", ">=", "==", "!=")
        simple = [
            lambda: f"({self._real(d)} {choose(compare)} {self._real(d)})",
            lambda: f"({self._integer(d)} {choose(compare)} {self._integer(d)})",
            lambda: "f",
        ]
        if depth <= 0:
            return self._pick(*simple)
        i = choose("ijnp")
        guarded = [lambda: f"(0 <= {i} < len(a) and a[{i}] > {self._real(d)})",
                   lambda: f"({i} < 0 or {i} >= 5 or a[{i}] < {self._real(d)})"]  # fmt: skip
        return self._pick(
            *simple,
            lambda: (
                f"({self._integer(d)} {choose(compare)} {self._real(d)} {choose(compare)} "
                f"{self._real(d)})"
            ),
            lambda: f"({self._condition(d)} {choose(('and', 'or'))} {self._condition(d)})",
            lambda: f"(not {self._condition(d)})",
            *(guarded * self._arrays),
        )

    # statements

    def _block(self, indent: int, count: int, depth: int) -> None:
        for _ in range(count):
            self._statement(indent, depth)

    def _statement(self, indent: int, depth: int) -> None:
        choices = [self._assign] * 6
        if depth:
            choices += [lambda n: self._if(n, depth)] * 3 + [lambda n: self._loop(n, depth)] * 2
        self._random.choice(choices)(indent)

    def _assign(self, indent: int) -> None:
        choose = self._random.choice
        self._write(indent, self._pick(
            lambda: f"{choose('uvx')} = {self._real()}",
            lambda: f"{choose('uvx')} {choose('+-*')}= {self._real()}",
            lambda: f"{choose('npi')} = ({self._integer()}) % 99 - 33",
            lambda: f"{choose('np')} {choose(('//', '%', '&'))}= {choose((5, -7, 3))}",
            lambda: f"f = {self._condition()}",
            lambda: f"u, v = {self._real(2)}, {self._real(2)}",
            *([lambda: f"{self._element()} = {self._real()}",
               lambda: f"{self._element()} += {self._real(2)}",
               lambda: f"k[{self._index(4)}] = ({self._integer()}) % 50"] * self._arrays),
        ))  # fmt: skip

    def _if(self, indent: int, depth: int) -> None:
        self._write(indent, f"if {self._condition()}:")
        self._body(indent + 1, depth - 1)
        if self._random.random() < 0.4:
            self._write(indent, f"elif {self._condition(2)}:")
            self._body(indent + 1, depth - 1)
        if self._random.random() < 0.5:
            self._write(indent, "else:")
            self._body(indent + 1, depth - 1)

    def _body(self, indent: int, depth: int) -> None:
        self._block(indent, self._random.randint(1, 2), depth)
        exits = self._random.random()
        if exits < 0.2:
            self._return(indent)
        elif self._loops and exits < 0.45:
            self._write(indent, self._random.choice(("break", "continue")))

    def _loop(self, indent: int, depth: int) -> None:
        self._counters += 1
        counter = f"c{self._counters}"
        bound, step = f"{self._integer(1)} % 5", self._random.choice((1, 2, -1, -2))
        heads = [
            f"for {counter} in range({bound}):",
            f"for {counter} in range({self._random.randint(0, 4)}):",
            f"for {counter} in range({bound}, {self._integer(1)} % 7, {step}):",
            f"for {counter} in range({self._random.randint(60, 70)}, 0, "
            f"-{self._random.randint(9, 20)}):",
            *(["for u in a:"] * self._arrays),
            "for v in (x, 2.0, y):",
        ]
        self._loops += 1
        if self._random.random() < 0.25:
            self._write(indent, f"{counter} = 0")
            self._write(indent, f"while {counter} < 6 and {self._condition(2)}:")
            self._write(indent + 1, f"{counter} += 1")
        else:
            self._write(indent, self._random.choice(heads))
        self._body(indent + 1, depth - 1)
        self._loops -= 1


def write_programs(seeds: range, folder: Path) -> list[Any]:
    """Return the functions of some seeds, of a module that is written into a folder."""
    file = folder / f"programs_{seeds.start}.py"
    file.write_text(_HEAD + "".join(Program(seed).text for seed in seeds) + "\n")
    return [getattr(load(file), f"program_{seed}") for seed in seeds]


def load(file: Path) -> Any:
    """Return the module of a file."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def compiled(function: Any) -> Any:
    """Return a function as machine code that is kept nowhere."""
    entry = EntryPoint(function)
    entry._compile = lambda key: compile_entry(function, key)[0]  # type: ignore[method-assign]
    return entry


def arguments(seed: int) -> list[Any]:
    """Return arguments of a program: of usual sizes, and infinities, zeros and NaNs among them."""
    rng = np.random.default_rng(seed)

    def reals(*shape: int) -> np.ndarray:
        x = np.round(rng.normal(size=shape) * 4.0, 1)
        return np.where(rng.random(shape) < 0.1 * (seed % 3), rng.choice(_NUMBERS, shape), x)

    x, y = reals(2).tolist()
    i, j = rng.integers(-4, 8, 2).tolist()
    return [x, y, i, j, reals(5), reals(3, 2), rng.integers(0, 9, 4)]


def bits(tree: Any) -> Any:
    """Return a tree of numbers and arrays with bits in place of numbers; a NaN is a NaN."""
    if isinstance(tree, tuple | list):
        return tuple(bits(part) for part in tree)
    if isinstance(tree, np.ndarray):
        return tree.dtype.str, bits(tree.tolist())
    if isinstance(tree, np.generic):
        return bits(tree.item())
    if isinstance(tree, float):
        return "nan" if math.isnan(tree) else struct.pack("d", tree)
    return type(tree).__name__, tree


def run(function: Any, given: list[Any]) -> Any:
    """Return the bits of what a function returns and leaves in its arrays."""
    copies = [x.copy() if isinstance(x, np.ndarray) else x for x in given]
    result = function(*copies)
    return bits([result, [x for x in copies if isinstance(x, np.ndarray)]])
