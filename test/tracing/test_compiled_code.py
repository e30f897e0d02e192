"""Code from traced functions: machine code, lanes and C have the bits of the Python function that was traced."""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from traced_program import INPUTS, OUTPUTS, PROGRAM, program

from crane_sim.tracing import machine_code
from crane_sim.tracing.c_source import c_source
from crane_sim.tracing.function import trace
from crane_sim.tracing.graph import Kind, TraceError
from crane_sim.tracing.llvm import module_text
from crane_sim.tracing.machine_code import Library, compile_text, read_code, write_code
from crane_sim.tracing.operations import branch, repeat

LANES = 4


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


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_c_source_has_the_bits_of_python(tmp_path: Path) -> None:
    """The C source compiles without a warning, by the C standard, and its outputs have the same bits."""
    (tmp_path / "program.c").write_text(c_source(PROGRAM))
    flags = ["-std=c99", "-O2", "-Wall", "-Wno-unused-variable", "-Werror", "-ffp-contract=off", "-shared", "-fPIC"]
    command = ["cc", *flags, "program.c", "-o", "program.so", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True, timeout=100)
    function = ctypes.CDLL(str(tmp_path / "program.so")).program
    function.argtypes, function.restype = [ctypes.c_void_p] * 2, None
    for x in inputs(100):
        assert outputs_of(function, x).tobytes() == computed(x).tobytes()


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
    ],
)
def test_what_lanes_cannot_do_is_refused(function: Any, kinds: tuple[Kind, ...]) -> None:
    """An index that differs between lanes, a result outside memory, a store of some lanes: an error, no wrong code."""
    with pytest.raises(TraceError):
        module_text(trace(function, kinds, "f"), width=LANES)


def test_compiled_code_is_read_from_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A second library of the same functions compiles nothing."""
    Library(PROGRAM, folder=tmp_path)
    monkeypatch.setattr(machine_code, "compile_text", None)
    x = inputs(1)[0]
    assert outputs_of(Library(PROGRAM, folder=tmp_path).function(PROGRAM), x).tobytes() == computed(x).tobytes()


@pytest.mark.parametrize(
    "damage", [lambda code: b"", lambda code: code[:-9], lambda code: code[:50] + b"?" + code[51:]]
)
def test_a_damaged_file_costs_a_compilation(tmp_path: Path, damage: Any) -> None:
    """An empty, a cut and a changed file are as none, and are replaced."""
    text = module_text(PROGRAM)
    code = compile_text(text)
    write_code(tmp_path, text, code)
    (file,) = tmp_path.iterdir()
    file.write_bytes(damage(file.read_bytes()))
    assert read_code(tmp_path, text) is None
    Library(PROGRAM, folder=tmp_path)
    assert read_code(tmp_path, text) is not None


def test_a_folder_that_cannot_be_written_costs_nothing_else(tmp_path: Path) -> None:
    """Where there can be no folder, code is compiled and used."""
    (tmp_path / "file").write_text("")
    assert Library(PROGRAM, folder=tmp_path / "file" / "folder").address(PROGRAM)
    assert list(tmp_path.iterdir()) == [tmp_path / "file"]
