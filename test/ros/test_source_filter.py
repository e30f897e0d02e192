"""Whose messages a node takes: those of the plant's own publisher, by its identifier."""

from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.qos import QoSProfile

from crane_sim.ros.common import source_filter
from crane_sim.ros.common.source_filter import SourceFilter

A, B, C = b"a" * 16, b"b" * 16, b"c" * 16
TOPIC = "/overhead/joint_states"


class Graph:
    """A node's view of the publishers of a topic."""

    def __init__(self) -> None:
        """Begin without any."""
        self.publishers: dict[bytes, str] = {}

    def get_namespace(self) -> str:
        """Return the crane's namespace."""
        return "/overhead"

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        """Return the entries of the graph."""
        assert topic == TOPIC
        return [
            SimpleNamespace(
                endpoint_gid=list(gid),
                node_namespace="/overhead",
                node_name=name,
                qos_profile=QoSProfile(depth=1),
            )
            for gid, name in self.publishers.items()
        ]


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    """Return a graph at which a filter looks whenever it wants to."""
    monkeypatch.setattr(source_filter, "_LOOK_PERIOD", 0.0)
    return Graph()


def make_filter(graph: Any, standbys: bool = False) -> SourceFilter:
    """Return a filter of the plant's messages."""
    return SourceFilter(graph, TOPIC, standbys=standbys)


def test_only_the_plant_is_accepted(graph: Graph) -> None:
    """Messages of other nodes are refused and counted by name, before and after the plant's."""
    graph.publishers = {A: "bag_player", B: "plant"}
    sources = make_filter(graph)
    assert [sources.accepts(gid) for gid in (A, B, A, B)] == [False, True, False, True]
    assert sources.refused == {f"{TOPIC} of /overhead/bag_player": 2}


def test_a_name_that_has_not_arrived_decides_nothing(graph: Graph) -> None:
    """A message of a publisher without a name, or not in the graph yet, waits for the name."""
    sources = make_filter(graph)
    assert sources.accepts(A) is None
    graph.publishers = {A: "_NODE_NAME_UNKNOWN_"}
    assert sources.accepts(A) is None and not sources.has_source
    graph.publishers = {A: "plant"}
    assert sources.accepts(A) is True and sources.has_source


def test_another_node_of_the_same_name_is_refused(graph: Graph) -> None:
    """The first plant is accepted as long as it is in the graph, the next one when that is gone."""
    graph.publishers = {A: "plant"}
    sources = make_filter(graph)
    assert sources.accepts(A)
    graph.publishers[B] = "plant"
    assert not sources.accepts(B) and sources.accepts(A)
    del graph.publishers[A]
    # what the first one has sent before is its own
    assert sources.accepts(A) and sources.accepts(B)
    assert not sources.accepts(C)


def test_standbys_are_accepted_at_once(graph: Graph) -> None:
    """A standby takes over although the node that it replaces is still in the graph."""
    graph.publishers = {A: "plant", B: "plant"}
    sources = make_filter(graph, standbys=True)
    assert sources.accepts(A) and sources.accepts(B)
