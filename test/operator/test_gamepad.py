"""A gamepad: a virtual one where /dev/uinput is permitted, a double of `evdev` everywhere."""

import os
from types import SimpleNamespace
from typing import Any

import pytest
from process_helpers import wait_until

from crane_sim.files.errors import SceneError
from crane_sim.operator import gamepad
from crane_sim.operator.inputs import demand_of
from crane_sim.operator.levers import Buttons, make_lever_assignment

JOINTS = ("slew", "trolley", "rope")
CODES = {name: i for i, name in enumerate((*gamepad._STICKS, *gamepad._BUTTONS), start=16)}
ECODES = SimpleNamespace(
    EV_SYN=0,
    SYN_DROPPED=3,
    EV_KEY=1,
    EV_ABS=3,
    BTN_GAMEPAD=CODES["BTN_SOUTH"],
    BTN_JOYSTICK=-1,
    **CODES,
)


class FakeDevice:
    """A gamepad of the package evdev, with events to be read."""

    name = "pad"

    def __init__(self, path: str) -> None:
        """Begin with the sticks in their middle; any other path than that of the pad is none."""
        if path != "/dev/input/event7":
            raise OSError(13, "Permission denied")
        self.events: list[Any] = []
        self.pressed = [CODES["BTN_TL"]]  # the left shoulder: it is held from the start
        self.gone = False

    def capabilities(self, absinfo: bool = False) -> dict[int, Any]:
        """Return sticks with 8 bits, the right one with 16 bits with a sign, and all buttons."""
        small, large = (
            SimpleNamespace(min=0, max=254, value=127),
            SimpleNamespace(min=-32768, max=32768, value=0),
        )
        axes = [
            (CODES[name], small if name in ("ABS_X", "ABS_Y") else large)
            for name in gamepad._STICKS
        ]
        return {ECODES.EV_ABS: axes, ECODES.EV_KEY: [CODES[name] for name in gamepad._BUTTONS]}

    def active_keys(self) -> list[int]:
        """Return the buttons that are held."""
        return self.pressed

    def read(self) -> list[Any]:
        """Return the events; as evdev, an error if there are none or the device is gone."""
        if self.gone:
            raise OSError(19, "No such device")
        if not self.events:
            raise BlockingIOError
        events, self.events = self.events, []
        return events

    def close(self) -> None:
        """Close nothing."""


@pytest.fixture
def pad(monkeypatch: pytest.MonkeyPatch) -> gamepad.Gamepad:
    """Return an open gamepad of the double."""
    double = SimpleNamespace(
        InputDevice=FakeDevice, list_devices=lambda: ["/dev/input/event3", "/dev/input/event7"]
    )
    monkeypatch.setattr(gamepad, "evdev", double)
    monkeypatch.setattr(gamepad, "ecodes", ECODES)
    return gamepad.Gamepad()


def test_sticks_and_buttons(pad: gamepad.Gamepad) -> None:
    """Sticks are scaled by their ranges, left and forwards positive; buttons have lever numbers."""
    device: Any = pad._device
    assert demand_of(pad.read(), make_lever_assignment(JOINTS))[:2] == ((0.0, 0.0, 0.0), True)
    for kind, name, value in (
        (3, "ABS_X", 0),
        (3, "ABS_Y", 254),
        (3, "ABS_RY", -16384),
        (1, "BTN_EAST", 1),
    ):
        device.events.append(SimpleNamespace(type=kind, code=CODES[name], value=value))
    device.events.append(SimpleNamespace(type=4, code=4, value=9))  # a scan code
    demand = demand_of(pad.read(), make_lever_assignment(JOINTS))
    assert demand.axes == (1.0, -1.0, 0.5) and demand.enabled and demand.stop
    device.events.append(SimpleNamespace(type=1, code=CODES["BTN_TL"], value=0))
    assert not demand_of(pad.read(), make_lever_assignment(JOINTS)).enabled


def test_a_gamepad_that_is_gone(pad: gamepad.Gamepad) -> None:
    """Reading a gamepad that was unplugged is an OSError."""
    device: Any = pad._device
    device.gone = True
    with pytest.raises(OSError):
        pad.read()


def test_gamepads_that_are_none(pad: gamepad.Gamepad, monkeypatch: pytest.MonkeyPatch) -> None:
    """An unreadable file, a machine without gamepads and a missing package are one line each."""
    with pytest.raises(
        SceneError, match="--gamepad /dev/input/event3: cannot be read: Permission denied"
    ):
        gamepad.Gamepad("/dev/input/event3")
    monkeypatch.setattr(gamepad.evdev, "list_devices", lambda: ["/dev/input/event3"])
    with pytest.raises(SceneError, match="this machine has none that this user may read"):
        gamepad.Gamepad()
    monkeypatch.setattr(gamepad, "evdev", None)
    with pytest.raises(SceneError, match="needs the Python package evdev"):
        gamepad.Gamepad()


@pytest.mark.skipif(
    not os.access("/dev/uinput", os.W_OK), reason="/dev/uinput is not permitted here"
)
def test_a_virtual_gamepad() -> None:
    """A kernel's virtual gamepad demands the exact part of its range; its loss is an OSError."""
    evdev = pytest.importorskip("evdev")
    codes, info = (
        evdev.ecodes,
        evdev.AbsInfo(value=0, min=-1000, max=1000, fuzz=0, flat=0, resolution=0),
    )
    sticks = [(codes.ABS_X, info), (codes.ABS_Y, info), (codes.ABS_RX, info), (codes.ABS_RY, info)]
    buttons = [codes.BTN_SOUTH, codes.BTN_EAST, codes.BTN_TL, codes.BTN_START]
    virtual = evdev.UInput({codes.EV_ABS: sticks, codes.EV_KEY: buttons}, name="crane test pad")
    opened = gamepad.Gamepad(virtual.device.path)
    for kind, code, value in ((codes.EV_ABS, codes.ABS_X, -250), (codes.EV_KEY, codes.BTN_TL, 1)):
        virtual.write(kind, code, value)
    virtual.syn()
    wait_until(
        lambda: (
            demand_of(opened.read(), make_lever_assignment(JOINTS))[:2] == ((0.25, 0.0, 0.0), True)
        ),
        "the stick",
        20.0,
    )
    virtual.close()

    def lost() -> bool:
        try:
            opened.read()
        except OSError:
            return True
        return False

    wait_until(lost, "the loss of the gamepad", 20.0)
    assert Buttons().enable == 9


def test_a_gamepad_that_goes_while_it_is_opened_is_one_line(
    pad: gamepad.Gamepad, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A device gone before its first positions are read is an error like one not opened."""

    def gone(device: FakeDevice) -> list[int]:
        raise OSError(19, "No such device")

    monkeypatch.setattr(FakeDevice, "active_keys", gone)
    with pytest.raises(SceneError, match="gamepad pad: cannot be read: No such device"):
        gamepad.Gamepad("/dev/input/event7")


def test_lost_events_are_made_up_for(pad: gamepad.Gamepad) -> None:
    """Where the kernel's buffer was full, positions are read anew.

    The release of the dead man's switch may be lost.
    """
    device: Any = pad._device
    device.pressed = [CODES["BTN_EAST"]]
    device.events.append(SimpleNamespace(type=0, code=3, value=0))
    demand = demand_of(pad.read(), make_lever_assignment(JOINTS))
    assert demand.stop and not demand.enabled
