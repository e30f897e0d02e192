"""The structure: layers with imports one way, small functions, and code that is typed and clean."""

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path
from textwrap import dedent

import pytest
from changed_files import imports_in, is_inside
from process_helpers import run_to_completion

from crane_sim.tracing.cache import UNDIGESTED

ROOT = Path(__file__).parents[2]
PACKAGES = ("crane_sim", "crane_control", "crane_bench")
SOURCES = {
    ".".join(file.relative_to(ROOT).with_suffix("").parts): file
    for package in PACKAGES
    for file in sorted((ROOT / package).rglob("*.py"))
}
LAYERS = (
    "crane_sim.process_signals",
    "crane_sim.environment",
    "crane_sim.files",
    "crane_sim.tracing",
    "crane_sim.numerics",
    "crane_sim.multibody",
    "crane_sim.system",
    "crane_sim.laws",
    "crane_sim.trajectories",
    "crane_sim.integrators",
    "crane_sim.models.rotating_frame",
    "crane_sim.models.moving_base",
    "crane_sim.models.wind_load",
    "crane_sim.models.energy_meter",
    "crane_sim.models.effects",
    "crane_sim.models.loads",
    "crane_sim.models.guards",
    "crane_sim.models.stops",
    "crane_sim.models.wind_kink",
    "crane_sim.models.supports",
    "crane_sim.models.cables",
    "crane_sim.models.single_rope",
    "crane_sim.models.contact",
    "crane_sim.models.carrier",
    "crane_sim.models.suspended",
    "crane_sim.models.falls",
    "crane_sim.models.elastic",
    "crane_sim.models.hanging",
    "crane_sim.models.overhead",
    "crane_sim.models.__init__",
    "crane_sim.hardware",
    "crane_sim.stepping",
    "crane_sim.scenes.schema",
    "crane_sim.scenes",
    "crane_sim.simulation",
    "crane_control.estimation",
    "crane_control.tracking",
    "crane_control",
    "crane_sim.description",
    "crane_sim.recording.files",
    "crane_sim.recording.digest",
    "crane_sim.recording.mcap",
    "crane_sim.recording",
    "crane_sim.recording.rerun",
    "crane_sim.recording.read",
    "crane_sim.recording.comparison",
    "crane_sim.recording.rerun.comparison",
    "crane_sim.identification",
    "crane_sim.__init__",
    "crane_sim.study",
    "crane_sim.gym",
    "crane_sim.operator",
    "crane_sim.ros.common",
    "crane_sim.ros.plant",
    "crane_sim.ros.recorder",
    "crane_sim.ros.controller",
    "crane_sim.ros.operator",
    "crane_sim.ros",
    "crane_control.nodes",
    "crane_sim.interfaces",
    "crane_sim.orchestration",
    "crane_sim.report.plotting",
    "crane_sim.report",
    "crane_sim.cli",
    "crane_bench.nodes",
    "crane_bench.page",
    "crane_bench.tables",
    "crane_bench.reproduce",
    "crane_bench.speed",
    "crane_bench.league",
    "crane_bench.soak",
    "crane_bench.documentation",
    "crane_bench.__init__",
    "crane_bench.cli",
)
"""Layers from the bottom up: a module belongs to the longest of these names that it begins with."""
TOPS = {f"{package}.__init__" for package in PACKAGES}
PROJECT_NAME = re.compile(rf"\b(?:{'|'.join(PACKAGES)})(?:\.\w+)+")
ROS = (
    "rclpy",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "geometry_msgs",
    "trajectory_msgs",
    "rosgraph_msgs",
)
COMPILED = ("entry_point", "routine", "generic")  # decorators of jit
LOOSE = 5  # modules at the top of crane_sim


@cache
def tree_of(name: str) -> ast.Module:
    """Return the syntax tree of a module."""
    return ast.parse(SOURCES[name].read_text())


@cache
def imports(name: str) -> frozenset[str]:
    """Return the dotted names that a module imports, anywhere in it and also for types only."""
    return frozenset(imports_in(tree_of(name)))


def names_in_strings(tree: ast.Module) -> Iterator[str]:
    """Yield the project's dotted names in strings and parts of f-strings.

    Strings that are statements do not count.
    """
    prose = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose:
            yield from (match.group() for match in PROJECT_NAME.finditer(node.value))


@cache
def dependencies(name: str) -> frozenset[str]:
    """Return the modules of this project that a module imports, or that it names in a string."""
    named = {module_of(dotted) for dotted in names_in_strings(tree_of(name))} - TOPS
    return frozenset(({module_of(dotted) for dotted in imports(name)} | named) - {None})


def module_of(name: str) -> str | None:
    """Return the module of a dotted name, None where it is not of this project."""
    while name:
        for module in (name, f"{name}.__init__"):
            if module in SOURCES:
                return module
        name = name.rpartition(".")[0]
    return None


def layer_of(name: str) -> int:
    """Return the position of a module's layer."""
    fitting = [layer for layer in LAYERS if name == layer or name.startswith(layer + ".")]
    assert fitting, f"{name}: belongs to no layer"
    return LAYERS.index(max(fitting, key=len))


def importers(*modules: str) -> set[str]:
    """Return the modules that import one of `modules`, or from inside one."""
    return {
        name
        for name in SOURCES
        if any(is_inside(dotted, module) for dotted in imports(name) for module in modules)
    }


@pytest.mark.parametrize("name", SOURCES)
def test_imports_point_down(name: str) -> None:
    """A module belongs to a layer and imports only from its own layer and from those below."""
    upper_layers = {other for other in dependencies(name) if layer_of(other) > layer_of(name)}
    assert not upper_layers, f"{name}: is below {', '.join(sorted(upper_layers))}"


def test_every_layer_has_modules() -> None:
    """Every listed layer has modules."""
    assert {layer_of(name) for name in SOURCES} >= set(range(len(LAYERS)))


def test_no_import_cycles() -> None:
    """Imports have no cycle: a topological sort fails with one."""
    order = list(
        TopologicalSorter({name: dependencies(name) - {name} for name in SOURCES}).static_order()
    )
    assert set(order) == set(SOURCES)


def test_the_page_names_every_layer() -> None:
    """ARCHITECTURE.md is one page that names all folders and modules at the packages' top.

    Their order is bottom up.
    """
    page = (ROOT / "ARCHITECTURE.md").read_text()
    tops = {name.split(".")[1] for name in SOURCES if name.startswith("crane_sim.")} - {"__init__"}
    assert {top for top in tops if not re.search(rf"`{top}(/|\.py)", page)} == set()
    assert page.count("\n") < 120


def test_one_command_counts_the_lines() -> None:
    """The command of ARCHITECTURE.md counts lines of product, laboratory and tests."""
    found = re.search(
        r"^```sh title=\"lines.*?\n(.*?)^```$", (ROOT / "ARCHITECTURE.md").read_text(), re.M | re.S
    )
    assert found is not None
    counted = run_to_completion(["sh", "-c", found[1]], cwd=ROOT, check=True).stdout.splitlines()
    lines = {name: int(number) for number, _, name in (line.partition(" ") for line in counted)}
    assert list(lines) == ["crane_sim crane_control", "crane_bench", "test"]
    assert all(number > 5000 for number in lines.values())


def test_few_loose_modules() -> None:
    """The package has few modules outside of folders."""
    assert (
        len([name for name in SOURCES if name.count(".") == 1 and name.startswith("crane_sim.")])
        <= LOOSE
    )


def test_a_name_in_a_string_is_an_import() -> None:
    """What a function imports counts, and so does what a string names; prose does not.

    The string is as `import_module` takes it.
    """
    text = """
        "crane_sim.cli"
        def load(name):
            "As of crane_sim.gym."
            from crane_sim.study import result
            return import_module(f"crane_sim.recording.rerun.{name}"), "crane_bench.soak.page:write"
    """
    tree = ast.parse(dedent(text))
    assert {*imports_in(tree)} == {"crane_sim.study.result"}
    assert {*names_in_strings(tree)} == {"crane_sim.recording.rerun", "crane_bench.soak.page"}


def test_the_product_imports_no_laboratory() -> None:
    """Neither simulator nor laws import or name `crane_bench`: its commands are entry points."""
    names = {
        name
        for name in SOURCES
        if any(each.startswith("crane_bench") for each in dependencies(name))
    }
    assert names and all(name.startswith("crane_bench.") for name in names)


def test_the_simulator_imports_no_law() -> None:
    """`crane_sim` never imports `crane_control`: laws are looked up by name."""
    assert not {name for name in importers("crane_control") if name.startswith("crane_sim")}


@pytest.mark.parametrize(
    ("packages", "folders"),
    [
        (ROS, ("crane_sim.ros.", "crane_control.nodes.", "crane_bench.nodes.")),
        (("rerun",), ("crane_sim.recording.rerun.",)),
        (("llvmlite",), ("crane_sim.tracing.",)),
        (("gymnasium",), ("crane_sim.gym.",)),
    ],
    ids=["ros", "rerun", "llvmlite", "gymnasium"],
)
def test_packages_stay_in_their_folders(
    packages: tuple[str, ...], folders: tuple[str, ...]
) -> None:
    """ROS, Rerun, llvmlite and Gymnasium are imported in their folders and nowhere else."""
    imported = importers(*packages)
    assert imported and all(name.startswith(folders) for name in imported)


def test_undigested_folders_have_no_compiled_code() -> None:
    """Folders that the digest of compiled code leaves out compile nothing.

    No module that does imports them.
    """
    packages = "crane_sim", "crane_control"
    undigested = tuple(
        f"{package}.{name.replace('/', '.')}" for name in UNDIGESTED for package in packages
    )
    compiled = importers(*(f"crane_sim.numerics.jit.{name}" for name in COMPILED))
    assert compiled and not any(name.startswith(undigested) for name in compiled)
    assert not {
        name for name in importers(*undigested) & compiled if not name.startswith("crane_bench.")
    }


@pytest.mark.parametrize("name", SOURCES)
def test_sizes(name: str) -> None:
    """A function has at most 25 lines, a compiled or registered one 40, without its docstring."""
    for node in ast.walk(tree_of(name)):
        if isinstance(node, ast.FunctionDef):
            documented = ast.get_docstring(node) is not None
            first = (
                node.body[1].lineno if documented and len(node.body) > 1 else node.body[0].lineno
            )
            lines = (node.end_lineno or 0) - first + 1
            limit = 40 if node.decorator_list else 25
            assert lines <= limit, f"{name}.{node.name} has {lines} lines"


@pytest.mark.parametrize(
    "command",
    [["ruff", "check", "."], ["ruff", "format", "--check", "."], ["basedpyright"]],
    ids=["lint", "format", "types"],
)
def test_the_code_is_clean(command: list[str]) -> None:
    """The linter, the formatter and the type checker report nothing."""
    program = Path(sys.executable).with_name(command[0])
    result = run_to_completion([str(program), *command[1:]], cwd=ROOT)
    assert result.returncode == 0, result.stdout + result.stderr


_HARMLESS = {"isinstance", "issubclass", "callable", "hasattr", "len", "all", "any", "keys"}
"""Functions that an assertion may call: the program is the same without it."""


@pytest.mark.parametrize("name", SOURCES)
def test_assertions_have_no_effect(name: str) -> None:
    """No assertion binds a name or calls what may have an effect.

    With PYTHONOPTIMIZE there are no assertions.
    """
    for statement in ast.walk(tree_of(name)):
        if isinstance(statement, ast.Assert):
            for part in ast.walk(statement.test):
                assert not isinstance(part, ast.NamedExpr | ast.Await | ast.Yield), (
                    f"{name}: line {part.lineno}"
                )
                if isinstance(part, ast.Call):
                    called = ast.unparse(part.func).rpartition(".")[2]
                    assert called in _HARMLESS, f"{name}: line {part.lineno} calls {called}"
