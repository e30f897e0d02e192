"""Services of a node answer requests that rclpy's own callbacks raise errors for."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from bench_graph import graph
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node

from crane_sim.ros.common.nodes import ManagedNode, ServingNode


@pytest.fixture(params=[ServingNode, ManagedNode])
def node(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Node]:
    """Yield a node with a parameter."""
    with graph(tmp_path, monkeypatch):
        rclpy.init()
        node = request.param("guarded")
        node.declare_parameter("rate", 1.0)
        try:
            yield node
        finally:
            node.destroy_node()
            rclpy.shutdown()


def answer(node: Node, kind: Any, name: str, request: Any) -> Any:
    """Return what the callback of a service answers."""
    (service,) = [each for each in node.services if each.srv_name.endswith(f"/{name}")]
    return service.callback(request, kind.Response())


def parameter(kind: int, value: float) -> Parameter:
    """Return the parameter with a value of a kind."""
    return Parameter(name="rate", value=ParameterValue(type=kind, double_value=value))


@pytest.mark.parametrize("kind", [10, 77, 255])
def test_a_type_that_there_is_not_is_refused(node: Node, kind: int) -> None:
    """Each parameter of the request has its result: those before the bad one are set."""
    parameters = [parameter(3, 2.0), parameter(kind, 3.0), parameter(3, 4.0)]
    results = answer(
        node, SetParameters, "set_parameters", SetParameters.Request(parameters=parameters)
    ).results
    assert [result.successful for result in results] == [True, False, False]
    assert f"{kind} is not a valid" in results[1].reason
    request = SetParametersAtomically.Request(parameters=parameters)
    assert not answer(
        node, SetParametersAtomically, "set_parameters_atomically", request
    ).result.successful
    assert node.get_parameter("rate").value == 2.0


@pytest.mark.parametrize("node", [ManagedNode], indirect=True)
def test_a_transition_that_there_is_not_is_refused(node: ManagedNode) -> None:
    """A lifecycle node answers that it has not made the transition, and stays as it is."""
    request = ChangeState.Request(transition=Transition(id=77))
    assert not node._service_change_state.callback(request, ChangeState.Response()).success
