"""Plain DDS without ROS on the other side: what an example promises, tried against a real plant."""

import os
import sys
from importlib.util import find_spec

import pytest
from test_examples import check_arrival, example, in_process, run

PYTHON = os.environ.get("CRANE_SIM_CYCLONE_PYTHON", sys.executable if find_spec("cyclonedds") else "")
pytestmark = pytest.mark.skipif(
    not PYTHON, reason="no cyclonedds here; CRANE_SIM_CYCLONE_PYTHON may name a Python with it"
)


def test_plain_dds_drives_the_crane(domain_id: int) -> None:
    """A participant of Cyclone DDS without any ROS reads states, answers them, and no bit is lost on the way."""
    with example("plain_dds.py", domain_id, PYTHON):
        summary = run(domain_id)
    check_arrival(summary)
    assert summary["commands"] == {"received": 600, "rejected": 0, "late": 0, "duplicate": 0}
    assert summary["state_sha256"] == in_process()


@pytest.mark.slow
def test_plain_dds_in_real_time(domain_id: int) -> None:
    """The same in real time, where a command may be late and the newest one holds."""
    with example("plain_dds.py", domain_id, PYTHON):
        check_arrival(run(domain_id, mode="realtime", rate=2.0))
