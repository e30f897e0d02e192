"""Environments of Gymnasium: a scene whose commands come from an agent, once every control period.

    import gymnasium, crane_sim.gym
    env = gymnasium.make("crane_sim/Overhead-v0", scene="overhead_bench")
    envs = gymnasium.make_vec("crane_sim/Overhead-v0", num_envs=64)

Importing this registers the environments: one for each kind of crane of `DEFAULT_SCENES`, which
differ in the scene that they have where none is given.
"""

from crane_sim.files.installation import MissingPackage, missing_package

try:
    import gymnasium
except ModuleNotFoundError:
    raise MissingPackage(missing_package("gymnasium", "an environment")) from None

from crane_sim.gym.environment import CraneEnv
from crane_sim.gym.task import DEFAULT_SCENES
from crane_sim.gym.vector_environment import CraneVectorEnv

__all__ = ["DEFAULT_SCENES", "CraneEnv", "CraneVectorEnv"]

for _crane in DEFAULT_SCENES:
    gymnasium.register(
        f"crane_sim/{_crane.capitalize()}-v0",
        "crane_sim.gym.environment:CraneEnv",
        vector_entry_point="crane_sim.gym.vector_environment:CraneVectorEnv",
        kwargs={"crane": _crane},
    )
