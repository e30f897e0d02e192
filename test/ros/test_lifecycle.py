"""Plant and controllers as lifecycle nodes: inactive they are matched, and do nothing."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from bench_graph import PERIOD, NodeProcess, Remote, graph, remote, wait_until
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState

from crane_sim import load_scene

ACTIVATE, DEACTIVATE, SHUTDOWN = (
    Transition.TRANSITION_ACTIVATE,
    Transition.TRANSITION_DEACTIVATE,
    Transition.TRANSITION_ACTIVE_SHUTDOWN,
)


@pytest.fixture
def bench(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[tuple[Remote, NodeProcess, NodeProcess]]:
    """Yield a node of the test, a plant in the middle of a run, and its standby controller."""
    scene = tmp_path / "endless.yaml"
    load_scene("knuckle_setpoint", {"duration": 1e5}).dump(scene)
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        client.node.destroy_publisher(client.commands)
        with (
            NodeProcess(
                "crane_sim.ros.plant_node", env, f"scene:={scene}", "step_timeout:=0.2"
            ) as plant,
            NodeProcess(
                "crane_control.nodes.controller_node", env, f"scene:={scene}", "autostart:=false"
            ) as standby,
        ):
            plant.await_event("ready")
            standby.await_event("ready")
            plant.send("go")
            wait_until(lambda: bool(client.states))
            yield client, plant, standby


def get_state(client: Remote, node: str) -> str:
    """Return the lifecycle state of a node."""
    return client.request(GetState, f"{node}/get_state", GetState.Request()).current_state.label


def change_state(client: Remote, node: str, transition: int) -> bool:
    """Ask a node for a transition; return whether it has happened."""
    request = ChangeState.Request(transition=Transition(id=transition))
    return client.request(ChangeState, f"{node}/change_state", request).success


def wait_standing(client: Remote) -> int:
    """Return the stamp of the state at which the plant stands; fails where it does not."""
    newest = -1

    def moved() -> bool:
        nonlocal newest
        previous, newest = newest, client.states[-1]
        time.sleep(0.3)  # s, in which a plant that runs takes hundreds of steps
        return newest != previous

    wait_until(lambda: not moved(), "a plant that stands")
    return newest


def test_transitions(bench: tuple[Remote, NodeProcess, NodeProcess]) -> None:
    """An inactive controller is silent, an inactive plant paused.

    Activated they resume, and shut down they end.

    A controller without autostart is ready but silent until the request go, and then answers the
    newest state.
    """
    client, plant, standby = bench
    assert get_state(client, "plant") == "active"
    assert (get_state(client, "controller"), client.states[-1]) == ("inactive", PERIOD)
    standby.send("go")
    wait_until(lambda: client.states[-1] > 10 * PERIOD)
    assert get_state(client, "controller") == "active"
    for node in ("controller", "plant"):
        assert change_state(client, node, DEACTIVATE)
        wait_until(lambda: client.modes[-1] == 2)
        reached = wait_standing(client)
        if node == "plant":
            assert client.step() == "the node is inactive"
        assert change_state(client, node, ACTIVATE)
        wait_until(lambda: client.modes[-1] == 1 and client.states[-1] > reached + 10 * PERIOD)  # noqa: B023 called here
    assert client.pause(True) == "ok"
    assert change_state(client, "plant", DEACTIVATE) and change_state(client, "plant", ACTIVATE)
    client.take_steps(1)  # of a paused run: the user's pause outlasted the manager's
    assert client.pause(False) == "ok"
    assert change_state(client, "plant", SHUTDOWN)
    assert plant.await_event("done")["summary"]["steps"] > 20
    assert plant.process.wait(60.0) == 0
    assert change_state(client, "controller", SHUTDOWN)
    assert standby.process.wait(60.0) == 0
