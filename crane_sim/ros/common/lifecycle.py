"""Lifecycle nodes that external managers activate and deactivate; an inactive node is matched, but does nothing."""

from collections.abc import Callable

from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from crane_sim.ros.common.guarded_services import ServingNode
from crane_sim.ros.common.parameters import Option

MANAGED = {"autostart": Option(True, "activate itself; if not, wait, inactive, for an activation or the request go")}

ENDINGS = ("cleanup", "shutdown")
"""Transitions that end the node, and are no fault."""


class ManagedNode(ServingNode, LifecycleNode):
    """A lifecycle node that is configured as soon as it is built: only its activation is left to a manager.

    Publishers are plain ones: the owner of the node does not publish while it is inactive.

    Attributes:
        active: it may work.
    """

    def __init__(self, name: str) -> None:
        """Create the node, still without callbacks."""
        super().__init__(name, automatically_declare_parameters_from_overrides=True)
        self._service_change_state.callback = self.guard("change_state", self._service_change_state.callback)
        self.active = False
        self._on_change: Callable[[bool], None] = lambda active: None
        self._on_end: Callable[[str], None] = lambda why: None

    def manage(self, autostart: bool, on_change: Callable[[bool], None], on_end: Callable[[str], None]) -> None:
        """Configure the node, activate it with `autostart`, and call back at every later transition.

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
