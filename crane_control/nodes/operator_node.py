"""The node `operator`: answers every joint state with an operator's speeds.

They come from keys, a gamepad or a joystick.
"""

import sys
import time
from math import degrees
from types import SimpleNamespace
from typing import Any

from rclpy.duration import Duration
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool

from crane_control.assistance import Assistance
from crane_sim.files.errors import SceneError
from crane_sim.operator.desk import Desk, Mode, SoftLimits
from crane_sim.operator.drives import driven_joints
from crane_sim.operator.inputs import DEVICES, LEVELS, Demand, Keyboard
from crane_sim.operator.levers import make_lever_assignment
from crane_sim.ros.common import messages, node_host
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.controller.responder import OutputTopic, Responder, serve_responder
from crane_sim.ros.controller.states import State
from crane_sim.ros.operator.devices import Device, GamepadDevice, JoyDevice, KeyboardDevice
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.derived import derive_instant

PARAMETERS = {
    "scene": Option(
        "bridge_speed_drive",
        "scene, whose drives all follow speeds: a name of the catalogue or a path",
    ),
    "device": Option(
        "joy",
        "the operator's device; keys come from the terminal of `crane drive`",
        choices=DEVICES,
    ),
    "joy_topic": Option("/joy", "topic of sensor_msgs/Joy"),
    "gamepad": Option("", "device file of the gamepad; empty: the first one"),
    "mapping": Option("", "changes of levers and buttons, NAME=NUMBER, with commas between them"),
    "assistance": Option(False, "begin with assistance against swing"),
    "device_timeout": Option(
        0.5, "s without a sign of the device after which it counts as lost", 0.05, 60.0
    ),
    "expected_recorders": Option(0, "subscribers of the commands besides the plant", 0, 100),
}
_COMMANDS = OutputTopic(JointState, "joint_commands", messages.DEEP_STREAM_QOS)
_PANEL_PERIOD = 0.1  # s between two reports to the terminal
# s after a request of the brakes, refused or without an answer, until the next one
_RETRY_TIMEOUT = 1.0


class Brakes:
    """The plant's brakes, requested by its service until it has done so.

    Attributes:
        refusal: one line on why the plant does not, empty where it has not refused.
    """

    def __init__(self, host: NodeHost) -> None:
        """Find the service in the node's namespace."""
        self._client = host.node.create_client(SetBool, "plant/set_brakes")
        self._applied, self._requested, self._next_request, self.refusal = False, False, 0.0, ""
        self._answer: Future | None = None  # of the newest request

    def request(self, on: bool, now: float) -> bool:
        """Apply or release them; return whether that has just been done."""
        answer = self._answer
        if answer is not None and answer.done():
            result, self._answer = answer.result(), None
            if result is not None and result.success:
                self._applied, self._next_request, self.refusal = self._requested, now, ""
                return True
            action = "apply" if self._requested else "release"
            self.refusal = (
                f"the plant does not {action} the brakes: "
                f"{result.message if result else 'no answer'}"
            )
        if on == self._applied:
            self.refusal, self._next_request = "", now
        elif now >= self._next_request:
            self._next_request, self._requested = now + _RETRY_TIMEOUT, on
            self._answer = self._client.call_async(SetBool.Request(data=on))
        return False


class OperatorNode(Responder):
    """The operator's desk on the ROS graph; it goes on without a device or an answer."""

    def __init__(self, host: NodeHost, settings: SimpleNamespace) -> None:
        """Open the device; raises SceneError where the scene or the device does not allow it."""
        scene = load_scene(settings.scene).with_external_commands()
        super().__init__(host.node, scene, _COMMANDS, settings.expected_recorders)
        self._host, self._settings = host, settings
        joints, changes = (
            driven_joints(scene),
            [part for part in settings.mapping.split(",") if part],
        )
        self._assignment = make_lever_assignment(scene.actuated, changes)
        self._desk = Desk(joints, settings.device_timeout, settings.assistance)
        self._limits, self._brakes = SoftLimits(joints, scene.period), Brakes(host)
        self._keyboard = Keyboard(self._assignment)
        self._device = self._open_device()
        host.requests["key"] = lambda key: self._keyboard.press(key, time.monotonic())
        self._assistance, self._assistance_unavailable = _assistance(scene)
        self._driven = [scene.joint_names.index(name) for name in scene.actuated]
        self._warm_up()
        self._codec = CommandCodec(scene)
        self._last: State | None = None
        self._speeds = (0.0,) * len(joints)
        self._next_panel, self._counts = 0.0, {"stops": 0, "losses": 0}

    def on_spin(self) -> None:
        """Report the panel to the terminal when it is due."""
        now = time.monotonic()
        if now >= self._next_panel and self._last:
            self._next_panel = now + _PANEL_PERIOD
            self._host.pipes.report("panel", **self._panel(self._last))

    def finish(self) -> dict[str, Any]:
        """See `Responder`."""
        self._answers.wait_for_all_acked(Duration(seconds=messages.LIVELINESS_LEASE))
        return {"operator": {"device": self._device.name, **self._counts}}

    def _open_device(self) -> Device:
        settings, node = self._settings, self._host.node
        if settings.device == "joy":
            return JoyDevice(node, settings.joy_topic, self._desk, self._assignment)
        if settings.device == "gamepad":
            return GamepadDevice(settings.gamepad, self._desk, self._assignment)
        return KeyboardDevice(self._desk, self._keyboard)

    def _warm_up(self) -> None:
        """Compile what is called at every state."""
        scene, zeros = self._scene, (0.0,) * len(self._driven)
        start = [scene.initial_q[i] for i in self._driven]
        for sign in (1.0, -1.0):
            self._limits.take([sign * 1e-9] * len(zeros), start, zeros)
        self._limits.reset()
        _swing(scene, 0.0, scene.initial_q)

    def _on_state(self, state: State) -> None:
        last = self._last
        if last and state.stamp <= last.stamp:
            self._limits.reset()
        now, before, self._last = time.monotonic(), self._desk.mode, state
        operator = self._desk.take(self._demand(now), now)
        q, v = ([values[i] for i in self._driven] for values in (state.q, state.v))
        self._speeds = self._limits.take(self._assisted_speeds(state, operator), q, v)
        self._answers.publish(self._codec.encode(state.stamp, self._speeds))
        self._request_brakes(now)
        self._count(before)

    def _request_brakes(self, now: float) -> None:
        """Request what the desk wants of the brakes, and warn once where the plant refuses it."""
        before = self._brakes.refusal
        if self._brakes.request(self._desk.braked, now):
            self._limits.reset()
        if self._brakes.refusal not in ("", before):
            self._host.node.get_logger().warning(self._brakes.refusal)

    def _demand(self, now: float) -> Demand:
        """Return the device's demand; the terminal's keys that act once count with any device."""
        tail = self._assistance.delay if self._assistance and self._desk.assisted else 0.0
        demand = self._device.demand(now, tail)
        if isinstance(self._device, KeyboardDevice):
            return demand
        keys = self._keyboard.demand(now)
        either = {
            name: getattr(demand, name) or getattr(keys, name)
            for name in ("stop", "release", "assistance")
        }
        return demand._replace(**either)

    def _assisted_speeds(self, state: State, speeds: tuple[float, ...]) -> tuple[float, ...]:
        """Return the operator's speeds, through assistance if it is on and the crane may move."""
        if self._assistance is None:
            return speeds
        if self._desk.mode != Mode.MOVING:
            self._assistance.forget_commands()
            return speeds
        self._assistance.record_command(state.t, speeds)
        if not self._desk.assisted:
            return speeds
        return self._assistance.compute_velocity_command(state.t, state.q)

    def _count(self, before: Mode) -> None:
        for name, mode in (("stops", Mode.STOPPED), ("losses", Mode.DEVICE_LOST)):
            self._counts[name] += self._desk.mode == mode != before

    def _panel(self, state: State) -> dict[str, Any]:
        desk = self._desk
        return {
            "t": state.t,
            "mode": desk.mode.value,
            "assisted": desk.assisted and self._assistance is not None,
            "assistance_unavailable": self._assistance_unavailable,
            "device": self._device.name,
            "speed_scale": LEVELS[self._keyboard.level],
            "speeds": self._speeds,
            "positions": [state.q[i] for i in self._driven],
            "velocities": [state.v[i] for i in self._driven],
            "at_soft_limit": self._limits.limited,
            "dragged": []
            if desk.braked
            else self._limits.dragged([state.v[i] for i in self._driven]),
            "braked": desk.braked,
            "brakes_refused": self._brakes.refusal,
            "swing_deg": _swing(self._scene, state.t, state.q),
        }


def _assistance(scene: Scene) -> tuple[Assistance | None, str]:
    """Return (assistance, why there is none)."""
    try:
        return Assistance(scene), ""
    except SceneError as error:
        return None, str(error).partition(": ")[2]


def _swing(scene: Scene, t: float, q: tuple[float, ...]) -> float:
    """Return the angle [°] of the line from tip to payload from the vertical, at t [s].

    The tip is the suspension point.
    """
    return degrees(derive_instant(scene, t, q, (0.0,) * len(q)).swing[0])


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Answer states until the request to finish."""
    serve_responder(host, OperatorNode(host, settings), settings.autostart)


def main() -> int:
    """Run the node; see `node_host.main` for the exit code."""
    return node_host.main("operator", PARAMETERS, serve, managed=True)


if __name__ == "__main__":
    sys.exit(main())
