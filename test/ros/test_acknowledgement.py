"""Liveness of the command owner: its lease expires by its own missing acknowledgement.

Another subscriber's does not end it.
"""

import time
from types import SimpleNamespace
from typing import Any

import pytest
from lockstep_doubles import TIMEOUT, ZERO, FakeHost, FakeTopics, make_lockstep

from crane_sim.ros.plant.acknowledgement import AcknowledgementMonitor
from crane_sim.ros.plant.simulation_run import SimulationRun

LEASE = TIMEOUT  # s
STEP = 0.05  # s, the law's compute time while it answers


@pytest.mark.parametrize(
    ("other_missing", "suspended"),
    [(False, False), (True, True)],
    ids=["all acknowledge", "another subscriber does not"],
)
def test_missing_ack_of_another_subscriber_suspends_lease_expiry(
    other_missing: bool,
    suspended: bool,
    simulation: SimulationRun,
    topics: FakeTopics,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An owner that answered while an acknowledgement was missing keeps its lease, else loses it.

    In the first case the missing acknowledgement is another subscriber's, in the second one the
    owner's.
    """
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    lockstep: Any = make_lockstep(FakeHost(), simulation)
    lockstep._commands = SimpleNamespace(contested=True)
    topics.acknowledged = not other_missing
    for _ in range(15):
        now[0] += STEP
        lockstep._effort = ZERO
        lockstep._step()
    topics.acknowledged = False
    for _ in range(20):  # of a law that has died, or is slow
        now[0] += STEP
        assert lockstep._is_lease_suspended() == suspended


def test_old_observations_expire() -> None:
    """After a time without a second publisher a missing acknowledgement counts again.

    There were no updates in that time.
    """
    monitor = AcknowledgementMonitor(LEASE)
    monitor.update(True, 0.0)
    monitor.update(False, 100.0)
    assert not monitor.may_be_alive(100.0) and not monitor.may_be_alive(100.0 + LEASE)
    monitor.update(True, 100.1)
    assert monitor.may_be_alive(100.1)
