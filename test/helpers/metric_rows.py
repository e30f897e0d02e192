"""Metrics of motions that are made up: rows of joints in place of those of a run.

The equations do not matter.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim.scenes.scene import Scene
from crane_sim.simulation.metrics import Metrics
from crane_sim.stepping.periods import begin
from crane_sim.stepping.rows import row_width

Array = npt.NDArray[np.float64]


def metrics_of(scene: Scene, q: Array, cuts: tuple[int, ...] = ()) -> dict[str, Any]:
    """Return the metrics of joints q (K + 1, nq) at control steps and at the end, in blocks."""
    nq, start = (
        len(scene.joint_names),
        begin(scene.model, np.array(scene.initial_q), np.array(scene.initial_v))[0],
    )
    rows = np.zeros((len(q) - 1, row_width(scene.model, nq, len(scene.actuated))))
    rows[:, :nq], t = q[:-1], np.arange(len(q)) * scene.period
    metrics = Metrics(scene, scene.model, start.x)
    for block in zip(np.split(t[:-1], cuts), np.split(rows, cuts), strict=True):
        metrics.extend(*block)
    return metrics.summary(t[-1], tuple(q[-1]), (0.0,) * nq, start, 0)
