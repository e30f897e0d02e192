"""Parameters of a node: declared once, with description and range; errors take one line."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from types import SimpleNamespace
from typing import Any, NamedTuple

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

_KINDS = {bool: "true or false", int: "an integer", float: "a number", str: "a string"}
_ROS_PARAMETERS = {"use_sim_time", "start_type_description_service"}  # declared by rclpy itself


class Option(NamedTuple):
    """One parameter: its default, range and choices.

    A default of type tuple stands for an array of numbers; `live` ones may be set while the node
    runs.
    """

    default: Any
    description: str
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    live: bool = False


COMMON = {
    "control_fd": Option(
        -1, "pipe end with the orders of a supervisor; -1: there is none", -1, 1 << 20
    ),
    "report_fd": Option(
        -1, "pipe end for reports to the supervisor; -1: there is none", -1, 1 << 20
    ),
    "executor": Option(
        "events", "what serves callbacks: events is quicker", choices=("events", "single")
    ),
}


def read_overrides(node: Node) -> dict[str, Any]:
    """Return the parameters that a node was started with; it declares them from overrides."""
    names = [name for name in node.get_parameters_by_prefix("") if name not in _ROS_PARAMETERS]
    return {parameter.name: parameter.value for parameter in node.get_parameters(names)}


def common_parameters(node: Node) -> SimpleNamespace:
    """Return the parameters needed to report errors; the default where a value does not fit."""
    values = {name: option.default for name, option in COMMON.items()}
    for name, value in read_overrides(node).items():
        with suppress(ValueError):
            values |= {name: check_value(name, value, COMMON[name])} if name in COMMON else {}
    return SimpleNamespace(**values)


def declare_parameters(node: Node, options: Mapping[str, Option]) -> SimpleNamespace:
    """Declare a node's options; return the values in force, which follow later changes.

    Args:
        node: created with `automatically_declare_parameters_from_overrides`.
        options: by name.

    Raises:
        ValueError: a parameter is unknown, or its value is invalid; the message is one line.
    """
    overrides, known = read_overrides(node), COMMON | dict(options)
    if unknown := sorted(overrides.keys() - known.keys()):
        raise ValueError(
            f"unknown parameter {', '.join(unknown)}; this node has {', '.join(sorted(known))}"
        )
    for name in overrides:
        node.undeclare_parameter(name)
    values = {
        name: check_value(name, overrides.get(name, option.default), option)
        for name, option in known.items()
    }
    for name, option in known.items():
        node.declare_parameter(name, values[name], _descriptor(option), ignore_override=True)
    settings = SimpleNamespace(**values)
    node.add_pre_set_parameters_callback(
        lambda parameters: [_coerce_type(parameter, known) for parameter in parameters]
    )
    node.add_on_set_parameters_callback(lambda parameters: _apply(parameters, known, settings))
    for name, option in known.items():
        if isinstance(
            option.default, tuple
        ):  # declared empty, it would be described as an array of bytes
            node.set_parameters([Parameter(name, Parameter.Type.DOUBLE_ARRAY, list(values[name]))])
    return settings


def check_value(name: str, value: Any, option: Option) -> Any:
    """Return the value of a parameter in the type of its default.

    Raises:
        ValueError: it has another type, or is out of range; the message is one line.
    """
    kind = type(option.default)
    if kind is tuple:
        return _number_array(name, value)
    if kind is float and type(value) is int and abs(value) < 1 << 63:
        value = float(value)
    if type(value) is not kind:
        raise ValueError(f"parameter {name} is {value!r}; it must be {_KINDS[kind]}")
    if option.choices and value not in option.choices:
        raise ValueError(f"parameter {name} is {value!r}; it must be {' or '.join(option.choices)}")
    if (
        option.low is not None
        and option.high is not None
        and not option.low <= value <= option.high
    ):
        raise ValueError(
            f"parameter {name} is {value}; it must be from {option.low:g} to {option.high:g}"
        )
    return value


def _number_array(name: str, value: Any) -> tuple[float, ...]:
    """Return an array of numbers; the value may be of any type that ROS gives to an empty one."""
    try:
        numbers = tuple(map(float, value))
    except (TypeError, ValueError, OverflowError):
        numbers = (math.nan,)
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f"parameter {name} is {value!r}; it must be an array of finite numbers")
    return numbers


def _descriptor(option: Option) -> ParameterDescriptor:
    array = isinstance(
        option.default, tuple
    )  # of dynamic type: an empty array has no type of its numbers
    descriptor = ParameterDescriptor(
        description=option.description, read_only=not option.live, dynamic_typing=array
    )
    if option.choices:
        descriptor.additional_constraints = "one of " + ", ".join(option.choices)
    if option.low is not None and option.high is not None:
        if isinstance(option.default, float):
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=option.low, to_value=option.high)
            ]
        else:
            descriptor.integer_range = [
                IntegerRange(from_value=int(option.low), to_value=int(option.high), step=1)
            ]
    return descriptor


def _coerce_type(parameter: Parameter, known: Mapping[str, Option]) -> Parameter:
    """Return the parameter; an array of numbers as doubles.

    ROS has another type for empty arrays and for arrays of integers.
    """
    if parameter.name not in known or not isinstance(known[parameter.name].default, tuple):
        return parameter
    try:
        numbers = list(_number_array(parameter.name, parameter.value))
    except ValueError:
        return parameter  # `_apply` refuses it
    return Parameter(parameter.name, Parameter.Type.DOUBLE_ARRAY, numbers)


def _apply(
    parameters: Sequence[Parameter], known: Mapping[str, Option], settings: SimpleNamespace
) -> Any:
    """Apply parameters that are set while the node runs, all of them or none."""
    declared = [parameter for parameter in parameters if parameter.name in known]
    try:
        values = {
            parameter.name: check_value(parameter.name, parameter.value, known[parameter.name])
            for parameter in declared
        }
    except ValueError as error:
        return SetParametersResult(successful=False, reason=str(error))
    vars(settings).update(values)
    return SetParametersResult(successful=True)
