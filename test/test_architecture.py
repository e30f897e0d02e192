"""The structure: layers point one way, functions stay small, the code is typed and clean."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from process_helpers import completed

from crane_sim import compiled

ROOT = Path(__file__).parents[1]
SOURCES = sorted(file for package in ("crane_sim", "crane_control") for file in (ROOT / package).rglob("*.py"))
KERNELS = """supports cables loads overhead integrators frames effects model outputs sources stepping system
state_algebra array_algebra lane_algebra angles linear_systems meter jit compiled quantities references
base base_motions stops crane_modes""".split()
ABOVE = """hardware passage outcome starts batch batch_scenes batch_lanes batch_loops scene scene_document forms
lagrange reproduce description laws plant rollout functions averaging metrics tracking report cli
run_options scene_options help_lines orchestration ros recording bench league soak documentation commands
interruption""".split()
ROS = ("rclpy", "sensor_msgs", "std_msgs", "std_srvs", "geometry_msgs", "trajectory_msgs", "rosgraph_msgs")


def name_of(file: Path) -> str:
    """Return the dotted module name of a source file."""
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def imports(file: Path) -> Iterator[str]:
    """Yield the dotted names of the modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def importers(*modules: str) -> set[str]:
    """Return the names of the files that import one of the modules, or from inside one."""
    return {
        name_of(file)
        for file in SOURCES
        if any(found == module or found.startswith(module + ".") for found in imports(file) for module in modules)
    }


def is_kernel(name: str) -> bool:
    """Return whether a module belongs to the layer of models, effects and integrators."""
    _, _, rest = name.partition(".")
    return rest.split(".")[0] in KERNELS


def test_ros_stays_in_its_nodes() -> None:
    """Only the nodes import ROS: physics has none."""
    found = importers(*ROS)
    nodes = ("crane_control.controller_node", "crane_control.tracker_node")
    assert found and all(name.startswith("crane_sim.ros") or name in nodes for name in found)


def test_rerun_stays_in_the_recording() -> None:
    """Only the recording imports Rerun, and no kernel imports the recording."""
    assert importers("rerun") and all(name.startswith("crane_sim.recording") for name in importers("rerun"))
    assert not any(is_kernel(name) for name in importers("crane_sim.recording"))


def test_numba_stays_in_its_files() -> None:
    """Numba appears in the decorators and in the files of arithmetic beside them, and nowhere else."""
    arithmetic = ("state_algebra", "state_floats", "array_algebra", "lane_algebra", "fused")
    assert importers("numba") == {"crane_sim.jit", *(f"crane_sim.{name}" for name in arithmetic)}


def test_the_simulator_does_not_know_its_laws() -> None:
    """`crane_sim` never imports `crane_control`: laws are found by name."""
    assert not {name for name in importers("crane_control") if name.startswith("crane_sim")}


def test_kernels_know_no_scene() -> None:
    """Models, effects and integrators import no scene, law, plant, report or process."""
    assert not {name for name in importers(*(f"crane_sim.{part}" for part in ABOVE)) if is_kernel(name)}


def test_plain_folders_change_no_kernel() -> None:
    """Folders that the digest of compiled code leaves out have no kernel, and no file with one imports them."""
    plain = tuple(f"crane_sim.{name}" for name in compiled.PLAIN)
    kernels = importers("crane_sim.jit")
    assert kernels and not any(name.startswith(plain) for name in kernels)
    assert not {name for name in importers(*plain) & kernels if not name.startswith("crane_sim.bench")}


def test_integrators_know_no_crane() -> None:
    """Integrators import neither supports nor cables nor the model."""
    models = importers(
        "crane_sim.supports", "crane_sim.cables", "crane_sim.model", "crane_sim.effects", "crane_sim.overhead"
    )
    assert not {name for name in models if name.startswith("crane_sim.integrators")}


@pytest.mark.parametrize("file", SOURCES, ids=name_of)
def test_sizes(file: Path) -> None:
    """A function has at most 25 lines and a compiled or registered one 40, docstring not counted."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.FunctionDef):
            documented = ast.get_docstring(node) is not None
            first = node.body[1].lineno if documented and len(node.body) > 1 else node.body[0].lineno
            lines = (node.end_lineno or 0) - first + 1
            limit = 40 if node.decorator_list else 25
            assert lines <= limit, f"{name_of(file)}.{node.name} has {lines} lines"


@pytest.mark.parametrize(
    "command",
    [["ruff", "check", "."], ["ruff", "format", "--check", "."], ["basedpyright"]],
    ids=["lint", "format", "types"],
)
def test_the_code_is_clean(command: list[str]) -> None:
    """The linter, the formatter and the type checker have nothing to say."""
    program = Path(sys.executable).with_name(command[0])
    done = completed([str(program), *command[1:]], cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
