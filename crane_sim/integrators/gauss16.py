"""Gauss collocation with eight stages, order 16, with error control: for tight tolerances.

The stages are found by repeated evaluation, all eight at once: of a tuple state as lanes of
vectors, so that eight evaluations cost little more than one (M. Antoñana, J. Makazaga, A. Murua,
"SIMD-vectorized implicit symplectic integrators can outperform explicit symplectic ones",
arXiv:2511.03655). Nodes and weights: Abramowitz, Stegun, "Handbook of Mathematical Functions",
table 25.4. Positions whose rates are entries of the state (`system.rate_entries`) are integrated
twice from the accelerations, which halves the sweeps that a vibration takes (Hairer, Norsett,
Wanner, "Solving Ordinary Differential Equations I", 2nd ed., II.14, collocation for y'' = f).

Error: the derivative's Legendre series over the step has coefficients c_k; two orders shrink them
by the ratio r = |c_6, c_7| / |c_4, c_5|. What the series leaves out begins at order 8 and is
orthogonal to all polynomials below, so it moves the end by its product with the propagator's order
8 only, which shrinks alike: the estimate is h |c_6, c_7| r^4.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from crane_sim.files.types import NonNegative, Positive
from crane_sim.integrators.runge_kutta import evaluate_first_stage
from crane_sim.numerics.arrays import accumulate
from crane_sim.numerics.jit import local_array, routine, simd_range, use_wide_vectors
from crane_sim.numerics.lanes import LANES, lane, put_lane
from crane_sim.numerics.stage_lanes import (
    STAGES,
    mix_stages,
    reach_stages,
    take_row,
    weigh_stages,
)
from crane_sim.numerics.states import dimension
from crane_sim.system import rate_entries, rhs, rhs_into

ORDER = 16
_HALF_NODES = (0.9602898564975362316835609, 0.7966664774136267395915539,
               0.5255324099163289858177390, 0.1834346424956498049394761)  # fmt: skip
_HALF_WEIGHTS = (0.1012285362903762591525314, 0.2223810344533744705443560,
                 0.3137066458778872873379622, 0.3626837833783619829651504)  # fmt: skip
X = (*(-x for x in _HALF_NODES), *reversed(_HALF_NODES))  # in [-1, 1]
C = tuple(0.5 + 0.5 * x for x in X)
B = tuple(0.5 * w for w in (*_HALF_WEIGHTS, *reversed(_HALF_WEIGHTS)))


def legendre(x: float, count: int) -> list[float]:
    """Return the first `count` Legendre polynomials at x."""
    values = [1.0, x]
    for k in range(1, count - 1):
        values.append(((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1))
    return values


def _tableau() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the matrices (8, 8) from derivatives at the stages to integrals and a series.

    They give one integral, two integrals, and a Legendre series.
    """
    series = np.array([[(2 * k + 1) * b * legendre(x, STAGES)[k] for x, b in zip(X, B, strict=True)]
                       for k in range(STAGES)])  # fmt: skip
    once, twice = np.empty((STAGES, STAGES)), np.empty((STAGES, STAGES))
    for i, (x, c) in enumerate(zip(X, C, strict=True)):
        p = legendre(x, STAGES + 2)
        first = [c, *((p[k + 1] - p[k - 1]) / (2 * (2 * k + 1)) for k in range(1, STAGES + 1))]
        second = [
            c * c / 2,
            *((first[k + 1] - first[k - 1]) / (2 * (2 * k + 1)) for k in range(1, STAGES)),
        ]
        for j in range(STAGES):
            once[i, j] = sum(first[k] * series[k, j] for k in range(STAGES))
            twice[i, j] = sum(second[k] * series[k, j] for k in range(STAGES))
    return once, twice, series


A, A_TWICE, SERIES = _tableau()
B_TWICE = tuple(b * (1.0 - c) for b, c in zip(B, C, strict=True))
_NODES, _WEIGHTS, _WEIGHTS_TWICE = np.array(C), np.array(B), np.array(B_TWICE)
_ONCE, _TWICE, _SERIES = (np.ascontiguousarray(matrix.T) for matrix in (A, A_TWICE, SERIES))
# of one step: beyond them the next one is to contract faster, or this one is rejected
MANY_SWEEPS, MAX_SWEEPS = 8, 24
SETTLED = 0.3  # of the tolerance: what the sweeps may leave
# rows of a scratch: derivatives at the stages from FIRST on, state, new derivative
FIRST, STATE, NEW = 1, 9, 10
# between tolerance and aim: what errors vary by from step to step, or steps would be rejected in
# turn
MARGIN = 10.0
CONTRACTION = 0.1
"""Factor by which a sweep should shrink what is left: longer steps cost more sweeps than they
save."""
BASE, WEIGHT = STAGES, STAGES + 1
"""Lanes behind the stages: the state at the step's begin, and squared weights of changes of its
derivative."""


class Gauss16(NamedTuple):
    """Gauss collocation of order 16, for tight tolerances, with error control.

    It controls the rms of error / (atol + rtol |x|).

    There |x| stands for the most that an entry can be within a step of size h: |x| + |h x'|.
    """

    rtol: Positive = 1e-12  # -, relative tolerance
    atol: NonNegative = 1e-14  # state's unit, absolute tolerance
    order, stages, last_stage = ORDER, STAGES, 0

    def take_step(self, p, t, x, u, h, scratch, out):
        """Return (state, evaluations), see `Method`."""
        y, _, evaluations = self.step_with_error(
            scratch, evaluate_first_stage(scratch, p, t, x, u), p, t, x, u, h, out
        )
        return y, evaluations + 1

    def step_with_error(self, scratch, k1, p, t, x, u, h, out):
        """Return (state, error, evaluations), see `ErrorControlled`."""
        if scratch is None:
            y, error, sweeps = collocate(self, p, t, x, u, h, k1)
            return y, error, STAGES * sweeps
        error, sweeps = collocate_array(self, p, t, x, u, h, scratch.rows, scratch.work, out)
        return out, error, STAGES * sweeps


def is_paired(entries, i):
    """Return whether entry i is a position or its rate."""
    paired = False
    for first, count in entries:
        paired |= first <= i < first + 2 * count
    return paired


def begin_stages(entries, x, k1, h, rtol, atol, ys, ks):
    """Fill base, weights and the first estimate of all stages: k1, the derivative at the begin."""
    put_lane(ys, BASE, x)
    put_lane(ks, BASE, k1)
    for i in range(len(ys)):
        weight = h / (atol + rtol * (abs(ys[i, BASE]) + abs(h * ks[i, BASE])))
        ys[i, WEIGHT] = weight * weight
        for j in simd_range(STAGES):
            ys[i, j] = ks[i, j] = ks[i, BASE]
    for first, count in entries:
        for i in range(first, first + count):
            ys[i + count, WEIGHT] += h * h * ys[i, WEIGHT]


def update_entry(h, ys, ks, i):
    """Do what `update_stages` does for one entry."""
    moved = ys[i, WEIGHT] * take_row(ys, ks, i)
    reach_stages(_ONCE, ks, i, ys, i, (ys[i, BASE], 0.0, h, _NODES))
    return moved


def update_stages(entries, h, ys, ks):
    """Take the derivatives in ys over into ks, write the stages that follow from them into ys.

    Returns: the squared norm of what changed.
    """
    moved = 0.0
    for first, count in entries:
        for i in range(first, first + count):
            moved += update_entry(h, ys, ks, i + count)
            reach_stages(
                _TWICE, ks, i + count, ys, i, (ys[i, BASE], h * ys[i + count, BASE], h * h, _NODES)
            )
    for i in range(len(ys)):
        if not is_paired(entries, i):
            moved += update_entry(h, ys, ks, i)
    return moved


def end_of_step(entries, h, ys, ks, x):
    """Return the state at the end of the step, of a type like x."""
    for i in range(len(ys)):
        ys[i, 0] = ys[i, BASE] + h * weigh_stages(_WEIGHTS, ks, i)
    for first, count in entries:
        for i in range(first, first + count):
            twice = h * h * weigh_stages(_WEIGHTS_TWICE, ks, i + count)
            ys[i, 0] = ys[i, BASE] + (h * ys[i + count, BASE] + twice)
    return lane(x, ys, 0)


def estimate_error(entries, ys, ks):
    """Return a step's error from its derivatives' Legendre series; overwrite the stages in ys."""
    last, before = 0.0, 0.0
    for first, count in entries:
        for i in range(first, first + count):
            ys[i, WEIGHT] = 0.0  # in that of its rate
    for i in range(len(ys)):
        mix_stages(_SERIES, ks, i, ys, i, 1.0)
        last += ys[i, WEIGHT] * (ys[i, 6] * ys[i, 6] + ys[i, 7] * ys[i, 7])
        before += ys[i, WEIGHT] * (ys[i, 4] * ys[i, 4] + ys[i, 5] * ys[i, 5])
    return combine_estimates(last / len(ys), before / len(ys))


def combine_estimates(last, before):
    """Return the error from squared norms of the last two coefficients and the two before."""
    ratio = last / before if last < before else 1.0
    return sqrt(last) * ratio * ratio


def aim(error, contraction):
    """Return the error for step control: enlarged, and at most 1 where the step is accepted.

    So the size of the next step aims at an error of 1 / MARGIN of the tolerance, and at a
    contraction of CONTRACTION.
    """
    power = contraction / CONTRACTION
    power *= power
    power *= power
    power *= power
    return (
        max(MARGIN * error, power * power)
        if error > 1.0
        else min(1.0, max(MARGIN * error, power * power))
    )


@routine
def collocate(method, p, t, x, u, h, k1):
    """Return (state one step of size h after (t, x), error relative to the tolerance, sweeps).

    The error is inf where the sweeps did not converge. k1 is the derivative at (t, x).
    """
    use_wide_vectors()
    entries, ys, ks = (
        rate_entries(p),
        local_array((dimension(x), LANES)),
        local_array((dimension(x), LANES)),
    )
    begin_stages(entries, x, k1, h, method.rtol, method.atol, ys, ks)
    update_stages(entries, h, ys, ks)
    enough, moved, contraction, sweeps = SETTLED * SETTLED * len(ys), inf, 1.0, 0
    while sweeps < MAX_SWEEPS and contraction * moved > enough:
        for j in simd_range(STAGES):
            put_lane(ys, j, rhs(p, t + _NODES[j] * h, lane(x, ys, j), u))
        before, sweeps = moved, sweeps + 1
        moved = update_stages(entries, h, ys, ks)
        contraction = moved / before if sweeps > 1 else 1.0
    y = end_of_step(entries, h, ys, ks, x)
    error = aim(estimate_error(entries, ys, ks), sqrt(contraction) if sweeps > MANY_SWEEPS else 0.0)
    return y, error if contraction * moved <= enough else inf, sweeps


@routine
def collocate_array(method, p, t, x, u, h, rows, work, out):
    """Write the state one step after (t, x) into `out`; return (error, sweeps) as of `collocate`.

    The rows are the derivative at (t, x), those at the stages, and three more to work with. Each
    stage takes the newest derivatives of the others.
    """
    for j in range(FIRST, FIRST + STAGES):
        rows[j] = rows[0]
    enough, moved, contraction, sweeps = SETTLED * SETTLED * len(x), inf, 1.0, 0
    while sweeps < MAX_SWEEPS and contraction * moved > enough:
        before, moved, sweeps = moved, 0.0, sweeps + 1
        for j in range(STAGES):
            accumulate(h, A[j], STAGES, rows[FIRST:], x, rows[STATE])
            rhs_into(p, t + _NODES[j] * h, rows[STATE], u, rows[NEW], work)
            moved += take_stage(rows, FIRST + j, x, h, method.rtol, method.atol)
        contraction = moved / before if sweeps > 1 else 1.0
    accumulate(h, _WEIGHTS, STAGES, rows[FIRST:], x, out)
    last, before = 0.0, 0.0
    for k in range(4, STAGES):
        accumulate(h, SERIES[k], STAGES, rows[FIRST:], None, rows[NEW])
        square = row_square(rows, x, h, method.rtol, method.atol)
        last, before = (last + square, before) if k > 5 else (last, before + square)
    estimate = combine_estimates(last / len(x), before / len(x))
    error = aim(estimate, sqrt(contraction) if sweeps > MANY_SWEEPS else 0.0)
    return error if contraction * moved <= enough else inf, sweeps


@routine
def take_stage(rows, j, x, h, rtol, atol):
    """Move the new derivative into row j; return the squared norm of the change."""
    for i in range(len(x)):
        new = rows[NEW, i]
        rows[NEW, i] = h * (new - rows[j, i])
        rows[j, i] = new
    return row_square(rows, x, h, rtol, atol)


def row_square(rows, x, h, rtol, atol):
    """Return the squared norm of the row NEW, a change of the state."""
    total = 0.0
    for i in range(len(x)):
        ratio = rows[NEW, i] / (atol + rtol * (abs(x[i]) + abs(h * rows[0, i])))
        total += ratio * ratio
    return total
