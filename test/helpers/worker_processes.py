"""Processes in which tests of a pytest-xdist worker run, for the worker itself runs none.

Tests run in a fork of the worker, which is replaced between two files when it has grown: a process keeps the memory of
what it has compiled, a fork finds it on the disk. Tests marked `interpreted` run in a process without compilation,
where a new kind of scene costs nothing. Without workers (`-n 0`) tests run where pytest does, but for these.
"""

import faulthandler
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn, TextIO

import pytest
import session_guard
from interpreted_tests import OnRequest

PROGRAM = Path(__file__).parents[1] / "programs" / "interpreted_tests.py"
LARGE = 0.9e9
"""Resident bytes of a fork that is replaced: a file of tests may add half a gigabyte."""


def _ask(item: pytest.Item, after: pytest.Item | None, requests: TextIO, answers: TextIO) -> list[pytest.TestReport]:
    """Return the reports of a test by the process behind two streams; none if it has ended."""
    try:
        print(json.dumps([item.nodeid, after and after.nodeid]), file=requests, flush=True)
    except BrokenPipeError:
        return []
    hook, data = item.config.hook, json.loads(answers.readline() or "[]")
    reports = [hook.pytest_report_from_serializable(config=item.config, data=one) for one in data]
    for report in reports:
        if isinstance(report.longrepr, list):  # JSON has no tuples: where a test was skipped, and why
            report.longrepr = tuple(report.longrepr)
    return reports


def _report_end(item: pytest.Item, why: str) -> list[pytest.TestReport]:
    return [pytest.TestReport(item.nodeid, item.location, {}, "failed", why, "call")]


class Fork:
    """A fork of this process that runs tests."""

    def __init__(self, session: pytest.Session) -> None:
        """Fork, before any test has run here."""
        (reader, requests), (answers, writer) = os.pipe(), os.pipe()
        self._pid = os.fork()
        if not self._pid:
            _serve(session, os.fdopen(reader), os.fdopen(writer, "w"), (requests, answers))
        os.close(reader)
        os.close(writer)
        self._requests, self._answers = os.fdopen(requests, "w"), os.fdopen(answers)
        self.exit_code: int | None = None  # negative for a signal; None while it runs

    def run(self, item: pytest.Item, after: pytest.Item | None) -> list[pytest.TestReport]:
        """Return the reports of a test."""
        if reports := _ask(item, after, self._requests, self._answers):
            return reports
        return _report_end(item, f"the process of the tests ended with {self.close()}")

    def is_large(self) -> bool:
        """Return whether its memory is that of a process that is to be replaced."""
        pages = int(Path(f"/proc/{self._pid}/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") > LARGE

    def close(self) -> int:
        """Let it end; return its exit code."""
        if self.exit_code is None:
            with suppress(BrokenPipeError):
                self._requests.close()
            self._answers.close()
            self.exit_code = os.waitstatus_to_exitcode(os.waitpid(self._pid, 0)[1])
        return self.exit_code


def _serve(session: pytest.Session, requests: TextIO, answers: TextIO, others: Iterable[int]) -> NoReturn:
    """Run requested tests in this fork; nothing of what ends a process normally is run: it is the worker's."""
    code = 1
    try:
        session_guard.tie_to_parent()
        for other in others:
            os.close(other)
        session.config.stash[_PROCESSES] = None
        manager: Any = session.config.pluginmanager
        for plugin in [each for each in manager.get_plugins() if type(each).__name__ == "WorkerInteractor"]:
            manager.unregister(plugin)  # it would write into the worker's connection
        plugin = OnRequest(requests, answers)
        manager.register(plugin)
        plugin.pytest_runtestloop(session)
        code = 0
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


class Interpreter:
    """The process in which interpreted tests run."""

    def __init__(self, session: pytest.Session) -> None:
        """Start it, for all interpreted tests of the session."""
        files = dict.fromkeys(str(item.path) for item in session.items if is_interpreted(item))
        self._log = tempfile.TemporaryFile("w+")
        self._process = subprocess.Popen(
            [sys.executable, str(PROGRAM), *files],
            env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
            cwd=session.config.rootpath,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
        )

    def run(self, item: pytest.Item, after: pytest.Item | None) -> list[pytest.TestReport]:
        """Return the reports of a test."""
        assert self._process.stdin and self._process.stdout
        if reports := _ask(item, after, self._process.stdin, self._process.stdout):
            return reports
        self._log.seek(0)
        return _report_end(item, f"the process of interpreted tests ended:\n{self._log.read()[-4000:]}")

    def close(self) -> None:
        """Let it end."""
        with self._process:
            assert self._process.stdin
            self._process.stdin.close()
        self._log.close()


def is_interpreted(item: pytest.Item) -> bool:
    """Return whether a test is to run without compilation; slow ones take the time to compile."""
    marked = item.get_closest_marker("interpreted") is not None and item.get_closest_marker("slow") is None
    return marked and os.environ.get("NUMBA_DISABLE_JIT") != "1"


class Processes:
    """The processes in which tests of this one run, each started before its first test."""

    def __init__(self, session: pytest.Session) -> None:
        """Take the session that holds all tests."""
        self._session, self._forks = session, hasattr(session.config, "workerinput")
        self._interpreter: Interpreter | None = None
        self._fork: Fork | None = None

    def run(self, item: pytest.Item, after: pytest.Item | None) -> list[pytest.TestReport] | None:
        """Return the reports of a test; None: it is to run here."""
        if is_interpreted(item):
            self._interpreter = self._interpreter or Interpreter(self._session)
            return self._interpreter.run(item, after)
        if not self._forks:
            return None
        faulthandler.cancel_dump_traceback_later()  # the fork has its own limit, and a lock of this one would stay held
        self._fork = self._fork or Fork(self._session)
        last = after is None or (after.path != item.path and self._fork.is_large())
        reports = self._fork.run(item, None if last else after)
        if last or self._fork.exit_code is not None:
            self.end_fork()
        return reports

    def end_fork(self) -> None:
        """Let the fork end, if there is one."""
        if self._fork is not None:
            self._fork.close()
            self._fork = None

    def close(self) -> None:
        """Let all of them end: there are no further tests."""
        self.end_fork()
        if self._interpreter is not None:
            self._interpreter.close()


def _teardown(item: pytest.Item, after: pytest.Item | None) -> list[pytest.TestReport]:
    """End fixtures of this process that the next test does not share; return the report of a failure."""
    state = item.session._setupstate
    call = pytest.CallInfo.from_call(lambda: state.teardown_exact(after), when="teardown")
    return [pytest.TestReport.from_item_and_call(item, call)] if call.excinfo else []


_PROCESSES = pytest.StashKey[Processes | None]()  # None: in one of them


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run a test in its process, which is started before the first and ends before the last test does."""
    if _PROCESSES not in item.config.stash:
        item.config.stash[_PROCESSES] = Processes(item.session)
    processes = item.config.stash[_PROCESSES]
    if processes is None:
        return None
    reports = processes.run(item, nextitem)
    if nextitem is None:
        processes.close()
    if reports is None:
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in (*reports, *_teardown(item, nextitem)):
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True
