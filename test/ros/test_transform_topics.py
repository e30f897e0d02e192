"""The topics of transforms: what is published of which crane, how often, and under which names."""

from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim import load_scene
from crane_sim.ros.plant import transform_topics
from crane_sim.ros.plant.transform_topics import TransformTopics, missing_package
from crane_sim.simulation.plant import Plant


class Message(SimpleNamespace):
    """A message of tf2_msgs, which is no wheel."""


class Graph:
    """A node whose publishers keep their messages.

    Attributes:
        messages: by topic.
    """

    def __init__(self) -> None:
        """Begin without messages."""
        self.messages: dict[str, list[Any]] = {}

    def create_publisher(self, _kind: Any, topic: str, _qos: Any) -> Any:
        """Return a publisher with one subscriber."""
        kept = self.messages.setdefault(topic, [])
        return SimpleNamespace(publish=kept.append, get_subscription_count=lambda: 1)


def publish(
    name: str, steps: int, monkeypatch: pytest.MonkeyPatch, **changes: Any
) -> tuple[Graph, Plant]:
    """Return the graph and the plant after so many steps of a scene, the first state included."""
    monkeypatch.setattr(transform_topics, "TFMessage", Message)
    settings: dict[str, Any] = {"publish_tf": "all", "tf_rate": 50.0, "frame_prefix": ""}
    graph, plant = Graph(), Plant(load_scene(name))
    topics = TransformTopics(graph, plant.scene, SimpleNamespace(**settings | changes))  # pyright: ignore
    topics.update_subscribers()
    for _ in range(steps + 1):
        topics.publish((plant.k + 1) * plant.scene.period_ns, plant)
        plant.advance((0.0,) * len(plant.scene.actuated) if plant.scene.sampled else None)
    return graph, plant


def test_frames_that_stand_are_published_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fixed frames are latched on /tf_static, moving ones come on /tf; each has one publisher."""
    graph, plant = publish("bridge_hook_and_sling", 1, monkeypatch)
    (static,), moving = graph.messages["/tf_static"], graph.messages["/tf"]
    fixed = {transform.child_frame_id for transform in static.transforms}
    others = [transform.child_frame_id for transform in moving[0].transforms]
    assert "base_link" in fixed and "payload_link" in others
    assert len({*fixed, *others}) == len(fixed) + len(others)
    assert moving[0].transforms[0].header.stamp.nanosec == plant.scene.period_ns


def test_the_rate_is_that_of_the_parameter(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 25 messages a second one is sent every so many periods, beginning with the first state."""
    graph, plant = publish("overhead_energy", 20, monkeypatch, tf_rate=25.0)
    every, period = round(0.04 / plant.scene.period), plant.scene.period_ns
    stamps = [message.transforms[0].header.stamp.nanosec for message in graph.messages["/tf"]]
    assert stamps == [(k + 1) * period for k in range(0, 21, every)]


def test_beside_a_robot_state_publisher_there_is_only_the_base(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With `base` there is world to base_link where the base moves, and nothing of the URDF."""
    graph, _ = publish("overhead_sway", 0, monkeypatch, publish_tf="base", frame_prefix="sea/")
    (message,) = graph.messages["/tf"]
    (transform,) = message.transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("world", "sea/base_link")
    assert not graph.messages["/tf_static"]
    standing, _ = publish("overhead_energy", 2, monkeypatch, publish_tf="base")
    assert standing.messages == {"/tf": [], "/tf_static": []}


def test_without_the_package_one_line_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where tf2_msgs is missing a line names it and the command that makes it, if it is wanted."""
    monkeypatch.setattr(transform_topics, "TFMessage", None)
    assert "tf2_msgs" in missing_package("all") and "\n" not in missing_package("all")
    assert missing_package("off") == ""
    monkeypatch.setattr(transform_topics, "TFMessage", Message)
    assert missing_package("all") == ""
