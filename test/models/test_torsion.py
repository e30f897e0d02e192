"""Torsion of the rope: virtual work of its twist, and closed forms of a load that turns.

The twist is in rotation matrices.
"""

from math import asin, pi, sqrt
from typing import Any

import numpy as np
import pytest
from point_masses import DIGITS, STEP, Extras, accelerations, mp, mpf, mpmath, rotate
from test_suspended import (
    LENGTHS,
    MASSES,
    START,
    SUPPORTS,
    base,
    body,
    crane_places,
    direction,
    mapped,
    turn,
)

import crane_sim
from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.support import Support
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.suspended.torsion import Torsion

STIFFNESS, DAMPING = 40.0, 7.0  # N m/rad, N m s/rad


def matrix(columns: Any) -> Any:
    """Return the matrix (3, 3) with these columns."""
    return mpmath.matrix([list(column) for column in columns]).T


def bend_matrix(a: Any, b: Any) -> Any:
    """Return the rotation about a × b that takes the unit vector a to b (Rodrigues)."""
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    skew = mpmath.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return mpmath.eye(3) + skew + skew * skew / (1 + mpmath.fdot(a, b))


def twist(name: str, q: Any) -> Any:
    """Return the angle of the load about its vertical from the tip's frame down the links."""
    ns = len(START[name])
    axes = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    frame = matrix([rotate(2, q[0], tuple(map(mpf, axis))) for axis in axes])
    load = matrix([turn(q[ns + 7 :], tuple(map(mpf, axis))) for axis in axes])
    path = [
        (mpf(0), mpf(0), mpf(-1)),
        *(direction(q[ns + 1 + 2 * k : ns + 3 + 2 * k]) for k in range(3)),
    ]
    for a, b in zip(path, [*path[1:], tuple(-load[i, 2] for i in range(3))], strict=True):
        frame = bend_matrix(a, b) * frame
    turned = frame.T * load
    return mpmath.atan2(turned[1, 0], turned[0, 0])


def gradient(name: str, q: Any) -> Any:
    """Return the derivatives of the twist by all coordinates."""
    moved = [
        [[a + s * STEP * (i == k) for k, a in enumerate(q)] for s in (1, -1)] for i in range(len(q))
    ]
    return [(twist(name, up) - twist(name, down)) / (2 * STEP) for up, down in moved]


@pytest.mark.parametrize(("name", "sea"), [("tower", False), ("mobile", True)])
def test_accelerations_are_those_of_virtual_work(name: str, sea: bool) -> None:
    """With torsion and damping, accelerations below three links agree with virtual work.

    The virtual work is that of the twist.
    """
    rng, ns, t = np.random.default_rng(5), len(START[name]), 1.3
    q = np.array([*START[name], LENGTHS[0], 0.7, 0.4, -1.1, 0.5, 2.0, 0.3, 0.9, -0.4, 0.8])
    v, added = rng.uniform(-0.6, 0.6, len(q)), np.zeros(len(q))
    added[ns] = 1.5
    efforts = np.concatenate([rng.uniform(-20.0, 20.0, ns), [-120.0], np.zeros(len(q) - ns - 1)])
    with mp.workdps(DIGITS):
        exact = [mpf(float(a)) for a in q]
        by_coordinate = np.array([float(a) for a in gradient(name, exact)])
        angle = float(twist(name, exact))
    damped = efforts - DAMPING * (by_coordinate @ v) * by_coordinate
    extras = Extras(added, lambda t, q: STIFFNESS * twist(name, q) ** 2 / 2)
    expected = accelerations(crane_places(name, True, sea), t, q, v, damped, extras)
    joints, rates, second = mapped(name, q, v, expected)
    cable = Chain(np.array(MASSES), np.array(LENGTHS))
    p = SuspendedCrane(
        Support(SUPPORTS[name]), cable, body(), ForceHoist(1.5), base=base() if sea else None
    )
    p = p._replace(torsion=Torsion(STIFFNESS, DAMPING))
    state = system.state(p, t, joints, rates)
    got = system.acceleration(p, t, state, tuple(map(float, efforts[: ns + 1])))
    # rounding, 60 terms
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-12 * max(1.0, abs(second).max()))
    for sign, turned in (
        (1.0, angle),
        (-1.0, angle - 2.0 * pi),
    ):  # the opposite quaternion: the rope has one turn more
        at = system.state(
            p, t, np.concatenate([joints[:-4], sign * joints[-4:]]), np.zeros(len(rates))
        )
        stored = system.potential(p, at) - system.potential(p._replace(torsion=None), at)
        assert stored == pytest.approx(0.5 * STIFFNESS * turned**2, rel=1e-12)


INERTIA, TWIST = 300.0, 75.0  # kg m², N m/rad: of 0.5 rad/s
SCENE: dict[str, Any] = {
    "crane": "bridge",
    "duration": 5.0,  # past the first turning point, after 3.1 s
    "trolley": {"mass": 500.0},
    "bridge": {"mass": 3000.0},
    "rope": {"drive": "locked", "torsion": {"stiffness": TWIST}},
    "links": [{"mass": 50.0, "length": 2.0}],
    "payload": {"mass": 1000.0, "inertia": [500.0, 400.0, INERTIA], "attachment": [0.0, 0.0, 1.0]},
    "initial": {"q": [0.0, 0.0, 5.0, 0.0, 0.0], "rigging": {"angular_velocity": [0.0, 0.0, 2.9]}},
    "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-12},
}


@pytest.mark.long
def test_a_load_that_turns_and_swings() -> None:
    """A load turns to and fro by 332 degrees at √(k/I), damped as in closed form.

    With swing the energy balance still closes.
    """
    omega, rate, damping = sqrt(TWIST / INERTIA), 2.9, 15.0
    run = crane_sim.simulate(SCENE)
    yaw = 2.0 * np.arctan2(run.q[:, 11], run.q[:, 8])
    np.testing.assert_allclose(
        yaw, rate / omega * np.sin(omega * run.t), rtol=0.0, atol=1e-9 * rate / omega
    )
    decay = damping / (2.0 * INERTIA)
    slower = sqrt(omega**2 - decay**2)
    run = crane_sim.simulate(SCENE, overrides={"rope.torsion.damping": damping})
    yaw = 2.0 * np.arctan2(run.q[:, 11], run.q[:, 8])
    expected = rate / slower * np.exp(-decay * run.t) * np.sin(slower * run.t)
    np.testing.assert_allclose(yaw, expected, rtol=0.0, atol=1e-9 * rate / slower)
    start = {"initial.v": [0.3, -0.2, 0.0, 0.2, -0.3], "initial.q": [0.0, 0.0, 5.0, 0.3, -0.4]}
    run = crane_sim.simulate(SCENE, overrides={"rope.torsion.damping": damping, **start})
    assert run.summary["energy_audit_max"] < 1e-9


def test_a_run_ends_before_a_whole_turn() -> None:
    """A load that turns too fast ends the run at 6 rad, at the closed form's time.

    6 rad is the twist of the rope.
    """
    with pytest.raises(
        crane_sim.SimulationError, match="the rope is twisted by almost a turn"
    ) as error:
        crane_sim.simulate(SCENE, overrides={"initial.rigging.angular_velocity": [0.0, 0.0, 4.0]})
    omega = sqrt(TWIST / INERTIA)
    assert f"{asin(6.0 * omega / 4.0) / omega:.4g}"[:4] in str(error.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"payload": {"mass": 5.0}, "initial.rigging": None},
            "rope.torsion: belongs to a payload that is a body",
        ),
        ({"rope.torsion.stiffness": 0.0}, "rope.torsion.stiffness = 0.0: must be greater than 0"),
        (
            {"rope.torsion.damping": -1.0},
            "rope.torsion.damping = -1.0: must be greater than or equal to 0",
        ),
        (
            {"integrator": {"method": "rk4", "step": 9.0}},
            "integrator.step = 9: too large for the stiffest motion, 13.7",
        ),
    ],
    ids=lambda case: str(case)[:40],
)
def test_a_torsion_that_cannot_be_is_refused(changes: Any, message: str) -> None:
    """What has no body, no sense, or no step small enough is refused in one line with its key."""
    with pytest.raises(crane_sim.SceneError) as error:
        crane_sim.load_scene(SCENE, changes)
    assert message in str(error.value) and "\n" not in str(error.value)
