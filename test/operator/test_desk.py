"""The operator's desk: levers' speeds, dead man's switch, zero position, stop, loss of device."""

import pytest

from crane_sim.hardware.reference_profiles import Bounds
from crane_sim.hardware.soft_limits import ReferenceMotion, follow
from crane_sim.operator.desk import Desk, DrivenJoint, Mode, SoftLimits
from crane_sim.operator.inputs import Demand

JOINTS = (
    DrivenJoint("slew", "rad", Bounds(0.3, 0.1, 0.4)),
    DrivenJoint("rope", "m", Bounds(0.7, 0.5, 2.0)),
)
TIMEOUT = 0.5
REST, LEVERS = (0.0, 0.0), (0.3, -0.9)
SPEEDS = (0.3 * 0.3, -0.9 * 0.7)


FULL, NONE = SPEEDS, REST
# levers are out, the dead man's switch held or open
ON, OFF = Demand(LEVERS, True), Demand(LEVERS, False)
RESTING, OPEN = Demand(REST, True), Demand(REST, False)


def desk_at_zero(assisted: bool = False) -> Desk:
    """Return a desk with a heartbeat at 0 s."""
    desk = Desk(JOINTS, TIMEOUT, assisted)
    desk.heartbeat(0.0)
    return desk


SCENARIOS: dict[str, list[tuple[Demand | str, float, tuple[float, ...], Mode]]] = {
    "nothing moves unless the switch is held, and with it again the levers count at once": [
        (OFF, 0.1, NONE, Mode.OPEN),
        (ON, 0.2, FULL, Mode.MOVING),
    ],
    "a lost device stops, and levers are to rest when it is back": [
        (ON, TIMEOUT, FULL, Mode.MOVING),
        (ON, TIMEOUT + 0.001, NONE, Mode.DEVICE_LOST),
        ("heartbeat", 1.0, NONE, Mode.DEVICE_LOST),
        (ON, 1.0, NONE, Mode.INTERLOCKED),
        (RESTING, 1.1, NONE, Mode.MOVING),
        (ON, 1.2, FULL, Mode.MOVING),
    ],
    "a loss that the device reports does not wait for the time-out": [
        ("lose", 0.0, NONE, Mode.MOVING),
        (ON, 0.0, NONE, Mode.DEVICE_LOST),
    ],
    "a stop is latched: no lever, switch or loss ends it, and it outweighs a release": [
        (ON._replace(stop=True), 0.1, NONE, Mode.STOPPED),
        *((demand, 0.2, NONE, Mode.STOPPED) for demand in (ON, RESTING, OPEN)),
        ("lose", 0.2, NONE, Mode.STOPPED),
        (OPEN, 0.2, NONE, Mode.STOPPED),
        ("heartbeat", 0.2, NONE, Mode.STOPPED),
        (OPEN._replace(stop=True, release=True), 0.2, NONE, Mode.STOPPED),
    ],
    "a release counts only with the switch open and all levers at rest, and nothing moves by it": [
        (OPEN._replace(stop=True), 0.1, NONE, Mode.STOPPED),
        (RESTING._replace(release=True), 0.1, NONE, Mode.STOPPED),
        (OFF._replace(release=True), 0.1, NONE, Mode.STOPPED),
        (OPEN._replace(release=True), 0.1, NONE, Mode.OPEN),
        (ON, 0.2, FULL, Mode.MOVING),
    ],
}


@pytest.mark.parametrize("name", SCENARIOS)
def test_interlocks(name: str) -> None:
    """A desk that lets speeds through takes demands: each has its speeds and its mode."""
    desk = desk_at_zero()
    desk.take(OPEN, 0.0)
    assert desk.take(ON, 0.0) == FULL and desk.mode == Mode.MOVING
    for action, now, speeds, mode in SCENARIOS[name]:
        if action == "heartbeat":
            desk.heartbeat(now)
        elif action == "lose":
            desk.lose()
        else:
            assert isinstance(action, Demand) and desk.take(action, now) == speeds
        assert desk.mode == mode


def test_levers_begin_at_rest() -> None:
    """A lever out of its rest when the desk begins moves nothing until all have been at rest."""
    desk = desk_at_zero()
    assert desk.take(ON, 0.0) == NONE and desk.mode == Mode.INTERLOCKED
    assert desk.take(Demand((0.3, 0.0), True), 0.1) == desk.take(RESTING, 0.2) == NONE
    for part in (
        1.0,
        -1.0,
        0.1,
        1.0 / 3.0,
        -0.7,
    ):  # the lever's part of the largest speed, to the last bit
        assert desk.take(Demand((part, 0.0), True), 0.3) == (part * 0.3, 0.0)


def test_brakes_stay_on_until_a_lever_moves() -> None:
    """After the release of an emergency stop only a lever that counts opens the brakes."""
    desk = desk_at_zero()
    desk.take(OPEN, 0.0)
    steps = [(ON, False), (ON._replace(stop=True), True), (OPEN._replace(release=True), True)]
    steps += [(OPEN, True), (RESTING, True), (OFF, True), (ON, False), (OPEN, False)]
    for k, (demand, braked) in enumerate(steps):
        desk.take(demand, 0.05 * k)
        assert desk.braked == braked, k


def test_a_dragged_joint_is_named() -> None:
    """A velocity far from its drive's reference is named, one on a ramp or behind a lag is not."""
    limits = SoftLimits((JOINTS[0], JOINTS[1]._replace(lag=0.2)), 0.01)
    for _ in range(600):  # 6 s: both ramps are over
        limits.take((0.3, 0.7), (0.0, 0.0), (0.3, 0.7))
    # speed / 4 + lag × acceleration: 0.075 rad/s, 0.275 m/s
    assert limits.dragged((0.37, 0.7 - 0.27)) == []
    assert limits.dragged((0.38, 0.7)) == ["slew"] and limits.dragged((0.3, 0.7 - 0.28)) == ["rope"]
    limits.reset()
    assert limits.dragged((0.0, 0.3)) == ["rope"] and limits.dragged((0.0, 0.2)) == []


def test_assistance_is_switched_once_a_press() -> None:
    """Assistance changes when its button is pressed, not held, and may be on from the start."""
    desk = desk_at_zero(assisted=True)
    seen = []
    for pressed in (False, True, True, False, True, False):
        desk.take(Demand(LEVERS, True, assistance=pressed), 0.1)
        seen.append(desk.assisted)
    assert seen == [True, False, False, False, True, True]


@pytest.mark.parametrize(
    ("lag", "delay"), [(0.0, 0.0), (0.2, 0.0), (1.0, 0.0), (0.0, 0.5), (0.2, 0.5)]
)
def test_a_drive_with_lag_stops_before_the_soft_limit(lag: float, delay: float) -> None:
    """A lever held towards a soft limit stops the joint there, also behind a delay and a lag."""
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
