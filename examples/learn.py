"""An agent learns to carry a load, and is judged by the rows of the league, beside the energy law.

    .venv/bin/pip install stable-baselines3
    .venv/bin/python examples/learn.py --minutes 10

It learns by proximal policy optimisation on many cranes at once, of the scene `overhead_energy`
with other loads, ropes, starts and targets in every episode, on a base at rest and without wind.
The league's trials come then: their loads and ropes are within that range, moving bases and gusts
are new. The weights are in a file that `agent.py` reads.
"""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from agent import FORCE, HOLD, inputs_of
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecMonitor, VecNormalize

import crane_sim
import crane_sim.gym
from crane_bench.league.cases import GROUPS, Entrant
from crane_bench.league.cells import Cell, evaluate

AGENT = Path(__file__).with_name("agent.py")
BESIDE = ("energy", "lqr")
HEAD = (
    "trial",
    "law",
    "MAE, m",
    "peak swing, deg",
    "residual swing, deg",
    "settling, s",
    "largest force, N",
)
CRANES = 256
UNCERTAIN = {
    "cable.node_masses": {"distribution": "uniform", "low": 0.7, "high": 1.3, "relative": True},
    "cable.lengths": {"distribution": "uniform", "low": 0.9, "high": 1.1, "relative": True},
    "initial.angles.0": {"distribution": "uniform", "low": -0.5, "high": 0.5},
    "reference.q.0": {"distribution": "uniform", "low": -3.5, "high": 3.5},
}
CHANGES = {
    "duration": 10.0,
    "trolley.limits": [-6.0, 6.0],
    "control.period": HOLD * 0.01,
    "uncertain": UNCERTAIN,
}


class Cranes(VecEnv):
    """The vector environment as Stable Baselines has it: actions ±1, inputs of the agent."""

    def __init__(self, envs: Any) -> None:
        """Take a vector environment whose episodes begin anew in the step in which they end."""
        box = gymnasium.spaces.Box
        self.envs, self.actions = envs, np.zeros(envs.action_space.shape)
        super().__init__(
            envs.num_envs,
            box(-np.inf, np.inf, (4,)),
            box(-1.0, 1.0, envs.single_action_space.shape),
        )

    def reset(self) -> Any:
        """Begin an episode of every crane."""
        return inputs_of(self.envs.reset(seed=self._seeds[0])[0])

    def step_async(self, actions: Any) -> None:
        """Take the actions."""
        self.actions = FORCE * actions

    def step_wait(self) -> Any:
        """Step the cranes; a crane at the end of its time has a future, which counts."""
        observations, rewards, failed, over, info = self.envs.step(self.actions)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(failed | over):
            end = inputs_of(info["final_obs"][i])
            infos[i] = {"terminal_observation": end, "TimeLimit.truncated": bool(over[i])}
        return inputs_of(observations), rewards, failed | over, infos

    def close(self) -> None:
        """Close the environment."""
        self.envs.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return what all cranes have in common, for each of them."""
        return [getattr(self.envs, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: cranes have nothing that one sets."""
        raise NotImplementedError(attr_name)

    def env_method(
        self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any
    ) -> list[Any]:
        """Refuse: cranes have no methods of their own."""
        raise NotImplementedError(method_name)

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return that none is wrapped."""
        return [False] * self.num_envs


class TimeLimit(BaseCallback):
    """Ends the training after some seconds, and shows how it goes."""

    def __init__(self, seconds: float) -> None:
        """Count from now."""
        super().__init__()
        self.began, self.seconds, self.shown = time.monotonic(), seconds, 0.0

    @property
    def left(self) -> float:
        """Part of the time that is left."""
        return max(0.0, 1.0 - (time.monotonic() - self.began) / self.seconds)

    def _on_step(self) -> bool:
        passed = time.monotonic() - self.began
        if passed >= self.shown and self.model.ep_info_buffer:
            error = -np.mean([episode["r"] for episode in self.model.ep_info_buffer])
            print(
                f"{passed:5.0f} s  {self.num_timesteps:9d} steps  mean error {error:.4f} m",
                flush=True,
            )
            self.shown = passed + self.seconds / 20.0
        return passed < self.seconds


def train(minutes: float, seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the layers (matrix, bias) of an agent that learned for some minutes."""
    torch.set_num_threads(1)  # perceptrons this small are slower on two
    scene = crane_sim.load_scene("overhead_energy", CHANGES)
    envs = gymnasium.make_vec(
        "crane_sim/Overhead-v0",
        num_envs=CRANES,
        scene=scene,
        max_effort=FORCE,
        autoreset_mode="SameStep",
    )
    cranes = VecNormalize(VecMonitor(Cranes(envs)), norm_obs=False, gamma=0.99)
    cranes.seed(seed)
    clock = TimeLimit(60.0 * minutes)
    model = PPO(
        "MlpPolicy",
        cranes,
        n_steps=50,
        batch_size=1600,
        n_epochs=10,
        gamma=0.99,
        seed=seed,
        device="cpu",
        learning_rate=lambda _: 1e-3 * clock.left,
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -0.5},
    )
    model.learn(10**12, clock)
    cranes.close()
    policy = model.policy
    layers = [part for part in policy.mlp_extractor.policy_net if hasattr(part, "weight")] + [
        policy.action_net
    ]
    return [(part.weight.detach().numpy(), part.bias.detach().numpy()) for part in layers]


def judge(weights: Path) -> None:
    """Print the rows of the league for the agent and the laws of BESIDE."""
    (group,) = (group for group in GROUPS if group.name == "overhead, trolley")
    agent = Entrant("agent", f"{AGENT}:build", settings={"weights": str(weights.resolve())})
    entrants = [*(entrant for entrant in group.entrants if entrant.name in BESIDE), agent]
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for trial in group.trials:
        for entrant in entrants:
            row = trial.column, entrant.name, *judged(evaluate(group, entrant, trial))
            print(f"| {' | '.join(row)} |", flush=True)


def judged(cell: Cell) -> list[str]:
    """Return the metrics of a cell of the league as text."""
    metrics = cell.metrics
    if metrics is None:
        return [cell.failed, *["-"] * (len(HEAD) - 3)]
    settling = "-" if metrics.settling is None else f"{metrics.settling:.2f}"
    numbers = [f"{x:.3g}" for x in (metrics.mae, metrics.peak_swing, metrics.residual_swing)]
    return [*numbers, settling, f"{metrics.effort['trolley']:.0f}"]


def main(arguments: Sequence[str] | None = None) -> None:
    """Train, keep the weights, and judge."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--minutes",
        type=float,
        default=10.0,
        help="of training; 0: judge the weights that are there",
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--weights", type=Path, default=Path("agent.npz"), help="file of the agent")
    given = parser.parse_args(arguments)
    if given.minutes:
        layers = train(given.minutes, given.seed)
        np.savez(given.weights, *(part for layer in layers for part in layer))
    judge(given.weights)


if __name__ == "__main__":
    main()
