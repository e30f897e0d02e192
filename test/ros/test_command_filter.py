"""Validation of commands, and the bounds on their efforts."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crane_sim import load_scene
from crane_sim.ros.common.command_filter import CommandValidator, largest_efforts
from crane_sim.ros.common.command_stamps import StampRange, lockstep_range, realtime_range
from crane_sim.ros.common.serialization import EFFORT, JointStateCodec, decode_array

JOINTS = ["slew", "boom", "jib", "rope"]
EFFORTS = [1.0, 2.0, 3.0, 4.0]
LARGEST = [1e9, 1e9, 1e9, 50.0]
NOW = 50_000_000  # ns


def validate(
    validator: CommandValidator,
    stamp: int = NOW,
    names: list[str] = JOINTS,
    efforts: list[float] = EFFORTS,
):
    """Validate one command as in lockstep."""
    return validator.validate(stamp, names, efforts, StampRange(NOW, NOW))


@given(st.permutations(range(4)))
def test_joints_are_matched_by_name(order: list[int]) -> None:
    """In any order of its joints, a command reaches each joint with the effort meant for it."""
    names, efforts = [JOINTS[i] for i in order], [EFFORTS[i] for i in order]
    assert validate(CommandValidator(JOINTS, LARGEST), names=names, efforts=efforts) == tuple(
        EFFORTS
    )


NAMED = [*JOINTS, "swing"]  # a joint that nothing drives, too


@pytest.mark.parametrize(
    ("names", "efforts", "line"),
    [
        (NAMED, [*EFFORTS, 0.0], ""),
        (NAMED, [*EFFORTS, math.nan], ""),
        (["swing", *JOINTS], EFFORTS, ""),
        ([*JOINTS[2:], "swing", *JOINTS[:2]], [*EFFORTS[2:], *EFFORTS[:2]], ""),
        (NAMED, [*EFFORTS, 5.0], "effort 5.0 on swing"),
        ([*JOINTS, "hook"], [*EFFORTS, 0.0], "the actuated ones are"),
        ([*NAMED, "swing"], EFFORTS, "the actuated ones are"),
        ([*JOINTS[:3], "swing"], EFFORTS, "the actuated ones are"),
    ],
)
def test_passive_joints_may_be_named(names: list[str], efforts: list[float], line: str) -> None:
    """A command may name undriven joints without effort, with zero or NaN; others are refused."""
    validator = CommandValidator(JOINTS, LARGEST, NAMED)
    assert validate(validator, names=names, efforts=efforts) == (None if line else tuple(EFFORTS))
    assert line in validator.last_refusal and validator.last_refusal.endswith(
        "(names)" if line else ""
    )


def test_stamps_of_two_clocks() -> None:
    """In real time by ROS time stamps are of simulated time or the wall clock.

    Each must be within its time-out.
    """
    second, wall, state = 10**9, 17 * 10**17, 50 * 10**9
    timeouts = (second, second)

    def is_possible(stamp: int) -> bool:
        span = realtime_range("ros", stamp, state, wall, timeouts)
        return span is not None and span.oldest <= stamp <= span.newest

    assert (
        is_possible(state) and is_possible(state - second) and not is_possible(state - second - 1)
    )
    assert not is_possible(state + 1) and is_possible(wall - second) and is_possible(wall + second)
    assert not is_possible(wall - second - 1) and not is_possible(wall + second + 1)


def test_the_clock_leads_by_one_period() -> None:
    """In lockstep by ROS time the answer to state k has a stamp behind it, up to state k + 1."""
    possible = lockstep_range("ros", NOW, 10)
    validator = CommandValidator(JOINTS, LARGEST)
    assert validator.validate(NOW, JOINTS, EFFORTS, possible) is None
    assert validator.validate(NOW + 11, JOINTS, EFFORTS, possible) is None
    assert validator.validate(NOW + 10, JOINTS, EFFORTS, possible) == tuple(EFFORTS)
    assert lockstep_range("any", NOW, 10) is None and lockstep_range(
        "state", NOW, 10
    ) == StampRange(NOW, NOW)


@pytest.mark.parametrize(
    ("reason", "bad"),
    [
        ("not finite", {"efforts": [1.0, math.nan, 3.0, 4.0]}),
        ("not finite", {"efforts": [1.0, 2.0, -math.inf, 4.0]}),
        ("length", {"efforts": EFFORTS[:3]}),
        ("length", {"efforts": [*EFFORTS, 5.0]}),
        ("length", {"efforts": []}),
        ("length", {"names": JOINTS[::-1], "efforts": EFFORTS[:3]}),
        ("huge", {"efforts": [1.0, 2.0, 1e308, 4.0]}),
        ("huge", {"efforts": [1.0, 2.0, -1.1e9, 4.0]}),
        ("huge", {"efforts": [1.0, 2.0, 3.0, 51.0]}),
        ("huge", {"names": JOINTS[::-1], "efforts": [-51.0, 3.0, 2.0, 1.0]}),
        ("names", {"names": JOINTS[:3], "efforts": EFFORTS[:3]}),
        ("names", {"names": [*JOINTS, "swing_radial"], "efforts": [*EFFORTS, 0.0]}),
        ("names", {"names": ["slew", "boom", "jib", "jib"]}),
        ("names", {"names": ["slew", "boom", "jib", "hoist"]}),
        ("names", {"names": []}),
        ("future", {"stamp": NOW + 1}),
        ("unstamped", {"stamp": 0}),
    ],
)
def test_a_mistaken_command_is_rejected(reason: str, bad: dict) -> None:
    """A wrong command is refused for the reason that it is wrong, and counts as rejected."""
    validator = CommandValidator(JOINTS, LARGEST)
    assert validate(validator, **bad) is None
    assert validator.refused == {reason: 1}
    assert validator.last_refusal.endswith(f"({reason})")
    assert validator.summary() == {"received": 1, "rejected": 1, "late": 0, "duplicate": 0}
    assert validate(validator) == tuple(EFFORTS)  # the right command with the same stamp


def test_an_answer_counts_once() -> None:
    """The same answer again is a duplicate, an earlier one is late; neither moves the crane."""
    validator = CommandValidator(JOINTS, LARGEST)
    assert validate(validator) == tuple(EFFORTS)
    assert validate(validator) is None
    assert validate(validator, stamp=NOW - 1) is None
    assert validator.refused == {"duplicate": 1, "late": 1}
    assert validate(validator, stamp=0) is None  # neither early nor late
    assert validator.refused["unstamped"] == 1
    assert validator.summary() == {"received": 4, "rejected": 1, "late": 1, "duplicate": 1}


def test_lockstep_requires_the_exact_stamp_and_realtime_a_recent_one() -> None:
    """A command older than `oldest` is stale.

    In lockstep that is any but the newest, in real time one beyond the time-out.
    """
    assert validate(CommandValidator(JOINTS, LARGEST), stamp=NOW - 1) is None
    validator = CommandValidator(JOINTS, LARGEST)
    assert validator.validate(NOW - 10, JOINTS, EFFORTS, StampRange(NOW - 10, NOW)) == tuple(
        EFFORTS
    )
    validator = CommandValidator(JOINTS, LARGEST)
    assert validator.validate(NOW - 11, JOINTS, EFFORTS, StampRange(NOW - 10, NOW)) is None
    assert validator.refused == {"stale": 1}
    assert validator.summary()["late"] == 1


@given(st.binary(max_size=400))
def test_garbage_is_refused(data: bytes) -> None:
    """Bytes that are no message are counted as unreadable, and have no other effect."""
    validator = CommandValidator(JOINTS, LARGEST)
    for decode in (JointStateCodec(JOINTS, EFFORT).decode, decode_array):
        validator.decode(decode, data)
        validator.decode(decode, b"\x00\x01\x00\x00" + data)
    assert set(validator.refused) <= {"unreadable"}


@given(st.data(), st.integers(0, 200), st.integers(1, 60))
def test_a_damaged_command_is_accepted_or_refused(
    data: st.DataObject, at: int, length: int
) -> None:
    """A command of damaged bytes is accepted with finite efforts, or refused under a reason.

    Bytes are overwritten or cut off.
    """
    validator, codec = CommandValidator(JOINTS, LARGEST), JointStateCodec(JOINTS, EFFORT)
    whole = codec.encode(NOW, EFFORTS)
    noise = data.draw(st.binary(min_size=length, max_size=length))
    for message in (whole[:at] + noise + whole[at + length :], whole[:at]):
        frame = validator.decode(codec.decode, message)
        efforts = (
            validate(validator, frame.stamp, frame.names, list(frame.effort)) if frame else None
        )
        assert efforts is None or all(map(math.isfinite, efforts))
    # the second is cut off, or the first one again
    assert validator.received == 2 and validator.refused.total() >= 1


def test_inertia_and_gravity_of_the_scene_bound_efforts() -> None:
    """The bound of the rope, which lifts the payload alone, is that of mass and weight.

    Those of imposed motions differ.
    """
    scene = load_scene("knuckle_setpoint", {"payload.mass": 2.5})
    by_joint = dict(zip(scene.actuated, largest_efforts(scene), strict=True))
    expected = 2.5 * 1e5 + 2.5 * scene.document.get("gravity", 9.81) * 1e3
    assert by_joint["rope"] == pytest.approx(expected, rel=1e-6)  # the potential is linear
    assert set(largest_efforts(load_scene("offshore_resonant"))) == {1e5}
    assert largest_efforts(scene, 7.0) == (7.0,) * 4
    assert largest_efforts(load_scene("overhead_sway")) == ()  # it has no actuated joint


def test_refusals_of_every_command_are_described() -> None:
    """A line on commands of which none was accepted has the last one and the option that helps.

    The option is there where stamps are the reason.
    """
    validator = CommandValidator(["slew"], [1.0])
    assert validator.describe_refusals() == ""
    for k in range(1, 4):
        validator.validate(k * 10**18, ["slew"], [0.0], StampRange(1, 2))
    line = validator.describe_refusals()
    assert line.startswith(
        "all 3 commands so far were refused, the last one: command with stamp 3000000000000000000 "
        "ns"
    )
    assert "--command-stamps ros" in line
    validator.validate(2, ["slew"], [0.0], StampRange(1, 2))
    assert validator.describe_refusals() == ""
    other = CommandValidator(["slew"], [1.0])
    other.validate(1, ["boom"], [0.0], StampRange(1, 2))
    assert (
        "the actuated ones are" in other.describe_refusals()
        and "--command-stamps" not in other.describe_refusals()
    )
