"""A node that others may manage: inactive it is there and matched, but does nothing."""

from collections.abc import Callable

from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn

from crane_sim.ros.common.parameters import Option

MANAGED = {"autostart": Option(True, "activate itself; if not, wait, inactive, for an activation or the order go")}

ENDINGS = ("cleanup", "shutdown")
"""Transitions that end the node, and are no fault."""


class Managed(LifecycleNode):
    """Is configured as soon as it is built: what is still to be decided is when it is active.

    Publishers are plain ones: what an inactive node does not do, its owner leaves out.

    Attributes:
        active: it may work.
    """

    def __init__(self, name: str) -> None:
        """Create the node, still without an owner."""
        super().__init__(name, automatically_declare_parameters_from_overrides=True)
        self.active = False
        self._on_change: Callable[[bool], None] = lambda active: None
        self._on_end: Callable[[str], None] = lambda why: None

    def manage(self, autostart: bool, on_change: Callable[[bool], None], on_end: Callable[[str], None]) -> None:
        """Be configured, and active with `autostart`; from here on the owner hears of every transition.

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
        """Go on."""
        return self._set_active(True)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Pause, be silent."""
        return self._set_active(False)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End: what was built is given up with the process."""
        return self._ended("cleanup")

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End."""
        return self._ended("shutdown")

    def _set_active(self, active: bool) -> TransitionCallbackReturn:
        self.active = active
        self._on_change(active)
        return TransitionCallbackReturn.SUCCESS

    def _ended(self, why: str) -> TransitionCallbackReturn:
        self.active = False
        self._on_end(why)
        return TransitionCallbackReturn.SUCCESS
