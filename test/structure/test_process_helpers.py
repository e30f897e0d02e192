"""The guards of the tests: their programs always end with them; a hanging test fails alone."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from process_helpers import (
    has_exited,
    next_line,
    run_to_completion,
    started_program,
    wait_exited,
    wait_until,
)

TEST = Path(__file__).parents[1]
IGNORES_SIGTERM = """
import os, signal, time
signal.signal(signal.SIGTERM, signal.SIG_IGN)
os.fork()
os.write(1, f"{os.getpid()}\\n".encode())
time.sleep(600)
"""
OTHER_SESSION = """
import os, subprocess, sys, time

def test_that_is_killed():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], start_new_session=True)
    with open("pid_file", "w") as pid_file:
        pid_file.write(f"{os.getpid()} {child.pid}\\n")
    time.sleep(600)
"""  # noqa: E501
HANGING = """
import hashlib, os, time

def test_that_hangs():
    {hang}

def test_behind_it():
    pass
"""


def test_a_program_ends_with_its_block() -> None:
    """One that ignores SIGTERM and its child are gone after the block, whatever is raised."""
    with (
        pytest.raises(ZeroDivisionError),
        started_program(
            [sys.executable, "-c", IGNORES_SIGTERM], grace=0.2, stdout=subprocess.PIPE
        ) as process,
    ):
        both = {int(next_line(process)), int(next_line(process))}
        raise ZeroDivisionError
    for pid in both:
        wait_exited(pid)
    assert process.pid in both and process.returncode == -signal.SIGKILL


def test_a_wait_for_a_program_that_hangs_ends() -> None:
    """At its limit a program is killed: a read from it returns, and the error names the program."""
    with (
        pytest.raises(AssertionError, match="sleep 600: still ran after 0.5 s, and was killed"),
        started_program(["sleep", "600"], limit=0.5, stdout=subprocess.PIPE) as process,
    ):
        next_line(process)
    with pytest.raises(AssertionError, match="sleep 600: still ran after 0.5 s, and was killed"):
        run_to_completion(["sleep", "600"], limit=0.5)


def nested(folder: Path, test: str, *options: str) -> list[str]:
    """Return a command that runs a test in its own session, with this suite's guards and limits."""
    (folder / "test_nested.py").write_text(test)
    usual = ["-p", "conftest", "-c", str(TEST.parent / "pyproject.toml"), "--rootdir", str(folder)]
    return [sys.executable, "-m", "pytest", *usual, *options, str(folder / "test_nested.py")]


def environment() -> dict[str, str]:
    """Return the environment of a session within a test."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")} | {
        "PYTHONPATH": os.pathsep.join(
            [str(TEST), str(TEST / "helpers"), str(TEST / "programs"), str(TEST.parent)]
        )
    }


@pytest.mark.parametrize("workers", ["0", "1"])
def test_nothing_outlives_a_session_that_is_killed(workers: str, tmp_path: Path) -> None:
    """When pytest is killed in a test, its workers and programs end.

    That holds even for programs in a session of their own.
    """
    pid_file = tmp_path / "pid_file"
    with started_program(
        nested(tmp_path, OTHER_SESSION, "-n", workers), env=environment(), cwd=tmp_path
    ) as session:
        wait_until(
            lambda: (
                has_exited(session.pid)
                or (pid_file.exists() and pid_file.read_text().endswith("\n"))
            ),
            "the nested test",
        )
        test_process, other_session = map(int, pid_file.read_text().split())
        assert (
            not has_exited(test_process)
            and not has_exited(other_session)
            and (test_process == session.pid) == (workers == "0")
        )
        session.kill()
        wait_exited(test_process)
        wait_exited(other_session)


@pytest.mark.long(cases=["in compiled code"])
@pytest.mark.parametrize(
    ("hang", "message"),
    [
        ("time.sleep(600)", "test_nested.py::test_that_hangs: still ran after 8 s"),
        (
            'hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)',
            "test_nested.py::test_that_hangs: its process ended with exit status 1",
        ),
        ("os.abort()", "test_nested.py::test_that_hangs: its process ended with signal 6"),
    ],
    ids=["in Python", "in compiled code", "a crash"],
)
def test_a_test_that_hangs_or_crashes_fails_alone(hang: str, message: str, tmp_path: Path) -> None:
    """It fails at its limit, or with its process in compiled code and in a crash.

    Later tests are run.
    """
    # setup starts a process
    limits = ["-n", "1", "-o", "test_limit=8", "-o", "faulthandler_timeout=25"]
    result = run_to_completion(
        nested(tmp_path, HANGING.format(hang=hang), *limits), env=environment(), cwd=tmp_path
    )
    assert message in result.stdout and "1 failed, 1 passed" in result.stdout, (
        result.stdout + result.stderr
    )
    assert result.returncode == 1
