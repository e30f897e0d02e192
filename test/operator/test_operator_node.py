"""The node `operator` without DDS: what its panel says, and how it requests the plant's brakes."""

from math import degrees
from types import SimpleNamespace
from typing import Any

import pytest
from fake_node import fake_sources

from crane_control.nodes.operator_node import OperatorNode
from crane_sim import load_scene
from crane_sim.operator.drives import with_operator_drives
from crane_sim.ros.common.serialization import STATE, JointStateCodec
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import derive_instant

__all__ = ["fake_sources"]

pytestmark = pytest.mark.usefixtures("fake_sources")


class Graph:
    """A node's host; keeps what is sent, shown and logged.

    Its plant answers requests of its brakes at once.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.now, self.requests = scene, 0.0, {}
        self.brakes: list[tuple[float, bool]] = []
        self.panels: list[dict[str, Any]] = []
        self.warnings: list[str] = []
        self.answer = SimpleNamespace(success=True, message="")
        self.pipes = SimpleNamespace(report=lambda _, **panel: self.panels.append(panel))
        self.node = SimpleNamespace(
            create_client=lambda *_: SimpleNamespace(call_async=self._call),
            create_publisher=lambda *_: SimpleNamespace(publish=lambda _: None),
            create_subscription=self._subscribe,
            get_logger=lambda: SimpleNamespace(
                warning=lambda line, **_: self.warnings.append(line)
            ),
        )

    def _call(self, request: Any) -> Any:
        self.brakes.append((self.now, request.data))
        answer = self.answer
        return SimpleNamespace(done=lambda: True, result=lambda: answer)

    def _subscribe(self, _type: Any, _topic: str, callback: Any, *_: Any, **__: Any) -> None:
        self._deliver = callback

    def send(self, t: float) -> None:
        """Deliver the joints' initial positions at a time of the scene and of the wall."""
        self.now, stamp = t, round((t / self.scene.period + 1.0) * self.scene.period_ns)
        zeros = (0.0,) * len(self.scene.joint_names)
        self._deliver(
            JointStateCodec(self.scene.joint_names, STATE).encode(
                stamp, self.scene.initial_q, zeros, zeros
            )
        )


@pytest.fixture
def graph(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> tuple[Graph, OperatorNode]:
    """Return the graph of a scene for an operator, and the active node on it."""
    scene = with_operator_drives(load_scene(request.param))
    graph: Any = Graph(scene)
    monkeypatch.setattr(
        "crane_control.nodes.operator_node.time", SimpleNamespace(monotonic=lambda: graph.now)
    )
    names = {
        "mapping": "",
        "assistance": False,
        "device_timeout": 0.5,
        "device": "keyboard",
        "expected_recorders": 0,
    }
    node = OperatorNode(graph, SimpleNamespace(scene=scene.to_dict(), **names))
    node.set_active(True)
    return graph, node


@pytest.mark.parametrize("graph", ["knuckle_sea"], indirect=True)
def test_the_panel_has_the_swing_from_the_present_vertical(
    graph: tuple[Graph, OperatorNode],
) -> None:
    """On a base that moves the swing angle is that of the state's time, not that at t = 0."""
    plant, node = graph
    plant.send(7.0)
    node.on_spin()
    scene, zeros = plant.scene, (0.0,) * len(plant.scene.joint_names)
    at_start, now = (
        degrees(derive_instant(scene, t, scene.initial_q, zeros).swing[0]) for t in (0.0, 7.0)
    )
    assert (
        plant.panels[0]["swing_deg"] == pytest.approx(now, rel=1e-9) and abs(now - at_start) > 0.1
    )


@pytest.mark.parametrize("graph", ["bridge_speed_drive"], indirect=True)
def test_refused_brakes_are_requested_once_a_second(graph: tuple[Graph, OperatorNode]) -> None:
    """The panel says why the plant refuses the brakes, until it applies them; one log warning."""
    plant, node = graph
    plant.answer = SimpleNamespace(success=False, message="the run has not begun")
    plant.requests["key"]("space")
    for k in range(250):
        plant.send(0.01 * (k + 1))
    assert [round(at, 2) for at, on in plant.brakes if on] == [0.01, 1.01, 2.01]
    node.on_spin()
    line = "the plant does not apply the brakes: the run has not begun"
    assert plant.panels[-1]["brakes_refused"] == line and plant.warnings == [line]
    plant.answer = SimpleNamespace(success=True, message="")
    for k in range(250, 400):
        plant.send(0.01 * (k + 1))
    node.on_spin()
    assert len(plant.brakes) == 4 and plant.panels[-1]["brakes_refused"] == ""
