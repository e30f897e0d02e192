"""A joystick of a test on the ROS graph, and the operator of a run who uses it."""

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from math import nan
from types import TracebackType
from typing import Any, Self

import rclpy
from process_helpers import wait_until
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState, Joy

from crane_sim.operator.levers import Buttons
from crane_sim.orchestration.desk_link import DeskLink

_PERIOD = 0.02  # s between two messages, as joy_node repeats them
_JOIN_TIMEOUT = 20.0  # s for a thread to end
_TIMEOUT = 120.0  # s for what takes some seconds at most, on a machine that has other things to do


class Joystick:
    """A node that publishes a joystick's positions again and again, and listens to the crane.

    Attributes:
        axes: positions.
        pressed: numbers of the buttons that are held.
        silent: nothing is published.
        commands, states: newest `joint_commands`, by joint, and velocities of `joint_states`.
        held: newest `held_command`, by joint.
    """

    def __init__(self, domain: int, namespace: str) -> None:
        """Join the graph."""
        self._context = Context()
        self._context.init(domain_id=domain)
        self._node = rclpy.create_node("joystick", namespace=namespace, context=self._context)
        self.axes, self.pressed, self.silent = [0.0] * 4, set[int](), False
        self.commands: dict[str, float] = {}
        self.held: dict[str, float] = {}
        # no speed before the first state
        self.velocities: dict[str, float] = defaultdict(lambda: nan)
        self._joy = self._node.create_publisher(Joy, "/joy", 10)
        for topic, taken in (("joint_commands", "commands"), ("held_command", "held")):
            self._node.create_subscription(
                JointState, topic, lambda m, taken=taken: self._take(taken, m), 100
            )
        self._node.create_subscription(JointState, "joint_states", self._on_state, 100)
        self._node.create_timer(_PERIOD, self._publish)
        self._closing = False
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, daemon=True)

    def __enter__(self) -> Self:
        """Begin to publish."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        """Leave the graph."""
        self._closing = True
        self._thread.join(_JOIN_TIMEOUT)
        assert not self._thread.is_alive(), f"the joystick did not stop within {_JOIN_TIMEOUT:g} s"
        self._node.destroy_node()
        self._context.shutdown()

    def move(self, axes: Sequence[float], *pressed: int) -> None:
        """Set all axes, and hold these buttons."""
        self.axes, self.pressed = list(axes), set(pressed)

    def _publish(self) -> None:
        if not self.silent:
            buttons = [int(i in self.pressed) for i in range(max(Buttons()) + 1)]
            self._joy.publish(Joy(axes=self.axes, buttons=buttons))

    def _take(self, where: str, message: JointState) -> None:
        vectors = (
            message.velocity or [0.0] * len(message.name),
            message.effort or [0.0] * len(message.name),
        )
        # NaN: the drive takes the other field
        numbers = [v if v == v else e for v, e in zip(*vectors, strict=True)]
        setattr(self, where, dict(zip(message.name, numbers, strict=True)))

    def _on_state(self, message: JointState) -> None:
        self.velocities = dict(zip(message.name, message.velocity, strict=True))

    def _spin(self) -> None:
        while not self._closing:
            self._executor.spin_once(timeout_sec=0.05)


class ScriptedOperator:
    """An operator that is a function, called in a thread during the run, which ends with it."""

    def __init__(self, script: Callable[[DeskLink], None], **parameters: Any) -> None:
        """Take the function, and parameters of the node."""
        self.parameters = {"device": "joy"} | parameters
        self._script, self._error = script, list[BaseException]()
        self._thread: threading.Thread | None = None

    def begin(self, desk: DeskLink) -> None:
        """Begin: see `desk_link.Operator`."""
        self._thread = threading.Thread(target=self._run, args=(desk,), daemon=True)
        self._thread.start()

    def check(self) -> None:
        """Raise what the function has raised; to be called when the run is over."""
        assert self._thread is not None, "the run never began"
        self._thread.join(_JOIN_TIMEOUT)
        if self._error:
            raise self._error[0]

    def _run(self, desk: DeskLink) -> None:
        try:
            self._script(desk)
        except BaseException as error:  # it is raised again by `check`
            self._error.append(error)
        finally:
            desk.end()


def wait_mode(desk: DeskLink, mode: str) -> None:
    """Wait until the operator's node reports this mode."""
    wait_until(
        lambda: desk.panel().get("mode") == mode, f"mode {mode!r} of the operator's desk", _TIMEOUT
    )


def wait_for(condition: Callable[[], bool], what: str) -> None:
    """Wait for what takes some seconds at most."""
    wait_until(condition, what, _TIMEOUT)


def settle(seconds: float) -> None:
    """Let the run go on for a while, for what only has to be recorded."""
    time.sleep(seconds)
