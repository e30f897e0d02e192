"""Arbitration of command topics: one publisher owns the crane at a time, under a lease.

While there is one publisher, messages arrive through the executor, which is fast but does not identify the sender. As
soon as there is a second one, subscriptions with senders are opened, and messages from the executor are dropped.

The first publisher of a valid command owns the crane until its lease ends: that long without another valid command.
With an exclusive lease that is no reason to accept a rival, one that commands although the owner does, too: messages of
a flood push the owner's out of the middleware's queues. It waits until the owner has left the graph.
"""

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from crane_sim.ros.common import messages
from crane_sim.ros.common.command_filter import Refusal
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.sender_subscription import UNNAMED, SenderSubscription, publishers
from crane_sim.ros.plant.simulation_run import SimulationRun

_BATCH = 1000  # messages received at a time, so that other work of the node is not held up
_QOS = QoSProfile(depth=10_000)  # of subscriptions with senders: one publisher must not push out another one's messages
_UPDATE_PERIOD = 0.1  # s between two updates of the publishers
_WARNING_TIME = 2.0  # s for which a refused publisher is warned of
_GONE = "a node that left"


class CommandLease:
    """The lease on the crane: one owner at a time, known by the identifier of its publisher.

    Attributes:
        owner: the owner, empty while there is none; a sole publisher that has sent valid commands may be set as owner.
    """

    def __init__(self, duration: float, exclusive: bool = False) -> None:
        """Create a lease that ends `duration` seconds after the owner's last valid command, `exclusive`: see above."""
        self.owner = b""
        self._duration, self._renewed, self._exclusive = duration, 0.0, exclusive
        self._refused, self._rivals = set[bytes](), set[bytes]()  # since the owner's last command; before it

    def accepts(self, sender: bytes, now: float) -> bool:
        """Return whether a message that this sender published at `now` [s] may be a command."""
        if sender == self.owner or not self.owner:
            return True
        accepted = now - self._renewed > self._duration and sender not in self._rivals
        if not accepted and self._exclusive:
            self._refused.add(sender)
        return accepted

    def acquire(self, sender: bytes, now: float) -> None:
        """Make the sender of a valid command at `now` [s] the owner, and restart its lease."""
        self._rivals = self._rivals | self._refused if sender == self.owner else set()
        self._refused.clear()
        self.owner, self._renewed = sender, now

    def renew(self, now: float) -> None:
        """Restart the owner's lease at `now` [s], if that is later than its start."""
        self._renewed = max(self._renewed, now)


Callback = Callable[[bytes], bool]  # of a serialized message; returns whether it was a valid command


class CommandTopic(NamedTuple):
    """A topic of commands."""

    kind: Any  # message class
    on_message: Callback


class CommandArbiter:
    """Arbiter that passes on the commands of the owner, and refuses those of all other publishers by name."""

    def __init__(
        self,
        host: NodeHost,
        simulation: SimulationRun,
        topics: Mapping[str, CommandTopic],
        lease: float,
        lease_expiry_suspended: Callable[[], bool],
        exclusive: bool = False,
    ) -> None:
        """Subscribe.

        Args:
            host: of the node with the topics.
            simulation: counts refusals, and publishes warnings of them.
            topics: by name; an invalid command makes no publisher the owner.
            lease: time without a valid command after which the owner loses the crane, s.
            lease_expiry_suspended: whether the lease cannot expire now: the owner has a reason to send no command.
            exclusive: the lease of an owner in the graph expires for no publisher that commands beside it.
        """
        self._host, self._node, self._simulation, self._topics = host, host.node, simulation, topics
        self._lease = CommandLease(lease, exclusive)
        self._lease_duration, self._lease_expiry_suspended = lease, lease_expiry_suspended
        self._subscriptions: dict[str, Subscription] = {
            name: host.node.create_subscription(
                topic.kind,
                name,
                partial(self._on_message, topic.on_message),
                messages.STREAM_QOS,
                raw=True,
                event_callbacks=SubscriptionEventCallbacks(incompatible_qos=partial(self._on_incompatible, name)),
            )
            for name, topic in topics.items()
        }
        self._with_sender: dict[str, SenderSubscription] = {}  # while there are several publishers
        self._refused: dict[bytes, float] = {}  # publishers refused lately, and the last instant [s]
        self._warning = ""  # of them
        self._publisher_names: dict[bytes, str] = {}  # at the last update, while there were several
        self._sole_publisher, self._has_commanded = (
            b"",
            False,
        )  # the only publisher, and whether it has sent a valid command
        self._last_command = self._last_update = 0.0  # s

    @property
    def contested(self) -> bool:
        """Whether there are several publishers: then `take_all` passes messages on, and the executor does not."""
        return bool(self._with_sender)

    @property
    def has_newcomer(self) -> bool:
        """Whether the only publisher has not sent a valid command yet."""
        return bool(self._sole_publisher) and not self._has_commanded

    @property
    def topic_names(self) -> str:
        """The full names of the topics."""
        return " or ".join(subscription.topic_name for subscription in self._subscriptions.values())

    def count_publishers(self) -> int:
        """Return the number of publishers."""
        return sum(subscription.handle.get_publisher_count() for subscription in self._subscriptions.values())

    def publishing_nodes(self) -> set[str]:
        """Return the full names of the nodes with publishers."""
        return set(self._list_publishers().values())

    def take_one(self) -> bool:
        """Take and pass on a message without the executor; False where there is none."""
        if self._with_sender:
            return self.take_all()
        for name, subscription in self._subscriptions.items():
            topic = self._topics[name]
            if data := messages.take_message(subscription, topic.kind):
                self._on_message(topic.on_message, data)
                return True
        return False

    def wait(self, seconds: float) -> None:
        """Wait for a message on the first topic, while there are several publishers, or for `seconds`."""
        next(iter(self._with_sender.values())).wait(seconds)

    def take_all(self) -> bool:
        """Take all messages with their senders: pass the owner's on, refuse the rest; False where there is none."""
        received = False
        for name, subscription in self._with_sender.items():
            for _ in range(_BATCH):
                if (message := subscription.take()) is None:
                    break
                received = True
                now = time.monotonic()
                if not self._lease.accepts(message.sender, now):
                    self._refuse(name, message.sender)
                elif self._topics[name].on_message(message.data):
                    self._lease.acquire(message.sender, now)
        return received

    def start(self) -> None:
        """Update the publishers at the start of the run."""
        self._last_update = 0.0
        self.update()

    def update(self) -> None:
        """Update the publishers, ten times a second, and renew the owner's lease while its expiry is suspended."""
        now = time.monotonic()
        if now - self._last_update >= _UPDATE_PERIOD:
            self._last_update = now
            self._update_publishers(now)
        if self._with_sender and self._lease_expiry_suspended():
            self._lease.renew(now)

    def _update_publishers(self, now: float) -> None:
        count = self.count_publishers()
        if count > 1 and not self._with_sender:
            self._open()
        elif count < 2 and self._with_sender:
            self._close()
        if self._with_sender:
            names = self._list_publishers()
            if self._lease.owner in self._publisher_names.keys() - names.keys():
                self._lease.owner = b""  # it has left the graph in order: its lease is over
            self._publisher_names = names
        if count < 2:
            self._set_sole_publisher(list(self._list_publishers()))
        self._refused = {sender: last for sender, last in self._refused.items() if now - last < _WARNING_TIME}
        self._update_warning()

    def _set_sole_publisher(self, publishers: list[bytes]) -> None:
        """Record the sole publisher; it owns the crane from its first valid command on, however idle."""
        sole = publishers[0] if len(publishers) == 1 else b""
        if self._sole_publisher in publishers:
            sole = self._sole_publisher  # the graph has a publisher before it is matched
        if sole != self._sole_publisher:
            # A publisher that was not in the graph before may have sent the first valid command already.
            has_commanded = sole == self._lease.owner or (not self._sole_publisher and self._has_commanded)
            self._sole_publisher, self._has_commanded = sole, bool(sole) and has_commanded
        self._lease.owner = sole if self._has_commanded else b""

    def _on_message(self, callback: Callback, data: bytes) -> None:
        if self._with_sender:
            return  # it is also received with its sender
        if self.count_publishers() > 1:
            self._open()  # the sender of this message is unknown; it is lost unless it is sent again
            return
        if callback(data):
            self._last_command, self._has_commanded = time.monotonic(), True

    def _open(self) -> None:
        now = time.monotonic()
        self._set_sole_publisher([self._sole_publisher])
        busy = now - self._last_command < self._lease_duration
        # A busy publisher needs a while to be matched with the subscriptions; then the middleware detects its death.
        self._lease.renew(now + messages.LIVELINESS_LEASE if busy else self._last_command)
        self._sole_publisher, self._has_commanded = b"", False
        self._with_sender = {
            name: SenderSubscription(self._node, topic.kind, name, _QOS) for name, topic in self._topics.items()
        }

    def _close(self) -> None:
        for name, subscription in self._subscriptions.items():
            while messages.take_message(subscription, self._topics[name].kind):
                pass  # it is also received with its sender
        self.take_all()
        for subscription in self._with_sender.values():
            subscription.close()
        self._with_sender = {}

    def _on_incompatible(self, topic: str, event: Any) -> None:
        """Say which publisher is not matched, and why: it would be waited for."""
        name = self._node.resolve_topic_name(topic)
        unmatched = sorted({each.node for each in publishers(self._node, name) if not each.reliable})
        whose = f" of {' and '.join(unmatched)}" if unmatched else ""
        self._host.notify(f"a publisher{whose} of {name} is not matched: {messages.describe_policy(event.last_policy_kind)}")

    def _refuse(self, topic: str, sender: bytes) -> None:
        """Count a refusal; warn at once of a new sender only, since there may be thousands of messages in a second."""
        known = sender in self._refused
        self._refused[sender] = time.monotonic()
        if not known:
            self._publisher_names |= self._list_publishers()
            self._update_warning()
        name = self._subscriptions[topic].topic_name
        self._simulation.refused_messages[f"{name} of {self._publisher_names.get(sender, _GONE)}"] += 1
        self._simulation.validator.reject(Refusal.COMMANDER, self._warning)

    def _update_warning(self) -> None:
        """Warn of publishers refused lately; again with every update: the graph may have a node before its name."""
        self._refused.pop(self._lease.owner, None)  # it owns the crane by now
        if self._refused:
            refused = " and ".join(sorted({self._publisher_names.get(sender, _GONE) for sender in self._refused}))
            owner = self._publisher_names.get(self._lease.owner, _GONE)
            self._warning = f"command of {refused} refused: {owner} owns the crane"
            if not {UNNAMED, _GONE} & {refused, owner}:
                self._host.notify(self._warning)
        self._simulation.warn(self._warning if self._refused else "", "commander")

    def _list_publishers(self) -> dict[bytes, str]:
        return {
            publisher.gid: publisher.node
            for subscription in self._subscriptions.values()
            for publisher in publishers(self._node, subscription.topic_name)
            if publisher.reliable
        }
