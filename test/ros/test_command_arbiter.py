"""Command arbiter and its lease, without DDS: which publisher owns the crane, and which warnings there are."""

import time
from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.qos import QoSProfile

from crane_sim.ros.common.sender_subscription import MessageWithSender
from crane_sim.ros.plant.command_arbiter import CommandArbiter, CommandLease, CommandTopic, Ownership

A, B, C = b"a" * 16, b"b" * 16, b"c" * 16
LEASE = 0.1  # s
TOPIC = "joint_commands"
QOS = QoSProfile(depth=1)  # reliable
INVALID = b"invalid"  # prefix of a message that is no valid command


def publisher(gid: bytes) -> SimpleNamespace:
    """Return the graph's entry of a publisher."""
    return SimpleNamespace(endpoint_gid=list(gid), node_namespace="/", node_name=gid[:1].decode(), qos_profile=QOS)


class ArbiterFixture:
    """An arbiter with doubles of its surroundings.

    Attributes:
        matched: publishers that the subscription is matched with.
        graph: the ROS graph's entries of publishers.
        suspended: whether the lease is suspended.
        passed_on: messages that the arbiter has passed on.
        warnings: those that differ from the one before.
    """

    def __init__(self, exclusive: bool = False, commander: str = "") -> None:
        """Begin with two publishers."""
        self.matched, self.suspended = [A, B], False
        self.graph = [publisher(A), publisher(B)]
        self.passed_on: list[bytes] = []
        self.warnings: list[str] = []
        node = SimpleNamespace(get_namespace=lambda: "/", get_publishers_info_by_topic=lambda _: self.graph)
        host: Any = SimpleNamespace(node=node, notify=lambda _: None, subscribe_with_sender=self._subscribe)
        validator = SimpleNamespace(reject=lambda *_: None)
        self.refused = Counter[str]()
        simulation: Any = SimpleNamespace(warn=self._warn, validator=validator, refused_messages=self.refused)
        topics = {TOPIC: CommandTopic(bytes, self._on_message)}
        lease = CommandLease(LEASE, lambda: self.suspended)
        self.arbiter = CommandArbiter(host, simulation, topics, lease, exclusive, commander)
        self.arbiter.start()

    def set_publishers(self, *gids: bytes) -> None:
        """Change the publishers, in the graph and matched."""
        self.matched, self.graph = list(gids), [publisher(gid) for gid in gids]

    def send(self, sender: bytes, data: bytes) -> None:
        """Let a message come."""
        self.arbiter.update()
        self._deliver([MessageWithSender(data, sender)])

    def _subscribe(self, _kind: type, topic: str, callback: Any, *_: Any) -> Any:
        self._deliver = callback
        self.subscription = SimpleNamespace(topic=topic)
        self.subscription.count_publishers = lambda: len(self.matched)
        return self.subscription

    def _on_message(self, data: bytes) -> bool:
        self.passed_on.append(data)
        return not data.startswith(INVALID)

    def _warn(self, line: str, _: str) -> None:
        if line != (self.warnings or [""])[-1]:
            self.warnings.append(line)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return the time [s] of the monotonic clock, which stands until it is changed."""
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return now


@pytest.fixture
def bench(clock: list[float]) -> ArbiterFixture:
    """Return an arbiter with two publishers."""
    return ArbiterFixture()


def test_states_of_the_lease() -> None:
    """It is held until its owner was silent for longer than the lease, and does not lapse while it is suspended."""
    suspended = [False]
    lease = CommandLease(0.25, lambda: suspended[0])
    assert lease.state(9.0) == Ownership.FREE
    lease.hold(A, 1.0)
    assert (lease.state(1.25), lease.state(1.26)) == (Ownership.HELD, Ownership.LAPSED)
    suspended[0] = True
    assert lease.state(9.0) == Ownership.HELD
    suspended[0] = False
    assert (lease.state(9.25), lease.state(9.26)) == (Ownership.HELD, Ownership.LAPSED)


def test_a_suspended_lease_does_not_expire(bench: ArbiterFixture, clock: list[float]) -> None:
    """However long the owner is silent, another one is accepted only a lease after the suspension ends."""
    bench.send(A, b"first")
    bench.suspended = True
    clock[0] += 1.5 * LEASE
    bench.send(B, b"second")
    bench.send(A, b"third")
    bench.suspended = False
    bench.send(B, b"fourth")
    clock[0] += 1.5 * LEASE
    bench.send(B, b"fifth")
    assert bench.passed_on == [b"first", b"third", b"fifth"]


def test_an_exclusive_lease_ends_for_standbys_only(clock: list[float]) -> None:
    """However long the owner is silent, another node waits until it has left; one with the owner's name does not.

    A starved owner answers late, and a flood pushes its answers out of queues.
    """
    bench = ArbiterFixture(exclusive=True)
    bench.graph[0].node_name = "controller"
    clock[0] += LEASE
    bench.send(A, b"first")
    clock[0] += 9.0
    bench.send(B, b"second")
    bench.send(A, b"third")
    standby = publisher(C)
    standby.node_name = "controller"
    bench.graph.append(standby)
    clock[0] += LEASE
    bench.send(B, b"fourth")
    bench.send(C, b"fifth")
    bench.set_publishers(B)
    clock[0] += LEASE
    bench.send(B, b"sixth")
    assert bench.passed_on == [b"first", b"third", b"fifth", b"sixth"]


def test_a_stranger_never_owns_the_crane_of_a_commander(clock: list[float]) -> None:
    """A valid command of another node, even the first one, is refused, and a standby that has just come is not."""
    bench = ArbiterFixture(exclusive=True, commander="a")
    bench.send(B, b"first")
    clock[0] += LEASE
    bench.send(A, b"second")
    bench.set_publishers(B)
    clock[0] += LEASE
    bench.send(B, b"third")
    standby = publisher(C)
    standby.node_name = "a"
    bench.graph.append(standby)
    bench.send(C, b"fourth")
    bench.set_publishers(B)
    bench.graph.append(next_standby := publisher(A))
    next_standby.node_name = "a_2"
    clock[0] += LEASE
    bench.send(A, b"fifth")
    bench.send(B, b"sixth")
    clock[0] += LEASE
    bench.send(A, b"seventh")
    assert bench.passed_on == [b"second", b"fourth", b"fifth", b"seventh"]
    assert bench.refused == {f"{TOPIC} of /b": 3}
    assert bench.warnings[0] == "command of /b refused: /a owns the crane"
    assert bench.warnings[-1] == "command of /b refused: /a_2 owns the crane"


def test_a_run_waits_for_its_commander() -> None:
    """However many others publish commands: the run begins when the commander does, and says that it waits for it."""
    bench = ArbiterFixture(exclusive=True, commander="c")
    assert bench.arbiter.missing(1) == "/c on joint_commands"
    assert bench.arbiter.missing(3) == "1 more publisher(s) of joint_commands"
    bench.set_publishers(A, B, C)
    assert not bench.arbiter.missing(1) and not ArbiterFixture(commander="c").arbiter.missing(0)


def test_who_was_refused_is_counted(bench: ArbiterFixture) -> None:
    """Refused messages are counted by topic and node."""
    for sender in (A, B, A, B):
        bench.send(sender, b"command")
    assert bench.refused == {f"{TOPIC} of /b": 2}


def test_an_owner_that_leaves_the_graph_loses_the_lease(bench: ArbiterFixture, clock: list[float]) -> None:
    """An owner whose publisher is gone has no lease any more, although no acknowledgement is missing."""
    bench.suspended = True
    bench.send(A, b"first")
    bench.set_publishers(B, C, b"d" * 16)
    clock[0] += LEASE  # the next update
    bench.send(B, b"second")
    assert bench.passed_on == [b"first", b"second"]


def test_a_late_node_name_is_in_the_warning(bench: ArbiterFixture, clock: list[float]) -> None:
    """A publisher that is refused before its node's name arrives is named as soon as it does, at any message rate."""
    bench.graph[1] = SimpleNamespace(
        endpoint_gid=list(B), node_namespace="?", node_name="_NODE_NAME_UNKNOWN_", qos_profile=QOS
    )
    bench.send(A, b"first")
    for _ in range(100):
        bench.send(B, b"refused")
        clock[0] += 0.01
        bench.send(A, b"another")
        bench.graph[1] = publisher(B)
    unnamed, named = bench.warnings
    assert unnamed == "command of a node without a name refused: /a owns the crane"
    assert named == "command of /b refused: /a owns the crane"


def test_refused_publishers_in_turn_are_one_warning(bench: ArbiterFixture, clock: list[float]) -> None:
    """However many are refused, and in which order: a warning comes only with a new one, and ends after a time."""
    bench.graph.append(publisher(C))
    bench.send(A, b"first")
    for _ in range(100):
        bench.send(B, b"refused")
        bench.send(C, b"refused")
        clock[0] += 0.01
        bench.send(A, b"another")
    assert bench.warnings == [f"command of {names} refused: /a owns the crane" for names in ("/b", "/b and /c")]
    clock[0] += 3.0
    bench.send(A, b"last")
    assert bench.warnings[-1] == ""


def test_the_warning_of_a_refused_publisher_ends_when_it_owns_the_crane(
    bench: ArbiterFixture, clock: list[float]
) -> None:
    """A publisher that was refused and is the owner by now is not warned of."""
    bench.send(A, b"first")
    bench.send(B, b"second")
    clock[0] += 1.5 * LEASE
    bench.send(B, b"third")
    clock[0] += LEASE
    bench.send(B, b"fourth")
    assert bench.warnings == ["command of /b refused: /a owns the crane", ""]


def test_an_invalid_command_acquires_no_lease(bench: ArbiterFixture, clock: list[float]) -> None:
    """Neither the first publisher nor one after the end of a lease becomes the owner by an invalid command."""
    bench.send(B, b"invalid")
    bench.send(A, b"first")
    clock[0] += 1.5 * LEASE
    bench.send(B, b"invalid, too")
    bench.send(A, b"second")
    bench.send(B, b"third")
    assert bench.passed_on == [b"invalid", b"first", b"invalid, too", b"second"]


def test_an_invalid_command_renews_no_lease(bench: ArbiterFixture, clock: list[float]) -> None:
    """However often the owner sends invalid commands: another publisher is accepted when the lease is over."""
    bench.send(A, b"first")
    for _ in range(4):
        clock[0] += 0.4 * LEASE
        bench.send(A, b"invalid")
    bench.send(B, b"second")
    assert bench.passed_on[-1] == b"second"


@pytest.mark.parametrize("has_commanded", [True, False])
def test_a_sole_publisher_owns_the_lease_after_its_first_command(
    has_commanded: bool, bench: ArbiterFixture, clock: list[float]
) -> None:
    """A sole publisher keeps the crane when others come; one that never commanded does not, expiry suspended or not."""
    bench.suspended = True
    bench.set_publishers(A)
    clock[0] += LEASE
    bench.arbiter.update()
    if has_commanded:
        bench.send(A, b"first")
    bench.set_publishers(A, B)
    clock[0] += LEASE
    bench.arbiter.update()
    bench.send(B, b"second")
    assert bench.passed_on == ([b"first"] if has_commanded else [b"second"])


def test_a_remaining_publisher_must_acquire_the_lease(bench: ArbiterFixture, clock: list[float]) -> None:
    """The crane of an owner that has left does not fall to a publisher that remains and never commanded it."""
    for gids in ((A,), (A, B)):
        bench.set_publishers(*gids)
        clock[0] += LEASE
        bench.arbiter.update()
    bench.send(B, b"second")
    for gids in ((A,), (A, B)):
        bench.set_publishers(*gids)
        clock[0] += LEASE
        bench.arbiter.update()
    bench.send(B, b"third")
    assert bench.passed_on == [b"second", b"third"]


def test_a_publisher_that_is_not_matched_takes_no_lease_away(bench: ArbiterFixture, clock: list[float]) -> None:
    """A publisher that is in the graph without being matched, by another type or not yet, leaves the owner's lease."""
    bench.matched, bench.graph = [A], []
    clock[0] += LEASE
    bench.arbiter.update()
    bench.send(A, b"first")  # its publisher is in the graph only afterwards
    unmatched = publisher(b"s" * 16)
    for graph in ([publisher(A)], [unmatched, publisher(A)]):
        bench.graph = graph
        clock[0] += LEASE
        bench.arbiter.update()
    bench.matched, bench.graph = [A, B], [unmatched, publisher(A), publisher(B)]
    bench.suspended = True
    clock[0] += LEASE
    bench.arbiter.update()
    bench.send(B, b"second")
    assert bench.passed_on == [b"first"]
