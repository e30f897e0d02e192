"""Node parameters fuzzed: a value that is possible, or an error of one line; nothing else."""

import math
from typing import Any

import pytest
from fuzz_settings import LONG, QUICK
from hypothesis import given, settings
from hypothesis import strategies as st
from mutilation import JUNK, NUMBERS, ODD

from crane_control.nodes import controller_node, tracker_node
from crane_sim.ros import plant_node, recorder_node
from crane_sim.ros.common.parameters import COMMON, Option, check_value

NODES = (plant_node, recorder_node, controller_node, tracker_node)
OPTIONS = [
    (name, option if isinstance(option, Option) else Option(option, ""))
    for options in (COMMON, *(node.PARAMETERS for node in NODES))
    for name, option in options.items()
]
WORDS = st.sampled_from([word for _, option in OPTIONS for word in option.choices] + ["", "knuckle_setpoint"])


def check_parameter(name: str, option: Option, value: Any) -> None:
    """Check one value of one parameter."""
    try:
        found = check_value(name, value, option)
    except ValueError as error:
        assert len(str(error).splitlines()) == 1
        assert name in str(error)
        return
    assert type(found) is type(option.default)
    if option.choices:
        assert found in option.choices
    if option.low is not None and option.high is not None:
        assert option.low <= found <= option.high
    if isinstance(found, float | tuple):
        assert all(map(math.isfinite, found if isinstance(found, tuple) else (found,)))


@settings(**QUICK | {"max_examples": 300})
@given(st.sampled_from(OPTIONS), NUMBERS | ODD | WORDS | JUNK)
def test_an_odd_parameter(option: tuple[str, Option], value: Any) -> None:
    """Whatever a parameter is set to: it is of its type and in its range, or refused in one line with its name."""
    check_parameter(*option, value)


@pytest.mark.slow
@settings(**LONG)
@given(st.sampled_from(OPTIONS), NUMBERS | ODD | WORDS | JUNK)
def test_ten_thousand_odd_parameters(option: tuple[str, Option], value: Any) -> None:
    """The same, ten thousand times."""
    check_parameter(*option, value)
