"""The environment of one crane: a `Plant` between an agent's commands and the measured states.

One step is one control period: the same commands move the crane as in `simulate`, bit for bit.

The reward is the league's metric of how far the payload is from its goal, so that the sum over an
episode is its negative `mae`: e_k is the distance [m] at instant k of the N + 1 instants of a run
of N periods, in the axes of the base; step k from 0 on is rewarded by -e_{k+1} / (N + 1), and the
first one by -e_0 / (N + 1) more. A run that fails is charged the largest distance that it had for
every instant that it lacks, so that it does not pay to fail.
"""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded

from crane_sim.files.errors import SceneError, shorten, unknown_key
from crane_sim.gym.task import (
    Array,
    MaxEffort,
    action_space,
    distance_from,
    goal_of,
    observation_names,
    observation_space,
    task_scene,
    with_seed,
)
from crane_sim.scenes.scene import SceneSource
from crane_sim.simulation.derived import swing_angles, world_points
from crane_sim.simulation.goals import express_in_base
from crane_sim.simulation.plant import Plant, SimulationError

SEEDS = 2**31
"""Seeds of episodes without one of their own are drawn below this."""
_OPTIONS = ("q", "v")


class CraneEnv(gymnasium.Env[Array, Array]):
    """A crane that an agent commands once every control period.

    A copy, by `copy.deepcopy` or `pickle`, goes on with the episode equally, bit for bit.

    Attributes:
        scene: of the present episode, its uncertain parameters drawn.
        plant: the crane in motion; `plant.summary()` are the metrics of the episode.
        observation_names, observation_units: of the entries of an observation.
        action_names, action_units: of the entries of an action.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        scene: SceneSource | None = None,
        max_effort: MaxEffort | None = None,
        crane: str = "overhead",
    ) -> None:
        """Prepare the crane of a scene.

        Args:
            scene: a name of the catalogue, a file, a dict or a Scene; None: the one of
                `DEFAULT_SCENES` for `crane`.
            max_effort: bound of the commands that the scene does not bound, one or one for each
                actuated joint, in the units of the commands.
            crane: kind of crane, see `scene`.

        Raises:
            SceneError: the scene is invalid, takes no commands, has no goal, or lacks a bound.
        """
        self.scene = task_scene(scene, crane)
        self.action_space = action_space(self.scene, max_effort)
        self.observation_space = observation_space(self.scene)
        self.observation_names, self.observation_units = observation_names(self.scene)
        self.action_names, self.action_units = self.scene.actuated, self.scene.command_units
        self._drawn, self._goal = self.scene, goal_of(self.scene)
        self.plant = Plant(self.scene, picklable=True)
        self._ended = True

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: the scene's seed, of uncertain parameters, seas, gusts and noise; None: drawn from
                the last one given.
            options: "q", "v": the initial state, the scene's own where left out.

        Raises:
            SceneError: the crane cannot be in that state, or an option is unknown.
        """
        super().reset(seed=seed)
        for name in options or ():
            if name not in _OPTIONS:
                raise SceneError(unknown_key(name, _OPTIONS, "option of reset"))
        self._ended = True  # until the crane is in its state
        self.scene = with_seed(
            self.scene, int(self.np_random.integers(SEEDS)) if seed is None else seed
        )
        if self.scene.model is not self._drawn.model:
            self._drawn, self._goal = self.scene, goal_of(self.scene)
        self.plant = Plant(self.scene, picklable=True)
        if options:
            self.plant.reset(options.get("q"), options.get("v"))
        self._ended, info = False, self._measure()
        self._owed = self._largest = info["error"]
        return self._observe(), info

    def step(
        self, action: Array | Sequence[float]
    ) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold a command (nu,) for one control period.

        Returns:
            (observation, reward, whether the run failed, whether its time is over, info): `error`
            [m] and `swing` [rad] of the payload, and the `reason` of a failure.

        Raises:
            ValueError: the action is not one number for each actuated joint.
            ResetNeeded: the episode has ended, or none has begun.
        """
        if self._ended:
            raise ResetNeeded(
                "there is no episode: it has ended, or none has begun; reset the environment"
            )
        command, instants = self._checked(action), self.scene.steps + 1
        try:
            self.plant.advance(command)
        except SimulationError as error:
            self._ended, lacking = True, instants - 1 - self.plant.k
            charged = self._owed + lacking * self._largest
            return (
                self._observe(),
                -charged / instants,
                True,
                False,
                self._measure() | {"reason": str(error)},
            )
        info = self._measure()
        reward = -(self._owed + info["error"]) / instants
        self._owed, self._largest = 0.0, max(self._largest, info["error"])
        self._ended = self.plant.k >= self.scene.steps
        return self._observe(), reward, False, self._ended, info

    def _checked(self, action: Array | Sequence[float]) -> tuple[float, ...]:
        """Return the action as a command."""
        line = (
            f"action = {shorten(action)}: must be a number for each of "
            f"{', '.join(self.action_names)}"
        )
        try:
            values = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError):
            raise ValueError(line) from None
        if values.shape != (len(self.action_names),) or not np.isfinite(values).all():
            raise ValueError(line)
        return tuple(values.tolist())

    def _observe(self) -> Array:
        goal, (q, v) = self._goal, self.plant.seen
        return np.array([*q, *v, *goal.shown[goal.row(self.plant.k)]])

    def _measure(self) -> dict[str, Any]:
        """Return distance from the goal [m] and swing [rad] of the payload."""
        plant, goal = self.plant, self._goal
        points, tip = world_points(plant.model, plant.t, np.array(plant.q), np.array(plant.v))
        payload = express_in_base(plant.model, np.array([plant.t]), points[-1:])
        distance = distance_from(goal.position[None, goal.row(plant.k)], payload)
        return {
            "error": float(distance[0]),
            "swing": float(swing_angles(points[None, tip], points[-1:])[0]),
        }
