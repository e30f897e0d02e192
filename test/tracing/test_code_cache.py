"""Compiled code on the disk: damage, or what prevents writing, costs only compilations."""

import errno
import os
import random
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from process_helpers import run_to_completion

from crane_sim.hardware.instruments import fill_standard_normals
from crane_sim.numerics.jit import entry_point
from crane_sim.tracing import cache
from crane_sim.tracing.compile_time import compile_time, watch_compiling


def test_sources_that_are_no_files_are_left_out(tmp_path: Path) -> None:
    """A link to nowhere, as an editor leaves beside a file that is being changed, is no source."""
    (tmp_path / "a.py").write_text("A = 1\n")
    before = cache.digest((tmp_path,))
    (tmp_path / ".#a.py").symlink_to("user@host.123")
    assert cache.digest((tmp_path,)) == before and cache.SourceState((tmp_path,)).is_current()


def test_old_folders_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the folders of other states of the sources, the newest few are kept."""
    root = tmp_path / "crane_sim"
    for i in range(cache.MAX_CACHES + 2):
        (root / str(i)).mkdir(parents=True)
        os.utime(root / str(i), (i, i))
    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    folder = cache.cache_folder()
    kept = {str(i) for i in range(3, cache.MAX_CACHES + 2)}
    assert {entry.name for entry in root.iterdir()} == {folder.name, *kept}


@pytest.mark.parametrize("kind", ["none", "own", "link", "another user's"])
def test_compiled_code_is_only_taken_from_an_own_folder(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A folder of temporary files that another user made, or a link, is not taken."""
    usual = tmp_path / f"crane_sim_{os.getuid()}"
    if kind == "link":
        (tmp_path / "elsewhere").mkdir()
        usual.symlink_to(tmp_path / "elsewhere")
    elif kind != "none":
        usual.mkdir(mode=0o777)
    monkeypatch.setattr(cache.tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("CRANE_SIM_CACHE", "/dev/null/nowhere")
    if kind == "another user's":
        monkeypatch.setattr(cache.os, "getuid", lambda: os.geteuid() + 1)
        (tmp_path / f"crane_sim_{os.getuid()}").mkdir()
    cache._temporary_folder.cache_clear()
    try:
        root = cache.cache_folder().parent
    finally:
        cache._temporary_folder.cache_clear()
    assert (root == usual) is (kind in ("none", "own"))
    assert root.stat().st_mode & 0o077 == 0 and root.parent == tmp_path


def draw_once() -> tuple[bytes, bool]:
    """Return what a function draws, loaded from the cache or compiled, and whether compiled."""
    function, compilations, drawn = (
        entry_point(fill_standard_normals.py_func),
        list[None](),
        np.zeros(4),
    )
    with watch_compiling(lambda: compilations.append(None)):
        function(1, 2, 3, drawn)
    return drawn.tobytes(), bool(compilations)


def test_only_compilation_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Watchers are called, and time counts, for compilations only: not for loading or calls."""
    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    function, seconds, compilations = (
        entry_point(fill_standard_normals.py_func),
        compile_time(),
        list[None](),
    )
    with watch_compiling(lambda: compilations.append(None)):
        function(1, 2, 3, np.zeros(4))
        assert len(compilations) == 1 and compile_time() > seconds
        seconds = compile_time()
        function(4, 5, 6, np.zeros(7))
        entry_point(fill_standard_normals.py_func)(1, 2, 3, np.zeros(4))
    assert len(compilations) == 1 and compile_time() == seconds


def flip_bit(content: bytes) -> bytes:
    """Return bytes with one bit flipped, at a place that follows from them."""
    place = random.Random(content).randrange(8 * len(content))
    flipped = bytearray(content)
    flipped[place // 8] ^= 1 << place % 8
    return bytes(flipped)


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[: len(content) // 2],
        lambda content: content[:-1],
        lambda content: bytes(len(content)),
        lambda content: content[1024:] + content[:1024],
        flip_bit,
    ],
    ids=["empty", "half", "cut", "zeros", "swapped", "flipped"],
)
def test_a_damaged_file_costs_a_compilation(
    damage: Callable[[bytes], bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The function is compiled once more, returns the same, and is whole on disk from then on."""
    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    drawn, compiled = draw_once()
    assert compiled and draw_once() == (drawn, False)
    (file,) = tmp_path.rglob("*.code")
    file.write_bytes(damage(file.read_bytes()))
    assert draw_once() == (drawn, True) and draw_once() == (drawn, False)


def test_a_cache_on_a_full_disk_costs_compilations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a cache file cannot be written, in whole or part, processes compile and leave none."""

    def fail(path: Path, data: bytes) -> None:
        with open(path, "wb") as file:
            file.write(data[:100])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setenv("CRANE_SIM_CACHE", str(tmp_path))
    monkeypatch.setattr(Path, "write_bytes", fail)
    assert draw_once() == draw_once() and draw_once()[1]
    assert not [entry for entry in tmp_path.rglob("*") if entry.is_file()]


def test_a_cache_without_a_folder_costs_compilations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where not even a temporary folder can be made, functions are compiled."""

    def fail(*_: object, **__: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setenv("CRANE_SIM_CACHE", "/dev/null/nowhere")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    monkeypatch.setattr(cache.tempfile, "mkdtemp", fail)
    cache._temporary_folder.cache_clear()
    try:
        assert draw_once() == draw_once() and draw_once()[1]
    finally:
        cache._temporary_folder.cache_clear()


LAW = """
from typing import NamedTuple
from own_gain import GAIN, Gains
from crane_sim.numerics.jit import entry_point
from crane_sim.tracing.compile_time import compile_time

class Offset(NamedTuple):
    value: float
    size: float = GAIN

@entry_point
def law(x, gains):
    return FACTOR * x * gains.own + Gains(1.0).size + Offset(0.0).size
"""


def import_law(folder: Path, gain: float = 0.5, factor: str = "2.0") -> str:
    """Write the files of a law; return what imports it."""
    (folder / "own_gain.py").write_text(
        "from typing import NamedTuple\nfrom own_constant import GAIN\n\n"
        "class Gains(NamedTuple):\n    own: float\n    size: float = GAIN\n"
    )
    (folder / "own_constant.py").write_text(f"GAIN = {gain}\n")
    (folder / "law.py").write_text(LAW.replace("FACTOR", factor))
    return (
        f"import sys; sys.dont_write_bytecode = True; sys.path.insert(0, {str(folder)!r}); from "
        "law import *; "
    )


def run_law(cache_folder: Path, code: str) -> list[str]:
    """Return the words that a process with this cache prints."""
    environment = os.environ | {"CRANE_SIM_CACHE": str(cache_folder)}
    return run_to_completion(
        [sys.executable, "-c", code], env=environment, check=True
    ).stdout.split()


def test_defaults_of_tuples_of_ones_own_are_part_of_the_code(tmp_path: Path) -> None:
    """A default from a third file, of a type in another one, is not taken from older code."""
    call = "print(law(1.0, Gains(1.0)), compile_time() > 0.0)"
    assert run_law(tmp_path / "cache", import_law(tmp_path) + call) == ["3.0", "True"]
    assert run_law(tmp_path / "cache", import_law(tmp_path) + call) == ["3.0", "False"]
    assert run_law(tmp_path / "cache", import_law(tmp_path, 1.5) + call) == ["5.0", "True"]


def test_a_type_of_an_argument_is_part_of_the_code(tmp_path: Path) -> None:
    """A property of a user's type, read in another file, is not taken from older code."""
    (tmp_path / "reader.py").write_text(
        "from crane_sim.numerics.jit import entry_point\n@entry_point\ndef read(x):\n    return "
        "x.twice\n"
    )
    head = f"import sys; sys.dont_write_bytecode = True; sys.path.insert(0, {str(tmp_path)!r}); "
    for factor in ("2.0", "3.0"):
        (tmp_path / "kind.py").write_text(
            "from typing import NamedTuple\nclass X(NamedTuple):\n    own: float\n    @property\n"
            f"    def twice(self):\n        return {factor} * self.own\n"
        )
        code = f"{head}from reader import read; from kind import X; print(read(X(1.5)))"
        assert run_law(tmp_path / "cache", code) == [str(1.5 * float(factor))]


def test_code_of_a_file_that_was_edited_in_between_is_not_kept(tmp_path: Path) -> None:
    """A session that goes on with imported functions leaves no code for the edited file."""
    begin, file = import_law(tmp_path), tmp_path / "law.py"
    edited = file.read_text().replace("2.0 *", "4.0 *")
    edit = f"open({str(file)!r}, 'w').write({edited!r}); "
    # another structure: compiled anew
    first, second = "print(law(1.0, Gains(1.0))); ", "print(law(1.0, Gains(1)))"
    assert run_law(tmp_path / "cache", begin + first + edit + second) == ["3.0", "3.0"]
    assert run_law(tmp_path / "cache", begin + second) == ["5.0"]


def test_which_of_two_functions_a_name_is_decides_on_the_code(tmp_path: Path) -> None:
    """A function defined in one of two ways by a condition is not taken from the other one."""
    (tmp_path / "either.py").write_text(
        "import sys\nif sys.argv[1] == 'twice':\n    def scale(x):\n        return 2.0 * x\n"
        "else:\n    def scale(x):\n        return 3.0 * x\n"
    )
    (tmp_path / "caller.py").write_text(
        "from either import scale\nfrom crane_sim.numerics.jit import entry_point\n"
        "@entry_point\ndef call(x):\n    return scale(x)\n"
    )
    head = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); "
    for word, result in (("twice", "3.0"), ("thrice", "4.5")):
        code = f"{head}sys.argv = ['', {word!r}]; from caller import call; print(call(1.5))"
        assert run_law(tmp_path / "cache", code) == [result]
