"""The example of plain DDS without ROS, against a real plant."""

import importlib
import os
import sys
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import pytest
from example_helpers import EXAMPLES, check_lockstep, run, started_example

PYTHON = os.environ.get(
    "CRANE_SIM_CYCLONE_PYTHON", sys.executable if find_spec("cyclonedds") else ""
)
needs_python = pytest.mark.skipif(
    not PYTHON, reason="no cyclonedds here; CRANE_SIM_CYCLONE_PYTHON may name a Python with it"
)


def test_plain_dds_outlasts_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    """However long no state comes, the example answers the next; only the plant's end ends it."""
    pytest.importorskip("cyclonedds", reason="no cyclonedds in this Python")
    monkeypatch.syspath_prepend(str(EXAMPLES))
    plain_dds = importlib.import_module("plain_dds")
    state = SimpleNamespace(
        sample_info=SimpleNamespace(valid_data=True),
        header_=plain_dds.Header(plain_dds.Time(0, 10_000_000), ""),
        name_=list(plain_dds.TARGET),
        position_=[0.0] * 4,
        velocity_=[0.0] * 4,
    )
    batches = iter(
        [[], [], [state], [], [SimpleNamespace(sample_info=SimpleNamespace(valid_data=False))]]
    )
    written: list[Any] = []
    reader = SimpleNamespace(take=lambda _: next(batches))
    writer = SimpleNamespace(write=written.append)
    waits = SimpleNamespace(attach=lambda _: None, wait=lambda _: 0)  # timed out each time
    fakes = {"DataReader": reader, "DataWriter": writer, "WaitSet": waits}
    for name in ("DomainParticipant", "Topic", "ReadCondition"):
        monkeypatch.setattr(plain_dds, name, lambda *_, **__: None)
    for name, fake in fakes.items():
        monkeypatch.setattr(plain_dds, name, lambda *_, fake=fake, **__: fake)
    monkeypatch.setenv("CYCLONEDDS_URI", "")  # so that it is restored after main() has set it
    plain_dds.main(7)
    assert [command.header_ for command in written] == [state.header_]


@needs_python
def test_plain_dds_drives_the_crane(domain_id: int) -> None:
    """A Cyclone DDS participant without ROS answers all states, the bits as in one process."""
    with started_example("plain_dds.py", domain_id, PYTHON):
        summary = run(domain_id)
    check_lockstep(summary)
