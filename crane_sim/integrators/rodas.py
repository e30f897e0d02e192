"""A Rosenbrock method of order 5, error control by order 4: for stiff models with an array state.

It solves linear systems with the model's Jacobian (`system.compute_jacobian`) instead of iterating,
is L-stable and stiffly accurate. Coefficients: Rodas5P, G. Steinebach, "Construction of
Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia Differential Equations
package", BIT Numerical Mathematics 63:27 (2023), in the form that needs no product with the
Jacobian (Hairer, Wanner, "Solving Ordinary Differential Equations II", eq. IV.7.25): stage i solves
(I / (γ h) - J) U_i = f(t + c_i h, x + Σ a_ij U_j) + Σ (C_ij / h) U_j + h d_i ∂f/∂t.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive
from crane_sim.integrators.runge_kutta import evaluate_first_stage, to_dense_tableau
from crane_sim.numerics.jit import routine, simd_range
from crane_sim.numerics.states import squared_error_norm
from crane_sim.system import compute_jacobian, factor_shifted, rhs_into, solve_shifted, workspace

# fmt: off
GAMMA = 0.21193756319429014
_LAST = (-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
    0.030198172008377946)
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
    (24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125,
     -0.6610691825249471),
    (30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783,
     -19.097331116725623,
     -28.087943162872662),
    (37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047,
     -40.06618937091002,
     -54.66780262877968, -9.48861652309627),
)
NODES = (0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0,
    1.0, 1.0)
# sums of gamma's rows, weights of the derivative in time
GAMMA_SUMS = (GAMMA, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734,
    2.325825639765069, 0.0, 0.0, 0.0)
# fmt: on
ORDER, STAGES = 5, 8
_DENSE_A, _DENSE_C = to_dense_tableau(A), to_dense_tableau(C)
_NODES, _GAMMA_SUMS = np.array(NODES), np.array(GAMMA_SUMS)


class Rodas(NamedTuple):
    """A Rosenbrock method of order 5 for stiff cables.

    Error control by the rms of error / (atol + rtol max(|x|, |y|)), step x to y.
    """

    rtol: Positive = 1e-7  # -, relative tolerance
    atol: NonNegative = 1e-9  # state's unit, absolute tolerance
    order, stages, last_stage = ORDER, STAGES, 0

    def take_step(self, p, t, x, u, h, scratch, out):
        """Return (state, evaluations), see `Method`."""
        try_step(self, p, t, x, u, h, evaluate_first_stage(scratch, p, t, x, u), out)
        return out, self.stages

    def step_with_error(self, scratch, k1, p, t, x, u, h, out):
        """Return (state, error, evaluations), see `ErrorControlled`."""
        return out, try_step(self, p, t, x, u, h, k1, out), STAGES - 1


@routine
def rosenbrock_step(p, t, x, u, h, k1):
    """Return (the state one step of size h after (t, x), the last increment).

    k1 is the derivative at (t, x).
    """
    jacobian, change = compute_jacobian(p, t, x, u)
    factors = factor_shifted(p, jacobian, 1.0 / (GAMMA * h))
    ks, y, work = np.empty((STAGES, len(x))), x.copy(), workspace(p)
    for s in range(STAGES):
        if s == 0:
            ks[0] = k1
        else:
            reach_stage(s, x, ks, y)
            rhs_into(p, t + _NODES[s] * h, y, u, ks[s], work)
        for j in range(s):
            weight = _DENSE_C[s, j] / h
            for i in simd_range(len(x)):
                ks[s, i] += weight * ks[j, i]
        for i in simd_range(len(x)):
            ks[s, i] += h * _GAMMA_SUMS[s] * change[i]
        solve_shifted(p, factors, ks[s])
    for i in simd_range(len(x)):
        y[i] += ks[STAGES - 1, i]
    return y, ks[STAGES - 1]


def reach_stage(s, x, ks, y):
    """Write the state of stage s into y."""
    y[:] = 0.0
    for j in range(s):
        for i in simd_range(len(x)):
            y[i] += _DENSE_A[s, j] * ks[j, i]
    for i in simd_range(len(x)):
        y[i] += x[i]


@routine
def try_step(method, p, t, x, u, h, k1, out):
    """Write the state one step of h after (t, x) into `out`; return its relative error.

    The error is relative to the tolerance.
    """
    y, error = rosenbrock_step(p, t, x, u, h, k1)
    out[:] = y
    return sqrt(squared_error_norm(error, x, y, method.rtol, method.atol) / len(x))
