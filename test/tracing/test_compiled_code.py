"""Code from traced functions: machine code, lanes and C have the bits of the Python function that was traced."""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from traced_program import INPUTS, OUTPUTS, PROGRAM, program

from crane_sim.tracing.c_source import c_source
from crane_sim.tracing.function import Function, call_address, trace
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.llvm import module_text
from crane_sim.tracing.machine_code import Library
from crane_sim.tracing.operations import branch, power, repeat, repeat_while, to_real
from crane_sim.tracing.trace_error import TraceError

LANES = 4


def _multiply(x: Any, factor: Any) -> None:
    x[0] = x[0] * factor


MULTIPLY = trace(_multiply, (Kind.ARRAY, Kind.REAL), "multiply_first")


def inputs(count: int) -> np.ndarray:
    """Return rows of inputs of sizes from 0.1 to 100."""
    rng = np.random.default_rng(7)
    return rng.standard_normal((count, INPUTS)) * 10.0 ** rng.integers(-1, 3, (count, 1))


def outputs_of(function: Any, x: np.ndarray) -> np.ndarray:
    """Return what a compiled function writes."""
    out = np.zeros(OUTPUTS)
    function(x.ctypes.data, out.ctypes.data)
    return out


def computed(x: np.ndarray) -> np.ndarray:
    """Return what the Python function computes."""
    out = np.zeros(OUTPUTS)
    program(x.tolist(), out)
    return out


def test_machine_code_has_the_bits_of_python() -> None:
    """Branches, loops, calls, selections and functions: every output has the bits of the traced Python function."""
    library = Library(PROGRAM)
    for x in inputs(500):
        assert outputs_of(library.function(PROGRAM), x).tobytes() == computed(x).tobytes()


def test_lanes_have_the_bits_of_one() -> None:
    """Each lane, with branches and loops of its own length, has the bits of a single evaluation."""
    library = Library(PROGRAM, width=LANES)
    for x in inputs(400).reshape(-1, LANES, INPUTS):
        lanes, out = np.ascontiguousarray(x.T), np.zeros((OUTPUTS, LANES))
        library.function(PROGRAM)(lanes.ctypes.data, out.ctypes.data)
        assert out.T.tobytes() == np.array([computed(row) for row in x]).tobytes()


def c_function(function: Function, folder: Path) -> Any:
    """Return a function compiled from its C source."""
    (folder / "source.c").write_text(c_source(function))
    warnings = ["-std=c99", "-D_GNU_SOURCE", "-Wall", "-Wno-unused-variable", "-Werror"]
    bits = ["-ffp-contract=off", "-fno-builtin-pow"]
    command = ["cc", "-O2", *warnings, *bits, "-shared", "-fPIC", "source.c", "-o", "source.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True, timeout=100)
    return getattr(ctypes.CDLL(str(folder / "source.so")), function.name)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_c_source_has_the_bits_of_python(tmp_path: Path) -> None:
    """The C source compiles without a warning, by the C standard and beside GNU's names, and has the same bits."""
    function = c_function(PROGRAM, tmp_path)
    function.argtypes, function.restype = [ctypes.c_void_p] * 2, None
    for x in inputs(100):
        assert outputs_of(function, x).tobytes() == computed(x).tobytes()


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_squares_in_c_are_those_of_the_c_library(tmp_path: Path) -> None:
    """As in machine code, a known exponent changes no bit."""
    f = trace(lambda x: power(x, 2.0), (Kind.REAL,), "f")
    compiled = c_function(f, tmp_path)
    compiled.argtypes, compiled.restype = [ctypes.c_double], ctypes.c_double
    assert all(compiled(x) == f(x) for x in np.random.default_rng(1).uniform(0.1, 10.0, 20000).tolist())


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_c_calls_a_function_at_an_address(tmp_path: Path) -> None:
    """A function that is given by its address gets reals and arrays and returns a real; one returns nothing."""

    def apply(change: Any, measure: Any, x: Any) -> Any:
        call_address(change, (x, 3.0))
        return call_address(measure, (x[0], 2), (Kind.REAL,))

    compiled = c_function(trace(apply, (Kind.FUNCTION, Kind.FUNCTION, Kind.ARRAY), "apply"), tmp_path)
    compiled.restype = ctypes.c_double
    measure = trace(lambda x, n: x * to_real(n) + 1.0, (Kind.REAL, Kind.INTEGER), "measure")
    library, x = Library(MULTIPLY, measure), np.array([5.0])
    addresses = [ctypes.c_void_p(library.address(f)) for f in (MULTIPLY, measure)]
    assert compiled(*addresses, ctypes.c_void_p(x.ctypes.data)) == 31.0


def test_a_loop_over_elements_reads_computed_indices() -> None:
    """A loop whose length is an argument sums an array, and indices may be computed."""

    def total(x: Any, n: Any) -> Any:
        return repeat(n, lambda i, s: s + x[i], 0.0)

    f = trace(total, (Kind.ARRAY, Kind.INTEGER), "total")
    x = np.arange(10.0)
    assert Library(f).function(f)(x.ctypes.data, 10) == 45.0 == total(x.tolist(), 10)


@pytest.mark.parametrize(
    ("function", "kinds"),
    [
        (lambda x, n: repeat(n, lambda i, s: s + x[i], 0.0), (Kind.ARRAY, Kind.INTEGER)),
        (lambda x: x * 2.0, (Kind.REAL,)),
        (lambda x: branch(x[0] > 0.0, lambda: x.__setitem__(0, 1.0), lambda: None), (Kind.ARRAY,)),
        (lambda x: branch(x[0] > 0.0, lambda: MULTIPLY(x, 2.0), lambda: None), (Kind.ARRAY,)),
        (
            lambda x: branch(
                x[0] > 0.0, lambda: branch(x[0] > 1.0, lambda: MULTIPLY(x, 2.0), lambda: None), lambda: None
            ),
            (Kind.ARRAY,),
        ),
        (lambda f, t: call_address(f, (t,)), (Kind.FUNCTION, Kind.REAL)),
    ],
)
def test_what_lanes_cannot_do_is_refused(function: Any, kinds: tuple[Kind, ...]) -> None:
    """An index that differs between lanes, a result outside memory, a store of some lanes: an error, no wrong code."""
    with pytest.raises(TraceError):
        module_text(trace(function, kinds, "f"), width=LANES)


def test_lanes_call_what_is_called_from_outside_too() -> None:
    """A function with a number among its arguments can be called from outside and from another one."""
    f = trace(lambda x, a: MULTIPLY(x, a * x[0]), (Kind.ARRAY, Kind.REAL), "f")
    library, x = Library(MULTIPLY, f, width=LANES), np.arange(1.0, 1.0 + LANES)
    library.function(f)(x.ctypes.data, 2.0)
    library.function(MULTIPLY)(x.ctypes.data, 0.5)
    assert x.tolist() == [1.0, 4.0, 9.0, 16.0]


def halvings(x: Any) -> Any:
    """Return how often x, positive, is halved until it is below 1; without an end for a negative one."""
    return repeat_while(lambda s: abs(s[0] - 0.5) >= 0.5, lambda s: (s[0] * 0.5, s[1] + 1.0), (x, 0.0))[1]


def test_a_loop_on_a_side_that_is_not_taken_ends() -> None:
    """In lanes, a loop that would not end for a lane that takes the other side of a branch ends, in a call, too."""
    callee = trace(halvings, (Kind.REAL,), "halvings")
    for loop in (halvings, callee):
        f = trace(
            lambda x, loop=loop: x.__setitem__(0, branch(x[0] > 0.0, lambda: loop(x[0]), lambda: -1.0)),
            (Kind.ARRAY,),
            "f",
        )
        x = np.array([-3.0, 0.5, 1.5, 4.5])
        Library(f, width=LANES).function(f)(x.ctypes.data)
        assert x.tolist() == [-1.0, 0.0, 1.0, 3.0]


def test_the_text_of_lanes_is_always_the_same() -> None:
    """Text that is written twice is equal, so that its code is found again."""
    assert module_text(PROGRAM, width=LANES) == module_text(PROGRAM, width=LANES)


def test_a_condition_is_returned() -> None:
    """A condition as result or argument is 0 or 1 for its caller."""
    f = trace(lambda i, c: ((i & 1) == 1) & c, (Kind.INTEGER, Kind.BOOLEAN), "f")
    g = trace(lambda i: (i & 1) == 1, (Kind.INTEGER,), "g")
    library = Library(f, g)
    assert [library.function(f)(i, c) for i in (2, 3) for c in (False, True)] == [False, False, False, True]
    assert [library.function(g)(i) for i in (1, 2, 3, 4)] == [True, False, True, False]


def test_powers_are_those_of_the_c_library() -> None:
    """A known exponent or base changes no bit: of 20 000 squares, some 20 of the C library's are not x x."""
    functions = (lambda x: power(x, 2.0)), (lambda x: power(x, -1.0)), (lambda x: power(2.0, x))
    for function in functions:
        f = trace(function, (Kind.REAL,), "f")
        compiled = Library(f).function(f)
        assert all(compiled(x) == function(x) for x in np.random.default_rng(1).uniform(0.1, 10.0, 20000).tolist())


def test_functions_that_code_could_not_tell_apart_are_refused() -> None:
    """Two functions of one name, a name that is none and several results of a call from outside: errors."""
    first, second = (trace(lambda x, k=k: x * k, (Kind.REAL,), "g") for k in (2.0, 3.0))
    with pytest.raises(TraceError, match="two functions are called g"):
        Library(trace(lambda x: first(x) + second(x), (Kind.REAL,), "f"))
    with pytest.raises(TraceError, match="is no name"):
        trace(lambda x: x, (Kind.REAL,))
    with pytest.raises(TraceError, match="returns several numbers"):
        Library(trace(lambda x: (x, x), (Kind.REAL,), "f"))
