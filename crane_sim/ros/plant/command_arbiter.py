"""Arbitration of command topics: one publisher owns the crane at a time, under a lease.

While there is one publisher, messages come the quick way, through the executor, and need no sender. As soon as there
is a second one, inboxes are opened, whose messages have senders, and what the executor brings no longer counts.

The first publisher of a valid command owns the crane until its lease ends: that long without another valid command.
"""

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from crane_sim.ros.common import messages
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.sender_subscription import SenderSubscription, publishers
from crane_sim.ros.plant.simulation_run import SimulationRun


class CommandLease:
    """The lease on the crane: one owner at a time, known by the identifier of its publisher.

    Attributes:
        owner: the owner, empty while there is none; a sole publisher that has sent valid commands may be put in.
    """

    def __init__(self, lease: float) -> None:
        """Let a commander keep the crane for `lease` seconds without a good command."""
        self.owner = b""
        self._lease, self._heard = lease, 0.0

    def accepts(self, sender: bytes, now: float) -> bool:
        """Return whether a message that this sender published at `now` [s] may be a command."""
        return sender == self.owner or not self.owner or now - self._heard > self._lease

    def follow(self, sender: bytes, now: float) -> None:
        """Make the sender of a valid command at `now` [s] the owner, and begin its lease anew."""
        self.owner, self._heard = sender, now

    def renew(self, now: float) -> None:
        """Begin the commander's lease anew at `now` [s], if that is later than it began."""
        self._heard = max(self._heard, now)


Callback = Callable[[bytes], bool]  # whether it was a good command


_MOST = 1000  # messages handed on at a time, so that other work of the node is not held up


_QOS = QoSProfile(depth=1000)  # of inboxes, where one sender must not push another one's messages out at once


_LOOK = 0.1  # s between two looks at who publishes


_MEMORY = 2.0  # s for which a refused commander is warned of


_GONE = "a node that left"


class CommandArbiter:
    """Hands on the commands of one commander, and refuses those of all other publishers by name."""

    def __init__(
        self,
        host: NodeHost,
        stepper: SimulationRun,
        takers: Mapping[str, tuple[Any, Callback]],
        lease: float,
        excused: Callable[[], bool],
    ) -> None:
        """Listen.

        Args:
            host: whose topics they are.
            stepper: whose books and diagnostics tell of refusals.
            takers: message class, and what takes the bytes of a message, by topic; it returns whether they are a good
                command: a bad one makes no publisher the owner.
            lease: time without a good command that costs a commander the crane, s.
            excused: whether the commander has a good reason to send none.
        """
        self._node, self._stepper, self._takers, self._helm = host.node, stepper, takers, CommandLease(lease)
        self._lease, self._excused = lease, excused
        self._ears: dict[str, Subscription] = {
            topic: host.node.create_subscription(
                kind, topic, partial(self._on_message, take), messages.STREAM, raw=True
            )
            for topic, (kind, take) in takers.items()
        }
        self._inboxes: dict[str, SenderSubscription] = {}
        self._refused: dict[bytes, float] = {}  # senders refused lately, and the last instant [s]
        self._line = ""  # the words for it
        self._there: dict[bytes, str] = {}  # publishers at the last look, while there were several, by name of the node
        self._sole_publisher, self._proven = b"", False  # the only publisher, and whether it has sent a good command
        self._heard = self._looked = 0.0  # s, the newest good command, and the last look

    @property
    def several(self) -> bool:
        """Whether more than one may command: then `poll` hands the messages on, and the executor does not."""
        return bool(self._inboxes)

    @property
    def topics(self) -> str:
        """The full names of the topics."""
        return " or ".join(ear.topic_name for ear in self._ears.values())

    def count(self) -> int:
        """Return the number of publishers."""
        return sum(ear.handle.get_publisher_count() for ear in self._ears.values())

    def fetch(self) -> bool:
        """Hand on a message that waits, without the executor; False where there is none."""
        if self._inboxes:
            return self.poll()
        for topic, ear in self._ears.items():
            kind, take = self._takers[topic]
            if data := messages.take_message(ear, kind):
                self._on_message(take, data)
                return True
        return False

    def wait(self, seconds: float) -> None:
        """Let so much time pass, less where a message comes on the first topic."""
        next(iter(self._inboxes.values())).wait(seconds)

    def poll(self) -> bool:
        """Hand on what has come of the commander, refuse the rest; False where nothing has come."""
        found = False
        for topic, inbox in self._inboxes.items():
            for _ in range(_MOST):
                if (letter := inbox.take()) is None:
                    break
                found = True
                now = time.monotonic()
                if not self._helm.accepts(letter.sender, now):
                    self._refuse(letter.sender)
                elif self._takers[topic][1](letter.data):
                    self._helm.follow(letter.sender, now)
        return found

    def begin(self) -> None:
        """Look for publishers at the begin of the run."""
        self._looked = 0.0
        self.look()

    def look(self) -> None:
        """Look for publishers now and then, and whether the commander's silence counts."""
        now = time.monotonic()
        if now - self._looked >= _LOOK:
            self._looked = now
            self._count_in(now)
        if self._inboxes and self._excused():
            self._helm.renew(now)

    def _count_in(self, now: float) -> None:
        count = self.count()
        if count > 1 and not self._inboxes:
            self._open()
        elif count < 2 and self._inboxes:
            self._close()
        if self._inboxes:
            there = self._publishers()
            if self._helm.owner in self._there.keys() - there.keys():
                self._helm.owner = b""  # it has left in order: its lease is over
            self._there = there
        if count < 2:
            self._set_sole_publisher(list(self._publishers()))
        self._refused = {who: when for who, when in self._refused.items() if now - when < _MEMORY}
        self._tell()

    def _set_sole_publisher(self, publishers: list[bytes]) -> None:
        """Record the sole publisher; it owns the crane from its first valid command on, however idle."""
        alone = publishers[0] if len(publishers) == 1 else b""
        if self._sole_publisher in publishers:
            alone = self._sole_publisher  # the graph knows a publisher before it is matched
        if alone != self._sole_publisher:
            # A publisher that was not known before may have sent the first good command already.
            proven = alone == self._helm.owner or (not self._sole_publisher and self._proven)
            self._sole_publisher, self._proven = alone, bool(alone) and proven
        self._helm.owner = alone if self._proven else b""

    def _on_message(self, take: Callback, data: bytes) -> None:
        if self._inboxes:
            return  # they have it, too, and its sender
        if self.count() > 1:
            self._open()  # the sender of this one is unknown; what does not come again is lost
            return
        if take(data):
            self._heard, self._proven = time.monotonic(), True

    def _open(self) -> None:
        now = time.monotonic()
        self._set_sole_publisher([self._sole_publisher])
        busy = now - self._heard < self._lease
        # A busy publisher needs a while to find the inboxes; then the middleware knows whether it is alive.
        self._helm.renew(now + messages.LEASE if busy else self._heard)
        self._sole_publisher, self._proven = b"", False
        self._inboxes = {
            topic: SenderSubscription(self._node, kind, topic, _QOS) for topic, (kind, _) in self._takers.items()
        }

    def _close(self) -> None:
        for topic, ear in self._ears.items():
            while messages.take_message(ear, self._takers[topic][0]):
                pass  # the inboxes have it, too, and know whose it is
        self.poll()
        for inbox in self._inboxes.values():
            inbox.close()
        self._inboxes = {}

    def _refuse(self, sender: bytes) -> None:
        """Count it; warn at once of a sender that is new, since there may be thousands of messages in a second."""
        known = sender in self._refused
        self._refused[sender] = time.monotonic()
        if not known:
            self._there |= self._publishers()
            self._tell()
        self._stepper.gate.reject("commander", self._line)

    def _tell(self) -> None:
        """Warn of senders refused lately; again with every look, since the graph may know a node before its name."""
        self._refused.pop(self._helm.owner, None)  # it owns the crane by now
        if self._refused:
            intruders = " and ".join(sorted({self._there.get(who, _GONE) for who in self._refused}))
            self._line = f"command of {intruders} refused: {self._there.get(self._helm.owner, _GONE)} commands"
        self._stepper.warn(self._line if self._refused else "", "commander")

    def _publishers(self) -> dict[bytes, str]:
        return {gid: name for ear in self._ears.values() for gid, name in publishers(self._node, ear.topic_name)}
