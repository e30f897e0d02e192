"""A pytest session without compilation, which runs requested tests: `interpreted_tests.py FILE ...`.

Requests are lines of JSON on its standard input, [test, the one after it or null]; for each it prints one line, the
test's reports. A file is imported when one of its tests is first named, since each worker requests tests of a part
of the files only. States that are arrays pass through `plain_arrays`.
"""

import json
import os
import sys
from importlib import import_module
from typing import TextIO

import plain_arrays
import pytest


class OnRequest:
    """A plugin: tests run in the order of the requests, and their reports are the answers."""

    def __init__(self, requests: TextIO, answers: TextIO) -> None:
        """Take requests from one stream, write answers into another one."""
        self._requests, self._answers = requests, answers
        self._modules: dict[str, pytest.Item | pytest.Collector] = {}  # by file
        self._items: dict[str, dict[str, pytest.Item]] = {}  # by file and test
        self._reports: list[pytest.TestReport] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection(self, session: pytest.Session) -> bool:
        """Find the files, all at once since their folders have the fixtures, without importing them."""
        self._modules = {module.nodeid: module for module in session.perform_collect(genitems=False)}
        return True

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Run requested tests until the requests end."""
        hook = session.config.hook
        for name, after in map(json.loads, self._requests):
            item, following = self._find(session, name), self._find(session, after)
            assert item, f"{name}: could not be collected"
            self._reports = []
            session._setupstate.teardown_exact(item)  # fixtures kept for a test that ran elsewhere
            hook.pytest_runtest_protocol(item=item, nextitem=following)
            data = [hook.pytest_report_to_serializable(config=session.config, report=one) for one in self._reports]
            print(json.dumps(data), file=self._answers, flush=True)
        return True

    def _find(self, session: pytest.Session, name: str | None) -> pytest.Item | None:
        """Return a test of the files; None where it is in none of them."""
        file = (name or "").partition("::")[0]
        if file not in self._modules:
            return None
        if file not in self._items:
            items = list(session.genitems(self._modules[file]))
            session.config.hook.pytest_collection_modifyitems(session=session, config=session.config, items=items)
            self._items[file] = {item.nodeid: item for item in items}
        return self._items[file].get(name)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Keep a report for the answer."""
        self._reports.append(report)


def main() -> None:
    """Run the program: what tests print goes to standard error."""
    import_module("crane_sim.simulation.rollout")  # with all integrators, of which `plain_arrays` replaces parts
    plain_arrays.install()
    requests, answers = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    pytest.main(["-n", "0", "-m", "", *sys.argv[1:]], plugins=[OnRequest(requests, answers)])


if __name__ == "__main__":
    main()
