"""How long a law takes for a step, measured in its node."""

import time
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from crane_sim.laws import Law, asked
from crane_sim.ros import messages
from crane_sim.ros.punctuality import Errors
from crane_sim.ros.states import State

_DIAGNOSTICS = 1.0  # s of wall time between two diagnostic messages


class Workload:
    """Asks a law, takes the time, and tells the diagnostics."""

    def __init__(self, node: Node) -> None:
        """Begin with no step."""
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", messages.STREAM)
        self._source = f"{node.get_namespace().strip('/')}/{node.get_name()}"
        self._durations, self._told, self._stamp = Errors(), 0.0, 0

    def asked(self, law: Law, state: State, nu: int) -> tuple[float, ...]:
        """Return the efforts (nu,) that the law demands.

        Raises:
            LawError: as `laws.asked`.
        """
        began = time.perf_counter()
        effort = asked(law, state.t, state.q, state.v, nu)
        self._durations.add(time.perf_counter() - began)
        self._stamp = state.stamp
        return effort

    def silent(self) -> bool:
        """Return whether the last diagnostics are a second old."""
        return time.monotonic() - self._told >= _DIAGNOSTICS

    def tell(self, warning: str, values: Mapping[str, object]) -> None:
        """Publish diagnostics: what the law takes, and `values` besides; a warning where there is one."""
        self._told = time.monotonic()
        taken = {f"law {name} [us]": f"{value:.1f}" for name, value in self.figures().items()}
        message = messages.diagnostics(self._source, warning, taken | dict(values))
        messages.set_stamp(message.header.stamp, self._stamp)
        self._diagnostics.publish(message)

    def figures(self) -> dict[str, float]:
        """Return median, 99 % quantile and largest time of a step, µs."""
        return self._durations.figures()
