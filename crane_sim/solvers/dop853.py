"""A step of Dormand and Prince's method of order 8, with the error that orders 5 and 3 estimate."""

from typing import Any

from crane_sim.solvers.dop853_tableau import E3, E5, A, B, C
from crane_sim.tracing.function import Function, trace
from crane_sim.tracing.graph import Kind
from crane_sim.tracing.operations import branch, fma, from_element, maximum, sqrt

ORDER, STAGES = 8, 12
ROWS = STAGES + 2
"""Rows (ROWS, n) of a step's work array: the stages' derivatives, the state at a stage, and the driver's new state."""
STEP_KINDS = (
    *(Kind.ARRAY, Kind.REAL, Kind.ARRAY, Kind.ARRAY),  # p, t, x, u
    *(Kind.REAL, Kind.ARRAY, Kind.REAL, Kind.REAL, Kind.ARRAY),  # h, y, rtol, atol, rows
)


def trace_step(derivative: Function, n: int) -> Function:
    """Return the function step(p, t, x, u, h, y, rtol, atol, rows) of equations with a state (n,).

    It writes the state one step of size h [s] after (t, x) into y and returns the step's error relative to the
    tolerance atol + rtol max(|x|, |y|), as DOP853 does. The first row has the derivative at (t, x).
    """

    def step(p: Any, t: Any, x: Any, u: Any, h: Any, y: Any, rtol: Any, atol: Any, rows: Any) -> Any:
        state = from_element(rows, STAGES * n)
        for stage, (row, node) in enumerate(zip(A, C, strict=True), 1):
            for i in range(n):
                state[i] = x[i] + _combine(h, row, rows, n, i)
            derivative(p, t + node * h, state, u, from_element(rows, stage * n))
        fifth = third = 0.0
        for i in range(n):
            y[i] = x[i] + _combine(h, B, rows, n, i)
            tolerance = atol + rtol * maximum(abs(x[i]), abs(y[i]))
            fifth = fifth + _square(_combine(h, E5, rows, n, i) / tolerance)
            third = third + _square(_combine(h, E3, rows, n, i) / tolerance)
        return branch(fifth == 0.0, lambda: 0.0, lambda: fifth / sqrt((fifth + 0.01 * third) * n))

    return trace(step, STEP_KINDS, "step")


def _combine(h: Any, row: tuple[float | None, ...], rows: Any, n: int, i: int) -> Any:
    """Return the sum of h row[j] k_j of component i, from left to right."""
    terms = [(h * weight, rows[j * n + i]) for j, weight in enumerate(row) if weight is not None]
    total = terms[0][0] * terms[0][1]
    for factor, slope in terms[1:]:
        total = fma(factor, slope, total)
    return total


def _square(x: Any) -> Any:
    return x * x
