"""What one who dies leaves to the next one: messages, where to go on, which files; and when nobody follows."""

import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim import load_scene
from crane_sim.orchestration.roles import RecorderRole, Role, RoleSpec
from crane_sim.orchestration.supervisor import Callbacks, RunError, Supervisor
from crane_sim.recording.files import before_reset, existing_parts, files_before_resets
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.recorder.outputs import ResumeState, read_resume_state
from crane_sim.ros.recorder.replay_buffer import SECONDS, ReplayBuffer

SCENE = load_scene("knuckle_setpoint")
STATE, EFFORT = JointWire(SCENE.joint_names, effort=False), JointWire(SCENE.actuated, effort=True)
SECOND = 10**9


def state(second: int, by: float = 0.0) -> bytes:
    """Return the state of a second, with a number that tells which pass it is of."""
    return STATE.encode(second * SECOND, (by,) * 6, (0.0,) * 6)


def tail_of_two_passes(now: list[float]) -> ReplayBuffer:
    """Return the tail of a run that is reset behind the state of second 20, and has three seconds since then."""
    tail = ReplayBuffer(["joint_states", "simulation_state", "joint_trajectory"], passes=3)
    takers = tail.takers()
    takers["simulation_state"](b"playing")
    takers["joint_trajectory"](b"old target")
    for second in range(1, 21):
        now[0] = float(second)
        takers["joint_states"](state(second))
    takers["joint_trajectory"](b"late target")
    for second in range(1, 4):
        now[0] = 20.0 + second
        takers["joint_states"](state(second, 1.0))
    return tail


def handed_over(tail: ReplayBuffer, behind: int, passes: int) -> list[bytes]:
    """Return what a tail hands over to who goes on behind a second of a pass."""
    heard: list[bytes] = []
    names = ("joint_states", "simulation_state", "joint_trajectory")
    tail.pass_to([dict.fromkeys(names, heard.append)], [behind * SECOND], passes)
    return heard


def test_a_tail_forgets_the_pass_before_a_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the dead one had taken in the reset, nothing older is handed over but what is latched."""
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    assert handed_over(tail_of_two_passes(now), behind=1, passes=4) == [b"playing", state(2, 1.0), state(3, 1.0)]


def test_a_tail_knows_who_has_not_heard_of_a_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the dead one had not, its pass is handed over to its end, and then the new one from its beginning."""
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    rest = [*map(state, (19, 20)), b"late target", *(state(second, 1.0) for second in (1, 2, 3))]
    assert handed_over(tail_of_two_passes(now), behind=18, passes=3) == [b"playing", b"old target", *rest]
    assert 23 - SECONDS < 18  # all of that was still kept


class Crewman:
    """A child without a process."""

    def __init__(self, name: str, ready: bool = True) -> None:
        """Stand there."""
        self.name, self.ready, self.fault, self.gone, self.fatal = name, ready, "", False, False
        self.pid, self.step, self.recorded, self.bagged, self.passes, self.waiting = 1, 0, 0, 0, 0, ""
        self.summary: dict[str, Any] | None = None
        self.orders: list[str] = []
        self.order = self.orders.append

    def die(self, why: str) -> None:
        """Be gone."""
        self.fault, self.gone = why, True


class Company:
    """A crew of them; at every look something is done to it, until there is nothing to do any more."""

    def __init__(self, happens: Callable[[], object] = lambda: None) -> None:
        """Let nobody be there yet."""
        self.children: list[Any] = []
        self.settings: list[Any] = []
        self.shutting_down, self._happens = False, happens

    def start(self, name: str, module: str, namespace: str, settings: Any) -> Crewman:
        """Add one."""
        self.children.append(Crewman(name))
        self.settings.append(settings)
        return self.children[-1]

    fork = start

    def request_shutdown(self) -> None:
        """Hear that somebody waits."""
        self.shutting_down = True

    def remove(self, child: Crewman) -> None:
        """Let one go."""
        self.children.remove(child)

    def listen(self, timeout: float) -> bool:
        """Let the next thing happen."""
        self._happens()
        return True


def test_the_handover_is_in_the_order_to_go() -> None:
    """Who follows a recorder is told by the order itself, so that no full disk is in the way, and knows the resets."""
    crew: Any = Company()
    place = RoleSpec("recorder", "module", "crane", {"path": "/full/run.rrd", "mcap": "", "live_port": 7})
    post = RecorderRole(crew, place, replaced=True)
    dead: Any = post.active
    dead.step, dead.recorded, dead.bagged, dead.passes = 70, 68, 60, 2
    dead.die("it was killed")
    assert post.fail_over(75)
    heir: Any = post.active
    word, _, told = heir.orders[0].partition(" ")
    assert word == "go" and "\n" not in told
    assert read_resume_state(told) == ResumeState(
        after=70, recorded=68, bagged=60, passes=2, since=post.began, number=2
    )
    assert (heir.step, heir.recorded, heir.bagged, heir.passes) == (70, 68, 60, 2)
    assert post.maintain_standbys() == ""
    assert crew.settings[-1] == {**place.settings, "standby": True, "passes": 2, "live_port": 0}
    assert read_resume_state("") == ResumeState()


def played(crew: Any, replaced: bool) -> tuple[list[str], Crewman]:
    """Return what a run with a law tells and what its plant was ordered; at every look the law dies at step 812."""
    plant, news = Crewman("plant"), list[str]()
    crew.children.append(plant)
    plant.step = 812
    law = Role(crew, RoleSpec("controller", "module", "crane", {}), replaced)
    post: Any = SimpleNamespace(name="plant", active=plant, failed="", standbys_ready=True)
    conductor = Supervisor(
        crew, [post, law], [], Callbacks(lambda step: None, news.append, lambda name, pid: None), 60.0
    )

    def happens() -> None:
        if law.failed:
            plant.summary = {}
        else:
            holder: Any = law.active
            holder.die("it was killed by SIGSEGV")

    crew._happens = happens
    conductor.play()
    return news, plant


def test_who_dies_at_one_state_again_and_again_is_given_up() -> None:
    """After three replacements with the plant at one step the crane is braked, and the line says why."""
    news, plant = played(Company(), replaced=True)
    why = "controller: it was killed by SIGSEGV"
    given_up = f"{why}; 3 replacements in a row died with the plant at step 812"
    assert news == [*(f"{why}; replaced",) * 3, f"{given_up}; the crane is braked to rest"]
    assert plant.orders == ["go", f"brake {given_up}"]


def test_who_dies_at_one_state_after_another_is_replaced() -> None:
    """As long as the plant goes on in between, nobody is given up."""
    crew: Any = Company()
    law = Role(crew, RoleSpec("controller", "module", "crane", {}), replaced=True)
    for step in range(10):
        holder: Any = law.active
        holder.die("it was killed by SIGKILL")
        assert law.fail_over(step)
    assert law.restarts == 10 and not law.failed


def test_a_plant_that_is_killed_as_it_starts_ends_the_run_at_once() -> None:
    """Who dies before all have met leaves nothing to wait for: the others are told to hurry."""
    crew = Company(lambda: crew.children[0].die("it was killed by SIGKILL"))
    plant: Any = Crewman("plant", ready=False)
    crew.children.append(plant)
    post: Any = SimpleNamespace(name="plant", active=plant, failed="", standbys_ready=True)
    fake: Any = crew
    conductor = Supervisor(
        fake, [post], [], Callbacks(lambda step: None, lambda line: None, lambda name, pid: None), 60.0
    )
    with pytest.raises(RunError, match=r"^plant: it was killed by SIGKILL$"):
        conductor.wait_ready()
    assert crew.shutting_down


def test_parts_are_found_under_the_names_that_they_have_by_then(tmp_path: Path) -> None:
    """Finished or not, a part of this run is found, in order; one of an earlier run is not."""
    names = ("run.rrd.part", "run.rrd", "run.part2.rrd", "run.part3.rrd.part", "run.part4.rrd")
    for name in names:
        (tmp_path / name).touch()
    path = str(tmp_path / "run.rrd")
    assert [file.name for file in existing_parts(path, 3, since=0.0)] == list(names[:4])
    assert existing_parts(path, 3, since=time.time() + 60.0) == []
    assert before_reset(tmp_path / "run.rrd", 1).name == "run.before_reset_1.rrd"
    (tmp_path / "run.before_reset_1.rrd").touch()
    assert before_reset(tmp_path / "run.rrd", 1).name == "run.before_reset_2.rrd"


def test_what_resets_set_aside_is_found(tmp_path: Path) -> None:
    """Files from before a reset are this run's, of whole or part, and neither another file's nor an earlier run's."""
    ours = ["run.before_reset_1.rrd", "run.part2.before_reset_2.rrd"]
    for name in (*ours, "run.before_reset_1.mcap", "rerun.before_reset_1.rrd", "run.rrd"):
        (tmp_path / name).touch()
    path = str(tmp_path / "run.rrd")
    assert sorted(file.name for file in files_before_resets(path, since=0.0)) == ours
    assert files_before_resets(path, since=time.time() + 60.0) == []
