"""The codec of joint states, compared with the generated message class."""

import math
from types import SimpleNamespace
from typing import Any

import pytest
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from crane_sim import load_scene
from crane_sim.recording.mcap.topic import has_stamp
from crane_sim.ros.common.messages import MalformedMessage, nanoseconds
from crane_sim.ros.common.serialization import EFFORT, STATE, JointStateCodec
from crane_sim.ros.controller.states import StateReader
from crane_sim.ros.recorder.decoder import MessageDecoder

SCENE = load_scene("knuckle_setpoint")

NAMES = st.lists(
    st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=20),
    min_size=1,
    max_size=7,
)
STAMPS = st.integers(0, 2**31 * 10**9 - 1)
NUMBERS = st.floats(allow_nan=False)


def vectors(data: st.DataObject, names: list[str], number: int) -> list[list[float]]:
    """Draw `number` vectors with one value per name."""
    return [
        data.draw(st.lists(NUMBERS, min_size=len(names), max_size=len(names)))
        for _ in range(number)
    ]


@pytest.mark.parametrize("fields", [STATE, EFFORT])
@given(st.data(), NAMES, STAMPS)
def test_encoded_messages_are_read_by_ros(
    fields: tuple[str, ...], data: st.DataObject, names: list[str], stamp: int
) -> None:
    """The generated class reads from the encoded bytes exactly what was written."""
    written = dict(zip(fields, vectors(data, names, len(fields)), strict=True))
    message = deserialize_message(
        JointStateCodec(names, fields).encode(stamp, *written.values()), JointState
    )
    assert (nanoseconds(message.header.stamp), message.name) == (stamp, names)
    assert {field: list(getattr(message, field)) for field in STATE} == {
        field: [] for field in STATE
    } | written


@given(
    st.data(),
    NAMES,
    NAMES,
    st.sampled_from([(1, 1, 0), (0, 0, 1), (1, 1, 1), (1, 0, 1), (0, 0, 0)]),
    st.booleans(),
)
def test_messages_of_any_layout_are_read(
    data: st.DataObject,
    expected_names: list[str],
    other_names: list[str],
    present: tuple[int, int, int],
    effort: bool,
) -> None:
    """Messages of the expected and any other layout are read as the generated class wrote them."""
    names = data.draw(st.sampled_from([expected_names, other_names]))
    q, v, u = (
        values if included else []
        for values, included in zip(vectors(data, names, 3), present, strict=True)
    )
    header = Header(
        stamp=Time(sec=7, nanosec=8), frame_id=data.draw(st.sampled_from(["", "world"]))
    )
    message = JointState(header=header, name=names, position=q, velocity=v, effort=u)
    decoded = JointStateCodec(expected_names, EFFORT if effort else STATE).decode(
        serialize_message(message)
    )
    assert (decoded.stamp, decoded.names) == (7_000_000_008, names)
    assert [list(field) for field in decoded[2:]] == [q, v, u]


class Received:
    """A node, whose warnings it keeps, and a recorder of the states and efforts of a decoder."""

    def __init__(self) -> None:
        self.warnings: list[str] = []
        self.taken: list[tuple[Any, ...]] = []
        self.add_state = self.add_true_state = self.add_effort = lambda *content: self.taken.append(
            content
        )

    def get_logger(self) -> Any:
        """Return what logs warnings."""
        return SimpleNamespace(warning=lambda line, **_: self.warnings.append(line))


@pytest.mark.parametrize(("positions", "velocities"), [(6, 0), (1, 6), (6, 7), (0, 0)])
@pytest.mark.parametrize("order", [1, -1])
def test_states_that_lack_numbers_are_ignored(positions: int, velocities: int, order: int) -> None:
    """A state without one number per joint in its fields reaches no law and no recording.

    A law's node warns.
    """
    received: Any = Received()
    names = list(SCENE.joint_names)[::order]
    message = JointState(name=names, position=[0.1] * positions, velocity=[0.2] * velocities)
    assert StateReader(received, SCENE).read(serialize_message(message)) is None
    assert f"{positions} positions and {velocities} velocities" in received.warnings[0]
    callbacks = MessageDecoder(SCENE, received).callbacks()
    for topic in ("joint_states", "true_states", "applied_effort"):
        callbacks[topic](serialize_message(message))
    assert not received.taken


def test_recorded_states_are_in_the_order_of_the_scene() -> None:
    """A recorder sorts states and efforts of joints in another order, as laws get them."""
    received: Any = Received()
    numbers = [float(i) for i in range(6)]
    message = JointState(name=list(SCENE.joint_names)[::-1], position=numbers, velocity=numbers)
    callbacks = MessageDecoder(SCENE, received).callbacks()
    callbacks["joint_states"](serialize_message(message))
    callbacks["applied_effort"](
        serialize_message(JointState(name=SCENE.actuated[::-1], effort=numbers[:4]))
    )
    assert received.taken == [
        (0, tuple(numbers[::-1]), tuple(numbers[::-1])),
        (0, tuple(numbers[3::-1])),
    ]


@pytest.mark.parametrize("numbers", [(math.nan,) * 6, (0.0, math.inf, 0.0, 0.0, 0.0, 0.0)])
@pytest.mark.parametrize("seconds", [1, -1, -(2**31)])
def test_fields_out_of_range_are_ignored(numbers: tuple[float, ...], seconds: int) -> None:
    """Non-finite numbers and stamps before zero reach no law or recording; the warning says so."""
    received: Any = Received()
    good = (0.1,) * 6
    for position, velocity in ((numbers, good), (good, numbers), (good, good)):
        message = JointState(
            name=list(SCENE.joint_names), position=position, velocity=velocity, effort=good
        )
        message.header.stamp.sec = seconds
        data, fits = serialize_message(message), position is velocity and seconds > 0
        assert (StateReader(received, SCENE).read(data) is not None) == fits
        cause = (
            "not finite: ["
            if seconds > 0
            else f"with the stamp {seconds}000000000 ns, which is before zero:"
        )
        assert [cause in line for line in received.warnings] == [True] * (not fits)
        received.warnings.clear()
        received.taken.clear()
        for topic in ("joint_states", "true_states"):
            MessageDecoder(SCENE, received).callbacks()[topic](data)
        assert len(received.taken) == 2 * fits
    effort = JointState(name=SCENE.actuated, effort=numbers[:4])
    received.taken.clear()
    MessageDecoder(SCENE, received).callbacks()["applied_effort"](serialize_message(effort))
    assert not received.taken


@pytest.mark.parametrize("fields", [EFFORT, STATE])
def test_a_second_has_less_than_1e9_nanoseconds(fields: tuple[str, ...]) -> None:
    """A stamp with more of them is none, in a message of the expected layout and in any other."""
    codec = JointStateCodec(["slew"], fields)
    message = JointState(name=["slew"], effort=[0.0])
    message.header.stamp.nanosec = 10**9
    with pytest.raises(MalformedMessage, match="1000000000 ns"):
        codec.decode(serialize_message(message))
    stamp: Any = message.header.stamp
    for stamp.sec, stamp.nanosec in ((0, 10**9), (-1, 0)):
        with pytest.raises(MalformedMessage):
            nanoseconds(stamp)
        assert not has_stamp(serialize_message(message))


def test_not_a_number_survives() -> None:
    """NaN is decoded unchanged: validation rejects it later, and counts it."""
    codec = JointStateCodec(["slew"], EFFORT)
    assert math.isnan(codec.decode(codec.encode(1, [math.nan])).effort[0])
