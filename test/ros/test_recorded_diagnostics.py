"""What a recorder takes from the plant's diagnostics: silent controller, refusals, stop."""

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import serialize_message
from recording_samples import SCENE

from crane_sim.ros.common import messages
from crane_sim.ros.recorder.decoder import MessageDecoder

NS_PER_S = 1_000_000_000


class States:
    """A recorder that keeps the states it is given."""

    def __init__(self) -> None:
        self.taken: list[tuple[str, int, str]] = []

    def add_timeline_state(self, timeline: str, normal: str, stamp: int, state: str) -> None:
        """Keep a state that is not the normal one."""
        self.taken += [(timeline, stamp // NS_PER_S, state)] if state != normal else []


def diagnostics(second: int, source: str, **values: object) -> bytes:
    """Return the serialized diagnostics of a source at a second of scene time."""
    named = {key.replace("_", ": "): value for key, value in values.items()}
    message: DiagnosticArray = messages.diagnostics(source, "", named)
    messages.set_stamp(message.header.stamp, second * NS_PER_S)
    return serialize_message(message)


def test_states_are_those_of_the_own_plant() -> None:
    """Warnings begin a state, refusals one from the diagnostics before.

    Other nodes and broken bytes begin none.
    """
    recorder: Any = States()
    take = MessageDecoder(SCENE, recorder, "crane/plant").callbacks()["/diagnostics"]
    take(
        diagnostics(
            1, "crane/plant", warning_commands="no valid command for 0.5 s", refused_names=0
        )
    )
    take(diagnostics(2, "other/plant", warning_commands="no valid command for 0.5 s"))
    take(b"no diagnostics")
    take(
        diagnostics(
            3, "crane/plant", warning_brakes="the brakes act", refused_names=2, refused_late=1
        )
    )
    take(diagnostics(4, "crane/plant", refused_names=2, refused_late=1, refused_huge="many"))
    assert recorder.taken == [
        ("controller", 1, "silent"),
        ("emergency stop", 3, "pressed"),
        ("commands", 1, "refused"),
    ]


def test_refusals_after_a_reset_are_counted_anew() -> None:
    """The first refusals after a reset are a state, although the run before it had more."""
    recorder: Any = States()
    take = MessageDecoder(SCENE, recorder, "crane/plant").callbacks()["/diagnostics"]
    take(diagnostics(7, "crane/plant", refused_names=5))
    take(diagnostics(1, "crane/plant", refused_names=2))
    assert recorder.taken == [("commands", 0, "refused")] * 2
