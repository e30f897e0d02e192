"""Compiled code is never stale, and is the same for concurrent processes and threads."""

import copy
import importlib
import math
import os
import pickle
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any, NamedTuple

import numpy as np
import pytest
from process_helpers import run_to_completion

from crane_sim.files.errors import SceneError
from crane_sim.hardware.instruments import fill_standard_normals
from crane_sim.numerics.jit import entry_point, seldom_called
from crane_sim.simulation.rollout import simulate
from crane_sim.tracing.compile_time import watch_compiling

ROOT = Path(__file__).parents[2]
PROBE = """
import crane_sim
print([crane_sim.energy('knuckle_setpoint', [0, 0, 0, 1, 0, 0], [0] * 6) for _ in range(10)][-1])
"""  # compiled, as it is called so often


def probe(tree: Path, cache: Path, code: str = PROBE) -> str:
    """Return what `code` prints with the package of `tree` and the given cache folder."""
    left_out = "PYTHONPYCACHEPREFIX"  # the tree's byte code stands in it, and is removed with it
    inherited = {key: value for key, value in os.environ.items() if key != left_out}
    environment = inherited | {"PYTHONPATH": str(tree), "CRANE_SIM_CACHE": str(cache)}
    done = run_to_completion([sys.executable, "-c", code], env=environment, cwd=tree, check=True)
    return done.stdout.strip()


def copied_tree(folder: Path) -> Path:
    """Return a copy of the packages and scenes, to be edited."""
    skip = shutil.ignore_patterns("__pycache__")
    for name in ("crane_sim", "crane_control", "config"):
        shutil.copytree(ROOT / name, folder / name, ignore=skip)
    return folder


def test_a_change_in_any_file_is_recompiled(tmp_path: Path) -> None:
    """After a callee in another file changed, the next process computes anew.

    It does so even with the file's old time stamp and size.
    """
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
    # Python's cache of byte code goes by time stamps
    shutil.rmtree(callee.parent / "__pycache__", ignore_errors=True)
    # at gamma = 0 the changed term is zero, so lift the jib
    lifted = PROBE.replace("[0, 0, 0, 1", "[0, 0, 1, 1")
    assert float(probe(tree, cache, lifted)) != float(probe(ROOT, cache, lifted))
    # one folder for each state of the sources
    assert len(list((cache / "crane_sim").iterdir())) == 2


def test_nothing_is_cached_after_sources_have_changed(tmp_path: Path) -> None:
    """A process whose sources were edited after import writes nothing that others could load."""
    tree, cache = copied_tree(tmp_path / "tree"), tmp_path / "cache"
    edit = (
        "import crane_sim.simulation.metrics, pathlib;"
        "p = pathlib.Path('crane_sim/models/rotating_frame.py'); p.write_text(p.read_text() + '#');"
    )
    probe(tree, cache, edit + PROBE)
    assert not list(cache.rglob("*.code"))


def test_processes_share_a_cache(tmp_path: Path) -> None:
    """Three processes that compile the same code at once return the same, and leave whole files."""
    with ThreadPoolExecutor() as pool:
        energies = set(pool.map(lambda _: probe(ROOT, tmp_path), range(3)))
    assert len(energies) == 1
    assert {file.suffix for file in tmp_path.rglob("*") if file.is_file()} == {".code"}
    compiled = (
        f"from crane_sim.tracing.compile_time import compile_time{PROBE}print(compile_time())"
    )
    assert probe(ROOT, tmp_path, compiled).split()[-1] == "0.0"


def test_threads_share_an_entry_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Threads that call an entry point at once, before and after compilation, do not mix."""
    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    draw, together = entry_point(fill_standard_normals.py_func), Barrier(4)

    def drawn(thread: int) -> list[bytes]:
        together.wait(60.0)  # s, of a start of threads
        found = []
        for k in range(200):
            out = np.zeros(3)
            draw(thread, 1, k, out)
            found.append(out.tobytes())
        return found

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(drawn, range(4)))
    for thread, rows in enumerate(found):
        for k, row in enumerate(rows):
            out = np.zeros(3)
            with np.errstate(over="ignore"):  # arithmetic on words
                draw.py_func(thread, 1, k, out)
            assert row == out.tobytes()


OWN_FUNCTION = """
from own_constants import GAIN
from crane_sim.numerics.jit import entry_point
from crane_sim.tracing.compile_time import compile_time

def twice(x):
    return 2.0 * x

@entry_point
def amplified(x):
    return GAIN * twice(x)

print(amplified(1.5), compile_time() > 0.0)
"""


def test_a_function_of_ones_own_is_compiled_anew_when_it_changes(tmp_path: Path) -> None:
    """Code of files outside the packages is loaded again until they or values they take change."""
    (tmp_path / "own_constants.py").write_text("GAIN = 5.0\n")
    (tmp_path / "own.py").write_text(OWN_FUNCTION)
    own = (
        f"import sys; sys.dont_write_bytecode = True; sys.path.insert(0, {str(tmp_path)!r}); "
        "import own"
    )
    assert [probe(ROOT, tmp_path / "cache", own) for _ in range(2)] == ["15.0 True", "15.0 False"]
    (tmp_path / "own.py").write_text(OWN_FUNCTION.replace("2.0 * x", "3.0 * x"))
    assert [probe(ROOT, tmp_path / "cache", own) for _ in range(2)] == ["22.5 True", "22.5 False"]
    (tmp_path / "own_constants.py").write_text("GAIN = 7.0\n")
    assert [probe(ROOT, tmp_path / "cache", own) for _ in range(2)] == ["31.5 True", "31.5 False"]


def test_a_file_that_has_changed_is_not_traced_in_place_of_the_imported_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A function whose file was edited after its import is an error, until it is imported anew."""
    source = (
        "from crane_sim.numerics.jit import entry_point\n\n@entry_point\ndef scaled(x):\n    "
        "return 2.0 * x\n"
    )
    file = tmp_path / "edited_module.py"
    file.write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    module = importlib.import_module("edited_module")
    file.write_text(source.replace("2.0", "3.0"))
    with pytest.raises(SceneError, match="edited_module.py has changed since scaled was imported"):
        module.scaled(1.0)
    assert importlib.reload(module).scaled(1.0) == 3.0


FACTORY = """
from crane_sim.numerics.jit import entry_point

def multiplied_by(k):
    @entry_point
    def multiplied(x):
        return k * x
    return multiplied

print(multiplied_by(2.0)(1.5), multiplied_by(3.0)(1.5))
"""


def test_functions_of_one_name_are_not_mixed_up(tmp_path: Path) -> None:
    """Functions that differ in outer variables have their own code, in a second process, too."""
    (tmp_path / "own.py").write_text(FACTORY)
    own = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import own"
    assert [probe(ROOT, tmp_path / "cache", own) for _ in range(2)] == ["3.0 4.5"] * 2


OWN_POTENTIAL = """
from crane_sim import system
from crane_sim.models.single_rope.crane import Crane

@system.potential.register(Crane)
def constant(p, x):
    return 100.0
"""


def test_an_implementation_of_ones_own_stays_in_its_process(tmp_path: Path) -> None:
    """A process with its own implementation for a package's type shares no code with others."""
    (tmp_path / "mine.py").write_text(f"{OWN_POTENTIAL}\n{PROBE}")
    mine, cache = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import mine",
        tmp_path / "cache",
    )
    own, usual = probe(ROOT, cache, mine), probe(ROOT, cache)
    assert own == probe(ROOT, cache, mine) != usual == probe(ROOT, cache)


def test_without_compilation_the_numbers_are_the_same() -> None:
    """With CRANE_SIM_INTERPRETED=1 plain Python ends in the same state, bit for bit."""
    code = (
        "import crane_sim; r = crane_sim.simulate('knuckle_setpoint', duration=0.05);"
        "print(r.summary['state_sha256'], r.summary['rhs_evaluations'])"
    )
    environment = os.environ | {"CRANE_SIM_INTERPRETED": "1"}
    plain = run_to_completion([sys.executable, "-c", code], env=environment, check=True)
    run = simulate("knuckle_setpoint", duration=0.05)
    assert plain.stdout.split() == [
        run.summary["state_sha256"],
        str(run.summary["rhs_evaluations"]),
    ]


@entry_point
def with_a_default(x, factor=2.0):
    """Return a product."""
    return x * factor


def test_arguments_that_are_left_out_have_their_defaults() -> None:
    """Defaults are compiled as other arguments; too few or too many give Python's error."""
    assert (with_a_default(3.0), with_a_default(3.0, 0.5)) == (6.0, 1.5)
    assert len(with_a_default.signatures) == 1
    for arguments in ((), (1.0, 2.0, 3.0)):
        with pytest.raises(TypeError, match="with_a_default"):
            with_a_default(*arguments)


@entry_point
def views_of(a, n):
    """Return views of an array (4, 4), and an array as it is."""
    return a.T, a[:, 0:2], a[1:n], a[0][::-1], a


def test_views_that_are_returned_have_their_own_elements() -> None:
    """Results of any strides are Python's, and a returned argument is that argument."""
    a = np.arange(16.0).reshape(4, 4)
    results = views_of(a, 3)
    for result, expected in zip(results, views_of.py_func(a, 3), strict=True):
        assert result.tolist() == expected.tolist()
    assert results[-1] is a


@entry_point
def size_of(a):
    """Return the sizes of an array."""
    return a.shape


def test_an_array_may_have_another_shape_in_the_next_call() -> None:
    """The same array whose shape was set is not taken for what it was."""
    a = np.zeros((2, 3))
    assert size_of(a) == (2, 3)
    a.shape = (3, 2)
    assert size_of(a) == (3, 2)


@entry_point
def add_in_place(a, x):
    """Add to an array and return its largest entry."""
    a += x
    return a.max()


def test_augmented_assignment_changes_an_array() -> None:
    """As in Python the array is changed, not just the variable; nan is the largest entry."""
    a = np.array([1.0, 5.0, 2.0])
    assert add_in_place(a, 1.5) == 6.5
    assert a.tolist() == [2.5, 6.5, 3.5]
    assert np.isnan(add_in_place(np.array([1.0, np.nan, 2.0]), 0.0))


class Motion(NamedTuple):
    """A state with an array, as a run passes it from call to call."""

    t: float
    x: Any  # (n,)
    scratch: Any  # (n, 2), the same all the time


@entry_point
def moved(motion, u):
    """Return (the state after a step, a view of it whose elements are apart)."""
    x = np.empty_like(motion.x)
    for i in range(len(x)):
        x[i] = motion.x[i] + u[0]
        motion.scratch[i, 0] += 1.0
    return Motion(motion.t + 0.5, x, motion.scratch), Motion(motion.t, x[::-1], motion.scratch)


def start() -> Motion:
    """Return a state at rest."""
    return Motion(0.0, np.zeros(3), np.zeros((3, 2)))


def test_what_a_call_returned_may_be_passed_to_any_later_one() -> None:
    """Results passed as arguments have their own values: last or older ones, views, others'."""
    first = start()
    states = [first]
    for k in range(3):
        states.append(moved(states[-1], (float(k + 1),))[0])
    assert [(each.t, each.x[0], each.scratch[0, 0]) for each in states] == [
        (0.0, 0.0, 3.0),
        (0.5, 1.0, 3.0),
        (1.0, 3.0, 3.0),
        (1.5, 6.0, 3.0),
    ]
    assert all(each.scratch is first.scratch for each in states)
    again, turned = moved(states[1], (2,))  # another structure: an integer
    assert (again.t, again.x.tolist()) == (1.0, [3.0] * 3)
    states[2].x[0] = 7.0
    assert moved(states[2], (1.0,))[1].x.tolist() == [4.0, 4.0, 8.0]
    assert moved(turned, (1.0,))[0].x.tolist() == [4.0] * 3


def test_callers_with_calls_of_their_own_share_the_code_alone() -> None:
    """What callers pass in turn does not mix; copies, in any process, are the same function."""
    callers = [moved.with_own_calls() for _ in range(2)]
    callers.append(copy.deepcopy(callers[0]))
    states = [start() for _ in callers]
    for _ in range(3):
        states = [
            call(state, (float(k),))[0]
            for k, (call, state) in enumerate(zip(callers, states, strict=True))
        ]
    assert [state.x.tolist() for state in states] == [[0.0] * 3, [3.0] * 3, [6.0] * 3]
    assert all(call.signatures == moved.signatures for call in callers)
    assert pickle.loads(pickle.dumps(callers[2])).signatures == moved.signatures


@entry_point
@seldom_called
def quotient(x, y):
    """Return x / y, which in Python is an error where y is 0."""
    return x / y


def test_a_function_that_is_seldom_called_is_compiled_late(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its first calls run as plain Python, with the same results; an error there compiles it."""
    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    function, compilations = entry_point(quotient.py_func), list[None]()
    with watch_compiling(lambda: compilations.append(None)):
        first = [function(1.0, 3.0) for _ in range(function.py_func.plain_calls)]
        assert not compilations and function(1.0, 3.0) == first[0] and len(compilations) == 1
        # loaded: another process has compiled it
        assert quotient(1.0, 0.0) == math.inf and len(compilations) == 1
        assert entry_point(quotient.py_func)(1.0, 3.0) == first[0] and len(compilations) == 1
        function._loaded.clear()  # as where code of many other structures has come since
        function._calls.clear()
        assert function(1.0, 3.0) == first[0] and len(compilations) == 1


def test_where_plain_python_raises_an_error_code_is_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A division by zero has the result of compiled code from the first call on."""
    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    assert entry_point(quotient.py_func)(1.0, 0.0) == math.inf
