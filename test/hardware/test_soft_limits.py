"""Soft limits: under any levers a drive's reference stays in its travel and can use all of it."""

from math import inf

import numpy as np
import pytest

from crane_sim.hardware.reference_profiles import Bounds
from crane_sim.hardware.soft_limits import ReferenceMotion, follow, permitted_speed
from crane_sim.operator.desk import REACTION_TIME, DrivenJoint, SoftLimits

PERIOD = 0.01  # s
ROUNDING = 1e-9  # m, of positions of some metres that are summed over a thousand periods
RAMPS = [Bounds(0.9, 0.2, 0.8), Bounds(0.9, 0.2, inf), Bounds(3.0, 0.4, 0.4), Bounds(0.5, 5.0, inf)]


def reference_by_quadrature(
    motion: ReferenceMotion, command: float, bounds: Bounds, s: float, n: int = 20_000
) -> ReferenceMotion:
    """Return the motion after s seconds with the jerk chosen anew in each of n short steps."""
    x, v, a = motion
    dt = s / n
    for _ in range(n):
        # the speed if the acceleration faded from now on
        to_fade = v + a * abs(a) / (2.0 * bounds.jerk)
        jerk = bounds.jerk * np.sign(command - to_fade)
        a_new = min(max(a + jerk * dt, -bounds.acceleration), bounds.acceleration)
        x, v, a = x + v * dt + 0.5 * a * dt * dt, v + 0.5 * (a + a_new) * dt, a_new
    return ReferenceMotion(x, v, a)


@pytest.mark.parametrize("s", [0.2, 2.5])
@pytest.mark.parametrize(
    ("v", "a", "command"), [(0.0, 0.0, 0.8), (0.5, -0.1, 0.3), (-0.4, 0.15, 0.6), (0.6, 0.1, -0.5)]
)
def test_the_reference_in_closed_form(s: float, v: float, a: float, command: float) -> None:
    """The reference after a while is that of a bang-bang jerk.

    The steps of the second derivation err by their size.
    """
    bounds, start = RAMPS[0], ReferenceMotion(1.0, v, a)
    there, again = (
        follow(start, command, bounds, s),
        reference_by_quadrature(start, command, bounds, s),
    )
    # chatter of the acceleration: jerk × step × a few
    assert there == pytest.approx(again, abs=2e-3)


@pytest.mark.parametrize("bounds", RAMPS)
def test_a_joint_stops_at_its_end(bounds: Bounds) -> None:
    """A lever held forward leads the reference to rest at the end of its travel, not beyond."""
    motion = ReferenceMotion(0.0, 0.0, 0.0)
    for _ in range(4000):
        speed = permitted_speed(motion, bounds.speed, bounds, -inf, 5.0, REACTION_TIME)
        motion = follow(motion, speed, bounds, PERIOD)
        assert motion.position <= 5.0 + ROUNDING
    # the last millimetres are approached ever slower
    assert motion == pytest.approx((5.0, 0.0, 0.0), abs=1e-3)


def test_no_lever_leads_beyond() -> None:
    """Levers that jump at random never lead the reference out of its travel.

    Far from its ends they are exact.
    """
    random = np.random.default_rng(5)
    joint = DrivenJoint("trolley", "m", Bounds(0.9, 0.4, 1.6), -3.0, 3.0)
    limits, motion, commands = (
        SoftLimits([joint], PERIOD),
        ReferenceMotion(0.0, 0.0, 0.0),
        random.uniform(-0.9, 0.9, 200),
    )
    free = 0
    for k in range(6000):
        command = float(commands[k // 30] + 0.6 * (-1.0) ** (k // 1500))
        command = min(max(command, -0.9), 0.9)
        (speed,) = limits.take([command], [motion.position], [motion.velocity])
        motion = follow(motion, speed, joint.bounds, PERIOD)
        assert -3.0 - ROUNDING <= motion.position <= 3.0 + ROUNDING
        assert speed == command or limits.limited == ["trolley"]
        free += speed == command
        if abs(motion.position) < 1.0:
            # 1.7 m are more than the way to rest from 0.9 m/s, with the time ahead
            assert speed == command
    assert 1000 < free < 6000


def test_a_joint_beyond_its_end_may_return() -> None:
    """Outside of the travel a speed outwards is zero, and one inwards is exact."""
    bounds, beyond = RAMPS[0], ReferenceMotion(5.5, 0.0, 0.0)
    assert permitted_speed(beyond, 0.4, bounds, -inf, 5.0, REACTION_TIME) == 0.0
    assert permitted_speed(beyond, -0.4, bounds, -inf, 5.0, REACTION_TIME) == -0.4


def test_a_lag_counts() -> None:
    """A joint that lags its reference by T rests v T behind it, within the travel."""
    joint = DrivenJoint("rope", "m", Bounds(0.5, 0.5, inf), 1.0, 7.0, lag=0.3)
    limits, reference, q, v = SoftLimits([joint], PERIOD), ReferenceMotion(5.0, 0.0, 0.0), 5.0, 0.0
    for _ in range(2000):
        (speed,) = limits.take([0.5], [q], [v])
        for _ in range(10):  # v' = (reference's speed - v) / lag, by short steps
            reference = follow(reference, speed, joint.bounds, PERIOD / 10)
            q, v = q + v * PERIOD / 10, v + (reference.velocity - v) / joint.lag * PERIOD / 10
        assert q <= 7.0 + 1e-4  # error of the short steps
    assert 6.9 < q and abs(v) < 1e-3


def test_joints_without_travel_are_free() -> None:
    """A joint without ends keeps every speed up to its largest."""
    limits = SoftLimits([DrivenJoint("slew", "rad", Bounds(0.1, 0.05, 0.2))], PERIOD)
    assert limits.take([0.07], [1e3], [0.1]) == (0.07,) and limits.take([0.2], [0.0], [0.0]) == (
        0.1,
    )
    assert limits.limited == ["slew"]
