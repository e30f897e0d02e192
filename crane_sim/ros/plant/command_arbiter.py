"""Arbitration of command topics: one publisher owns the crane at a time, under a lease.

| state | valid command of the owner | of another one that may own it | owner leaves the graph | lease over |
|---|---|---|---|---|
| FREE | | HELD, by it | | |
| HELD | HELD | refused | FREE | LAPSED |
| LAPSED | HELD | HELD, by it | FREE | |

An exclusive lease, that of lockstep, lapses only for another publisher of the owner's node, its
standby; any other one waits until the owner has left the graph: on a busy machine an owner that
answers may be silent for longer than any lease, and messages of a flood push its answers out of the
middleware's queues. Where the commander is known, publishers of other nodes never own the crane:
one that answers once and then no more would hold up the run for good.
"""  # noqa: E501

import re
import time
from collections.abc import Callable, Mapping, Sequence
from enum import Enum, auto
from functools import partial
from typing import Any, NamedTuple

from rclpy.qos import QoSProfile

from crane_sim.ros.common import messages
from crane_sim.ros.common.command_filter import Refusal
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.sender_subscription import GONE, UNNAMED, MessageWithSender, publishers
from crane_sim.ros.common.served_subscription import ServedSubscription
from crane_sim.ros.plant.simulation_run import SimulationRun

_QOS = QoSProfile(depth=10_000)  # one publisher must not push out another one's messages
_UPDATE_PERIOD = 0.1  # s between two updates of the publishers
_WARNING_TIME = 2.0  # s for which a refused publisher is warned of


class Ownership(Enum):
    """Whether a publisher owns the crane, and whether another one may take it over."""

    FREE = auto()
    HELD = auto()
    LAPSED = auto()


class CommandLease:
    """The lease on the crane: its owner is known by the identifier of its publisher.

    Attributes:
        owner: empty while there is none.
        suspended: returns whether the lease cannot lapse now: the owner has a reason to send no
            command.
    """

    def __init__(self, duration: float, suspended: Callable[[], bool]) -> None:
        """Create a free one that lapses `duration` seconds after the owner's last valid command."""
        self.owner, self.suspended = b"", suspended
        self._duration, self._renewed = duration, 0.0

    def state(self, now: float) -> Ownership:
        """Return the state at `now` [s]; a lease that ended while it was suspended begins anew."""
        if not self.owner:
            return Ownership.FREE
        if now - self._renewed <= self._duration:
            return Ownership.HELD
        if not self.suspended():
            return Ownership.LAPSED
        self._renewed = now
        return Ownership.HELD

    def hold(self, owner: bytes, now: float) -> None:
        """Let the lease of an owner begin at `now` [s]."""
        self.owner, self._renewed = owner, now


class CommandTopic(NamedTuple):
    """A topic of commands."""

    kind: Any  # message class
    on_message: Callable[[bytes], bool]  # takes a serialized message; returns whether it was a
    # valid command


class CommandArbiter:
    """Arbiter that passes on the owner's commands, and refuses those of all others by name.

    Attributes:
        contested: there were several publishers at the last update.
    """

    def __init__(
        self,
        host: NodeHost,
        simulation: SimulationRun,
        topics: Mapping[str, CommandTopic],
        lease: CommandLease,
        exclusive: bool = False,
        commander: str = "",
    ) -> None:
        """Subscribe.

        Args:
            host: of the node with the topics.
            simulation: counts refusals, and publishes warnings of them.
            topics: by name; an invalid command makes no publisher the owner.
            lease: on the crane.
            exclusive: the lease of an owner in the graph lapses only for publishers of its own
                node.
            commander: the only node, in this one's namespace, that may own the crane, beside its
                numbered standbys; empty: any node may.
        """
        self._host, self._node, self._simulation, self._topics = host, host.node, simulation, topics
        self._lease, self._exclusive, self.contested = lease, exclusive, False
        namespace = self._node.get_namespace().rstrip("/") if commander else ""
        self._commander = f"{namespace}/{commander}" if commander else ""
        self._commanders = re.compile(
            rf"{re.escape(self._commander)}(_\d+)?" if commander else ".*"
        )
        self._subscriptions: dict[str, ServedSubscription] = {
            name: host.subscribe_with_sender(
                topic.kind,
                name,
                partial(self._on_messages, name),
                _QOS,
                partial(self._on_incompatible, name),
            )
            for name, topic in topics.items()
        }
        # publishers refused lately, and the last instant [s]
        self._refused: dict[bytes, float] = {}
        self._warning = ""  # of them
        self._names: dict[bytes, str] = {}  # of the nodes of publishers, at the last update
        self._last_update = 0.0  # s

    @property
    def has_newcomer(self) -> bool:
        """Whether the only publisher has not sent a valid command yet."""
        return len(self._names) == 1 and self._lease.owner not in self._names

    def missing(self, number: int) -> str:
        """Return what is waited for, one line, until there are `number` publishers.

        The commander's must be among them.
        """
        topics = " or ".join(subscription.topic for subscription in self._subscriptions.values())
        if (missing := number - self._count_publishers()) > 0:
            return f"{missing} more publisher(s) of {topics}"
        named = not (number and self._commander) or self._commander in self.publishing_nodes()
        return "" if named else f"{self._commander} on {topics}"

    def publishing_nodes(self) -> set[str]:
        """Return the full names of the nodes with publishers."""
        return set(self._list_publishers().values())

    def take_one(self) -> bool:
        """Take and pass on a message at once; False where there is none."""
        for name, subscription in self._subscriptions.items():
            if message := subscription.take():
                self._on_messages(name, [message])
                return True
        return False

    def start(self) -> None:
        """Update the publishers at the start of the run."""
        self._last_update = 0.0
        self.update()

    def update(self) -> None:
        """Update the publishers ten times a second, and the owner's lease while suspended."""
        now = time.monotonic()
        if now - self._last_update < _UPDATE_PERIOD:
            return
        self._last_update, names = now, self._list_publishers()
        if self._lease.owner in self._names.keys() - names.keys():
            self._lease.owner = b""  # it has left the graph
        self._names = names
        self.contested = self._count_publishers() > 1
        if self.contested and self._lease.suspended():
            self._lease.hold(self._lease.owner, now)
        self._refused = {
            sender: last for sender, last in self._refused.items() if now - last < _WARNING_TIME
        }
        self._update_warning()

    def _on_messages(self, topic: str, taken: Sequence[MessageWithSender]) -> None:
        """Pass the owner's messages on; refuse those of each other sender together.

        There may be thousands.
        """
        refused: dict[bytes, int] = {}  # a Counter takes 1.5 us to make, at every command
        for data, sender, _ in taken:
            if not self._may_command(sender):
                refused[sender] = refused.get(sender, 0) + 1
            elif self._topics[topic].on_message(data):
                self._lease.hold(sender, time.monotonic())
        for sender, number in refused.items():
            self._refuse(topic, sender, number)

    def _may_command(self, sender: bytes) -> bool:
        owner = self._lease.owner
        if sender == owner:
            return True
        if self._commander and sender not in self._names and sender not in self._refused:
            self._names |= self._list_publishers()  # it has come since the last update
        name = self._names.get(sender, GONE)
        if not self._commanders.fullmatch(name):
            return False
        state = self._lease.state(time.monotonic())
        if state == Ownership.LAPSED and self._exclusive:
            return sender in self._names and name == self._names.get(owner)
        return state != Ownership.HELD

    def _on_incompatible(self, topic: str, event: Any) -> None:
        """Say which publisher is not matched, and why: it would be waited for."""
        name = self._subscriptions[topic].topic
        unmatched = sorted(
            {each.node for each in publishers(self._node, name) if not each.reliable}
        )
        whose = f" of {' and '.join(unmatched)}" if unmatched else ""
        why = messages.describe_policy(event.last_policy_kind)
        self._host.notify(f"a publisher{whose} of {name} is not matched: {why}")

    def _refuse(self, topic: str, sender: bytes, number: int) -> None:
        """Count refusals; warn at once of a new sender only, of others with the next update."""
        known = sender in self._refused
        self._refused[sender] = time.monotonic()
        if not known:
            self._names |= self._list_publishers()
            self._update_warning()
        name = self._subscriptions[topic].topic
        self._simulation.refused_messages[f"{name} of {self._names.get(sender, GONE)}"] += number
        self._simulation.validator.reject(Refusal.COMMANDER, self._warning, number)

    def _update_warning(self) -> None:
        """Warn of publishers refused lately, with every update.

        The graph may have a node before its name.
        """
        self._refused.pop(self._lease.owner, None)  # it owns the crane by now
        if self._refused:
            refused = {self._names.get(sender, GONE) for sender in self._refused}
            owner = self._names.get(self._lease.owner, self._commander or GONE)
            self._warning = (
                f"command of {' and '.join(sorted(refused))} refused: {owner} owns the crane"
            )
            if {UNNAMED, GONE}.isdisjoint(refused | {owner}):
                self._host.notify(self._warning)
        self._simulation.warn(self._warning if self._refused else "", "commander")

    def _count_publishers(self) -> int:
        return sum(subscription.count_publishers() for subscription in self._subscriptions.values())

    def _list_publishers(self) -> dict[bytes, str]:
        return {
            publisher.gid: publisher.node
            for subscription in self._subscriptions.values()
            for publisher in publishers(self._node, subscription.topic)
            if publisher.reliable
        }
