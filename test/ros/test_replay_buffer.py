"""Replay buffer of a standby recorder: messages from where the failed one's files end."""

import time

import pytest

from crane_sim import load_scene
from crane_sim.ros.common.serialization import STATE, JointStateCodec
from crane_sim.ros.recorder.replay_buffer import SECONDS, ReplayBuffer

SCENE = load_scene("knuckle_setpoint")
STATE_CODEC = JointStateCodec(SCENE.joint_names, STATE)
NS_PER_S = 10**9


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return the time [s] of the monotonic clock, which stands until it is changed."""
    time_now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: time_now[0])
    return time_now


def state(second: int, position: float = 0.0) -> bytes:
    """Return the state of a second; the position identifies the run between two resets."""
    return STATE_CODEC.encode(second * NS_PER_S, (position,) * 6, (0.0,) * 6, (0.0,) * 6)


def buffer_with_a_reset(clock: list[float]) -> ReplayBuffer:
    """Return a buffer whose run was reset after the state of second 20, three seconds ago."""
    buffer = ReplayBuffer(["joint_states", "simulation_state", "joint_trajectory"], resets=3)
    callbacks = buffer.callbacks()
    callbacks["simulation_state"](b"playing")
    callbacks["joint_trajectory"](b"old target")
    for second in range(1, 21):
        clock[0] = float(second)
        callbacks["joint_states"](state(second))
    callbacks["joint_trajectory"](b"late target")
    for second in range(1, 4):
        clock[0] = 20.0 + second
        callbacks["joint_states"](state(second, 1.0))
    return buffer


def replayed(buffer: ReplayBuffer, after: int, resets: int) -> list[bytes]:
    """Return what an output replays that resumes after a second, `resets` after the first."""
    messages: list[bytes] = []
    names = ("joint_states", "simulation_state", "joint_trajectory")
    buffer.replay_to([dict.fromkeys(names, messages.append)], [after * NS_PER_S], resets)
    return messages


def test_newest_and_latched_messages_are_replayed(clock: list[float]) -> None:
    """Latched messages and those after the last written stamp are replayed, then new ones pass."""
    received: list[bytes] = []
    buffer = ReplayBuffer(["joint_states", "simulation_state"])
    callbacks = buffer.callbacks()
    callbacks["simulation_state"](b"playing")
    messages = [state(second) for second in range(21)]
    for second in range(20):
        clock[0] = float(second)
        callbacks["joint_states"](messages[second])
    buffer.replay_to([{name: received.append for name in callbacks}], after=[11 * NS_PER_S])
    callbacks["joint_states"](messages[20])
    assert received == [b"playing", *messages[12:]]
    assert 19 - SECONDS < 11  # what was skipped was still buffered: it had been written


OTHERS = (
    "applied_effort",
    "payload_pose",
    "base/odometry",
    "base/imu",
    "camera/payload_pose",
    "tip_demand",
)
DELAY = 2  # s, of the camera


@pytest.mark.parametrize("name", OTHERS)
@pytest.mark.parametrize("after", [0, 3])
def test_what_was_recorded_is_not_replayed(clock: list[float], name: str, after: int) -> None:
    """Of a topic that follows the states only messages after the last recorded one are replayed.

    It does not matter whether they are late.
    """
    received: list[bytes] = []
    buffer = ReplayBuffer(["joint_states", name])
    callbacks = buffer.callbacks()
    delay = DELAY if name == "camera/payload_pose" else 0
    for second in range(1, 6):
        callbacks["joint_states"](state(second))
        callbacks[name](state(second - delay))  # of which only the header is read
    buffer.replay_to([{name: received.append}], [after * NS_PER_S])
    assert received == [state(second - delay) for second in range(after + 1, 6)]


def test_commands_without_a_stamp_are_replayed(clock: list[float]) -> None:
    """A command stamped 0 belongs to the state before it.

    What came before the first state is replayed at 0 alone.
    """
    for after, expected in ((0, [0, 1, 2]), (1, [2])):
        received: list[bytes] = []
        buffer = ReplayBuffer(["joint_states", "joint_commands"])
        callbacks = buffer.callbacks()
        for second in range(3):
            if second:
                callbacks["joint_states"](state(second))
            callbacks["joint_commands"](state(0, float(second)))
        buffer.replay_to([{"joint_commands": received.append}], [after * NS_PER_S])
        assert received == [state(0, float(second)) for second in expected]


def test_every_broadcaster_is_replayed(clock: list[float]) -> None:
    """Static transforms of several broadcasters are all replayed once, however old.

    Of more than a hundred the newest hundred are replayed.
    """
    received: list[bytes] = []
    buffer = ReplayBuffer(["/tf_static", "joint_states"])
    callbacks = buffer.callbacks()
    for sender in (*range(102), 50):
        callbacks["/tf_static"](b"from %d" % sender)
    clock[0] = 2.0 * SECONDS
    callbacks["joint_states"](state(1))
    buffer.replay_to([{"/tf_static": received.append}], after=[0])
    assert received == [b"from %d" % sender for sender in (*range(2, 50), *range(51, 102), 50)]


def test_every_broadcaster_outlives_a_reset(clock: list[float]) -> None:
    """Static transforms from before a recorded reset are all replayed, old and new.

    The failed recorder had recorded the reset.
    """
    received: list[bytes] = []
    buffer = ReplayBuffer(["/tf_static", "joint_states"])
    callbacks = buffer.callbacks()
    for t, sender in ((0.0, b"a"), (0.0, b"b"), (1.5 * SECONDS, b"c")):
        clock[0] = t
        callbacks["/tf_static"](sender)
        callbacks["joint_states"](state(5 + int(t)))
    clock[0] = 1.6 * SECONDS
    callbacks["joint_states"](state(1))
    buffer.replay_to([{"/tf_static": received.append}], after=[NS_PER_S], resets=1)
    assert received == [b"a", b"b", b"c"]


def test_the_pass_before_a_recorded_reset_is_dropped(clock: list[float]) -> None:
    """If the failed recorder recorded the reset, only latched messages from before are replayed."""
    assert replayed(buffer_with_a_reset(clock), after=1, resets=4) == [
        b"playing",
        state(2, 1.0),
        state(3, 1.0),
    ]


def test_the_pass_before_an_unrecorded_reset_is_replayed(clock: list[float]) -> None:
    """Otherwise the run before the reset is replayed to its end, then the new one."""
    rest = [*map(state, (19, 20)), b"late target", *(state(second, 1.0) for second in (1, 2, 3))]
    assert replayed(buffer_with_a_reset(clock), after=18, resets=3) == [
        b"playing",
        b"old target",
        *rest,
    ]
    assert 23 - SECONDS < 18  # all of that was still buffered
