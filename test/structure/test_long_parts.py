"""Long tests run in parts, one with each commit."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from long_parts import PARTS, part_of, part_of_commit
from process_helpers import run_to_completion

TEST = Path(__file__).parents[1]
NESTED = """
import pytest

@pytest.mark.long
@pytest.mark.parametrize("case", range(40))
def test_long(case):
    pass

@pytest.mark.long(cases=["1"])
@pytest.mark.parametrize("case", [0, 1])
def test_one_case_is_long(case):
    pass
"""
LONG = [f"test_nested.py::test_long[{case}]" for case in range(40)] + [
    "test_nested.py::test_one_case_is_long[1]"
]


def run_pytest(folder: Path, *options: str) -> str:
    """Return the output of a session of the long tests in `folder`."""
    usual = ["-p", "conftest", "-c", str(TEST.parent / "pyproject.toml"), "--rootdir", str(folder)]
    result = run_to_completion(
        [sys.executable, "-m", "pytest", *usual, "-m", "long", *options, str(folder)],
        env=os.environ
        | {
            "PYTHONPATH": os.pathsep.join(
                map(str, (TEST, TEST / "helpers", TEST / "programs", TEST.parent))
            )
        },
        cwd=folder,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def collect(folder: Path, *options: str) -> tuple[list[str], str]:
    """Return the ids of long tests in `folder` that a session would run, and its output.

    The session has these options.
    """
    output = run_pytest(folder, "--collect-only", "-n", "0", *options)
    return [line for line in output.splitlines() if "::" in line], output


def test_the_parts_cover_every_long_test_once(tmp_path: Path) -> None:
    """Each long test is in one part, whichever file it is in.

    What runs is printed, and how to run the others.
    """
    (tmp_path / "test_nested.py").write_text(NESTED)
    parts = [collect(tmp_path, "--part", str(part)) for part in range(PARTS)]
    assert sorted(test for tests, _ in parts for test in tests) == sorted(LONG)
    assert all(
        "the others: --part" in output and f"part {part} of" in output
        for part, (_, output) in enumerate(parts)
    )
    assert part_of("test/a.py::test_long[3]") == part_of("test/b/c.py::test_long[3]")


def test_workers_run_the_part_that_is_due(tmp_path: Path) -> None:
    """`--part auto` is the session's part in a worker as without one, here part 0."""
    (tmp_path / "test_nested.py").write_text(NESTED)
    number = [part_of(test) for test in LONG].count("0")
    assert 0 < number < len(LONG)
    for workers in ("0", "1"):
        assert f"{number} passed" in run_pytest(tmp_path, "--part", "auto", "-n", workers)


def git(folder: Path, *arguments: str) -> None:
    """Run a command of git in `folder`."""
    identity = ["-c", "user.name=tests", "-c", "user.email=tests@localhost"]
    subprocess.run(
        ["git", *identity, *arguments], cwd=folder, check=True, capture_output=True, timeout=60.0
    )


def test_consecutive_commits_run_all_parts(tmp_path: Path) -> None:
    """As many commits in a row as there are parts run each part once; without git part 0 runs."""
    assert part_of_commit(tmp_path) == "0"
    git(tmp_path, "init", "-q")
    due = []
    for number in range(PARTS):
        git(tmp_path, "commit", "-q", "--allow-empty", "-m", f"commit {number}")
        due.append(part_of_commit(tmp_path))
    assert sorted(due) == [str(part) for part in range(PARTS)]


def test_commits_of_shallow_clones_run_several_parts(tmp_path: Path) -> None:
    """A clone of one commit does not run one part for ever: its hash decides.

    Many services have such clones.
    """
    git(tmp_path, "init", "-q", "whole")
    due = set()
    for number in range(40):  # all of one part: once in 4^39
        git(tmp_path / "whole", "commit", "-q", "--allow-empty", "-m", f"commit {number}")
        git(tmp_path, "clone", "-q", "--depth", "1", (tmp_path / "whole").as_uri(), str(number))
        due.add(part_of_commit(tmp_path / str(number)))
    assert len(due) > 1


@pytest.mark.parametrize("part", ["4", "next"])
def test_other_parts_are_refused(part: str, tmp_path: Path) -> None:
    """A part that is none ends the session before any test."""
    (tmp_path / "test_nested.py").write_text(NESTED)
    with pytest.raises(AssertionError, match="invalid choice"):
        collect(tmp_path, f"--part={part}")
