"""The terminal of `crane drive`: names of keys, the panel, and a drive in a pseudo-terminal."""

import fcntl
import os
import pty
import re
import select
import struct
import termios
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from command_line import CRANE, crane_here
from process_helpers import started_program
from rich.console import Console

from crane_sim.cli import drive as drive_command
from crane_sim.cli import operator_console
from crane_sim.cli.operator_console import (
    OperatorConsole,
    format_bar,
    format_lever_note,
    make_lever_table,
    make_panel,
    read_keys,
    split_incomplete,
)
from crane_sim.files.errors import SceneError
from crane_sim.hardware.reference_profiles import Bounds
from crane_sim.operator.desk import DrivenJoint
from crane_sim.operator.levers import axis_name, make_lever_assignment

LIMIT = 400.0  # s for what a terminal is waited for: the first run of a kind of scene compiles
SLEW = DrivenJoint("slew", "rad", Bounds(0.1, 0.05, 0.2))
ROPE = DrivenJoint("rope", "m", Bounds(0.4, 0.4, 1.6), 1.0, 7.0)


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        (b"wA", ["w", "a"]),
        (b"\x1b[A\x1b[B", ["up", "down"]),
        (b"\x1bOA\x1b[1;5D", ["up", "left"]),
        (b" \r\n\t=", ["space", "enter", "enter", "tab", "+"]),
        (b"\x1b[15~\x1b[3~w", ["w"]),
        (b"\x00\x07\xff\x1b", []),
        (b"\x1b[", []),
        (b"\x1b[[Aw", ["w"]),
        (b"\x1b[ ", ["space"]),  # Alt and [, then the emergency stop
        (b"\x1bO ", ["space"]),
    ],
)
def test_names_of_keys(data: bytes, keys: list[str]) -> None:
    """Letters, arrows and the keys with names are read; other sequences and bytes are dropped."""
    assert read_keys(data) == keys


@pytest.mark.parametrize("data", [b"w\x1b[A", b"\x1b[1;5D", b"\x1b[[A", b"\x1bOB"])
def test_a_sequence_in_two_parts_is_one(data: bytes) -> None:
    """Wherever the reads of a terminal divide a sequence, its keys are those of the whole."""
    for cut in range(len(data) + 1):
        first, unread = split_incomplete(data[:cut])
        assert read_keys(first) + read_keys(unread + data[cut:]) == read_keys(data)
    assert split_incomplete(data) == (data, b"")


def test_a_bar_shows_sign_and_size() -> None:
    """A speed's bar grows from the middle to its side, by its fraction of the largest.

    It is never longer.
    """
    assert format_bar(0.0).strip() == "┃" and format_bar(0.5).strip() == "┃" + "━" * 6
    assert format_bar(-2.0) == "━" * 12 + "┃" + " " * 12


def printed(*things: object) -> str:
    """Return what rich prints."""
    console = Console(width=120, record=True, file=open(os.devnull, "w"))
    console.print(*things)
    return console.export_text()


def test_the_table_of_levers() -> None:
    """The table names each joint's lever, speed, ramp and soft limits in the units of people."""
    assignment = make_lever_assignment(("slew", "rope"))
    keys, sticks = (
        printed(make_lever_table((SLEW, ROPE), assignment, device))
        for device in ("keyboard", "joy")
    )
    assert "a / d" in keys and "5.73°/s" in keys and "none" in keys and "1.00 m .. 7.00 m" in keys
    assert "left stick horizontal" in sticks and "right stick vertical" in sticks
    assert "emergency stop: B" in format_lever_note(
        assignment, "gamepad"
    ) and "space" in format_lever_note(assignment, "keyboard")


def test_the_page_has_the_levers() -> None:
    """The documentation's table of levers has keys and directions of every joint with levers."""
    page = (Path(__file__).parents[2] / "docs" / "operator.md").read_text()
    rows = [line.split("|")[1:4] for line in page.splitlines() if line.startswith("| `")]
    described = {
        name: (keys, stick) for names, keys, stick in rows for name in re.findall(r"`(\w+)`", names)
    }
    joints = (
        "slew",
        "bridge",
        "trolley",
        "telescope",
        "jib",
        "boom",
        "rope",
        "hoist",
        "tip_x",
        "tip_y",
        "tip_z",
    )
    for joint in joints:
        (lever,), (keys, stick) = make_lever_assignment((joint,)).levers, described[joint]
        for key, direction in zip(lever.keys, lever.directions, strict=True):
            assert f"{key}: {direction}" in keys or (key in keys and "arrows" in keys), joint
        assert axis_name(lever).removesuffix(", inverted") in stick, joint


def test_the_panel() -> None:
    """The panel has the desk's mode, velocities, positions, active soft limits and refusals."""
    state = {
        "t": 12.3,
        "mode": "emergency stop",
        "assisted": False,
        "assistance_unavailable": "",
        "device": "keyboard",
    }
    state |= {
        "speed_scale": 0.25,
        "speeds": [0.05, 0.0],
        "positions": [0.5, 6.9],
        "velocities": [0.02, 0.0],
    }
    state |= {
        "at_soft_limit": ["rope"],
        "dragged": ["rope"],
        "braked": True,
        "swing_deg": 2.51,
        "brakes_refused": "",
    }
    text = printed(make_panel("tower_gust", (SLEW, ROPE), state, True))
    parts = (
        "12.3 s|emergency stop|1.15°/s|28.65°|6.90 m|soft limit, dragged|brakes on|25 %|swing "
        "2.5°|q end"
    )
    assert [part for part in parts.split("|") if part not in text] == []
    refused = printed(
        make_panel("x", (SLEW, ROPE), state | {"brakes_refused": "only in real time"}, False)
    )
    assert "only in real time" in refused and "brakes on" not in refused
    state |= {"assistance_unavailable": "nothing hangs"}
    assert "nothing hangs" in printed(make_panel("x", (SLEW, ROPE), state, False))


class Terminal:
    """A pseudo-terminal with a program at its other end."""

    def __init__(self) -> None:
        """Open it, 120 columns wide."""
        self.master, self.slave = pty.openpty()
        fcntl.ioctl(self.master, termios.TIOCSWINSZ, struct.pack("HHHH", 40, 120, 0, 0))
        self.text = ""

    def type_until(self, key: bytes, expected: str) -> None:
        """Press a key ten times a second until the program's new output is the expected one."""
        self.text, deadline = "", time.monotonic() + LIMIT
        while expected not in self.text:
            assert time.monotonic() < deadline, (
                f"{expected!r} after {key!r}: not within {LIMIT:g} s; {self.text[-2000:]}"
            )
            os.write(self.master, key)
            self._read(0.1)

    def close(self) -> None:
        """Close both ends."""
        os.close(self.master)
        os.close(self.slave)

    def _read(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0 and select.select([self.master], [], [], left)[
            0
        ]:
            self.text += re.sub(
                r"\x1b\[[0-9;?]*[A-Za-z]", "", os.read(self.master, 65536).decode(errors="ignore")
            )


@pytest.mark.long
def test_a_drive_by_keys(tmp_path: Path) -> None:
    """Keys move, stop, release and assist; q ends the run with exit code 0.

    The terminal is as it was before.
    """
    command = [CRANE, "drive", "bridge_speed_drive", "--no-record"]
    terminal = Terminal()
    before = termios.tcgetattr(terminal.slave)
    ends = {
        "stdin": terminal.slave,
        "stdout": terminal.slave,
        "stderr": terminal.slave,
        "cwd": tmp_path,
    }
    env = os.environ | {"TERM": "xterm-256color"}
    with started_program(command, env=env, **ends) as process:
        terminal.type_until(b"", "dead man's switch open")
        terminal.type_until(b"w", "in operation")
        terminal.type_until(b"w", "━━━━")
        # behind the time: the last line names the key, too
        terminal.type_until(b" ", " s    emergency stop ")
        terminal.type_until(b"w", " s    emergency stop ")
        terminal.type_until(b"\r", "dead man's switch open")
        os.write(terminal.master, b"\t")
        terminal.type_until(b"", "assistance: on")
        terminal.type_until(b"a", "in operation")
        terminal.type_until(b"q", "state sha256")
        assert process.wait(LIMIT) == 0
    assert termios.tcgetattr(terminal.slave) == before
    terminal.close()


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--input", "mouse"], "--input = 'mouse': possible: keyboard, gamepad, joy"),
        ([], "--input keyboard: needs a terminal, and the input is none; possible: gamepad, joy"),
        (["--input", "joy", "--speed", "slew"], "--speed 'slew': must be JOINT=NUMBER"),
        (
            ["--input", "joy", "--map", "slw=1"],
            "--map 'slw=1': unknown name 'slw', did you mean 'slew'?",
        ),
        (
            ["--input", "joy", "--gamepad", "/dev/x"],
            "--gamepad /dev/x: belongs to --input gamepad, here is --input joy",
        ),
        (
            ["--input", "joy", "--joy-topic", "a b"],
            "--joy-topic 'a b': is no topic's name; possible: letters, digits",
        ),
        (
            ["--input", "joy", "--joy-topic", "~joy"],
            "--joy-topic '~joy': is no topic's name; possible: letters, digits",
        ),
        (
            ["--input", "joy", "--set", "duration=5"],
            "--set duration=5: the length of a run by hand is --duration",
        ),
        (
            ["--input", "joy", "--set", "control.law=lqr"],
            "--set control.law=lqr: control is left out, since an operator",
        ),
        (
            ["--input", "joy", "--on-silence", "stop"],
            "Invalid value for '--on-silence': 'stop' is not one of",
        ),
    ],
)
def test_mistakes_are_one_line(
    arguments: list[str],
    line: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Scenes that cannot be driven, and inputs that cannot drive, are one line with exit code 2.

    The input of a test is no terminal.
    """
    result = crane_here(monkeypatch, capsys, "drive", "knuckle_setpoint", *arguments)
    assert result.returncode == 2
    assert result.stderr.startswith(f"crane: {line}") and result.stderr.count("\n") == 1, (
        result.stderr
    )


def test_levers_are_mapped_of_devices_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """The axes of `--map` belong to a gamepad: beside a keyboard they are refused, not ignored."""
    monkeypatch.setattr("sys.stdin", SimpleNamespace(isatty=lambda: True))
    with pytest.raises(
        SceneError,
        match="--map slew=2: belongs to --input gamepad or joy, here is --input keyboard",
    ):
        drive_command._check_device(
            {"device": "keyboard", "joy_topic": None, "gamepad": "", "mapping": ("slew=2",)}
        )


def test_a_key_after_a_pause_is_none_of_a_sequence(monkeypatch: pytest.MonkeyPatch) -> None:
    """Alt and [ begin like an arrow: keys a moment later count, as the emergency stop must."""
    reads, console = [b"\x1b[", b"", b" "], OperatorConsole({}, "tower_gust", (SLEW,), True)
    console._keys, sent = True, list[str]()

    def select_next(*_: object) -> tuple[bool]:
        if not reads:
            console._closing.set()
            return (False,)
        return (bool(reads[0]) or bool(reads.pop(0)),)

    monkeypatch.setattr(operator_console, "select", SimpleNamespace(select=select_next))
    monkeypatch.setattr(operator_console.sys, "stdin", SimpleNamespace(fileno=lambda: 0))
    monkeypatch.setattr(operator_console.os, "read", lambda *_: reads.pop(0))
    desk: Any = SimpleNamespace(send=sent.append, panel=lambda: None)
    console._serve(desk)
    assert sent == ["key space"]
