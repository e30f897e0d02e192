"""Nodes whose services answer every request: an exception in a callback becomes the answer.

It does not end the node.

rclpy's own services of parameters raise an error where a request has a number that none of their
enumerations has. Lifecycle nodes are activated and deactivated by external managers; an inactive
node is matched, but does nothing.
"""

import select
from collections.abc import Callable
from functools import partial
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node

from crane_sim.ros.common.parameters import Option

MANAGED = {
    "autostart": Option(
        True, "activate itself; if not, wait, inactive, for an activation or the request go"
    )
}

ENDINGS = ("cleanup", "shutdown")
"""Transitions that end the node, and are no fault."""


class ServingNode(Node):
    """A mix-in for nodes: the callback of each service is guarded.

    Attributes:
        served: subscriptions that the node's host serves in place of its executor, by the files of
            their arrivals.
        arrivals: an epoll of these files.
        calls: number of callbacks of services and other subscriptions so far.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """Create the node; arguments: see `Node`."""
        self.served, self.arrivals, self.calls = dict[int, Any](), select.epoll(), 0
        super().__init__(*arguments, **options)

    def serve(self, subscription: Any) -> None:
        """Have the host serve a subscription."""
        self.served[subscription.fileno()] = subscription
        self.arrivals.register(subscription.fileno(), select.EPOLLIN)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Callable[..., Any], **options: Any
    ) -> Any:
        """Create a service; arguments: see `Node.create_service`."""
        return super().create_service(srv_type, srv_name, self.guard(srv_name, callback), **options)

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[[Any], None], *qos: Any, **options: Any
    ) -> Any:
        """Create a subscription; arguments: see `Node.create_subscription`."""

        def count(message: Any) -> None:
            self.calls += 1
            callback(message)

        return super().create_subscription(msg_type, topic, count, *qos, **options)

    def guard(self, name: str, callback: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """Return the callback of the service `name`, with an answer in place of errors."""
        return partial(_answer, self, name, callback)


class ManagedNode(ServingNode, LifecycleNode):
    """A lifecycle node that configures itself when built: a manager only needs to activate it.

    Publishers are plain ones: the owner of the node does not publish while it is inactive.

    Attributes:
        active: it may work.
    """

    def __init__(self, name: str, **options: Any) -> None:
        """Create the node, still without callbacks; arguments: see `Node`."""
        super().__init__(name, **options)
        self._service_change_state.callback = self.guard(
            "change_state", self._service_change_state.callback
        )
        self.active = False
        self._on_change: Callable[[bool], None] = lambda active: None
        self._on_end: Callable[[str], None] = lambda why: None

    def manage(
        self, autostart: bool, on_change: Callable[[bool], None], on_end: Callable[[str], None]
    ) -> None:
        """Configure the node, with `autostart` activate it; call back at every later transition.

        Args:
            autostart: activate at once.
            on_change: is called with whether the node is active from now on.
            on_end: is called with the transition that ends the node.
        """
        self._on_change, self._on_end = on_change, on_end
        self.trigger_configure()
        if autostart:
            self.activate()

    def activate(self) -> None:
        """Activate the node, unless it is active."""
        if not self.active:
            self.trigger_activate()

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Resume work."""
        return self._set_active(True)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Suspend work."""
        return self._set_active(False)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the node: its resources are released with the process."""
        return self._end("cleanup")

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the node."""
        return self._end("shutdown")

    def _set_active(self, active: bool) -> TransitionCallbackReturn:
        self.active = active
        self._on_change(active)
        return TransitionCallbackReturn.SUCCESS

    def _end(self, transition: str) -> TransitionCallbackReturn:
        self.active = False
        self._on_end(transition)
        return TransitionCallbackReturn.SUCCESS


def _answer(
    node: ServingNode, name: str, callback: Callable[[Any, Any], Any], request: Any, response: Any
) -> Any:
    node.calls += 1
    try:
        return callback(request, response)
    except Exception as error:
        line = f"{name}: {type(error).__name__}: {error}".splitlines()[0]
        node.get_logger().warning(f"a request failed: {line}", throttle_duration_sec=1.0)
        return _write_failure(request, response, line)


def _write_failure(request: Any, response: Any, line: str) -> Any:
    """Return the response with the failure in the fields that the service has for it."""
    if hasattr(
        request, "parameters"
    ):  # of SetParameters: one result for each, also for those that were not read
        failure = SetParametersResult(successful=False, reason=line)
        if hasattr(response, "results"):
            response.results = [
                *response.results,
                *[failure] * (len(request.parameters) - len(response.results)),
            ]
        else:
            response.result = failure
    if hasattr(response, "success"):
        response.success = False
    if hasattr(response, "message"):
        response.message = line
    return response
