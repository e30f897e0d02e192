"""A silent commander loses the crane by its own missing acknowledgement, not by a third subscriber's."""

import time
from types import SimpleNamespace
from typing import Any

import pytest
from lockstep_doubles import ZERO, QuietHost, QuietTopics, lockstep

from crane_sim.ros.plant.acknowledgement import Acknowledgement
from crane_sim.ros.plant.simulation_run import SimulationRun

LEASE = 0.3  # s, as of `lockstep`
STEP = 0.05  # s that the law takes at first


@pytest.mark.parametrize(
    ("third", "alive"), [(False, False), (True, True)], ids=["all acknowledge", "a third one does not"]
)
def test_a_third_subscriber_s_silence_is_not_the_commander_s(
    third: bool,
    alive: bool,
    stepper: SimulationRun,
    topics: QuietTopics,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A commander that answered while acknowledgements were missing is excused; else the missing one is its own."""
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    pace: Any = lockstep(QuietHost(), stepper)
    pace._commands = SimpleNamespace(several=True)
    pace._stepper._topics = topics
    topics.acknowledged = not third
    for _ in range(15):
        now[0] += STEP
        pace._answer = ZERO
        pace._step()
    topics.acknowledged = False
    for _ in range(20):  # of a law that has died, or takes its time
        now[0] += STEP
        assert pace._excused() == alive


def test_what_was_not_looked_at_says_nothing() -> None:
    """After a time without a second publisher, in which nothing is noted, a missing acknowledgement begins anew."""
    acknowledgement = Acknowledgement(LEASE)
    acknowledgement.note(True, 0.0)
    acknowledgement.note(False, 100.0)
    assert not acknowledgement.excuses(100.0) and not acknowledgement.excuses(100.0 + LEASE)
    acknowledgement.note(True, 100.1)
    assert acknowledgement.excuses(100.1)
