"""The law that `learn.py` trains, in numpy: a perceptron whose output is the force on a trolley.

./crane simulate overhead_energy --law examples/agent.py:build --set control.weights=agent.npz
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.laws import read_settings

Array = npt.NDArray[np.float64]
SCALES = np.array(
    [1.0, 0.3, 2.0, 1.0]
)  # m, rad, m/s, rad/s: what makes an input of the perceptron 1
FORCE = 300.0  # N, the largest one
HOLD = (
    5  # periods of 0.01 s for which a force is held: an agent that decides less often learns sooner
)


def inputs_of(observations: Array) -> Array:
    """Return the inputs (..., 4) for observations (..., 5).

    Observations are trolley, angle, their velocities, and the target of the trolley.
    """
    state = observations[..., :4].copy()
    state[..., 0] -= observations[..., 4]
    return state / SCALES


class Settings(NamedTuple):
    """Settings of the law."""

    weights: str  # -, file of the weights, as `learn.py` writes it


class Agent:
    """The perceptron, its last layer limited to ±1, and the force that it holds."""

    def __init__(self, layers: Sequence[tuple[Array, Array]], target: float) -> None:
        """Take the layers (matrix, bias), hyperbolic tangents between them, and the target [m]."""
        self.layers, self.target = layers, target
        self._held = np.zeros(2)  # force [N], periods until the next one

    def with_initial_state(self) -> "Agent":
        """Return the law as it is before its first command."""
        return Agent(self.layers, self.target)

    def __call__(self, t: float, q: tuple[float, ...], v: tuple[float, ...]) -> tuple[float, ...]:
        """Return the force on the trolley [N]."""
        if self._held[1] == 0.0:
            self._held[:] = FORCE * self.decide(inputs_of(np.array([*q, *v, self.target]))), HOLD
        self._held[1] -= 1.0
        return (float(self._held[0]),)

    def decide(self, x: Array) -> float:
        """Return the command, ±1, for inputs (4,)."""
        for matrix, bias in self.layers[:-1]:
            x = np.tanh(matrix @ x + bias)
        matrix, bias = self.layers[-1]
        return float(np.clip(matrix @ x + bias, -1.0, 1.0)[0])


def build(settings: Mapping[str, Any], scene: Any) -> Agent:
    """Return the law of a scene."""
    with np.load(read_settings(Settings, settings).weights) as file:
        arrays = [file[name].astype(np.float64) for name in file.files]
    return Agent(list(zip(arrays[::2], arrays[1::2], strict=True)), scene.reference[0])
