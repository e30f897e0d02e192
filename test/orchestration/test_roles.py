"""Roles of a run: fail-over to a standby, its resume state, and the limit of restarts."""

from typing import Any

from supervisor_doubles import FakeChild, FakeGroup, news_into, role_of

from crane_sim.orchestration.roles import RecorderRole, Role, RoleSpec
from crane_sim.orchestration.supervisor import Supervisor
from crane_sim.ros.recorder.outputs import ResumeState, read_resume_state

CONTROLLER = RoleSpec("controller", "module", "crane", {})


def test_the_resume_state_is_in_the_request_to_go() -> None:
    """A standby recorder gets the resume state in `go`: a full disk does not matter.

    It counts resets.
    """
    group: Any = FakeGroup()
    spec = RoleSpec(
        "recorder", "module", "crane", {"path": "/full/run.rrd", "mcap": "", "live_port": 7}
    )
    role = RecorderRole(group, spec, restart=True)
    failed: Any = role.active
    failed.step, failed.recorded, failed.last_bag_step, failed.resets = 70, 68, 60, 2
    failed.lost_commands = 3
    failed.exit("it was killed")
    assert role.fail_over(75)
    successor: Any = role.active
    word, _, document = successor.requests[0].partition(" ")
    assert word == "go" and "\n" not in document
    assert read_resume_state(document) == ResumeState(
        after=70,
        recorded=68,
        last_bag_step=60,
        resets=2,
        lost_commands=3,
        since=role.start_time,
        number=2,
    )
    assert (successor.step, successor.recorded, successor.last_bag_step, successor.resets) == (
        70,
        68,
        60,
        2,
    )
    assert successor.lost_commands == 3
    assert role.maintain_standbys() == ""
    assert group.settings[-1] == {**spec.settings, "standby": True, "resets": 2, "live_port": 0}
    assert read_resume_state("") == ResumeState()


def test_a_role_that_fails_repeatedly_at_one_step_is_given_up() -> None:
    """After three restarts at one step of the plant the crane is braked, and a line says why."""
    plant, news, group = FakeChild("plant"), list[str](), FakeGroup()
    fake: Any = group
    group.children.append(plant)
    plant.step = 812
    law = Role(fake, CONTROLLER, restart=True)

    def kill_law() -> None:
        if law.failure:
            plant.summary = {}
        else:
            active: Any = law.active
            active.exit("it was killed by SIGSEGV")

    group.on_listen = kill_law
    Supervisor(fake, [role_of(plant), law], [], news_into(news), 60.0).run()
    why = "controller: it was killed by SIGSEGV"
    given_up = f"{why}; 3 replacements in a row died with the plant at step 812"
    assert news == [*(f"{why}; replaced",) * 3, f"{given_up}; the crane is braked to rest"]
    assert plant.requests == ["go", f"brake {given_up}"]


def test_a_role_that_fails_at_one_step_after_another_is_restarted() -> None:
    """As long as the plant takes steps in between, a role is not given up."""
    group: Any = FakeGroup()
    law = Role(group, CONTROLLER, restart=True)
    for step in range(10):
        active: Any = law.active
        active.exit("it was killed by SIGKILL")
        assert law.fail_over(step)
    assert law.restarts == 10 and not law.failure


def test_a_ready_standby_takes_over_though_another_one_did_not_start() -> None:
    """A standby that fails as it starts ends the supply of new ones; ready ones still take over."""
    group: Any = FakeGroup()
    law = Role(group, CONTROLLER, restart=True)
    law.maintain_standbys()
    law.maintain_standbys()
    first, second = group.children[-2:]
    first.ready, second.ready = True, False
    second.exit("it exited with code 1")
    assert law.maintain_standbys() == "controller: no more replacements: it exited with code 1"
    for expected in (True, False):
        active: Any = law.active
        active.exit("it was killed by SIGKILL")
        assert law.fail_over(5) is expected
    assert law.active is first and law.failure == "controller: it was killed by SIGKILL"
