"""Dormand and Prince's method of order 8, with error control by orders 5 and 3, or with a fixed step.

Coefficients: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 2nd ed., program DOP853.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive
from crane_sim.integrators.integration import (
    Scratch,
    advance,
    explicit_step,
    last_stage,
    latest_step_end,
    max_steps,
    result_of,
    stages,
)
from crane_sim.integrators.runge_kutta import evaluate_first_stage, evaluate_stage, fill_stages, to_dense_tableau
from crane_sim.integrators.step_control import MAX_STEPS, accepted_step, error_order, step_with_error
from crane_sim.numerics.jit import lean_generic, lean_kernel
from crane_sim.numerics.states import add_weighted, dimension, error_square

# fmt: off
A = (
    (0.05260015195876773,),
    (0.0197250569845379, 0.0591751709536137),
    (0.02958758547680685, None, 0.08876275643042054),
    (0.2413651341592667, None, -0.8845494793282861, 0.924834003261792),
    (0.037037037037037035, None, None, 0.17082860872947386, 0.12546768756682242),
    (0.037109375, None, None, 0.17025221101954405, 0.06021653898045596, -0.017578125),
    (0.03709200011850479, None, None, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
     0.008273789163814023),
    (0.6241109587160757, None, None, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
     20.154067550477894, -43.48988418106996),
    (0.47766253643826434, None, None, -2.4881146199716677, -0.590290826836843, 21.230051448181193,
     15.279233632882423, -33.28821096898486, -0.020331201708508627),
    (-0.9371424300859873, None, None, 5.186372428844064, 1.0914373489967295, -8.149787010746927,
     -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196),
    (2.273310147516538, None, None, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996,
     -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636),
)
C = (
    0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726, 0.3333333333333333, 0.25,
     0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0,
)
B = (
    0.054293734116568765, None, None, None, None, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
     0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259,
)
# error weights of orders 5 and 3
E5 = (
    0.01312004499419488, None, None, None, None, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864,
     -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294,
)
E3 = (
    -0.18980075407240762, None, None, None, None, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
     -0.4226823213237919, -0.1521609496625161, 0.20136540080403034, 0.02265179219836082,
)
# fmt: on
ORDER, STAGES = 8, 12
_DENSE, _NODES = to_dense_tableau(A), np.array((0.0, *C))


class DOP853(NamedTuple):
    """Dormand and Prince's order 8; error control by orders 5 and 3, against atol + rtol max(|x|, |y|), step x to y."""

    rtol: Positive = 1e-11  # -, relative tolerance
    atol: NonNegative = 1e-13  # state's unit, absolute tolerance


class RK8(NamedTuple):
    """Dormand and Prince's order 8 with a fixed step; one that is unstable for the stiffest motion is refused."""

    step: Positive  # s, shortened so that a whole number fills each control period; without control it may span several

    def safe_step(self, frequency: float) -> float:
        """Return half the largest step [s] that is stable for motions up to `frequency` [rad/s]."""
        return 2.9 / frequency


@lean_generic
def dop853_stages(scratch, k1, p, t, x, u, h):
    """Return the derivatives of all twelve stages, the first one that of `evaluate_first_stage`."""
    k2 = evaluate_stage(p, t, x, u, h, A[0], C[0], (k1,))
    k3 = evaluate_stage(p, t, x, u, h, A[1], C[1], (k1, k2))
    k4 = evaluate_stage(p, t, x, u, h, A[2], C[2], (k1, k2, k3))
    k5 = evaluate_stage(p, t, x, u, h, A[3], C[3], (k1, k2, k3, k4))
    k6 = evaluate_stage(p, t, x, u, h, A[4], C[4], (k1, k2, k3, k4, k5))
    k7 = evaluate_stage(p, t, x, u, h, A[5], C[5], (k1, k2, k3, k4, k5, k6))
    k8 = evaluate_stage(p, t, x, u, h, A[6], C[6], (k1, k2, k3, k4, k5, k6, k7))
    k9 = evaluate_stage(p, t, x, u, h, A[7], C[7], (k1, k2, k3, k4, k5, k6, k7, k8))
    k10 = evaluate_stage(p, t, x, u, h, A[8], C[8], (k1, k2, k3, k4, k5, k6, k7, k8, k9))
    k11 = evaluate_stage(p, t, x, u, h, A[9], C[9], (k1, k2, k3, k4, k5, k6, k7, k8, k9, k10))
    k12 = evaluate_stage(p, t, x, u, h, A[10], C[10], (k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11))
    return k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, k11, k12


@dop853_stages.register(Scratch)
def _(scratch, k1, p, t, x, u, h):
    fill_stages(scratch, p, t, x, u, h, _DENSE, _NODES)
    return scratch


@lean_kernel
def _combined_error(ks, x, y, h, rtol, atol):
    """Return the error of a step relative to the tolerance, |e5|² / sqrt((|e5|² + |e3|² / 100) n) as in DOP853."""
    e5 = error_square(h, E5, ks, x, y, rtol, atol)
    e3 = error_square(h, E3, ks, x, y, rtol, atol)
    return 0.0 if e5 == 0.0 else e5 / sqrt((e5 + 0.01 * e3) * dimension(x))  # a NaN is propagated


@step_with_error.register(DOP853)
def _(method, scratch, k1, p, t, x, u, h, out):
    ks = dop853_stages(scratch, k1, p, t, x, u, h)
    y = add_weighted(x, h, B, ks, out)
    return y, _combined_error(ks, x, result_of(out, y), h, method.rtol, method.atol), STAGES - 1


@max_steps.register(DOP853)
def _(method):
    return MAX_STEPS


@error_order.register(DOP853)
def _(method):
    return ORDER


@advance.register(DOP853)
def _(method, p, u, integration, end):
    return accepted_step(method, p, u, integration, end)


@latest_step_end.register(DOP853)
def _(method, k, steps, period):
    return inf


@lean_kernel
def _take_step(p, t, x, u, h, scratch, out):
    return add_weighted(x, h, B, dop853_stages(scratch, evaluate_first_stage(scratch, p, t, x, u), p, t, x, u, h), out)


@explicit_step.register(DOP853)
def _(method, p, t, x, u, h, scratch, out):
    return _take_step(p, t, x, u, h, scratch, out)


@explicit_step.register(RK8)
def _(method, p, t, x, u, h, scratch, out):
    return _take_step(p, t, x, u, h, scratch, out)


@stages.register(DOP853)
@stages.register(RK8)
def _(method):
    return STAGES


@last_stage.register(DOP853)
@last_stage.register(RK8)
def _(method):
    return STAGES - 1
