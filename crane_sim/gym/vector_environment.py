"""Many cranes as one vector environment, all stepped by one compiled call on several threads.

Crane i does what the environment of one crane does with the same commands and seed, bit for bit.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from math import ceil
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from crane_sim.files.errors import SceneError, shorten
from crane_sim.gym.environment import SEEDS
from crane_sim.gym.task import (
    Array,
    Goal,
    MaxEffort,
    action_space,
    distance_from,
    goal_of,
    observation_names,
    observation_space,
    task_scene,
    with_seed,
)
from crane_sim.numerics.lanes import put_entry, take_entry
from crane_sim.scenes.scene import Scene, SceneSource
from crane_sim.simulation.columns import ONE_KIND, kind_of, stack_columns
from crane_sim.simulation.derived import in_bases, swing_angles, world_points
from crane_sim.simulation.goals import follows_path
from crane_sim.simulation.initial_state import make_initial
from crane_sim.simulation.status import SimulationError, check_status
from crane_sim.stepping.cranes import CraneArrays, Cranes, advance_cranes
from crane_sim.stepping.rows import row_width
from crane_sim.trajectories.trajectory import sample_trajectories

Flags = npt.NDArray[np.bool_]
Seeds = int | Sequence[int | None] | None
Step = tuple[Array, Array, Flags, Flags, dict[str, Any]]
ONE_CRANE = (
    f"{ONE_KIND}, path (of as many pieces), drives and sensors; give the scene an "
    "integrator.method and a "
)
ONE_CRANE += (
    "cable.model, and draw nothing that changes the rest, such as limits of the path and delays"
)
WORTH_A_THREAD = 64
"""Cranes, from which on another thread is worth its hand-over of some 20 µs."""


class CraneVectorEnv(VectorEnv[Array, Array, npt.NDArray[Any]]):
    """n cranes of one kind, commanded every control period; ended ones reset at the next step.

    A copy, by `copy.deepcopy` or `pickle`, goes on with the episodes equally, bit for bit.

    Attributes:
        scenes: (n,) of the present episodes.
        observation_names, observation_units, action_names, action_units: as of `CraneEnv`.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int = 1,
        scene: SceneSource | None = None,
        max_effort: MaxEffort | None = None,
        crane: str = "overhead",
        threads: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    ) -> None:
        """Prepare `num_envs` cranes; other arguments of `CraneEnv`.

        Args:
            num_envs, scene, max_effort, crane: of all cranes.
            threads: None: as many as there are cores and as are worth it.
            autoreset_mode: NEXT_STEP or SAME_STEP: where a crane whose episode ended begins the
                next one.

        Raises:
            SceneError: as of `CraneEnv`, or there is no crane, no thread, or another mode.
        """
        for name, value in {"num_envs": num_envs, "threads": threads}.items():
            if value is not None and value < 1:
                raise SceneError(f"{name} = {value}: must be at least 1")
        own, mode = task_scene(scene, crane), _checked_mode(autoreset_mode)
        self.metadata = {"render_modes": [], "autoreset_mode": mode}
        self._restarts = mode is AutoresetMode.SAME_STEP
        self.num_envs, self.scenes = num_envs, [own] * num_envs
        self.single_action_space = action_space(own, max_effort)
        self.single_observation_space = observation_space(own)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.observation_names, self.observation_units = observation_names(own)
        self.action_names, self.action_units = own.actuated, own.command_units
        self._paths = stack_columns([own.trajectory] * num_envs) if follows_path(own) else None
        self._targets = None if follows_path(own) else _repeat(goal_of(own), num_envs)
        self._generators = [seeding.np_random()[0] for _ in range(num_envs)]
        self._arrays = _allocate(own, num_envs)
        self._kind = _kind(own), kind_of(_equipment(make_initial(own)[-1]))
        self._cranes: Any = None
        self._ended = np.zeros(num_envs, np.bool_)
        self._owed, self._largest = np.zeros(num_envs), np.zeros(num_envs)
        cores = threads or min(len(os.sched_getaffinity(0)), ceil(num_envs / WORTH_A_THREAD))
        self._start_threads(cores)

    def _start_threads(self, count: int) -> None:
        """Start threads, which share the cranes; none where one is enough."""
        self._pool = ThreadPoolExecutor(count) if count > 1 else None
        self._shares = [
            (self.num_envs * j // count, self.num_envs * (j + 1) // count) for j in range(count)
        ]

    def __getstate__(self) -> dict[str, Any]:
        """Return the attributes without the threads, which no copy can have."""
        return {name: value for name, value in vars(self).items() if name != "_pool"}

    def __setstate__(self, attributes: dict[str, Any]) -> None:
        """Take the attributes of another environment, and start threads."""
        vars(self).update(attributes)
        self._start_threads(len(self._shares))

    def reset(
        self, *, seed: Seeds = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode of every crane; crane i of an integer seed takes seed + i.

        Raises:
            ValueError: there is not one seed for each crane, or there are options: episodes begin
                as the scene says.
            SceneError: a seed draws a crane of another kind; `step`, which begins episodes too,
                raises it as well.
        """
        if options:
            raise ValueError(f"options = {shorten(options)}: a vector environment takes none")
        seeds, self._cranes = _seeds(seed, self.num_envs), None
        self._cranes = stack_columns([self._begin(i, own) for i, own in enumerate(seeds)])
        self._ended[:] = False
        info = self._measure()
        self._note_start(np.ones(self.num_envs, np.bool_), info["error"])
        return self._observe(), info

    def step(self, actions: Array) -> Step:
        """Hold a command for each crane (n, nu) for one control period; see `CraneEnv.step`.

        A crane whose episode ended at the step before begins a new one instead, with reward 0; in
        the mode SAME_STEP it has begun already, and `final_obs`, `final_info` are those of the end.

        Raises:
            ValueError: the actions are not one number for each actuated joint of each crane.
            ResetNeeded: there was no reset.
        """
        commands, arrays, fresh = self._checked(actions), self._arrays, self._ended
        self._begin_again(fresh)
        arrays.left_out[:], arrays.failed[:] = fresh, False
        self._advance(commands)
        info, failed = self._measure(), arrays.failed.copy()
        rewards = self._reward(fresh, info["error"])
        over = (arrays.periods >= self.scenes[0].steps) & ~fresh & ~failed
        if failed.any():
            info |= {"reason": self._reasons(), "_reason": failed.copy()}
        self._ended = failed | over
        if self._restarts and self._ended.any():
            info = self._restart(info)
        return self._observe(), rewards, failed, over, info

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _checked(self, actions: Array) -> Array:
        """Return the actions as commands (n, nu)."""
        if self._cranes is None:
            raise ResetNeeded("there is no episode yet: reset the environment")
        commands = np.ascontiguousarray(actions, dtype=np.float64)
        if (
            commands.shape != (self.num_envs, len(self.action_names))
            or not np.isfinite(commands).all()
        ):
            shape = f"a number for each of {', '.join(self.action_names)} of {self.num_envs} cranes"
            raise ValueError(f"actions = {shorten(actions)}: must be {shape}")
        return commands

    def _begin(self, i: int, seed: int | None) -> Cranes:
        """Return crane i at the start of an episode."""
        if seed is not None:
            self._generators[i], _ = seeding.np_random(seed)
        number = int(self._generators[i].integers(SEEDS)) if seed is None else seed
        scene = with_seed(self.scenes[i], number)
        is_new = scene.model is not self.scenes[i].model
        if is_new and _kind(scene) != self._kind[0]:  # before anything is compiled for another kind
            raise SceneError(f"seed = {number}: {ONE_CRANE}")
        integration, q, v, measured, hardware = make_initial(scene)
        equipment = _equipment(hardware)
        if is_new and kind_of(equipment) != self._kind[1]:
            raise SceneError(f"seed = {number}: {ONE_CRANE}")
        if is_new:
            self._put_goal(i, scene)
        self.scenes[i], arrays = scene, self._arrays
        arrays.periods[i], arrays.measured[i] = 0, [*measured[0], *measured[1]]
        points, tip = world_points(scene.model, 0.0, np.array(q), np.array(v))
        arrays.tip[i], arrays.payload[i] = points[tip], points[-1]
        return Cranes(scene.method, scene.model, equipment, integration)

    def _put_goal(self, i: int, scene: Scene) -> None:
        """Note the goal of crane i."""
        if self._targets is None:
            put_entry(self._paths, i, scene.trajectory)
        else:
            goal = goal_of(scene)
            self._targets.position[i], self._targets.shown[i] = goal.position[0], goal.shown[0]

    def _begin_again(self, ended: Flags) -> None:
        """Begin new episodes of the cranes whose last one ended."""
        for i in np.flatnonzero(ended).tolist():
            put_entry(self._cranes, i, self._begin(i, None))

    def _restart(self, info: dict[str, Any]) -> dict[str, Any]:
        """Begin new episodes where one ended; return the info of their start and of the end.

        The info of the start includes the other environments.
        """
        ended, shown = self._ended, self._observe()
        final = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(ended).tolist():
            final[i] = shown[i]
        last = {key: ended & value if key.startswith("_") else value for key, value in info.items()}
        self._begin_again(ended)
        now = self._measure()
        self._note_start(ended, now["error"])
        self._ended = np.zeros_like(ended)
        return now | {
            "final_obs": final,
            "_final_obs": ended,
            "final_info": last,
            "_final_info": ended.copy(),
        }

    def _advance(self, commands: Array) -> None:
        """Advance all cranes by one period."""
        batch = self._cranes, commands, self.scenes[0].period, self._arrays
        if self._pool is None:
            advance_cranes(*batch, 0, self.num_envs)
        else:
            list(self._pool.map(lambda share: advance_cranes(*batch, *share), self._shares))

    def _measure(self) -> dict[str, Any]:
        """Return `error` [m] and `swing` [rad] of the payloads."""
        arrays, everyone = self._arrays, np.ones(self.num_envs, np.bool_)
        error = distance_from(self._goals().position, self._payloads())
        return {
            "error": error, "_error": everyone,
            "swing": swing_angles(arrays.tip, arrays.payload), "_swing": everyone.copy(),
        }  # fmt: skip

    def _note_start(self, new: Flags, error: Array) -> None:
        """Note the distance at the start of the new episodes."""
        self._owed[new], self._largest[new] = error[new], error[new]

    def _reward(self, fresh: Flags, error: Array) -> Array:
        """Return the rewards (n,) of the last period, 0 of episodes that are `fresh`."""
        steps, failed = self.scenes[0].steps, self._arrays.failed
        lacking = (steps - self._arrays.periods) * self._largest
        rewards = np.where(
            fresh, 0.0, -(self._owed + np.where(failed, lacking, error)) / (steps + 1)
        )
        self._owed[:], self._largest = 0.0, np.maximum(self._largest, error)
        self._note_start(fresh, error)
        return rewards

    def _goals(self) -> Goal:
        """Return the present goals, a row for each crane."""
        if self._targets is not None:
            return self._targets
        path = sample_trajectories(self._paths, self._arrays.periods * self.scenes[0].period)
        return Goal(path[:, 0], np.concatenate([path[:, 0], path[:, 1]], axis=1))

    def _observe(self) -> Array:
        return np.concatenate([self._arrays.measured, self._goals().shown], axis=1)

    def _payloads(self) -> Array:
        """Return the payloads (n, 3) [m] in the axes of their bases."""
        arrays, bases = self._arrays, getattr(self._cranes.model, "base", None)
        if bases is None:
            return arrays.payload
        return in_bases(bases, arrays.periods * self.scenes[0].period, arrays.payload)

    def _reasons(self) -> npt.NDArray[np.object_]:
        """Return why cranes failed, None of one that did not."""
        reasons = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(self._arrays.failed).tolist():
            try:
                check_status(take_entry(self._cranes.integration, i), self.scenes[i].model)
            except SimulationError as error:
                reasons[i] = str(error)
        return reasons


def _checked_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """Return where episodes begin anew.

    Raises:
        SceneError: it is nowhere, or unknown.
    """
    value = mode.value if isinstance(mode, AutoresetMode) else mode
    if value not in (possible := [AutoresetMode.NEXT_STEP.value, AutoresetMode.SAME_STEP.value]):
        raise SceneError(f"autoreset_mode = {shorten(value)}: possible: {', '.join(possible)}")
    return AutoresetMode(value)


def _seeds(seed: Seeds, n: int) -> list[int | None]:
    """Return the seed of each of n cranes, None of one that draws its own."""
    if isinstance(seed, int | np.integer):
        return [int(seed) + i for i in range(n)]
    seeds: list[int | None] = [None] * n if seed is None else list(seed)
    if len(seeds) != n:
        raise ValueError(f"seed: has {len(seeds)} values for {n} cranes")
    return seeds


def _repeat(goal: Goal, count: int) -> Goal:
    """Return a goal of one row with a row for each crane."""
    return Goal(*(part.repeat(count, axis=0) for part in goal))


def _kind(scene: Scene) -> Any:
    """Return the kind of method, model and path, which all cranes share."""
    return kind_of((scene.method, scene.model, scene.trajectory if follows_path(scene) else None))


def _equipment(hardware: Any) -> Any:
    """Return drives and sensors of a run's hardware, None without."""
    return None if hardware is None else hardware.state


def _allocate(scene: Scene, n: int) -> CraneArrays:
    """Return the arrays of n cranes."""
    nq = len(scene.joint_names)
    return CraneArrays(
        periods=np.zeros(n, np.int64),
        left_out=np.zeros(n, np.bool_),
        failed=np.zeros(n, np.bool_),
        measured=np.empty((n, 2 * nq)),
        tip=np.empty((n, 3)),
        payload=np.empty((n, 3)),
        rows=np.empty((n, row_width(scene.model, nq, len(scene.actuated)))),
    )
