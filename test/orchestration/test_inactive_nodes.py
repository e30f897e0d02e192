"""A node that somebody deactivated is silent because it was told to be: nobody takes it for dead."""

import json
import os
import signal
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim.orchestration import supervisor as conductor_module
from crane_sim.orchestration.child import Child
from crane_sim.orchestration.supervisor import Callbacks, Supervisor
from crane_sim.ros.controller.responder import serve_responder


def test_a_node_reports_whether_it_is_active() -> None:
    """Whoever activates or deactivates it: it obeys, and its orchestrator hears of it."""
    heard, obeyed = [], []
    host: Any = SimpleNamespace(stopping="finish", wait=lambda _: None)
    host.pipes = SimpleNamespace(report=lambda event, **fields: heard.append((event, fields)))

    def manage(autostart: bool, on_change: Any) -> None:
        for active in (autostart, False, True):
            on_change(active)

    host.manage = manage
    node: Any = SimpleNamespace(activate=obeyed.append, missing=lambda: "", finish=dict)
    serve_responder(host, node, True)
    assert obeyed == [True, False, True]
    assert [fields["active"] for event, fields in heard if event == "active"] == obeyed


def test_the_orchestrator_knows_it() -> None:
    """A child is active until it reports that it is not, and again when it reports that."""
    pipes: list[int] = []

    def start(control: int, report: int) -> Any:
        pipes.append(os.dup(report))
        return SimpleNamespace(pid=1)

    child = Child("controller", start)
    seen = [child.active]
    for active in (False, True):
        os.write(pipes[0], json.dumps({"event": "active", "active": active}).encode() + b"\n")
        child.read()
        seen.append(child.active)
    os.close(pipes[0])
    os.close(child.reports)
    child.close_control_pipe()
    assert seen == [True, False, True]


@pytest.mark.parametrize(
    ("silent", "killed"), [(None, True), ("plant", False), ("controller", False), ("tracker", False)]
)
def test_who_was_deactivated_is_not_killed(silent: str | None, killed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A plant that waits too long for our controller costs its life, but not while one of them or a tracker may not."""
    monkeypatch.setattr(conductor_module, "_UNANSWERED", 0.05)
    signals: list[int] = []
    plant = SimpleNamespace(pid=1, ready=True, fault="", waiting="no command", summary=None, step=0)
    plant.active = silent != "plant"
    plant.order = lambda line: None
    looks = iter(range(20))

    def listen(_: float) -> bool:
        conductor_module.time.sleep(0.01)
        if next(looks, None) is None:
            plant.summary = {}
        return True

    posts: list[Any] = [SimpleNamespace(name="plant", active=plant)]
    for name in ("controller", "tracker"):
        holder = SimpleNamespace(pid=1, ready=True, fault="", active=silent != name, send_signal=signals.append)
        posts.append(SimpleNamespace(name=name, active=holder, failed="", maintain_standbys=lambda: ""))
    crew: Any = SimpleNamespace(listen=listen)
    telling = Callbacks(lambda step: None, lambda news: None, lambda name, pid: None)
    Supervisor(crew, posts, [], telling, 60.0).play()
    assert (signal.SIGKILL in signals) == killed
