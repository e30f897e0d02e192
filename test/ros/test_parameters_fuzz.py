"""Fuzzing of node parameters: each value fits its type and range, or is an error of one line."""

import math
from typing import Any

from document_mutations import JUNK, NUMBERS, ODD
from fuzz_settings import QUICK
from hypothesis import given, settings
from hypothesis import strategies as st

from crane_control.nodes import controller_node, tracker_node
from crane_sim.ros import plant_node, recorder_node
from crane_sim.ros.common.parameters import COMMON, Option, check_value

NODES = (plant_node, recorder_node, controller_node, tracker_node)
OPTIONS = [
    (name, option if isinstance(option, Option) else Option(option, ""))
    for options in (COMMON, *(node.PARAMETERS for node in NODES))
    for name, option in options.items()
]
WORDS = st.sampled_from(
    [word for _, option in OPTIONS for word in option.choices] + ["", "knuckle_setpoint"]
)


def check_parameter(name: str, option: Option, value: Any) -> None:
    """Check one value of one parameter."""
    try:
        checked = check_value(name, value, option)
    except ValueError as error:
        assert len(str(error).splitlines()) == 1
        assert name in str(error)
        return
    assert type(checked) is type(option.default)
    if option.choices:
        assert checked in option.choices
    if option.low is not None and option.high is not None:
        assert option.low <= checked <= option.high
    if isinstance(checked, float | tuple):
        assert all(map(math.isfinite, checked if isinstance(checked, tuple) else (checked,)))


@settings(**QUICK | {"max_examples": 300})
@given(st.sampled_from(OPTIONS), NUMBERS | ODD | WORDS | JUNK)
def test_an_odd_parameter(option: tuple[str, Option], value: Any) -> None:
    """Each value fits its parameter's type and range, or is a single-line error with its name."""
    check_parameter(*option, value)
