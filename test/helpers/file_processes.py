"""Runs the tests of each file in a process of their own: what they keep in memory ends with it.

A worker collects all tests once; then it forks a process for each file, which has everything that
was imported. That one runs the tests and sends their reports, which the worker hands on; its end,
by a signal too, fails only the test that ran. Without workers (`-n 0`) all tests run in one
process, as debuggers want it.

A file marked `unforked` runs in the worker: Rerun's client of its viewer has threads from its
import on, which a forked process lacks, while it shares what they wait for.
"""

import faulthandler
import multiprocessing
import os
import sys
from collections.abc import Iterator
from multiprocessing.connection import Connection
from typing import Any

import pytest
import session_guard
from _pytest.runner import runtestprotocol


class Forwarder:
    """The plugin of a file's process: it sends a worker plugin's reports to the controller."""

    def __init__(self, config: pytest.Config, connection: Connection) -> None:
        self._config = config
        self._connection = connection

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Send a report."""
        serialize = self._config.hook.pytest_report_to_serializable
        self._connection.send(serialize(config=self._config, report=report))


class FileProcess:
    """The process that runs the tests of one file, seen from the worker."""

    def __init__(self, session: pytest.Session) -> None:
        self._session = session
        self._places = {item: place for place, item in enumerate(session.items)}
        self._connection, other_end = multiprocessing.Pipe()
        self._pid = os.fork()
        if self._pid == 0:
            self._connection.close()
            _serve(session, other_end)
        other_end.close()

    def run(self, item: pytest.Item, next_item: pytest.Item | None) -> Iterator[pytest.TestReport]:
        """Yield the reports of a test.

        Raises:
            EOFError: the process has ended.
        """
        following = None if next_item is None else self._places[next_item]
        try:
            self._connection.send((self._places[item], following))
        except BrokenPipeError as error:
            raise EOFError from error
        while (data := self._connection.recv()) is not None:
            yield self._session.config.hook.pytest_report_from_serializable(
                config=self._session.config, data=data
            )

    def close(self) -> str:
        """Let the process end, wait for it, and return how it ended."""
        self._connection.close()
        code = os.waitstatus_to_exitcode(os.waitpid(self._pid, 0)[1])
        return f"signal {-code}" if code < 0 else f"exit status {code}"


def _serve(session: pytest.Session, connection: Connection) -> None:
    """Run the tests that the worker names, and end this process."""
    status = 1
    try:
        session_guard.tie_to_parent()
        manager = session.config.pluginmanager
        for plugin in manager.get_plugins():
            if isinstance(plugin, FileProcesses) or type(plugin).__name__ == "WorkerInteractor":
                manager.unregister(plugin)
        manager.register(Forwarder(session.config, connection))
        _forbid_viewer_client()
        _run_tests(session, connection)
        status = 0
    finally:
        os._exit(status)  # what ends with Python is the worker's


def _forbid_viewer_client() -> None:
    """Let a client of Rerun's viewer fail the test: it would hang here, and end the worker."""

    def refuse(*_: object) -> None:
        pytest.fail("needs pytestmark = pytest.mark.unforked (test/helpers/file_processes.py)")

    if module := sys.modules.get("rerun.experimental"):
        module.ViewerClient.connect = refuse


def _run_tests(session: pytest.Session, connection: Connection) -> None:
    while True:
        try:
            place, following = connection.recv()
        except EOFError:
            return
        item = session.items[place]
        next_item = None if following is None else session.items[following]
        session.config.hook.pytest_runtest_protocol(item=item, nextitem=next_item)
        connection.send(None)


class FileProcesses:
    """The plugin of a worker: it has one process at a time."""

    def __init__(self) -> None:
        self._process: FileProcess | None = None

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool:
        """Run a test in the process of its file; a test that does not end, ends that one."""
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        same_file = nextitem is not None and nextitem.path == item.path
        next_item = nextitem if same_file else None
        if item.get_closest_marker("unforked"):
            runtestprotocol(item, nextitem=next_item)
        else:
            # its thread would be missing in a forked process
            faulthandler.cancel_dump_traceback_later()
            self._report(item, next_item)
        if not same_file:
            self._close()
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def _report(self, item: pytest.Item, next_item: pytest.Item | None) -> None:
        if self._process is None:
            self._process = FileProcess(item.session)
        try:
            for report in self._process.run(item, next_item):
                item.ihook.pytest_runtest_logreport(report=report)
        except EOFError:
            item.ihook.pytest_runtest_logreport(
                report=_failure(item, f"its process ended with {self._close()}")
            )

    def _close(self) -> str:
        process, self._process = self._process, None
        return process.close() if process else ""


def _failure(item: pytest.Item, message: str) -> pytest.TestReport:
    """Return the report of a test that ended its process."""
    place = {"nodeid": item.nodeid, "location": item.location, "keywords": {}}
    outcome: dict[str, Any] = {
        "outcome": "failed",
        "longrepr": f"{item.nodeid}: {message}",
        "when": "call",
    }
    return pytest.TestReport(**place, **outcome)
