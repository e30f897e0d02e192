"""The operator's terminal: keys without echo, sent when pressed, and a panel of the crane."""

import os
import re
import select
import sys
import termios
import threading
import tty
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import degrees, inf, isfinite
from typing import Any

from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from crane_sim.cli.tables import print_line
from crane_sim.operator.desk import DrivenJoint, Mode
from crane_sim.operator.levers import Assignment, axis_name, button_names
from crane_sim.orchestration.desk_link import DeskLink

END = "q"
_REFRESH_PERIOD = 0.1  # s
_BAR = 12  # characters of each half of a speed's bar
_NAMES = {" ": "space", "\r": "enter", "\n": "enter", "\t": "tab", "=": "+"}
# [[: of the console
_KEY = re.compile(r"\x1b(\[\[\w?|[\[O][0-9;]*(?P<last>[A-Za-z~])?)?|.", re.DOTALL)
_INCOMPLETE = re.compile(rb"\x1b(?:\[\[|[\[O][0-9;]*)?\Z")
_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_COLORS = {
    Mode.STOPPED: "bold white on red",
    Mode.DEVICE_LOST: "bold white on red",
    Mode.MOVING: "bold green",
}


def read_keys(data: bytes) -> list[str]:
    """Return the names of the keys in what a terminal sent; sequences but arrows are dropped."""
    keys = []
    for match in _KEY.finditer(data.decode(errors="ignore")):
        key = match[0]
        is_sequence = key.startswith("\x1b")
        keys.append(_ARROWS.get(match["last"], "") if is_sequence else _NAMES.get(key, key.lower()))
    return [key for key in keys if key and key.isprintable()]


def split_incomplete(data: bytes) -> tuple[bytes, bytes]:
    """Return what a terminal has sent, split where a sequence is incomplete.

    The next read completes the sequence.
    """
    incomplete = _INCOMPLETE.search(data)
    begin = incomplete.start() if incomplete else len(data)
    return data[:begin], data[begin:]


class OperatorConsole:
    """The terminal of `crane drive`: an `orchestration.desk_link.Operator`.

    Attributes:
        parameters: parameters of the ROS node `operator`.
        console: prints above the panel while that is shown.
    """

    def __init__(
        self,
        parameters: Mapping[str, object],
        title: str,
        joints: Sequence[DrivenJoint],
        quiet: bool,
    ) -> None:
        """Create the console, closed; `quiet`: it prints nothing.

        Where stderr is no terminal there is no panel.
        """
        self.parameters, self.console = parameters, Console(stderr=True, quiet=quiet)
        self._title, self._joints = title, joints
        self._keys = sys.stdin.isatty()
        shows = self.console.is_terminal and not quiet
        self._live = (
            Live(console=self.console, auto_refresh=False, transient=True) if shows else None
        )
        self._closing, self._terminal_attributes = threading.Event(), None
        self._thread: threading.Thread | None = None

    def begin(self, desk: DeskLink) -> None:
        """Take the terminal: from now on keys go to the desk."""
        if self._keys:
            self._terminal_attributes = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
        self._thread = threading.Thread(
            target=self._run, args=(desk,), name="operator", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        """Give the terminal back as it was."""
        self._closing.set()
        if self._thread:
            self._thread.join()
        if self._terminal_attributes:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._terminal_attributes)

    def log(self, line: str) -> None:
        """Print a line above the panel."""
        print_line(self.console, f"crane: {line}")

    def _run(self, desk: DeskLink) -> None:
        with suppress(OSError):  # the run is over, and its pipes are closed
            if self._live:
                with self._live:
                    self._serve(desk)
            else:
                self._serve(desk)

    def _serve(self, desk: DeskLink) -> None:
        unread = b""
        while not self._closing.is_set():
            if self._keys and select.select([sys.stdin], [], [], _REFRESH_PERIOD)[0]:
                data = os.read(sys.stdin.fileno(), 1024)
                self._keys = bool(data)  # none at the end of the file: the terminal has been closed
                data, unread = split_incomplete(unread + data)
                for key in read_keys(data):
                    desk.end() if key == END else desk.send(f"key {key}")
            elif not self._keys:
                self._closing.wait(_REFRESH_PERIOD)
            else:
                # its rest would have come: it was a person's key, and the next one counts
                unread = b""
            if self._live and (state := desk.panel()):
                self._live.update(
                    make_panel(self._title, self._joints, state, self._keys), refresh=True
                )


def make_lever_table(joints: Sequence[DrivenJoint], assignment: Assignment, device: str) -> Table:
    """Return the table of levers: what moves which joint, how fast, and how far."""
    lever = "keys" if device == "keyboard" else "lever"
    table = Table(
        "joint", lever, "moves", "largest speed", "ramp", "soft limits", title_justify="left"
    )
    for joint, levers in zip(joints, assignment.levers, strict=True):
        control = " / ".join(levers.keys) if device == "keyboard" else axis_name(levers)
        speed, ramp = (
            _format_quantity(joint.bounds.speed, joint.unit, "/s"),
            _format_quantity(joint.bounds.acceleration, joint.unit, "/s²"),
        )
        table.add_row(
            joint.name, control, " / ".join(levers.directions), speed, ramp, _format_travel(joint)
        )
    return table


def format_lever_note(assignment: Assignment, device: str) -> str:
    """Return a line on dead man's switch, emergency stop, release, assistance, and the end."""
    if device == "keyboard":
        return (
            "speeds last while a key is held; space: emergency stop, enter: release, tab: "
            "assistance, q: end"
        )
    names = button_names(assignment.buttons)
    switches = (
        f"hold {names['enable']} to move; emergency stop: {names['stop']}, release: "
        f"{names['release']}"
    )
    return (
        f"{switches}, assistance: {names['assistance']}; in this terminal space, enter, tab, q do "
        "the same"
    )


def make_panel(
    title: str, joints: Sequence[DrivenJoint], state: Mapping[str, Any], keys: bool
) -> Table:
    """Return the panel: the desk's mode, and each joint's commands and motion.

    A commanded velocity is a bar; velocity and position are numbers.

    Args:
        title, joints: of the scene.
        state: what the node `operator` has reported last.
        keys: the terminal's keys are read.
    """
    mode, outer, table = Mode(state["mode"]), Table.grid(), Table.grid(padding=(0, 2))
    head = Text.assemble(
        f"{title}  {state['t']:7.1f} s   ", (f" {mode.value} ", _COLORS.get(mode, "bold yellow"))
    )
    assistance = state["assistance_unavailable"] or ("on" if state["assisted"] else "off")
    if state["braked"]:
        head.append("   brakes refused" if state["brakes_refused"] else "   brakes on")
    outer.add_row(head)
    if state["brakes_refused"]:
        outer.add_row(Text(state["brakes_refused"], style="bold red"))
    for i, joint in enumerate(joints):
        table.add_row(*_format_joint(joint, i, state))
    outer.add_row(table)
    scale = ""
    if keys and state["device"] == "keyboard":
        scale = f"   keys: {100.0 * state['speed_scale']:.0f} % of the speed"
    below = (
        f"swing {state['swing_deg']:.1f}°   assistance: {assistance}   device: "
        f"{state['device']}{scale}"
    )
    outer.add_row(escape(below))
    if keys:
        hints = "space emergency stop · enter release · tab assistance · + - speed · q end"
        outer.add_row(Text(hints, style="dim"))
    return outer


def _format_joint(joint: DrivenJoint, i: int, state: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the cells of the i-th joint's row of the panel."""
    bar = format_bar(state["speeds"][i] / joint.bounds.speed)
    velocity = _format_quantity(state["velocities"][i], joint.unit, "/s")
    position = _format_quantity(state["positions"][i], joint.unit)
    notes = {"at_soft_limit": "soft limit", "dragged": "dragged"}
    return (
        joint.name,
        bar,
        velocity,
        position,
        ", ".join(notes[key] for key in notes if joint.name in state[key]),
    )


def format_bar(fraction: float) -> str:
    """Return a bar about a middle for a fraction of the largest speed, -1 .. 1."""
    length = min(round(abs(fraction) * _BAR), _BAR)
    left = "━" * length if fraction < 0.0 else ""
    right = "━" * length if fraction > 0.0 else ""
    return f"{left:>{_BAR}}┃{right:<{_BAR}}"


def _format_travel(joint: DrivenJoint) -> str:
    low, high = (
        _format_quantity(end, joint.unit) if isfinite(end) else "-"
        for end in (joint.low, joint.high)
    )
    return "none" if joint.low == -inf and joint.high == inf else f"{low} .. {high}"


def _format_quantity(value: float, unit: str, rate: str = "") -> str:
    """Return a number with its unit; angles in degrees."""
    number, name = (degrees(value), "°") if unit == "rad" else (value, " m")
    return f"{number + 0.0:.2f}{name}{rate}"
