"""Eight stages side by side: compiled vectors and plain Python do the same arithmetic."""

import numpy as np
import pytest

from crane_sim.numerics.jit import entry_point, local_array
from crane_sim.numerics.lanes import LANES, lane, put_lane
from crane_sim.numerics.stage_lanes import STAGES, mix_stages, reach_stages, take_row, weigh_stages
from crane_sim.numerics.states import dimension

RANDOM = np.random.default_rng(3)
MATRIX, NODES, SOURCE = (
    RANDOM.normal(size=(STAGES, STAGES)),
    RANDOM.normal(size=STAGES),
    RANDOM.normal(size=(3, LANES)),
)


@entry_point
def compute(matrix, nodes, source, to):
    """Return what the functions return; they write into rows of `to`."""
    mix_stages(matrix, source, 0, to, 0, 0.3)
    reach_stages(matrix, source, 1, to, 1, (0.7, -1.3, 0.3, nodes))
    changed = take_row(source, to, 2)
    return changed, weigh_stages(nodes, source, 1)


def test_vectors_have_the_bits_of_plain_python() -> None:
    """Products with a matrix, sums and differences of stages have the bits of their Python."""
    compiled, plain = np.ones((3, LANES)), np.ones((3, LANES))
    results = compute(MATRIX, NODES, SOURCE, compiled)
    body = getattr(compute, "py_func", compute)
    assert results == body(MATRIX, NODES, SOURCE, plain)
    assert np.array_equal(compiled, plain)


def test_rows_are_those_of_linear_algebra() -> None:
    """Rows are products with the transposed argument; lanes behind the stages stay."""
    to = np.ones((3, LANES))
    changed, weighed = compute(MATRIX, NODES, SOURCE, to)
    stages = SOURCE[:, :STAGES]
    assert to[0, :STAGES] == pytest.approx(0.3 * MATRIX.T @ stages[0], rel=1e-14, abs=1e-15)
    assert to[1, :STAGES] == pytest.approx(
        0.7 - 1.3 * NODES + 0.3 * MATRIX.T @ stages[1], rel=1e-14, abs=1e-14
    )
    assert np.array_equal(to[2, :STAGES], stages[2]) and np.all(to[:, STAGES:] == 1.0)
    assert changed == pytest.approx(np.sum((stages[2] - 1.0) ** 2)) and weighed == pytest.approx(
        NODES @ stages[1]
    )


@entry_point
def through_the_stack(x):
    """Return the state after a way through a buffer."""
    rows = local_array((dimension(x), LANES))
    put_lane(rows, 3, x)
    return lane(x, rows, 3), rows.shape[0], rows.shape[1]


def test_a_buffer_has_a_row_for_each_float() -> None:
    """A nested state comes back from the buffer, which has a row for each of its floats."""
    x = ((1.0, 2.0), 3.0, (4.0, 5.0, 6.0))
    assert through_the_stack(x) == (x, 6, LANES)


@entry_point
def store_beside_a_lane(buffers, x):
    """Write x into lane 3 of the first buffer, and 5 into that of the second one."""
    first, second, j, _ = buffers[0], buffers[1], 3, x
    put_lane(first, j, x)
    second[0, j] = 5.0


def test_a_store_beside_a_lane_is_kept() -> None:
    """A store into an array from a tuple arrives, also in a function that writes a lane."""
    buffers = np.zeros((2, LANES)), np.zeros((1, LANES))
    store_beside_a_lane(buffers, (1.0, 2.0))
    assert buffers[0][:, 3].tolist() == [1.0, 2.0] and buffers[1][0, 3] == 5.0
