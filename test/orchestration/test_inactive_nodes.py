"""Deactivated nodes: their silence is on purpose, and the supervisor does not kill them for it."""

import json
import os
import signal
from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim.orchestration import supervisor as supervisor_module
from crane_sim.orchestration.child import Child
from crane_sim.orchestration.supervisor import Callbacks, Supervisor
from crane_sim.ros.controller.responder import serve_responder


def test_a_node_reports_whether_it_is_active() -> None:
    """Each activation and deactivation reaches the node, and is reported."""
    reports, activations = [], []
    host: Any = SimpleNamespace(
        stop_reason="finish", wait=lambda _: None, report_ready=lambda: None
    )
    host.pipes = SimpleNamespace(report=lambda event, **fields: reports.append((event, fields)))

    def manage(autostart: bool, on_change: Any) -> None:
        for active in (autostart, False, True):
            on_change(active)

    host.manage = manage
    node: Any = SimpleNamespace(
        set_active=activations.append, missing=lambda: "", finish=dict, refused=Counter
    )
    serve_responder(host, node, True)
    assert activations == [True, False, True]
    assert [fields["active"] for event, fields in reports if event == "active"] == activations


def test_a_child_has_the_reported_activation() -> None:
    """A child is active until it reports that it is not, and again when it reports that."""
    pipes: list[int] = []

    child = Child("controller", lambda _, report: pipes.append(os.dup(report)))
    states = [child.active]
    for active in (False, True):
        os.write(pipes[0], json.dumps({"event": "active", "active": active}).encode() + b"\n")
        child.read()
        states.append(child.active)
    os.close(pipes[0])
    os.close(child.report_fd)
    child.close_control_pipe()
    assert states == [True, False, True]


@pytest.mark.parametrize(
    ("inactive", "killed"),
    [(None, True), ("plant", False), ("controller", False), ("tracker", False)],
)
def test_a_controller_is_not_killed_while_a_node_is_inactive(
    inactive: str | None, killed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the time-out a waiting plant has our controller killed, unless a node is inactive."""
    monkeypatch.setattr(supervisor_module, "_ANSWER_TIMEOUT", 0.05)
    signals: list[int] = []
    plant = SimpleNamespace(pid=1, ready=True, fault="", waiting="no command", summary=None, step=0)
    plant.active = inactive != "plant"
    plant.send = lambda line: None
    polls = iter(range(20))

    def listen(_: float) -> bool:
        supervisor_module.time.sleep(0.01)
        if next(polls, None) is None:
            plant.summary = {}
        return True

    roles: list[Any] = [SimpleNamespace(name="plant", active=plant)]
    for name in ("controller", "tracker"):
        active = SimpleNamespace(
            pid=1, ready=True, fault="", active=inactive != name, send_signal=signals.append
        )
        roles.append(
            SimpleNamespace(name=name, active=active, failure="", maintain_standbys=lambda: "")
        )
    group: Any = SimpleNamespace(listen=listen, find_stopped=dict, children=())
    callbacks = Callbacks(lambda step: None, lambda news: None, lambda name, pid: None)
    Supervisor(group, roles, [], callbacks, 60.0).run()
    assert (signal.SIGKILL in signals) == killed
