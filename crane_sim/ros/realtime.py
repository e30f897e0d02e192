"""Real time: every step waits for its instant on the wall clock."""

import time
from types import SimpleNamespace
from typing import Any

from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from crane_sim.ros import messages
from crane_sim.ros.process import Host
from crane_sim.ros.punctuality import Punctuality
from crane_sim.ros.stepper import Stepper
from crane_sim.ros.wire import JointWire

_MARGIN = 0.0004  # s; spin_once comes back up to 0.3 ms late, a plain sleep does not


class Realtime:
    """Steps at absolute wall-clock deadlines with the newest valid command held."""

    def __init__(self, host: Host, stepper: Stepper, settings: SimpleNamespace) -> None:
        """Listen to `joint_commands` and `effort_controller/commands`, if the scene takes commands at all."""
        self._host, self._stepper, self._settings = host, stepper, settings
        self._zero = (0.0,) * len(stepper.scene.actuated)
        self._held, self._held_since = self._zero, 0.0
        self._punctuality = Punctuality()
        self._wire = JointWire(stepper.scene.actuated, effort=True)
        self._commands = self._subscriptions() if stepper.scene.sampled else []

    def missing(self) -> str:
        """See `Pace`."""
        found = sum(subscription.get_publisher_count() for subscription in self._commands)
        number = self._settings.expected_controllers - found if self._commands else 0
        return f"{number} more publisher(s) of joint_commands or effort_controller/commands" if number > 0 else ""

    def run(self) -> None:
        """See `Pace`; a late step is counted, and the next ones catch up with the schedule."""
        stepper, period = self._stepper, self._stepper.scene.period / self._settings.rate
        stepper.begin()
        due = self._held_since = time.monotonic()
        while stepper.running and not self._host.stopping:
            due += period
            self._serve_until(due)
            if stepper.paused:
                self._host.spin()
                due = time.monotonic()
                self._punctuality.pause()
            else:
                self._punctuality.note(due, time.monotonic())
                stepper.step(self._effort())
                stepper.deadline_misses += time.monotonic() > due + period
            stepper.heartbeat()

    def step_once(self) -> bool:
        """See `Pace`; the newest command holds, however long ago the pause began."""
        self._stepper.step(self._held if self._commands else None)
        return True

    def go_on(self) -> None:
        """See `Pace`."""
        self._held_since = time.monotonic()

    def forget(self) -> None:
        """See `Pace`."""
        self._held, self._held_since = self._zero, time.monotonic()
        self._punctuality = Punctuality()

    def figures(self) -> dict[str, Any]:
        """See `Pace`; how punctual the steps were."""
        return self._punctuality.figures()

    def _serve_until(self, due: float) -> None:
        self._host.spin(0.0)
        while (left := due - time.monotonic()) > _MARGIN and not self._host.stopping:
            self._host.spin(min(left - _MARGIN, 0.05))
        if left > 0.0 and not self._host.stopping:
            time.sleep(left)

    def _effort(self) -> tuple[float, ...] | None:
        if not self._commands:
            return None
        timeout = self._settings.command_timeout
        silent = timeout > 0.0 and time.monotonic() - self._held_since > timeout
        self._stepper.warning = f"no valid command for {timeout:g} s: zero effort" if silent else ""
        return self._zero if silent else self._held

    def _subscriptions(self) -> list[Subscription]:
        depth, node = messages.STREAM, self._host.node
        named = node.create_subscription(JointState, "joint_commands", self._on_command, depth, raw=True)
        ordered = node.create_subscription(Float64MultiArray, "effort_controller/commands", self._on_array, depth)
        return [named, ordered]

    def _on_command(self, data: bytes) -> None:
        stepper = self._stepper
        if not stepper.stamp or not stepper.running:
            return
        command = self._wire.decode(data)
        timeout = round(self._settings.command_timeout * messages.SECOND)
        oldest = stepper.stamp - timeout if timeout else 0
        effort = stepper.gate.screen(command.stamp, command.names, command.effort, now=stepper.stamp, oldest=oldest)
        self._hold(effort)

    def _on_array(self, message: Float64MultiArray) -> None:
        if self._stepper.stamp and self._stepper.running:
            self._hold(self._stepper.gate.screen_array(message.data))

    def _hold(self, effort: tuple[float, ...] | None) -> None:
        if effort is not None:
            self._held, self._held_since = effort, time.monotonic()
