"""Derivatives by forward mode against differences in 60 digits, of the same list of instructions."""

import operator
from typing import Any

import mpmath
import numpy as np
import pytest
from traced_program import INPUTS, OUTPUTS, PROGRAM, program

from crane_sim.tracing.derivatives import differentiate
from crane_sim.tracing.elementary import SINCOS
from crane_sim.tracing.evaluation import Location, Rules, evaluate
from crane_sim.tracing.function import trace
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.machine_code import Library
from crane_sim.tracing.operations import power, repeat_while, to_integer, to_real
from crane_sim.tracing.trace_error import TraceError

OPERATIONS = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "negate": operator.neg,
    "absolute": abs,
    "less": operator.lt,
    "less_equal": operator.le,
    "both": operator.and_,
    "sqrt": mpmath.sqrt,
    "exp": mpmath.exp,
    "power": mpmath.power,
    "fma": lambda a, b, c: a * b + c,
    "select": lambda condition, a, b: a if condition else b,
}
EXACT = Rules(mpmath.mpf, OPERATIONS, {SINCOS.name: lambda x: (mpmath.sin(x), mpmath.cos(x))})


def exact_outputs(x: list[Any]) -> list[Any]:
    """Return the program's outputs in the digits that mpmath works with."""
    out: dict[int, Any] = {}
    evaluate(PROGRAM, (Location(dict(enumerate(x))), Location(out)), EXACT)
    return [out[i] for i in range(OUTPUTS)]


def exact_jacobian(x: np.ndarray) -> np.ndarray:
    """Return the Jacobian by central differences: 60 digits, steps of 1e-20, so errors of 1e-40."""
    with mpmath.workdps(60):
        columns, step = [], mpmath.mpf(10) ** -20
        for j in range(INPUTS):
            ahead, behind = [mpmath.mpf(float(e)) for e in x], [mpmath.mpf(float(e)) for e in x]
            ahead[j], behind[j] = ahead[j] + step, behind[j] - step
            pairs = zip(exact_outputs(ahead), exact_outputs(behind), strict=True)
            columns.append([float((a - b) / (2 * step)) for a, b in pairs])
    return np.array(columns).T


def test_jacobian_equals_differences_in_sixty_digits() -> None:
    """The traced Jacobian is within 1e-11 of differences of the same list, whose loop ends at 1e-18 (1e-9 squared)."""
    jacobian = differentiate(PROGRAM, 0, INPUTS, 1, OUTPUTS)
    function = Library(jacobian).function(jacobian)
    for x in np.random.default_rng(3).uniform(-2.0, 2.0, (20, INPUTS)):
        out, matrix, expected = np.zeros(OUTPUTS), np.zeros((OUTPUTS, INPUTS)), np.zeros(OUTPUTS)
        function(x.ctypes.data, out.ctypes.data, matrix.ctypes.data)
        program(x.tolist(), expected)
        assert out.tobytes() == expected.tobytes()  # the values have the bits of the function itself
        exact = exact_jacobian(x)
        np.testing.assert_allclose(matrix, exact, rtol=1e-11, atol=1e-13)


@pytest.mark.parametrize(
    ("function", "gradient"),
    [
        (lambda x: to_real(to_integer(x[0] + 0.5) + 1) * x[1], (0.0, 3.0)),
        (lambda x: repeat_while(lambda s: s[1], lambda s: (s[0] * x[1], s[0] > 9.0), (x[0], True))[0], (0.7, 1.5)),
        (lambda x: to_real(repeat_while(lambda i: to_real(i) < x[0], lambda i: i + 1, 0)), (0.0, 0.0)),
        (lambda x: repeat_while(lambda s: s < x[0], lambda s: s + x[1], 0.25), (0.0, 2.0)),
    ],
)
def test_integers_and_conditions_have_no_derivatives(function: Any, gradient: Any) -> None:
    """At (1.5, 0.7), through integers, conditions that a loop keeps, and loops that begin with literals."""

    def program_of(x: Any, out: Any) -> tuple[()]:
        out[0] = function(x)
        return ()

    jacobian = differentiate(trace(program_of, (Kind.ARRAY, Kind.ARRAY), "f"), 0, 2, 1, 1)
    x, out, row = np.array([1.5, 0.7]), np.zeros(1), np.zeros(2)
    Library(jacobian).function(jacobian)(x.ctypes.data, out.ctypes.data, row.ctypes.data)
    assert row.tolist() == list(gradient)


def test_the_derivative_by_an_exponent_is_refused() -> None:
    """An exponent that the elements move is an error, and no derivative of 0."""
    f = trace(lambda x, out: out.__setitem__(0, power(x[0], x[1])), (Kind.ARRAY, Kind.ARRAY), "f")
    with pytest.raises(TraceError, match="exponent"):
        differentiate(f, 0, 2, 1, 1)


def test_directions_that_move_nothing_cost_nothing() -> None:
    """Of a linear function the Jacobian is stored as constants, without arithmetic."""

    def swap(x: Any, out: Any) -> tuple[()]:
        out[0], out[1] = x[1], -x[0]
        return ()

    f = trace(swap, (Kind.ARRAY, Kind.ARRAY), "swap")
    names = {i.operation for i in differentiate(f, 0, 2, 1, 2).block.instructions}
    assert names == {"constant", "load", "negate", "store"}
