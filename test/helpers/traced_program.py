"""A small program with everything that a traced function can do, and its compiled forms."""

from typing import Any

from crane_sim.tracing.elementary import sincos
from crane_sim.tracing.function import Function, trace
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.operations import branch, exp, fma, maximum, power, repeat_while, select, sign, sqrt

INPUTS, OUTPUTS = 3, 8


def _product_and_quotient(a: Any, b: Any) -> tuple[Any, Any]:
    return a * b + 1.0, a / b


CALLEE = trace(_product_and_quotient, (Kind.REAL, Kind.REAL), "product_and_quotient")


def cube_root(x: Any) -> Any:
    """Return the cube root of x > 0 by Newton's iteration, in a loop whose length depends on x."""

    def step(state: tuple[Any, Any]) -> tuple[Any, Any]:
        z, _ = state
        change = (z * z * z - x) / (3.0 * z * z)
        return z - change, change

    return repeat_while(lambda state: abs(state[1]) > 1e-9 * state[0], step, (x + 1.0, 1.0))[0]


def program(x: Any, out: Any) -> tuple[()]:
    """Write OUTPUTS numbers that are smooth functions of INPUTS numbers, but at switches."""
    s, c = sincos(x[0])
    out[0], out[1] = branch(s < c, lambda: (s * x[1], c), lambda: (sqrt(c * c + 1.0) + x[1], s))
    out[2] = cube_root(1.0 + x[2] * x[2])
    out[3], out[4] = CALLEE(out[2], c)
    out[5] = exp(s) * power(x[2] * x[2] + 1.0, 0.3) + maximum(s, c)
    out[6] = select((x[1] < x[2]) & (s <= c), (x[1], x[2]), (x[2] - x[1], -x[0]))[0] - abs(x[2])
    out[7] = fma(x[0], x[1], sign(x[2]) * out[5])
    return ()


PROGRAM: Function = trace(program, (Kind.ARRAY, Kind.ARRAY), "program")
