"""Whose silence counts, without DDS: a commander who lives, or has nothing to answer, keeps the crane."""

import time
from collections import deque
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.qos import QoSProfile

from crane_sim.ros.plant import command_arbiter as commands_module
from crane_sim.ros.plant.command_arbiter import CommandArbiter
from crane_sim.ros.plant.sender_subscription import MessageWithSender

A, B = b"a" * 16, b"b" * 16
LEASE = 0.1  # s
TOPIC = "joint_commands"
QOS = QoSProfile(depth=1)  # reliable
BAD = b"bad"  # how a message begins that is no good command


class FakeInbox:
    """An inbox that tests fill."""

    def __init__(self, *_: Any) -> None:
        """Be empty."""
        self.letters: deque[MessageWithSender] = deque()

    def take(self) -> MessageWithSender | None:
        """Return the oldest letter."""
        return self.letters.popleft() if self.letters else None

    def close(self) -> None:
        """Leave nothing behind."""


def publisher(gid: bytes) -> SimpleNamespace:
    """Return what the graph tells of a publisher."""
    return SimpleNamespace(endpoint_gid=list(gid), node_namespace="/", node_name=gid[:1].decode(), qos_profile=QOS)


class Scenery:
    """Commands with everything around them, of which nothing is a middleware's."""

    def __init__(self) -> None:
        """Let there be two publishers, and nobody excused."""
        self.publishers, self.excused = 2, False
        self.known = [publisher(A), publisher(B)]
        self.queue: deque[tuple[bytes, None]] = deque()  # of the executor's subscription
        self.taken: list[bytes] = []
        handle = SimpleNamespace(get_publisher_count=lambda: self.publishers, take_message=self._take)
        ear = SimpleNamespace(handle=_Entered(handle), topic_name=TOPIC)
        node = SimpleNamespace(
            create_subscription=lambda *_, **__: ear, get_publishers_info_by_topic=lambda _: self.known
        )
        gate = SimpleNamespace(reject=lambda *_: None)
        self.warnings: list[str] = []
        stepper = SimpleNamespace(paused=False, warn=self._warn, gate=gate)
        host: Any = SimpleNamespace(node=node)
        told: Any = stepper
        takers = {TOPIC: (bytes, self._accepts)}
        self.commands = CommandArbiter(host, told, takers, LEASE, lambda: self.excused)
        self.commands.begin()

    def send(self, sender: bytes, data: bytes) -> None:
        """Let a message come while there are several publishers."""
        inbox: Any = self.commands._inboxes[TOPIC]
        inbox.letters.append(MessageWithSender(data, sender))
        self.commands.look()
        self.commands.poll()

    def _accepts(self, data: bytes) -> bool:
        self.taken.append(data)
        return not data.startswith(BAD)

    def _warn(self, line: str, _: str) -> None:
        if line != (self.warnings or [""])[-1]:
            self.warnings.append(line)

    def _take(self, *_: Any) -> tuple[bytes, None] | None:
        return self.queue.popleft() if self.queue else None


class _Entered:
    """A handle that can be entered."""

    def __init__(self, handle: SimpleNamespace) -> None:
        self.get_publisher_count, self.take_message = handle.get_publisher_count, handle.take_message
        self._context = nullcontext()

    def __enter__(self) -> None:
        self._context.__enter__()

    def __exit__(self, *error: Any) -> None:
        self._context.__exit__(*error)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return the time [s], which stands until it is changed."""
    now = [1000.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    return now


@pytest.fixture
def scenery(clock: list[float], monkeypatch: pytest.MonkeyPatch) -> Scenery:
    """Return commands that two publishers send."""
    monkeypatch.setattr(commands_module, "SenderSubscription", FakeInbox)
    return Scenery()


def test_a_slow_commander_who_is_excused_keeps_the_crane(scenery: Scenery, clock: list[float]) -> None:
    """However long his silence, another one's commands count only once he is excused no more, and the lease is over."""
    scenery.send(A, b"first")
    scenery.excused = True
    clock[0] += 1.5 * LEASE
    scenery.send(B, b"second")
    scenery.send(A, b"third")
    scenery.excused = False
    scenery.send(B, b"fourth")
    clock[0] += 1.5 * LEASE
    scenery.send(B, b"fifth")
    assert scenery.taken == [b"first", b"third", b"fifth"]


def test_who_leaves_in_order_leaves_the_crane(scenery: Scenery, clock: list[float]) -> None:
    """A commander whose publisher is gone has no lease any more, although nobody fails to acknowledge the states."""
    scenery.excused = True
    scenery.send(A, b"first")
    scenery.publishers, scenery.known = 3, [publisher(B), publisher(b"c" * 16), publisher(b"d" * 16)]
    clock[0] += LEASE  # the next look at the graph
    scenery.send(B, b"second")
    assert scenery.taken == [b"first", b"second"]


def test_no_command_counts_twice_when_one_publisher_is_left(scenery: Scenery) -> None:
    """What the executor holds of messages that came through the inboxes is thrown away when these are closed."""
    scenery.send(A, b"first")
    scenery.queue.extend([(b"first", None), (b"of an intruder", None)])
    scenery.publishers = 1
    scenery.commands.begin()
    assert not scenery.commands.several
    assert not scenery.commands.fetch()
    assert scenery.taken == [b"first"]


def test_a_name_that_the_graph_learns_late_is_told(scenery: Scenery, clock: list[float]) -> None:
    """Who is refused before his node's name is known is named as soon as it is, however fast he goes on."""
    scenery.known[1] = SimpleNamespace(
        endpoint_gid=list(B), node_namespace="?", node_name="_NODE_NAME_UNKNOWN_", qos_profile=QOS
    )
    scenery.send(A, b"first")
    for _ in range(100):
        scenery.send(B, b"an intruder's")
        clock[0] += 0.01
        scenery.send(A, b"another")
        scenery.known[1] = publisher(B)
    nameless, named = scenery.warnings
    assert nameless == "command of a node without a name refused: /a commands"
    assert named == "command of /b refused: /a commands"


def test_intruders_in_turn_are_one_warning(scenery: Scenery, clock: list[float]) -> None:
    """However many there are, and whoever sends the newest command: a warning comes only with a new one."""
    third = b"c" * 16
    scenery.known.append(publisher(third))
    scenery.send(A, b"first")
    for _ in range(100):
        scenery.send(B, b"an intruder's")
        scenery.send(third, b"another's")
        clock[0] += 0.01
        scenery.send(A, b"another")
    assert scenery.warnings == [f"command of {who} refused: /a commands" for who in ("/b", "/b and /c")]
    clock[0] += 3.0
    scenery.send(A, b"last")
    assert scenery.warnings[-1] == ""


def test_who_was_refused_and_has_the_crane_now_is_no_intruder(scenery: Scenery, clock: list[float]) -> None:
    """The warning of him ends as soon as the crane is his."""
    scenery.send(A, b"first")
    scenery.send(B, b"second")
    clock[0] += 1.5 * LEASE
    scenery.send(B, b"third")
    clock[0] += LEASE
    scenery.send(B, b"fourth")
    assert scenery.warnings == ["command of /b refused: /a commands", ""]


def test_what_is_no_good_command_gives_nobody_the_crane(scenery: Scenery, clock: list[float]) -> None:
    """Neither the first nor the one who waited for the end of a lease gets it by sending what the plant refuses."""
    scenery.send(B, b"bad")
    scenery.send(A, b"first")
    clock[0] += 1.5 * LEASE
    scenery.send(B, b"bad, too")
    scenery.send(A, b"second")
    scenery.send(B, b"third")
    assert scenery.taken == [b"bad", b"first", b"bad, too", b"second"]


def test_a_commander_keeps_nothing_by_bad_commands(scenery: Scenery, clock: list[float]) -> None:
    """However often he sends what the plant refuses: another one has the crane when the lease is over."""
    scenery.send(A, b"first")
    for _ in range(4):
        clock[0] += 0.4 * LEASE
        scenery.send(A, b"bad")
    scenery.send(B, b"second")
    assert scenery.taken[-1] == b"second"


@pytest.mark.parametrize("at_work", [True, False])
def test_who_is_alone_has_the_crane_once_he_works(at_work: bool, scenery: Scenery, clock: list[float]) -> None:
    """Who was alone and commanded keeps the crane when others come; who was just there does not, not even excused."""
    scenery.excused = True
    scenery.publishers, scenery.known = 1, [publisher(A)]
    clock[0] += LEASE
    scenery.commands.look()
    if at_work:
        scenery.queue.append((b"first", None))
        assert scenery.commands.fetch()
    scenery.publishers, scenery.known = 2, [publisher(A), publisher(B)]
    clock[0] += LEASE
    scenery.commands.look()
    scenery.send(B, b"second")
    assert scenery.taken == ([b"first"] if at_work else [b"second"])


def test_who_has_left_and_come_back_has_to_begin_anew(scenery: Scenery, clock: list[float]) -> None:
    """The crane that another one had meanwhile does not fall to whoever is left, if he did not command it himself."""
    scenery.publishers, scenery.known = 1, [publisher(A)]
    scenery.commands.look()
    for publishers in ([publisher(A)], [publisher(A), publisher(B)]):
        scenery.publishers, scenery.known = len(publishers), publishers
        clock[0] += LEASE
        scenery.commands.look()
    scenery.send(B, b"second")
    scenery.publishers, scenery.known = 1, [publisher(A)]
    clock[0] += LEASE
    scenery.commands.look()
    scenery.publishers, scenery.known = 2, [publisher(A), publisher(B)]
    clock[0] += LEASE
    scenery.commands.look()
    scenery.send(B, b"third")
    assert scenery.taken == [b"second", b"third"]


def test_a_publisher_that_is_not_heard_takes_no_crane_away(scenery: Scenery, clock: list[float]) -> None:
    """Who is in the graph without being matched, by another type or not yet, leaves the commander what he has."""
    scenery.publishers, scenery.known = 1, []
    clock[0] += LEASE
    scenery.commands.look()
    scenery.queue.append((b"first", None))
    assert scenery.commands.fetch()  # whose it was, the graph tells afterwards
    for known in ([publisher(A)], [publisher(b"s" * 16), publisher(A)]):
        scenery.known = known
        clock[0] += LEASE
        scenery.commands.look()
    scenery.publishers, scenery.known = 2, [publisher(b"s" * 16), publisher(A), publisher(B)]
    scenery.excused = True
    clock[0] += LEASE
    scenery.commands.look()
    scenery.send(B, b"second")
    assert scenery.taken == [b"first"]
