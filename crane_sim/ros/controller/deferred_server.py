"""An action server whose goals are ended by the node that follows them.

rclpy's own runs a callback to the end of a goal; one that waits would keep its executor busy.
"""

from collections.abc import Callable
from typing import Any

from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.node import Node


class DeferredServer(ActionServer):
    """The server; every goal may be cancelled."""

    def __init__(
        self,
        node: Node,
        action: Any,
        name: str,
        on_goal: Callable[[Any], GoalResponse],
        on_accepted: Callable[[ServerGoalHandle], None],
    ) -> None:
        """Offer an action; `on_goal` decides whether a goal is accepted, `on_accepted` receives those that are."""
        super().__init__(
            node,
            action,
            name,
            lambda _: None,
            goal_callback=on_goal,
            handle_accepted_callback=on_accepted,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def notify_execute(self, goal_handle: ServerGoalHandle, execute_callback: Any) -> None:
        """Execute nothing: the goal's owner does."""

    def complete(self, handle: ServerGoalHandle, result: Any) -> None:
        """Give a goal whose state is final its result."""
        super().notify_execute(handle, lambda _: result)
