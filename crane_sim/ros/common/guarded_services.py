"""Nodes whose services answer every request: what a callback raises becomes the answer, and ends no node.

rclpy's own services of parameters raise an error where a request has a number that none of their enumerations has.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node


class ServingNode(Node):
    """A mix-in for nodes: the callback of each service is guarded.

    Attributes:
        served: subscriptions that the node's host serves in place of its executor.
        calls: number of callbacks of services and other subscriptions so far.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """Create the node; arguments: see `Node`."""
        self.served, self.calls = list[Any](), 0
        super().__init__(*arguments, **options)

    def create_service(self, srv_type: Any, srv_name: str, callback: Callable[..., Any], **options: Any) -> Any:
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


class GuardedNode(ServingNode):
    """A node that is not managed."""


def _answer(node: ServingNode, name: str, callback: Callable[[Any, Any], Any], request: Any, response: Any) -> Any:
    node.calls += 1
    try:
        return callback(request, response)
    except Exception as error:
        line = f"{name}: {type(error).__name__}: {error}".splitlines()[0]
        node.get_logger().warning(f"a request failed: {line}", throttle_duration_sec=1.0)
        return _write_failure(request, response, line)


def _write_failure(request: Any, response: Any, line: str) -> Any:
    """Return the response with the failure, in what fields for it the service has; others stay as they are."""
    if hasattr(request, "parameters"):  # of SetParameters: one result for each, also for those that were not read
        failure = SetParametersResult(successful=False, reason=line)
        if hasattr(response, "results"):
            response.results = [*response.results, *[failure] * (len(request.parameters) - len(response.results))]
        else:
            response.result = failure
    if hasattr(response, "success"):
        response.success = False
    if hasattr(response, "message"):
        response.message = line
    return response
