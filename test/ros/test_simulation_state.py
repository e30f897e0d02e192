"""What a recorder makes of simulation_state, on which anybody may publish anything; without DDS."""

from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import UInt8

from crane_sim import load_scene
from crane_sim.ros.common import messages
from crane_sim.ros.recorder import subscriptions as hearing_module
from crane_sim.ros.recorder.decoder import MessageDecoder
from crane_sim.ros.recorder.subscriptions import RecorderSubscriptions

PLAYING, STOPPED = (serialize_message(UInt8(data=mode)) for mode in (messages.PLAYING, messages.STOPPED))
NO_MODES = [b"", b"\0", b"\0\1\0\0"]  # the last one is a message's head, without the number


@pytest.mark.parametrize("data", NO_MODES)
def test_bytes_that_are_no_mode_end_no_recorder(data: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """The recorder goes on as if they had never come: it knows the run's end, and notes only the modes."""
    takers: dict[str, Any] = {}
    monkeypatch.setattr(hearing_module, "PolledSubscription", lambda _node, name, take: takers.update({name: take}))
    modes: list[str] = []
    recorder: Any = SimpleNamespace(mode=modes.append)
    node: Any = SimpleNamespace()
    transcript = MessageDecoder(load_scene("knuckle_setpoint"), recorder)
    hearing = RecorderSubscriptions(node, [transcript.takers()])
    take = takers["simulation_state"]
    for message in (data, PLAYING, data, STOPPED):
        take(message)
    take(data)
    assert hearing.over
    assert modes == ["playing", "stopped"]
