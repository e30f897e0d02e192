"""The package in an interpreter: what it shows of itself, and what it costs to import."""

import pydoc
import subprocess
import sys

import crane_sim
from crane_sim.simulation.batch import simulate_batch
from crane_sim.simulation.rollout import simulate


def test_the_front_door_stays_open() -> None:
    """Every public name of the package can be taken again and again.

    That holds whatever was imported meanwhile.
    """
    for _ in range(2):
        for name in crane_sim.__all__:
            assert callable(getattr(crane_sim, name)), name


def test_the_public_names_are_shown() -> None:
    """Completion and `dir` show the public names, and no other without underscores.

    Help shows the functions.
    """
    assert [name for name in dir(crane_sim) if not name.startswith("_")] == sorted(
        crane_sim.__all__
    )
    text = pydoc.plain(pydoc.render_doc(crane_sim))
    assert all(f"    {name}(" in text or f"class {name}(" in text for name in crane_sim.__all__)


def test_the_package_alone_is_light() -> None:
    """Importing the package, and looking at its names, imports nothing of what they need."""
    code = (
        "import sys, crane_sim; dir(crane_sim); print(sorted({'numpy', 'llvmlite', 'pydantic'} & "
        "set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_compiled_code_needs_no_scipy() -> None:
    """A crane's energy, compiled or loaded, imports nothing of SciPy, which takes long."""
    energy = "import sys, crane_sim; crane_sim.energy('knuckle_setpoint', [0] * 6, [0] * 6)"
    command = [
        sys.executable,
        "-c",
        f"{energy}; print('numpy' in sys.modules, 'scipy' in sys.modules)",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True False"


def test_results_are_shown_in_short() -> None:
    """Scenes, runs and batches show what they are in at most three lines."""
    run = simulate("knuckle_setpoint", duration=0.1)
    batch = simulate_batch("knuckle_setpoint", {"payload.mass": [1.0, 2.0]}, duration=0.1)
    texts = list(map(repr, (run.scene, run, batch)))
    assert all(text.count("\n") < 3 and len(text) < 300 for text in texts)
    assert "knuckle_setpoint" in texts[0] and "0.1 s" in texts[1] and "2 cranes" in texts[2]
