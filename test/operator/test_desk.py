"""The operator's desk: the speeds of levers, dead man's switch, zero position, emergency stop, loss of the device."""

import pytest

from crane_sim.hardware.reference_profiles import Bounds
from crane_sim.hardware.soft_limits import ReferenceMotion, follow
from crane_sim.operator.desk import Desk, DrivenJoint, Mode, SoftLimits
from crane_sim.operator.inputs import Demand

JOINTS = (DrivenJoint("slew", "rad", Bounds(0.3, 0.1, 0.4)), DrivenJoint("rope", "m", Bounds(0.7, 0.5, 2.0)))
TIMEOUT = 0.5
REST, LEVERS = (0.0, 0.0), (0.3, -0.9)
SPEEDS = (0.3 * 0.3, -0.9 * 0.7)


def moving_desk(assisted: bool = False) -> Desk:
    """Return a desk that lets speeds through at 0 s."""
    desk = Desk(JOINTS, TIMEOUT, assisted)
    desk.heartbeat(0.0)
    desk.take(Demand(REST, False), 0.0)
    assert desk.take(Demand(LEVERS, True), 0.0) == SPEEDS and desk.mode == Mode.MOVING
    return desk


def test_speeds_are_exact() -> None:
    """A speed is the lever's part times the joint's largest speed, to the last bit."""
    desk = moving_desk()
    for part in (1.0, -1.0, 0.1, 1.0 / 3.0, -0.7):
        assert desk.take(Demand((part, 0.0), True), 0.1) == (part * 0.3, 0.0)


def test_nothing_moves_unless_the_switch_is_held() -> None:
    """Without the dead man's switch every speed is zero, and with it again the levers count at once."""
    desk = moving_desk()
    assert desk.take(Demand(LEVERS, False), 0.1) == REST and desk.mode == Mode.OPEN
    assert desk.take(Demand(LEVERS, True), 0.2) == SPEEDS


def test_levers_begin_at_rest() -> None:
    """A lever that is out of its rest when the desk begins moves nothing until all levers have been at rest."""
    desk = Desk(JOINTS, TIMEOUT)
    desk.heartbeat(0.0)
    assert desk.take(Demand(LEVERS, True), 0.0) == REST and desk.mode == Mode.INTERLOCKED
    assert desk.take(Demand((0.3, 0.0), True), 0.1) == REST
    assert desk.take(Demand(REST, True), 0.2) == REST
    assert desk.take(Demand(LEVERS, True), 0.3) == SPEEDS


def test_a_lost_device_stops() -> None:
    """Without a heartbeat for longer than the time-out, speeds are zero; back again, levers are to rest first."""
    desk = moving_desk()
    assert desk.take(Demand(LEVERS, True), TIMEOUT) == SPEEDS
    assert desk.take(Demand(LEVERS, True), TIMEOUT + 0.001) == REST and desk.mode == Mode.DEVICE_LOST
    desk.heartbeat(1.0)
    assert desk.take(Demand(LEVERS, True), 1.0) == REST and desk.mode == Mode.INTERLOCKED
    desk.take(Demand(REST, True), 1.1)
    assert desk.take(Demand(LEVERS, True), 1.2) == SPEEDS


def test_a_device_that_is_gone_stops_at_once() -> None:
    """A loss that the device reports does not wait for the time-out."""
    desk = moving_desk()
    desk.lose()
    assert desk.take(Demand(LEVERS, True), 0.0) == REST and desk.mode == Mode.DEVICE_LOST


def test_the_stop_is_latched() -> None:
    """An emergency stop lasts after its button; no lever, switch or loss ends it, and stop outweighs release."""
    desk = moving_desk()
    assert desk.take(Demand(LEVERS, True, stop=True), 0.1) == REST and desk.stopped
    for demand in (Demand(LEVERS, True), Demand(REST, True), Demand(REST, False)):
        assert desk.take(demand, 0.2) == REST and desk.mode == Mode.STOPPED
    desk.lose()
    desk.take(Demand(REST, False), 0.2)
    desk.heartbeat(0.2)
    assert desk.take(Demand(REST, False, stop=True, release=True), 0.2) == REST and desk.stopped


def test_a_release_is_deliberate() -> None:
    """The release counts only with the switch open and all levers at rest; nothing moves by it."""
    desk = moving_desk()
    desk.take(Demand(REST, False, stop=True), 0.1)
    for demand in (Demand(REST, True, release=True), Demand(LEVERS, False, release=True)):
        desk.take(demand, 0.1)
        assert desk.stopped
    assert desk.take(Demand(REST, False, release=True), 0.1) == REST and not desk.stopped
    assert desk.take(Demand(LEVERS, True), 0.2) == SPEEDS


def test_brakes_stay_on_until_a_lever_moves() -> None:
    """After the release of an emergency stop the brakes act until a lever counts; nothing else opens them."""
    desk = moving_desk()
    assert not desk.braked
    desk.take(Demand(LEVERS, True, stop=True), 0.1)
    assert desk.braked
    desk.take(Demand(REST, False, release=True), 0.2)
    for demand in (Demand(REST, False), Demand(REST, True), Demand(LEVERS, False)):
        desk.take(demand, 0.3)
        assert desk.braked and not desk.stopped
    assert desk.take(Demand(LEVERS, True), 0.4) == SPEEDS and not desk.braked
    desk.take(Demand(REST, False), 0.5)
    assert not desk.braked


def test_a_dragged_joint_is_named() -> None:
    """A velocity that is far from the reference of its drive is named, one on a ramp or behind a lag is not."""
    limits = SoftLimits((JOINTS[0], JOINTS[1]._replace(lag=0.2)), 0.01)
    for _ in range(600):  # 6 s: both ramps are over
        limits.take((0.3, 0.7), (0.0, 0.0), (0.3, 0.7))
    assert limits.dragged((0.37, 0.7 - 0.27)) == []  # speed / 4 + lag × acceleration: 0.075 rad/s, 0.275 m/s
    assert limits.dragged((0.38, 0.7)) == ["slew"] and limits.dragged((0.3, 0.7 - 0.28)) == ["rope"]
    limits.reset()
    assert limits.dragged((0.0, 0.3)) == ["rope"] and limits.dragged((0.0, 0.2)) == []


def test_assistance_is_switched_once_a_press() -> None:
    """Assistance changes when its button is pressed, not while it is held, and may be on from the start."""
    desk = moving_desk(assisted=True)
    seen = []
    for pressed in (False, True, True, False, True, False):
        desk.take(Demand(LEVERS, True, assistance=pressed), 0.1)
        seen.append(desk.assisted)
    assert seen == [True, False, False, False, True, True]


@pytest.mark.parametrize(("lag", "delay"), [(0.0, 0.0), (0.2, 0.0), (1.0, 0.0), (0.0, 0.5), (0.2, 0.5)])
def test_a_drive_with_lag_stops_before_the_soft_limit(lag: float, delay: float) -> None:
    """A lever that is held towards a soft limit stops the joint there, also behind a delay and a lag."""
    period, low, q, v, reference = 0.01, 0.0, 5.0, 0.0, ReferenceMotion(0.0, 0.0, 0.0)
    joint = JOINTS[1]._replace(low=low, high=6.88, lag=lag + delay)
    limits, queue = SoftLimits((joint,), period), [0.0] * round(delay / period)
    for _ in range(2000):
        (speed,) = limits.take((joint.bounds.speed,), (q,), (v,))
        reference = follow(reference, speed, joint.bounds, period)
        queue.append(reference.velocity)
        v += (queue.pop(0) - v) * (period / (lag + period))
        q += v * period
        assert q < joint.high + 0.005  # m: what 0.7 m/s takes in a period
    assert q > joint.high - 0.1  # it did get there
