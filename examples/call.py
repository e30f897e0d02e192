"""Calls a service of the plant.

`call.py /knuckle/plant/set_pause true`, `call.py /knuckle/plant/step_simulation`.
Parameters go first: `call.py /knuckle/plant/step_simulation step_count=100`,
`call.py /knuckle/plant/reset_simulation "reset_positions=[0, 0.5, 0, 2, 0.1, 0]"`. Prints the
plant's answer. With ROS 2 from apt, `ros2 service call` and `ros2 param set` do the same.
"""

import json
import signal
import sys
from typing import Any

import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import SetBool, Trigger


def answer(node: Node, kind: type, name: str, request: object) -> Any:
    """Return what a service answers.

    That may take long, many steps for example, but no longer than its node lives.
    """
    client = node.create_client(kind, name)
    if not client.wait_for_service(10.0):
        services = (
            node.get_service_names_and_types()
        )  # with the one that is asked for, since it has a client
        known = sorted(
            service
            for service, kinds in services
            if service != name and kinds[0].startswith("std_srvs/")
        )
        sys.exit(
            f"{name}: no such service (there are: {', '.join(known) or 'none in this domain'})"
        )
    future = client.call_async(request)
    while not future.done():
        rclpy.spin_until_future_complete(node, future, timeout_sec=1.0)
        if not (future.done() or client.service_is_ready()):
            sys.exit(f"{name}: its node has left without an answer")
    return future.result()


def parameter(name: str, text: str) -> Any:
    """Return the message of a parameter whose value is written as JSON.

    Arrays are arrays of doubles.
    """
    value = json.loads(text)
    return Parameter(
        name, value=list(map(float, value)) if isinstance(value, list) else value
    ).to_parameter_msg()


def main() -> None:
    """Set the parameters, then call; SIGINT and SIGTERM end it at once, whenever they come."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(str(__doc__))
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node, (service, *words) = rclpy.create_node("call"), sys.argv[1:]
    pairs = [word.split("=", 1) for word in words if "=" in word]
    if pairs:
        plant = service.split("/plant/")[0] + "/plant/set_parameters"
        request = SetParameters.Request(parameters=[parameter(*pair) for pair in pairs])
        for (name, _), result in zip(
            pairs, answer(node, SetParameters, plant, request).results, strict=True
        ):
            if not result.successful:
                sys.exit(f"{name}: {result.reason}")
    values = [word for word in words if "=" not in word]
    if values not in ([], ["true"], ["false"]):
        sys.exit(
            f"{' '.join(values)}: a service takes true, false or nothing; parameters are name=value"
        )
    if values:
        response = answer(node, SetBool, service, SetBool.Request(data=values == ["true"]))
    else:
        response = answer(node, Trigger, service, Trigger.Request())
    print(response)
    sys.exit(0 if response.success else 1)


if __name__ == "__main__":
    main()
