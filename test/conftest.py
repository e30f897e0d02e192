"""Fixtures and hooks of all tests: own ROS domains, time limits, and checks for leftovers."""

import faulthandler
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

import changed_files
import file_processes
import hypothesis
import long_parts
import pytest
import session_guard

from crane_sim.orchestration import process_group, shutdown, supervisor
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain

# the same examples in every run, on a slow machine too; the long fuzzing tests draw new ones
hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.load_profile("repeatable")

_LONGEST = {"test_architecture.py", "test_study_runs.py", "test_batch.py", "test_catalogue_runs.py"}
_AGAIN = 60.0  # s from a test's limit until its clean-up is interrupted, too


@pytest.fixture
def domain_id() -> Iterator[int]:
    """Yield a ROS domain id that no other process on this machine uses."""
    with reserve_domain() as domain:
        yield domain


@pytest.fixture
def ros_environment(domain_id: int, tmp_path: Path) -> dict[str, str]:
    """Return the environment of a node in this test's domain, with checks of message fields."""
    return node_environment(domain_id, tmp_path) | {"ROS_PYTHON_CHECK_FIELDS": "1"}


@pytest.fixture
def patient_shutdown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give nodes of an interrupted run a minute for summaries and files, not a user's 3 s."""
    monkeypatch.setattr(process_group, "_SHUTDOWN_TIMEOUT", 60.0)
    for module in (supervisor, shutdown):
        monkeypatch.setattr(module, "_SHUTDOWN_SUMMARY_TIMEOUT", 60.0)


@pytest.fixture(scope="session", autouse=True)
def no_process_left() -> Iterator[None]:
    """Fail the session when a process that a test started outlives it, and end that process.

    It is ended also when this process is killed.
    """
    mark = str(uuid.uuid4())  # a session within a test of another one has both marks
    os.environ[session_guard.VARIABLE] = (
        f"{os.environ.get(session_guard.VARIABLE, '')} {mark}".strip()
    )
    with _guard(mark):
        yield
        deadline = time.monotonic() + 10.0
        while (leftover := _find_others(mark)) and time.monotonic() < deadline:
            time.sleep(0.1)
        for pid in leftover:
            os.kill(pid, signal.SIGKILL)
        assert not leftover, (
            f"processes outlived the tests, and were killed: {list(leftover.values())}"
        )


@contextmanager
def _guard(mark: str) -> Iterator[None]:
    """Run the session guard in a session of its own, beyond signals to this process's group."""
    command = [sys.executable, "-I", "-S", session_guard.__file__, str(os.getpid()), mark]
    env = {name: value for name, value in os.environ.items() if name != session_guard.VARIABLE}
    with subprocess.Popen(
        command, env=env, stdout=subprocess.PIPE, start_new_session=True
    ) as guard:
        try:
            assert guard.stdout is not None and guard.stdout.readline() == b"ready\n"
            yield
        finally:
            guard.kill()


def _find_others(mark: str) -> dict[int, str]:
    """Return the other processes of this session.

    multiprocessing's resource tracker ends with its process.
    """
    found = {
        pid: command
        for pid, command in session_guard.find_marked(mark).items()
        if pid != os.getpid()
    }
    return {
        pid: command
        for pid, command in found.items()
        if pid != resource_tracker._resource_tracker._pid
    }


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the time limit of `pyproject.toml`, and the part of the long tests."""
    parser.addini(
        "test_limit",
        "s for each phase of a test, which fails then; 0: none",
        type="string",
        default="0",
    )
    parts = (
        f"of the long tests only this part, of {long_parts.PARTS}; auto: the one that is due at "
        "this commit"
    )
    parser.addoption("--part", choices=long_parts.CHOICES, help=parts)
    changed_files.add_option(parser)


@contextmanager
def _limited(item: pytest.Item) -> Iterator[None]:
    """Fail the block after the time limit.

    Code that does not return to Python is left to `faulthandler_timeout`.

    Long tests have twice the time, slow ones have no limit.
    """
    usual = float(item.config.getini("test_limit"))
    limit = (
        0.0
        if item.get_closest_marker("slow")
        else 2.0 * usual
        if item.get_closest_marker("long")
        else usual
    )

    def expire(*_: object) -> None:
        faulthandler.dump_traceback(file=sys.__stderr__)
        pytest.fail(f"{item.nodeid}: still ran after {limit:g} s")

    before = signal.signal(signal.SIGALRM, expire)
    signal.setitimer(signal.ITIMER_REAL, limit, _AGAIN if limit else 0.0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def pytest_configure(config: pytest.Config) -> None:
    """Let processes of tests share byte code where Python is told to write none.

    Each would compile all modules otherwise.
    """
    long_parts.choose_part(config)
    changed_files.choose_files(config)
    if _worker_of(config):
        config.pluginmanager.register(file_processes.FileProcesses())
    if os.environ.get("PYTHONDONTWRITEBYTECODE") and not _worker_of(config):
        folder = tempfile.mkdtemp(prefix="crane_sim-bytecode-")
        config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
        os.environ["PYTHONPYCACHEPREFIX"] = folder
        del os.environ["PYTHONDONTWRITEBYTECODE"]


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Give a worker the part of the long tests: it reads the options of the command line anew."""
    node.workerinput["part"] = node.config.option.part


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Let every other worker collect from the last file on: each finds the other's byte code."""
    report = yield
    if _worker_of(collector.config)[-1:] in {*"13579"} and isinstance(collector, pytest.Directory):
        report.result.reverse()
    return report


def _worker_of(config: pytest.Config) -> str:
    """Return the name of this worker, such as gw1; "" where there are none."""
    return getattr(config, "workerinput", {"workerid": ""})["workerid"]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Take the mark `long(cases=[…])` from other cases before `-m` selects.

    Then `--part` selects.

    The longest files are first: at the end of the tests a worker has nothing to do while the other
    one runs a file of minutes. Workers must have one order of files.
    """
    if _worker_of(config):
        items.sort(key=lambda item: str(item.path))
    items.sort(key=lambda item: item.path.name not in _LONGEST)
    for item in items:
        mark = item.get_closest_marker("long")
        if mark is None or "cases" not in mark.kwargs:
            continue
        assert isinstance(item, pytest.Function)
        if item.callspec.id not in mark.kwargs["cases"]:
            item.own_markers.remove(mark)
    long_parts.deselect_other_parts(config, items)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, Any, Any]:
    """Limit the time of a test's fixtures; slow tests have no limit."""
    if item.get_closest_marker("slow"):
        faulthandler.cancel_dump_traceback_later()
    with _limited(item):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, Any, Any]:
    """Limit the time of a test."""
    with _limited(item):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, Any, Any]:
    """Limit the time of the clean-up of a test's fixtures."""
    with _limited(item):
        return (yield)


@pytest.hookimpl(optionalhook=True)
def pytest_handlecrashitem(crashitem: str, sched: Any) -> None:
    """Mark a test that crashed its worker as done: the next one would try it again."""
    # of the schedulers that keep files together
    for unit in getattr(sched, "workqueue", {}).values():
        if crashitem in unit:
            unit[crashitem] = True  # done


_FILES = pytest.StashKey[set[str]]()


def shared_files() -> set[str]:
    """Return the names of Fast DDS's files in shared memory."""
    return {
        name for name in os.listdir("/dev/shm") if name.startswith(("fastrtps", "sem.fastrtps"))
    }


def pytest_sessionstart(session: pytest.Session) -> None:
    """Record files in shared memory before the first test; a worker is killed with its leader."""
    if _worker_of(session.config):
        session_guard.tie_to_parent()
    session.config.stash[_FILES] = shared_files()


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail when tests leave files in shared memory; of several workers, only the leader checks."""
    leftover = shared_files() - session.config.stash[_FILES]
    if leftover and not _worker_of(session.config):
        print(f"\nfiles left in /dev/shm: {sorted(leftover)}")
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
