"""The example of an agent: its law is a policy of the environment, in the league like others.

Each action is held for some periods.
"""

import json
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crane_sim import load_scene, simulate
from crane_sim.gym import CraneEnv

ROOT = Path(__file__).parents[2]
FILE = ROOT / "examples" / "agent.py"
PERIODS = 12


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    """Return a file of a perceptron's weights, of the shapes that `learn.py` writes."""
    generator = np.random.default_rng(0)
    shapes = ((8, 4), (8,), (8, 8), (8,), (1, 8), (1,))
    np.savez(
        tmp_path / "agent.npz",
        *(generator.normal(0.0, 0.5, shape).astype(np.float32) for shape in shapes),
    )
    return tmp_path / "agent.npz"


def test_the_agent_is_a_law_of_scenes(weights: Path) -> None:
    """Named by a scene's file, it gives the forces of its perceptron in an environment.

    Each is held.
    """
    changes = {
        "control.law": f"{FILE}:build",
        "control.weights": str(weights),
        "duration": PERIODS * 0.01,
    }
    scene = load_scene("overhead_energy", changes)
    agent: dict[str, Any] = runpy.run_path(str(FILE))
    law: Any = agent["build"]({"weights": str(weights)}, scene)
    env = CraneEnv(scene, max_effort=agent["FORCE"])
    (observation, _), forces = env.reset(seed=0), list[float]()
    for k in range(PERIODS):
        if k % agent["HOLD"] == 0:
            force = agent["FORCE"] * law.decide(agent["inputs_of"](observation))
        forces.append(force)
        observation, *_ = env.step([force])
    assert len(set(forces)) == 3 and all(abs(force) <= agent["FORCE"] for force in forces)
    for _ in range(2):  # every run begins with a law that holds nothing
        run = simulate(scene)
        np.testing.assert_array_equal(run.u[:-1, 0], forces)
        assert run.summary["state_sha256"] == env.plant.summary()["state_sha256"]


def test_the_page_s_laws_are_those_of_the_league() -> None:
    """On the page the rows of the laws are the league's own: the agent had the same trials."""
    cells = json.loads((ROOT / "docs" / "league.json").read_text())["cells"]
    own = {
        (cell["trial"], cell["law"]): cell["metrics"]
        for cell in cells
        if cell["crane"] == "overhead, trolley"
    }
    lines = [
        line.strip("| ").split(" | ")
        for line in (ROOT / "docs" / "gymnasium.md").read_text().splitlines()
    ]
    laws = [cells for cells in lines if cells[1:2] in (["energy"], ["lqr"])]
    agents = [cells[0] for cells in lines if cells[1:2] == ["agent"]]
    assert agents == [trial for trial, law in own if law == "energy"] and len(laws) == 2 * len(
        agents
    )
    for trial, law, mae, peak, *_ in laws:
        metrics = own[trial, law]
        assert (mae, peak) == (f"{metrics['mae']:.3g}", f"{metrics['peak_swing']:.3g}")
