"""A Rosenbrock method of order 5 with error control by order 4, for stiff models whose state is an array.

It solves linear systems with the model's Jacobian (`system.linearised`) instead of iterating, is L-stable and stiffly
accurate. Coefficients: Rodas5P, G. Steinebach, "Construction of Rosenbrock-Wanner method Rodas5P and numerical
benchmarks within the Julia Differential Equations package", BIT Numerical Mathematics 63:27 (2023), in the form that
needs no product with the Jacobian (Hairer, Wanner, "Solving Ordinary Differential Equations II", eq. IV.7.25):
stage i solves (I / (γ h) - J) U_i = f(t + c_i h, x + Σ a_ij U_j) + Σ (C_ij / h) U_j + h d_i ∂f/∂t.
"""

from math import inf, isfinite, sqrt
from typing import NamedTuple

import numpy as np

from crane_sim.integrators.flow import NOT_FINITE, OK, STALLED, Flow, advance, horizon, stages, step
from crane_sim.integrators.runge_kutta import dense
from crane_sim.jit import routine
from crane_sim.quantities import NonNegative, Positive
from crane_sim.state_algebra import weighted_square
from crane_sim.system import factored, fill, linearised, project, solve_shifted

# fmt: off
GAMMA = 0.21193756319429014
_LAST = (-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946)
A = (
    (3.0,),
    (2.849394379747939, 0.45842242204463923),
    (-6.954028509809101, 2.489845061869568, -10.358996098473584),
    (2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641),
    _LAST,
    (*_LAST, 1.0),
    (*_LAST, 1.0, 1.0),
)
B = (*_LAST, 1.0, 1.0, 1.0)  # the last increment is also the error estimate
C = (
    (-14.155112264123755,),
    (-17.97296035885952, -2.859693295451294),
    (147.12150275711716, -1.41221402718213, 71.68940251302358),
    (165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306),
    (24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471),
    (30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
     -28.087943162872662),
    (37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
     -54.66780262877968, -9.48861652309627),
)
NODES = (0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0)
DRIFTS = (GAMMA, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734, 2.325825639765069, 0.0, 0.0, 0.0)
# fmt: on
ORDER, STAGES = 5, 8
_DENSE_A, _DENSE_C, _NODES, _DRIFTS = dense(A), dense(C), np.array(NODES), np.array(DRIFTS)
SAFETY, SHRINK, GROW = 0.9, 0.2, 6.0
"""Step control: h is scaled by SAFETY err^(-1/5), within these bounds."""
FIRST = 1e-6  # s, tried first; a few steps bring it to what the problem allows
AHEAD = 1e-4  # of a step: how far differences in time reach


class Rodas(NamedTuple):
    """Settings of the stiff method: a component's error is measured by atol + rtol |component|."""

    rtol: Positive = 1e-7
    atol: NonNegative = 1e-9


@routine
def opened(p, t, x, u, h):
    """Return (the derivative at (t, x), its partial derivative in time from there on), arrays like x."""
    now, soon, later = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    ahead = (t + AHEAD * h) - t
    fill(p, t, x, u, now)
    fill(p, t + ahead, x, u, soon)
    fill(p, t + 2.0 * ahead, x, u, later)
    for i in range(len(x)):
        soon[i] = (4.0 * (soon[i] - now[i]) - (later[i] - now[i])) / (2.0 * ahead)
    return now, soon


@routine
def fill_increments(ks, p, t, x, u, h, jacobian, opening):
    """Fill the rows of ks (stages, n) with the increments U_i of a step of size h; return the state that it reaches.

    Args:
        ks: to fill.
        p, t, x, u, h: of the step.
        jacobian: what `linearised` returns at (t, x).
        opening: what `opened` returns there.
    """
    factors, y = factored(p, jacobian, 1.0 / (GAMMA * h)), np.empty_like(x)
    for s in range(STAGES):
        for i in range(len(x)):
            y[i] = 0.0
        for j in range(s):
            for i in range(len(x)):
                y[i] += _DENSE_A[s, j] * ks[j, i]
        for i in range(len(x)):
            y[i] += x[i]
            ks[s, i] = opening[0][i]
        if s > 0:
            fill(p, t + _NODES[s] * h, y, u, ks[s])
        for j in range(s):
            weight = _DENSE_C[s, j] / h
            for i in range(len(x)):
                ks[s, i] += weight * ks[j, i]
        for i in range(len(x)):
            ks[s, i] += h * _DRIFTS[s] * opening[1][i]
        solve_shifted(p, factors, ks[s])
    for i in range(len(x)):
        y[i] += ks[STAGES - 1, i]
    return y


@advance.register(Rodas)
def _(method, p, u, flow, end):
    return accepted_step(method, p, u, flow, end)


@routine
def accepted_step(method, p, u, flow, end):
    """Return the flow one step further, tried again with smaller steps until its error is within the tolerance."""
    t, x, h, n, rejected = flow.t, flow.x, flow.h, flow.evaluations, flow.rejected
    h = FIRST if h == 0.0 else h
    jacobian, opening = linearised(p, t, x, u), opened(p, t, x, u, h)
    ks, y, reached, growth = np.empty((STAGES, len(x))), x, t, GROW
    status, n = STALLED if isfinite(h) else NOT_FINITE, n + 3
    while t + 0.1 * h > t:
        last = t + 1.000000001 * h >= end
        size = end - t if last else h
        y = fill_increments(ks, p, t, x, u, size, jacobian, opening)
        error, n = sqrt(weighted_square(ks[STAGES - 1], x, y, method.rtol, method.atol) / len(x)), n + STAGES - 1
        factor = min(growth, max(SHRINK, SAFETY * error ** (-1.0 / ORDER))) if error > 0.0 else growth
        if error <= 1.0:
            y, reached, status, h = project(p, y), end if last else t + size, OK, max(size * factor, h if last else 0.0)
            break
        h, growth, rejected = size * (factor if isfinite(error) else SHRINK), 1.0, rejected + 1
        status = STALLED if isfinite(error) else NOT_FINITE
    y = y if status == OK else x  # a step that failed leaves the state as it was
    return Flow(t, x, reached, y, h, n, flow.steps + (status == OK), rejected, status, flow.seen)


@horizon.register(Rodas)
def _(method, end):
    return inf


@step.register(Rodas)
def _(method, p, t, x, u, h):
    ks = np.empty((STAGES, len(x)))
    return fill_increments(ks, p, t, x, u, h, linearised(p, t, x, u), opened(p, t, x, u, h))


@stages.register(Rodas)
def _(method):
    return STAGES + 2
