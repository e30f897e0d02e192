"""Bytes on simulation_state that are no such message, at a recorder without DDS."""

from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import UInt8

from crane_sim import load_scene
from crane_sim.ros.common.messages import SimulationState
from crane_sim.ros.recorder import subscriptions as subscriptions_module
from crane_sim.ros.recorder.decoder import MessageDecoder
from crane_sim.ros.recorder.subscriptions import RecorderSubscriptions

PLAYING, STOPPED = (
    serialize_message(UInt8(data=state)) for state in (SimulationState.PLAYING, SimulationState.STOPPED)
)
INVALID = [b"", b"\0", b"\0\1\0\0"]  # the last one is a CDR encapsulation header without payload


@pytest.mark.parametrize("data", INVALID)
def test_invalid_bytes_end_no_recorder(data: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """The recorder ignores them: it detects the run's end, and records only valid states."""
    callbacks: dict[str, Any] = {}
    monkeypatch.setattr(
        subscriptions_module, "PolledSubscription", lambda _node, name, callback: callbacks.update({name: callback})
    )
    states: list[str] = []
    recorder: Any = SimpleNamespace(add_simulation_state=states.append)
    node: Any = SimpleNamespace()
    decoder = MessageDecoder(load_scene("knuckle_setpoint"), recorder)
    subscriptions = RecorderSubscriptions(node, [decoder.callbacks()])
    on_state = callbacks["simulation_state"]
    for message in (data, PLAYING, data, STOPPED):
        on_state(message)
    on_state(data)
    assert subscriptions.over
    assert states == ["playing", "stopped"]
