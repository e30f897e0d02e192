"""The supervisor of a run: a plant that is killed, and one that waits for the user's node."""

import time
from typing import Any, cast

import pytest
from supervisor_doubles import FakeChild, FakeGroup, news_into, role_of

from crane_sim.orchestration import supervisor
from crane_sim.orchestration.supervisor import RunError, Supervisor


def test_a_plant_that_is_killed_as_it_starts_ends_the_run_at_once() -> None:
    """A fault before all are ready requests a shutdown of the others."""
    group = FakeGroup(lambda: group.children[0].exit("it was killed by SIGKILL"))
    plant, fake = FakeChild("plant", ready=False), cast(Any, group)
    group.children.append(plant)
    with pytest.raises(RunError, match=r"^plant: it was killed by SIGKILL$"):
        Supervisor(fake, [role_of(plant)], [], news_into([]), 60.0).wait_ready()
    assert group.shutting_down


def test_a_stopped_process_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that a signal has stopped is reported once, as soon as it is waited for.

    It is also reported where the wait ends.
    """
    monkeypatch.setattr(supervisor, "READY_TIMEOUT", 0.2)
    news, group = list[str](), cast(Any, FakeGroup(lambda: time.sleep(0.01)))
    group.children.append(plant := FakeChild("plant", ready=False))
    group.find_stopped, group.listen = lambda: {12: "fork server"}, lambda _: time.sleep(0.01)
    with pytest.raises(RunError, match=r"no report for 0.2 s; fork server is stopped$"):
        Supervisor(group, [role_of(plant)], [], news_into(news), 0.2).wait_ready()
    assert news == ["fork server: a signal has stopped process 12; `kill -CONT 12` lets it go on"]
    group.find_stopped = dict
    with pytest.raises(RunError, match=r"no report for 0.2 s; plant is not ready$"):
        Supervisor(group, [role_of(plant)], [], news_into(news), 0.2).wait_ready()


def news_of_run(changes: list[dict[str, Any]], timeout: float) -> list[str]:
    """Return the news of a run without our own controller, as the plant's attributes change.

    They change one after the other.
    """
    plant, news, pending = FakeChild("plant"), list[str](), list(changes)

    def change_plant() -> None:
        time.sleep(0.01)
        if pending:
            vars(plant).update(pending.pop(0))

    group: Any = FakeGroup(change_plant)
    supervision = Supervisor(group, [role_of(plant)], [], news_into(news), timeout)
    supervision.wait_ready()
    try:
        supervision.run()
    except RunError as error:
        news.append(f"error: {error}")
    return news


def test_a_plant_that_waits_for_the_user_s_node_is_reported() -> None:
    """The news report that the plant waits and that it resumes; after the time-out the run ends."""
    waits, goes_on = {"waiting": "no command for state 7"}, {"waiting": ""}
    news = ["the plant waits: no command for state 7", "the plant goes on"]
    assert news_of_run([waits, waits, goes_on, {"summary": {}}], timeout=60.0) == news
    given_up = "error: plant: no command for state 7; that was 0.05 s ago"
    assert news_of_run([waits], timeout=0.05) == [news[0], given_up]
    paused = [waits | {"active": False}] * 10  # 0.1 s, in which the user's node need not answer
    assert news_of_run([*paused, goes_on, {"summary": {}}], timeout=0.05) == news
