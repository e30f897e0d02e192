"""The operator's devices: keys that hold for a while, a controller's axes and buttons, levers.

Levers are chosen by names of joints.
"""

from math import inf, nan

import pytest

from crane_sim.files.errors import SceneError
from crane_sim.operator.inputs import (
    DEAD_ZONE,
    FIRST_HOLD,
    LEVELS,
    REPEAT_HOLD,
    Keyboard,
    Sample,
    demand_of,
)
from crane_sim.operator.levers import NO_AXIS, Buttons, axis_name, make_lever_assignment

JOINTS = ("slew", "trolley", "rope")
HELD = tuple(int(i == Buttons().enable) for i in range(10))


def demand_at(
    axes: tuple[float, ...], buttons: tuple[int, ...] = HELD, *changes: str
) -> tuple[float, ...]:
    """Return the demand of the joints for positions of a controller."""
    return demand_of(Sample(axes, buttons), make_lever_assignment(JOINTS, changes)).axes


def test_axes_are_demands() -> None:
    """An axis beyond its neutral part is its joint's demand, unchanged; all others are zero."""
    assert demand_at((0.25, -0.75, 0.5, 1.0)) == (0.25, -0.75, 1.0)
    assert demand_at((DEAD_ZONE, -DEAD_ZONE, 0.0, 0.051)) == (0.0, 0.0, 0.051)


@pytest.mark.parametrize("axes", [(nan, inf, -inf, nan), (), (0.0,)])
def test_axes_that_say_nothing_are_at_rest(axes: tuple[float, ...]) -> None:
    """NaN and axes that a controller lacks demand nothing; more than a full way is a full way."""
    assert demand_at(axes) == (0.0, 0.0, 0.0)
    assert demand_at((7.0, -7.0)) == (1.0, -1.0, 0.0)


def test_buttons() -> None:
    """Each button does what the assignment says; buttons that a controller lacks are open."""
    for name, number in Buttons()._asdict().items():
        pressed = demand_of(
            Sample((), tuple(int(i == number) for i in range(12))), make_lever_assignment(JOINTS)
        )
        said = dict(zip(("enable", "stop", "release", "assistance"), pressed[1:], strict=True))
        assert said == {key: key == name for key in said}
    assert demand_of(Sample((), ()), make_lever_assignment(JOINTS))[1:] == (
        False,
        False,
        False,
        False,
    )


def test_changes_of_the_assignment() -> None:
    """A joint takes the axis named for it, inverted with a minus, also -0; a button its number."""
    assert demand_at((0.5, 0.25, 0.0, 0.0), HELD, "slew=1", "trolley=-0") == (0.25, -0.5, 0.0)
    assert make_lever_assignment(JOINTS, ["enable=5"]).buttons == Buttons()._replace(enable=5)
    with pytest.warns(FutureWarning, match="--map dead_man is now called enable"):
        assert make_lever_assignment(JOINTS, ["dead_man=5"]).buttons == Buttons()._replace(enable=5)
    assert axis_name(make_lever_assignment(JOINTS, ["rope=-7"]).levers[2]) == "axis 7, inverted"


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("slew", "--map 'slew': must be NAME=NUMBER, a joint's axis or a button"),
        ("slew=left", "--map 'slew=left': must be NAME=NUMBER, a joint's axis or a button"),
        ("slw=1", "--map 'slw=1': unknown name 'slw', did you mean 'slew'?"),
        ("stop=-1", "--map 'stop=-1': a button has no sign"),
    ],
)
def test_changes_that_are_none(change: str, line: str) -> None:
    """What is no change of a lever or a button is refused in one line."""
    with pytest.raises(SceneError) as error:
        make_lever_assignment(JOINTS, [change])
    assert str(error.value).startswith(line) and "\n" not in str(error.value)


def test_joints_of_any_name_have_levers() -> None:
    """Joints of unknown names get keys and axes of no other joint, and none when all are taken."""
    levers = make_lever_assignment((*JOINTS, "spreader_1", "spreader_2")).levers
    assert len({lever.keys for lever in levers}) == 5
    assert [lever.axis for lever in levers] == [0, 1, 3, 2, NO_AXIS] and axis_name(levers[4]) == "-"


def test_a_key_holds_and_ends() -> None:
    """A pressed key demands full speed for FIRST_HOLD s, a repeated one REPEAT_HOLD, then none."""
    keyboard = Keyboard(make_lever_assignment(JOINTS))
    keyboard.press("d", 10.0)
    assert keyboard.demand(10.0 + FIRST_HOLD - 0.01)[:2] == ((-1.0, 0.0, 0.0), True)
    assert keyboard.demand(10.0 + FIRST_HOLD)[:2] == ((0.0, 0.0, 0.0), False)
    for k in range(20):
        keyboard.press("w", 20.0 + 0.1 * k)
        assert keyboard.demand(20.0 + 0.1 * k).axes == (0.0, 1.0, 0.0)
    last = 20.0 + 0.1 * 19
    assert (
        keyboard.demand(last + REPEAT_HOLD - 0.01).enabled
        and not keyboard.demand(last + REPEAT_HOLD + 0.01).enabled
    )


def test_the_opposite_key_takes_over() -> None:
    """The key for the other way ends the first at once; keys of several joints hold together."""
    keyboard = Keyboard(make_lever_assignment(JOINTS))
    for key in ("a", "w", "d", "up"):
        keyboard.press(key, 0.0)
    assert keyboard.demand(0.1).axes == (-1.0, 1.0, -1.0)


def test_keys_that_act_once() -> None:
    """Stop, release and assistance are reported once each; unknown keys do nothing."""
    keyboard = Keyboard(make_lever_assignment(JOINTS))
    for key in ("space", "tab", "x", "right"):
        keyboard.press(key, 0.0)
    assert keyboard.demand(0.0)[1:] == (False, True, False, True)
    assert keyboard.demand(0.0)[1:] == (False, False, False, False)


def test_levels_of_the_keys() -> None:
    """+ and - choose the part of the largest speed, between the smallest and all of it."""
    keyboard, seen = Keyboard(make_lever_assignment(JOINTS)), []
    for key in "----+++++":
        keyboard.press(key, 0.0)
        keyboard.press("w", 0.0)
        seen.append(keyboard.demand(0.0).axes[1])
    assert seen == [LEVELS[i] for i in (2, 1, 0, 0, 1, 2, 3, 3, 3)]


def test_the_switch_stays_closed_for_a_tail() -> None:
    """With a tail the dead man's switch stays closed after the last key, with levers at rest."""
    keyboard = Keyboard(make_lever_assignment(JOINTS))
    keyboard.press("w", 0.0)
    assert keyboard.demand(FIRST_HOLD + 1.0, tail=1.5)[:2] == ((0.0, 0.0, 0.0), True)
    assert not keyboard.demand(FIRST_HOLD + 2.0, tail=1.5).enabled
