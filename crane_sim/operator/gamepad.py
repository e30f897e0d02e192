"""A gamepad of this machine, read by the optional package `evdev`, numbered as in `levers`."""

import sys
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.operator.inputs import Sample

try:
    import evdev  # pyright: ignore[reportMissingImports]
    from evdev import ecodes  # pyright: ignore[reportMissingImports]
except ImportError:  # it is optional, and compiled where it is installed
    evdev: Any = None
    ecodes: Any = None

MISSING = (
    f"needs the Python package evdev, which is not installed ({sys.prefix}/bin/pip install evdev "
    "compiles it)"
)
# by the numbers of axes; evdev: right and back > 0
_STICKS = ("ABS_X", "ABS_Y", "ABS_RX", "ABS_RY", "ABS_Z", "ABS_RZ")
_BUTTONS = (
    *("BTN_SOUTH", "BTN_EAST", "BTN_WEST", "BTN_NORTH", "BTN_SELECT", "BTN_MODE", "BTN_START"),
    *(
        "BTN_THUMBL",
        "BTN_THUMBR",
        "BTN_TL",
        "BTN_TR",
        "BTN_DPAD_UP",
        "BTN_DPAD_DOWN",
        "BTN_DPAD_LEFT",
    ),
    "BTN_DPAD_RIGHT",
)  # by the numbers of buttons


class Gamepad:
    """An open gamepad.

    Attributes:
        name: its own.
    """

    def __init__(self, path: str = "") -> None:
        """Open the device file `path`, or the first gamepad of this machine.

        Raises:
            SceneError: there is none, or it cannot be read; the message is one line.
        """
        self._device = _open(path)
        self.name = self._device.name
        self._ranges: Mapping[int, Any] = {}
        self._axes = [0.0] * len(_STICKS)
        self._buttons: list[int] = []
        self._codes = {getattr(ecodes, name): i for i, name in enumerate(_STICKS)}
        self._keys = {getattr(ecodes, name): i for i, name in enumerate(_BUTTONS)}
        try:
            self._read_positions()
        except OSError as error:  # it is gone again
            self.close()
            raise SceneError(f"gamepad {self.name}: cannot be read: {error.strerror}") from None

    def _read_positions(self) -> None:
        """Read where sticks and buttons are; later events have their changes."""
        self._buttons = [0] * len(_BUTTONS)
        self._ranges = dict(self._device.capabilities(absinfo=True).get(ecodes.EV_ABS, ()))
        for code, i in self._codes.items():
            if code in self._ranges:
                self._axes[i] = self._normalise(code, self._ranges[code].value)
        for key in self._device.active_keys():
            if key in self._keys:
                self._buttons[self._keys[key]] = 1

    def read(self) -> Sample:
        """Return the present positions.

        Raises:
            OSError: the gamepad is gone.
        """
        # by the kernel, whose buffer was full: the release of a button, for instance
        events_were_lost = False
        with suppress(BlockingIOError):
            for event in self._device.read():
                if event.type == ecodes.EV_ABS and event.code in self._codes:
                    self._axes[self._codes[event.code]] = self._normalise(event.code, event.value)
                elif event.type == ecodes.EV_KEY and event.code in self._keys:
                    self._buttons[self._keys[event.code]] = int(bool(event.value))
                elif event.type == ecodes.EV_SYN and event.code == ecodes.SYN_DROPPED:
                    events_were_lost = True
        if events_were_lost:
            self._read_positions()
        return Sample(tuple(self._axes), tuple(self._buttons))

    def close(self) -> None:
        """Close the device file."""
        with suppress(OSError):
            self._device.close()

    def _normalise(self, code: int, value: int) -> float:
        """Return an axis's position, -1 .. 1: left and forwards positive."""
        info = self._ranges[code]
        half = 0.5 * (info.max - info.min)
        return -(value - info.min - half) / half if half > 0.0 else 0.0


def _open(path: str) -> Any:
    if evdev is None:
        raise SceneError(f"--input gamepad: {MISSING}")
    for candidate in [path] if path else sorted(evdev.list_devices()):
        try:
            device = evdev.InputDevice(candidate)
        except OSError as error:
            if path:
                raise SceneError(f"--gamepad {path}: cannot be read: {error.strerror}") from None
            continue
        keys = device.capabilities().get(ecodes.EV_KEY, ())
        if path or ecodes.BTN_GAMEPAD in keys or ecodes.BTN_JOYSTICK in keys:
            return device
        device.close()
    raise SceneError(
        "--input gamepad: this machine has none that this user may read (/dev/input/event*)"
    )
