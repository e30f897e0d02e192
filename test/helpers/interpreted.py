"""Tests marked `interpreted`: they run in a process without compilation, where a new kind of scene costs nothing."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest

PROGRAM = Path(__file__).parents[1] / "programs" / "interpreted_tests.py"


def is_interpreted(item: pytest.Item) -> bool:
    """Return whether a test is to run in the other process; slow ones take the time to compile."""
    marked = item.get_closest_marker("interpreted") is not None and item.get_closest_marker("slow") is None
    return marked and os.environ.get("NUMBA_DISABLE_JIT") != "1"


class Interpreter:
    """The process in which interpreted tests run."""

    def __init__(self, session: pytest.Session) -> None:
        """Start it, for all interpreted tests of the session."""
        files = dict.fromkeys(item.nodeid.partition("::")[0] for item in session.items if is_interpreted(item))
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
        """Return the reports of a test; `after` is the next one of the session, which may share fixtures."""
        assert self._process.stdin and self._process.stdout
        print(json.dumps([item.nodeid, after and after.nodeid]), file=self._process.stdin, flush=True)
        answer = self._process.stdout.readline()
        if not answer:
            self._log.seek(0)
            line = f"the process of interpreted tests ended:\n{self._log.read()[-4000:]}"
            return [pytest.TestReport(item.nodeid, item.location, {}, "failed", line, "call")]
        hook = item.config.hook
        return [hook.pytest_report_from_serializable(config=item.config, data=_as_sent(d)) for d in json.loads(answer)]

    def close(self) -> None:
        """Let the process end: there are no further requests."""
        with self._process:
            assert self._process.stdin
            self._process.stdin.close()
        self._log.close()


def _as_sent(data: dict[str, Any]) -> dict[str, Any]:
    """Return a report with the tuple (file, line, reason) of a skipped test, of which JSON makes a list."""
    skip = data["longrepr"]
    return data | {"longrepr": tuple(skip)} if isinstance(skip, list) else data


def _teardown(item: pytest.Item, after: pytest.Item | None) -> list[pytest.TestReport]:
    """End fixtures of this process that the next test does not share; return the report of a failure."""
    state = item.session._setupstate
    call = pytest.CallInfo.from_call(lambda: state.teardown_exact(after), when="teardown")
    return [pytest.TestReport.from_item_and_call(item, call)] if call.excinfo else []


_INTERPRETER = pytest.StashKey[Interpreter]()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run an interpreted test in its process, which is started before the first and ends before the last test does."""
    stash, interpreted, reports = item.config.stash, is_interpreted(item), []
    if interpreted:
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        if _INTERPRETER not in stash:
            stash[_INTERPRETER] = Interpreter(item.session)
        reports = stash[_INTERPRETER].run(item, nextitem)
    if nextitem is None and _INTERPRETER in stash:
        stash[_INTERPRETER].close()
    if not interpreted:
        return None
    for report in (*reports, *_teardown(item, nextitem)):
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True
