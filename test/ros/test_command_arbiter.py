"""Command arbiter and its lease, without DDS: which publisher owns the crane, and warnings."""

import time
from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.qos import QoSProfile

from crane_sim.ros.common.sender_subscription import MessageWithSender
from crane_sim.ros.plant.command_arbiter import (
    CommandArbiter,
    CommandLease,
    CommandTopic,
    Ownership,
)

LEASE = 0.1  # s
TOPIC = "joint_commands"
INVALID = "invalid"  # prefix of a message that is no valid command


def gid(letter: str) -> bytes:
    """Return the identifier of a publisher."""
    return letter.encode() * 16


def publisher(letter: str, node: str = "") -> SimpleNamespace:
    """Return the graph's entry of a publisher, by default of a node of its own name."""
    qos = QoSProfile(depth=1)  # reliable
    return SimpleNamespace(
        endpoint_gid=list(gid(letter)),
        node_namespace="/",
        node_name=node or letter,
        qos_profile=qos,
    )


class Bench:
    """An arbiter with doubles of its surroundings, and a clock that stands until it is changed.

    Attributes:
        now: s of the monotonic clock.
        matched: number of publishers that the subscription is matched with.
        graph: the ROS graph's entries of publishers.
        passed_on: messages that the arbiter has passed on.
        warnings: those that differ from the one before.
    """

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, exclusive: bool = False, commander: str = ""
    ) -> None:
        """Begin with two publishers, a and b."""
        self.now, self.matched, self.suspended = 1000.0, 2, False
        monkeypatch.setattr(time, "monotonic", lambda: self.now)
        self.graph = [publisher("a"), publisher("b")]
        self.passed_on, self.warnings, self.refused = list[str](), list[str](), Counter[str]()
        node = SimpleNamespace(
            get_namespace=lambda: "/", get_publishers_info_by_topic=lambda _: self.graph
        )
        host: Any = SimpleNamespace(
            node=node, notify=lambda _: None, subscribe_with_sender=self._subscribe
        )
        validator = SimpleNamespace(reject=lambda *_: None)
        simulation: Any = SimpleNamespace(
            warn=self._warn, validator=validator, refused_messages=self.refused
        )
        lease, topics = (
            CommandLease(LEASE, lambda: self.suspended),
            {TOPIC: CommandTopic(bytes, self._on_message)},
        )
        self.arbiter = CommandArbiter(host, simulation, topics, lease, exclusive, commander)
        self.arbiter.start()

    def do(self, action: str) -> None:
        """Do something.

        Args:
            action: "a: words" sends a message; "wait 1.5" lets so many leases pass; "nodes a b:c"
                are the publishers from now on, b of a node c; "suspend" and "go on" are about the
                lease's expiry.
        """
        word, _, rest = action.partition(" ")
        if word == "wait":
            self.now += float(rest) * LEASE
        elif word == "nodes":
            self.graph = [publisher(*each.split(":")) for each in rest.split()]
            self.matched = len(self.graph)
            self.now += LEASE
        elif word in ("suspend", "go"):
            self.suspended = word == "suspend"
        else:
            self.arbiter.update()
            self._deliver([MessageWithSender(rest.encode(), gid(word[0]))])

    def _subscribe(self, _kind: type, topic: str, callback: Any, *_: Any) -> Any:
        self._deliver = callback
        return SimpleNamespace(topic=topic, count_publishers=lambda: self.matched)

    def _on_message(self, data: bytes) -> bool:
        self.passed_on.append(data.decode())
        return not self.passed_on[-1].startswith(INVALID)

    def _warn(self, line: str, _: str) -> None:
        if line != (self.warnings or [""])[-1]:
            self.warnings.append(line)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    """Return an arbiter with two publishers."""
    return Bench(monkeypatch)


def test_states_of_the_lease() -> None:
    """It is held until its owner was silent for longer than the lease, not while suspended.

    A suspended lease does not lapse.
    """
    suspended = [False]
    lease = CommandLease(0.25, lambda: suspended[0])
    assert lease.state(9.0) == Ownership.FREE
    lease.hold(gid("a"), 1.0)
    assert (lease.state(1.25), lease.state(1.26)) == (Ownership.HELD, Ownership.LAPSED)
    suspended[0] = True
    assert lease.state(9.0) == Ownership.HELD
    suspended[0] = False
    assert (lease.state(9.25), lease.state(9.26)) == (Ownership.HELD, Ownership.LAPSED)


SCENARIOS = {
    "however long a suspended owner is silent, another one is accepted only a lease after the "
    "suspension ends": (
        {},
        ["a: 1", "suspend", "wait 1.5", "b: 2", "a: 3", "go on", "b: 4", "wait 1.5", "b: 5"],
        "1 3 5",
    ),
    "an exclusive lease ends for a standby of the owner's node alone, as long as that is in the "
    "graph": (
        {"exclusive": True},
        [
            *("nodes a:controller b", "a: 1", "wait 90", "b: 2", "a: 3"),
            *("nodes a:controller b c:controller", "wait 1", "b: 4", "c: 5", "nodes b", "b: 6"),
        ],
        "1 3 5 6",
    ),
    "an owner that leaves the graph has no lease any more, although its expiry is suspended": (
        {},
        ["suspend", "a: 1", "nodes b c d", "b: 2"],
        "1 2",
    ),
    "an invalid command acquires no lease, neither the first one nor after the end of another's": (
        {},
        ["b: invalid", "a: 1", "wait 1.5", "b: invalid", "a: 2", "b: 3"],
        "invalid 1 invalid 2",
    ),
    "an invalid command renews no lease": (
        {},
        ["a: 1", *["wait 0.4", "a: invalid"] * 4, "b: 2"],
        "1 invalid invalid invalid invalid 2",
    ),
    "a sole publisher keeps the crane when others come": (
        {},
        ["suspend", "nodes a", "a: 1", "nodes a b", "b: 2"],
        "1",
    ),
    "a sole publisher that never commanded does not": (
        {},
        ["suspend", "nodes a", "nodes a b", "b: 2"],
        "2",
    ),
    "the crane of an owner that has left does not fall to one that remains and never commanded "
    "it": (
        {},
        ["nodes a", "nodes a b", "b: 2", "nodes a", "nodes a b", "b: 3"],
        "2 3",
    ),
}


@pytest.mark.parametrize("name", SCENARIOS)
def test_who_owns_the_crane(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The commands that are passed on are the owner's."""
    options, actions, passed_on = SCENARIOS[name]
    bench = Bench(monkeypatch, **options)
    for action in actions:
        bench.do(action)
    assert " ".join(bench.passed_on) == passed_on


def test_a_stranger_never_owns_the_crane_of_a_commander(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another node's valid command, even the first, is refused; that of a new standby is not."""
    bench = Bench(monkeypatch, exclusive=True, commander="a")
    for action in ("b: 1", "wait 1", "a: 2", "nodes b", "b: 3"):
        bench.do(action)
    bench.graph.append(publisher("c", "a"))
    for action in ("c: 4", "nodes b a:a_2", "a: 5", "b: 6", "wait 1", "a: 7"):
        bench.do(action)
    assert bench.passed_on == ["2", "4", "5", "7"] and bench.refused == {f"{TOPIC} of /b": 3}
    assert bench.warnings[0] == "command of /b refused: /a owns the crane"
    assert bench.warnings[-1] == "command of /b refused: /a_2 owns the crane"


def test_a_run_waits_for_its_commander(monkeypatch: pytest.MonkeyPatch) -> None:
    """However many others publish commands, the run begins when the commander does.

    It says that it waits for the commander.
    """
    bench = Bench(monkeypatch, exclusive=True, commander="c")
    assert bench.arbiter.missing(1) == "/c on joint_commands"
    assert bench.arbiter.missing(3) == "1 more publisher(s) of joint_commands"
    bench.do("nodes a b c")
    assert not bench.arbiter.missing(1) and not Bench(monkeypatch, commander="c").arbiter.missing(0)


def test_a_late_node_name_is_in_the_warning(bench: Bench) -> None:
    """A publisher refused before its node's name arrives is then named, at any message rate."""
    bench.graph[1] = publisher("b", "_NODE_NAME_UNKNOWN_")
    bench.do("a: 1")
    for _ in range(100):
        for action in ("b: refused", "wait 0.1", "a: 2"):
            bench.do(action)
        bench.graph[1] = publisher("b")
    unnamed, named = bench.warnings
    assert unnamed == "command of a node without a name refused: /a owns the crane"
    assert named == "command of /b refused: /a owns the crane"


def test_refused_publishers_in_turn_are_one_warning(bench: Bench) -> None:
    """However many are refused, a warning comes only with a new one, and ends after a time.

    The order of refusals does not matter either.
    """
    bench.graph.append(publisher("c"))
    bench.do("a: 1")
    for action in ("b: refused", "c: refused", "wait 0.1", "a: 2") * 100:
        bench.do(action)
    assert bench.warnings == [
        f"command of {names} refused: /a owns the crane" for names in ("/b", "/b and /c")
    ]
    for action in ("wait 30", "a: 3"):
        bench.do(action)
    assert bench.warnings[-1] == "" and bench.refused == {
        f"{TOPIC} of /b": 100,
        f"{TOPIC} of /c": 100,
    }


def test_the_warning_of_a_refused_publisher_ends_when_it_owns_the_crane(bench: Bench) -> None:
    """A publisher that was refused and is the owner by now is not warned of."""
    for action in ("a: 1", "b: 2", "wait 1.5", "b: 3", "wait 1", "b: 4"):
        bench.do(action)
    assert bench.warnings == ["command of /b refused: /a owns the crane", ""]


def test_a_publisher_that_is_not_matched_takes_no_lease_away(bench: Bench) -> None:
    """A publisher in the graph that is not matched does not change the owner's lease.

    It has another type, or is not matched yet.
    """
    bench.do("nodes")
    bench.matched = 1
    bench.do("a: 1")  # its publisher is in the graph only afterwards
    for nodes in ("nodes a", "nodes s a"):
        bench.do(nodes)
        bench.matched = 1
        bench.arbiter.update()
    bench.do("suspend")
    bench.do("nodes s a b")
    bench.matched = 2
    bench.do("b: 2")
    assert bench.passed_on == ["1"]
