"""Levers: the keys, the axis and the buttons of an operator's device that move each joint.

Axes and buttons are numbered as by the node `game_controller_node` of ROS's package joy, whose axes
are positive to the left and forwards. Levers follow what is usual on cranes: the left one slews or
travels, the right one hoists (pulled back: upwards) and luffs.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from crane_sim.files.errors import RenameWarning, SceneError, shorten, unknown_key

AXES = (
    "left stick horizontal",
    "left stick vertical",
    "right stick horizontal",
    "right stick vertical",
)
"""Names of the axes of a game controller, by their numbers."""
NO_AXIS = -1
BUTTON_NAMES = {1: "B", 3: "Y", 6: "start", 9: "left shoulder"}


class Lever(NamedTuple):
    """The two keys and the axis of a game controller that command one joint's speed."""

    joint: str
    keys: tuple[str, str]  # for positive and for negative speed
    directions: tuple[str, str]  # positive and negative, in words
    axis: int  # number on the game controller, or NO_AXIS
    sign: float = 1.0  # of the joint's speed at positive values of the axis


class Buttons(NamedTuple):
    """Numbers of the buttons of a game controller, by what they do."""

    enable: int = 9  # the dead man's switch: enables motion while it is held
    stop: int = 1  # emergency stop
    release: int = 6  # resets the emergency stop
    assistance: int = 3  # switches assistance on and off


class Assignment(NamedTuple):
    """Levers and buttons of one crane."""

    levers: tuple[Lever, ...]  # (nu,) of the actuated joints
    buttons: Buttons


_USUAL_LEVERS = {  # keys, directions, axis and its sign, by joint
    "slew": (("a", "d"), ("left", "right"), 0, 1.0),
    "bridge": (("a", "d"), ("left", "right"), 0, 1.0),
    "trolley": (("w", "s"), ("out", "in"), 1, 1.0),
    "telescope": (("w", "s"), ("out", "in"), 1, 1.0),
    "jib": (("w", "s"), ("up", "down"), 1, 1.0),
    "boom": (("r", "f"), ("up", "down"), 2, 1.0),
    "rope": (("down", "up"), ("lower", "raise"), 3, 1.0),
    "hoist": (("down", "up"), ("lower", "raise"), 3, 1.0),
    "tip_x": (("w", "s"), ("forward", "back"), 1, 1.0),
    "tip_y": (("a", "d"), ("left", "right"), 0, 1.0),
    "tip_z": (("up", "down"), ("up", "down"), 3, -1.0),
}
_SPARE_KEYS = (("t", "g"), ("y", "h"), ("u", "j"), ("i", "k"), ("o", "l"))


def make_lever_assignment(joints: Sequence[str], changes: Sequence[str] = ()) -> Assignment:
    """Return the levers of the actuated joints, and the buttons.

    Args:
        joints: names of the actuated joints; one not in `_USUAL_LEVERS` gets keys and an axis that
            are still free.
        changes: `NAME=NUMBER` each: the axis of a joint, with a minus sign if inverted, or one of
            `Buttons`.

    Raises:
        SceneError: a change is invalid.
    """
    levers: list[Lever] = []
    for joint in joints:
        levers.append(_choose_lever(joint, levers))
    return _apply_changes(Assignment(tuple(levers), Buttons()), changes)


def _choose_lever(joint: str, others: Sequence[Lever]) -> Lever:
    known = _USUAL_LEVERS.get(joint)
    taken_keys, taken_axes = {lever.keys for lever in others}, {lever.axis for lever in others}
    if known is not None and known[0] not in taken_keys:
        return Lever(joint, *known)
    keys = next((keys for keys in _SPARE_KEYS if keys not in taken_keys), ("", ""))
    axis = next((axis for axis in range(len(AXES)) if axis not in taken_axes), NO_AXIS)
    return Lever(joint, keys, ("+", "-"), axis)


def _apply_changes(assignment: Assignment, changes: Sequence[str]) -> Assignment:
    levers, buttons = {lever.joint: lever for lever in assignment.levers}, assignment.buttons
    for change in changes:
        name, _, value = change.partition("=")
        if name == "dead_man":
            warnings.warn("--map dead_man is now called enable", RenameWarning, stacklevel=2)
            name = "enable"
        digits = value.removeprefix("-")
        if not digits.isdecimal():
            raise SceneError(
                f"--map {shorten(change)}: must be NAME=NUMBER, a joint's axis or a button"
            )
        if name in levers:
            sign = -1.0 if value.startswith("-") else 1.0
            levers[name] = levers[name]._replace(axis=int(digits), sign=sign)
        elif name in Buttons._fields and value.startswith("-"):
            raise SceneError(f"--map {shorten(change)}: a button has no sign")
        elif name in Buttons._fields:
            buttons = buttons._replace(**{name: int(digits)})
        else:
            raise SceneError(
                f"--map {shorten(change)}: {unknown_key(name, (*levers, *Buttons._fields), 'name')}"
            )
    return Assignment(tuple(levers.values()), buttons)


def axis_name(lever: Lever) -> str:
    """Return the name of a lever's axis on the game controller, '-' without one."""
    if lever.axis == NO_AXIS:
        return "-"
    name = AXES[lever.axis] if lever.axis < len(AXES) else f"axis {lever.axis}"
    return f"{name}, inverted" if lever.sign < 0.0 else name


def button_names(buttons: Buttons) -> Mapping[str, str]:
    """Return the names of the buttons by what they do."""
    return {
        field: BUTTON_NAMES.get(number, f"button {number}")
        for field, number in buttons._asdict().items()
    }
