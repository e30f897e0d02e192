"""Compiled code is never stale, computes what plain Python does, and contains nothing that a scene leaves out."""

import os
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from crane_sim.numerics.linked_library import LinkedLibrary, linked_sources
from process_helpers import run_to_completion

import crane_sim
from crane_sim.models.effects import PayloadDrag, add_drag
from crane_sim.models.rotating_frame import inertial_velocity
from crane_sim.numerics import jit
from crane_sim.numerics.states import add, add_scaled, dimension, leaves, scale, squared_error_norm, weighted_sum
from crane_sim.simulation.rollout import simulate
from crane_sim.tracing.compile_time import compile_time

ROOT = Path(__file__).parents[2]
PROBE = "import crane_sim; print(crane_sim.energy('knuckle_setpoint', [0, 0, 0, 1, 0, 0], [0] * 6))"


def probe(tree: Path, cache: Path, code: str = PROBE) -> str:
    """Return what `code` prints with the package of `tree` and the given cache folder."""
    left_out = "NUMBA", "PYTHONPYCACHEPREFIX"  # the tree's byte code stands in it, and is removed with it
    inherited = {key: value for key, value in os.environ.items() if not key.startswith(left_out)}
    environment = inherited | {"PYTHONPATH": str(tree), "CRANE_SIM_CACHE": str(cache)}
    done = run_to_completion([sys.executable, "-c", code], env=environment, cwd=tree, check=True)
    return done.stdout.strip()


def copied_tree(folder: Path) -> Path:
    """Return a copy of the packages and scenes, to be edited."""
    skip = shutil.ignore_patterns("__pycache__")
    for name in ("crane_sim", "crane_control", "config"):
        shutil.copytree(ROOT / name, folder / name, ignore=skip)
    return folder


@pytest.mark.long
def test_a_change_in_any_file_is_recompiled(tmp_path: Path) -> None:
    """After a callee in another file changed, even with its old time stamp and size, the next process computes anew."""
    tree, cache = copied_tree(tmp_path / "tree"), tmp_path / "cache"
    before = float(probe(tree, cache))
    assert float(probe(tree, cache)) == before  # from the cache
    callee = tree / "crane_sim" / "models" / "supports" / "knuckle_boom.py"
    stamp = callee.stat()
    text = callee.read_text()
    changed = text.replace("energy + 0.5 * gravity * jib.mass", "energy + 9.5 * gravity * jib.mass")
    assert changed != text and len(changed) == len(text)
    callee.write_text(changed)
    os.utime(callee, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    shutil.rmtree(callee.parent / "__pycache__", ignore_errors=True)  # Python's cache of byte code goes by time stamps
    # at gamma = 0 the changed term is zero, so lift the jib
    lifted = PROBE.replace("[0, 0, 0, 1", "[0, 0, 1, 1")
    assert float(probe(tree, cache, lifted)) != float(probe(ROOT, cache, lifted))
    assert len(list((cache / "crane_sim").iterdir())) == 2  # one folder for each state of the sources


def test_nothing_is_cached_after_sources_have_changed(tmp_path: Path) -> None:
    """A process whose sources were edited after it imported them writes nothing that a later one could load."""
    tree, cache = copied_tree(tmp_path / "tree"), tmp_path / "cache"
    edit = (
        "import crane_sim.simulation.metrics, pathlib;"
        "p = pathlib.Path('crane_sim/models/rotating_frame.py'); p.write_text(p.read_text() + '#');"
    )
    probe(tree, cache, edit + PROBE)
    assert not list(cache.rglob("*.nbc"))


def test_processes_share_a_compilation(tmp_path: Path) -> None:
    """Of two processes that need the same code at the same time, one compiles it, and the other one loads it."""
    code = (
        "import crane_sim; from crane_sim.numerics.jit import watch_compiling; compilations = [];"
        "exec('with watch_compiling(lambda: compilations.append(1)): ' + " + repr(PROBE.partition("; ")[2]) + ");"
        "print(bool(compilations))"
    )
    with ThreadPoolExecutor() as pool:
        compiled = list(pool.map(lambda _: probe(ROOT, tmp_path, code).split()[-1], range(2)))
    assert sorted(compiled) == ["False", "True"]
    assert list(tmp_path.rglob("*.nbc")) and not list(tmp_path.rglob("*.lock"))


OWN_TYPE = """
from typing import NamedTuple
from crane_sim import system
from crane_sim.numerics.jit import entry_point, kernel
from crane_sim.simulation.dynamics import energy_at

class Mine(NamedTuple):
    value: float

@kernel
def twice(x):
    return 2.0 * x

@entry_point
def four_times(x):
    return twice(twice(x))

four_times(1.0)
"""
OWN_ENERGY = """
@system.kinetic.register(Mine)
def mine(p, x):
    return twice(p.value)

@system.potential.register(Mine)
def zero(p, x):
    return 0.0

@system.base_energy.register(Mine)
def none(p, t, x):
    return 0.0, 0.0

@system.state.register(Mine)
def state(p, t, q, v):
    return q

assert energy_at(Mine(1.5), 0.0, 1.0, 1.0) == (3.0, 0.0)
"""
FOR_THEIR_TYPE = """
from crane_sim.models.effects import PayloadDrag, add_drag
add_drag.register(PayloadDrag | Mine)(lambda drag, force, velocity: force)
"""


@pytest.mark.parametrize(
    ("own", "cached"),
    [
        pytest.param(OWN_TYPE + OWN_ENERGY, set(), id="functions of own types"),
        pytest.param(OWN_TYPE + PROBE, {"energy_at"}, id="other functions"),
        pytest.param(OWN_TYPE + FOR_THEIR_TYPE + PROBE, set(), id="with an implementation for a type of the packages"),
    ],
)
def test_what_the_digest_does_not_cover_is_not_cached(own: str, cached: set[str], tmp_path: Path) -> None:
    """Neither entry points nor types of a file outside the packages are cached.

    Nothing is, once the file implements a function of the packages for a type of theirs.
    """
    (tmp_path / "mine.py").write_text(own)
    probe(ROOT, tmp_path / "cache", f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import mine")
    assert {file.name.partition(".")[2].partition("-")[0] for file in tmp_path.rglob("*.nbc")} == cached


OWN_POTENTIAL = """
from crane_sim.models.supports import support_potential
from crane_sim.models.supports.knuckle_boom import Knuckle
support_potential.register(Knuckle)(lambda support, pose, gravity: 100.0)
"""


def test_code_of_ones_own_stays_in_its_process(tmp_path: Path) -> None:
    """A process with an implementation of its own loads nothing that others compiled, and leaves them nothing."""
    (tmp_path / "mine.py").write_text(OWN_POTENTIAL + PROBE)
    mine, cache = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import mine", tmp_path / "cache"
    own, usual = probe(ROOT, cache, mine), probe(ROOT, cache)
    assert own == probe(ROOT, cache, mine) != usual == probe(ROOT, cache)


@jit.kernel
def double(x):
    """Return twice a number."""
    return 2.0 * x


@jit.entry_point
def doubled_speed(position, velocity, rate):
    """Return what a kernel of this file makes of the result of one of the packages."""
    return double(inertial_velocity(position, velocity, rate)[0])


def test_the_files_of_compiled_code_are_known() -> None:
    """The files of all functions in compiled code are known: a module may have got one by assignment."""
    assert doubled_speed((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), 0.5) == 6.0
    (compiled,) = doubled_speed.overloads.values()
    files = {Path(file).name for file in linked_sources(compiled.library)}
    assert files == {"test_jit.py", "rotating_frame.py"}


def test_without_compilation_the_numbers_are_the_same(tmp_path: Path) -> None:
    """With CRANE_SIM_INTERPRETED=1 everything runs as plain Python and ends in the same state, bit for bit."""
    code = (
        "import crane_sim; r = crane_sim.simulate('knuckle_setpoint', duration=0.05);"
        "print(r.summary['state_sha256'], r.summary['rhs_evaluations'])"
    )
    environment = os.environ | {"CRANE_SIM_INTERPRETED": "1"}
    plain = run_to_completion([sys.executable, "-c", code], env=environment, check=True)
    run = simulate("knuckle_setpoint", duration=0.05)
    assert plain.stdout.split() == [run.summary["state_sha256"], str(run.summary["rhs_evaluations"])]


@jit.entry_point
def compiled_algebra(x, y, h, ks):
    """Return everything that the state algebra computes."""
    row = (0.5, None, 0.25)
    total = weighted_sum(h, row, ks)
    return (
        add(x, y),
        scale(h, x),
        add_scaled(x, h, y),
        total,
        squared_error_norm(x, x, y, 1e-3, 1e-6),
        dimension(x),
        leaves(x),
    )


def test_state_algebra_is_the_same_in_python() -> None:
    """The LLVM forms of the state algebra compute what their Python forms do, to the bit, on nested tuples."""
    rng = np.random.default_rng(3)

    def state() -> tuple:
        a, b, c, d = map(float, rng.normal(size=4))
        return ((a, b), (c,), d)

    x, y, ks, h = state(), state(), (state(), state(), state()), 0.37
    assert compiled_algebra(x, y, h, ks) == (
        add(x, y),
        scale(h, x),
        add_scaled(x, h, y),
        weighted_sum(h, (0.5, None, 0.25), ks),
        squared_error_norm(x, x, y, 1e-3, 1e-6),
        4,
        leaves(x),
    )


@jit.entry_point
def apply_drag(drag, force, velocity):
    """Compiled `add_drag`."""
    return add_drag(drag, force, velocity)


def test_a_generic_function_chooses_by_type() -> None:
    """The body is chosen by the type of the first argument, in Python and compiled; None takes the default."""
    force, velocity = (1.0, 2.0, 3.0), (3.0, 0.0, 4.0)
    assert apply_drag(None, force, velocity) == add_drag(None, force, velocity) == force
    expected = (1.0 - 7.5, 2.0, 3.0 - 10.0)
    assert apply_drag(PayloadDrag(0.5), force, velocity) == add_drag(PayloadDrag(0.5), force, velocity) == expected
    assert add_drag.has_implementation(PayloadDrag) and not add_drag.has_implementation(int)


@jit.entry_point
def velocity_in_a_frame(position, velocity, rate):
    """Compiled `inertial_velocity`."""
    return inertial_velocity(position, velocity, rate)


def test_a_kernel_has_no_machine_code_of_its_own() -> None:
    """A kernel computes what its Python source does, and is compiled only as part of its callers."""
    position, velocity, kernel = (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), cast(Any, inertial_velocity)
    assert velocity_in_a_frame(position, velocity, 0.5) == kernel.py_func(position, velocity, 0.5)
    assert {type(compiled.library) for compiled in kernel.overloads.values()} == {LinkedLibrary}


@pytest.mark.parametrize("group", ["springs", "swing_friction", "payload_drag", "inputs"])
def test_a_group_set_to_none_is_one_left_out(group: str) -> None:
    """Leaving a group out and setting it to nothing give the same model, type for type."""
    left_out = crane_sim.load_scene("knuckle_setpoint")
    empty = crane_sim.load_scene("knuckle_setpoint", {group: {} if group == "springs" else None})
    assert empty.model == left_out.model and repr(empty.model) == repr(left_out.model)


def test_only_compilation_is_reported() -> None:
    """`watch_compiling` calls its function when a kernel is compiled, not when it runs again; the time is counted."""
    compilations: list[str] = []
    seconds = compile_time()

    @jit.entry_point
    def double(x):
        return 2.0 * x

    with jit.watch_compiling(lambda: compilations.append("compiling")):
        assert double(1.0) == 2.0 and compilations
        compilations.clear()
        assert compile_time() > seconds
        seconds = compile_time()
        assert double(2.0) == 4.0 and not compilations and compile_time() == seconds
    assert double(1) == 2.0 and not compilations


@jit.routine_returning("state")
def changed_state(state: Any, given: Any) -> Any:
    """Return the state, a tuple whose last entry may be an array, with the sum of an array added to its first entry."""
    return (state[0] + given.sum(), *state[1:])


@jit.entry_point
def change_repeatedly(state: Any, given: Any, times: int) -> Any:
    """Return the state after many changes."""
    for _ in range(times):
        state = changed_state(state, given)
    return state


def test_routines_without_references_keep_arrays_alive() -> None:
    """A routine that returns its state counts references only where that holds an array: none is freed or kept."""
    given, held = np.ones(3), np.arange(4.0)
    counts = [sys.getrefcount(array) for array in (given, held)]
    assert change_repeatedly((0.0, 1.0), given, 1000) == (3000.0, 1.0)
    total, returned = change_repeatedly((0.0, held), given, 1000)
    assert total == 3000.0 and np.array_equal(returned, [0.0, 1.0, 2.0, 3.0])
    del returned
    assert [sys.getrefcount(array) for array in (given, held)] == counts
