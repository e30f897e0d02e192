"""What all tests share: a ROS domain of their own, and a check that a test session leaves nothing behind."""

import faulthandler
import os
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

from crane_sim.orchestration.children import environment, reserved_domain

_MARK = "CRANE_SIM_TEST_SESSION"


@pytest.fixture
def domain_id() -> Iterator[int]:
    """Yield a ROS domain id that nobody else on this machine uses."""
    with reserved_domain() as domain:
        yield domain


@pytest.fixture
def ros_environment(domain_id: int, tmp_path: Path) -> dict[str, str]:
    """Return the environment of a node in this test's domain, with the message classes checking their fields."""
    return environment(domain_id, tmp_path) | {"ROS_PYTHON_CHECK_FIELDS": "1"}


@pytest.fixture(scope="session", autouse=True)
def no_process_left() -> Iterator[None]:
    """Fail the session when a process that a test started outlives it."""
    os.environ[_MARK] = str(uuid.uuid4())  # every process of this session inherits it
    yield
    deadline = time.monotonic() + 10.0
    while (left := marked_processes()) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert not left, f"processes outlive the tests: {left}"


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Let slow tests take as long as they do: the limit of pyproject.toml is for tests that hang."""
    if item.get_closest_marker("slow"):
        faulthandler.cancel_dump_traceback_later()


@pytest.hookimpl(optionalhook=True)
def pytest_handlecrashitem(crashitem: str) -> None:
    """End the session where a test has taken its worker with it: the next worker would try it again, and so on."""
    pytest.exit(f"{crashitem} has ended its worker: it crashed, or hung, then its stacks are above", returncode=1)


_FILES = pytest.StashKey[set[str]]()


def shared_files() -> set[str]:
    """Return the names of Fast DDS's files in shared memory."""
    return {name for name in os.listdir("/dev/shm") if name.startswith(("fastrtps", "sem.fastrtps"))}


def pytest_sessionstart(session: pytest.Session) -> None:
    """Note what is in shared memory before the first test."""
    session.config.stash[_FILES] = shared_files()


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail when tests leave files in shared memory; of workers side by side, only the leader asks."""
    left = shared_files() - session.config.stash[_FILES]
    if left and not hasattr(session.config, "workerinput"):
        print(f"\nfiles left in /dev/shm: {sorted(left)}")
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def marked_processes() -> list[str]:
    """Return the command lines of the processes that this test session started and that still live."""
    mark = os.environ[_MARK].encode()
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            ours = folder.name != str(os.getpid()) and mark in (folder / "environ").read_bytes()
            if ours:  # a zombie has no environment and is skipped: whoever adopted it has yet to reap it
                found.append((folder / "cmdline").read_bytes().replace(b"\0", b" ").decode())
        except OSError:
            continue
    return found
