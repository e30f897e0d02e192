"""A cable of links with a point mass or a rigid body below every support, by virtual work.

The virtual work is that of point masses.
"""

from math import hypot
from typing import Any

import numpy as np
import pytest
from point_masses import (
    Extras,
    Point,
    accelerations,
    body_points,
    mp,
    mpf,
    mpmath,
    on_base,
    plus,
    ring_points,
    rod_points,
    rotate,
)

from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.cables.rope import ForceRope, LockedRope, MotionRope
from crane_sim.models.effects import LinearFriction, PayloadDrag, QuadraticFriction
from crane_sim.models.loads import PointLoad, RigidLoad
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.supports.driven_point import DrivenPoint, Lift, Servo
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import ForceHoist, MasslessHoist, MotionHoist
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.models.supports.support import Support
from crane_sim.models.supports.support_dynamics import constraint_effort as constraint_effort_of
from crane_sim.models.supports.telescopic_boom import (
    BaseSection,
    Superstructure,
    TelescopedSection,
    TelescopicBoom,
)
from crane_sim.models.supports.tower_crane import JibTrolley, Slew, TowerCrane
from crane_sim.models.suspended.crane import SuspendedCrane, solve_dynamics
from crane_sim.models.wind_load import Windage
from crane_sim.trajectories.base_motion import AXES, Base
from crane_sim.trajectories.wind import Wind

INERTIA = np.array([[3.0, 0.3, -0.2], [0.3, 4.0, 0.5], [-0.2, 0.5, 5.0]])
ATTACHMENT = (0.1, 0.2, 1.0)
SEA = {
    "surge": {"amplitude": 0.5, "frequency": 0.7},
    "heave": {"amplitude": 0.8, "frequency": 1.1, "phase": 0.4},
    "roll": {"amplitude": 0.2, "frequency": 0.9, "phase": 1.0},
    "pitch": {"amplitude": 0.15, "frequency": 1.3},
    "yaw": {"amplitude": 0.1, "frequency": 0.5, "phase": 2.0},
}
WIND, PRESSED, NO_GUSTS = (9.0, -4.0), (0.3, -0.2, 0.4), (None, None, None)
LENGTHS, MASSES = (2.5, 1.2, 0.8), (2.0, 1.5, 10.0)
SUPPORTS = {
    "tower": TowerCrane(Slew(50.0), JibTrolley(8.0)),
    "mobile": TelescopicBoom(
        Superstructure(30.0, (0.5, 1.2)),
        BaseSection(5.0, 2.0, 4.0),
        TelescopedSection(3.0, 1.5, 2.0),
    ),
    "knuckle": Knuckle(Rod(5.0, 2.0, 4.2, 0.0), Rod(4.0, 3.0, 4.0, 0.0), Tower(8.0)),
}
START = {"tower": (0.4, 6.0), "mobile": (0.4, 0.6, 7.0), "knuckle": (0.4, 0.6, -0.2)}


def body() -> RigidLoad:
    """Return the payload that is a rigid body."""
    inverse = np.linalg.inv(INERTIA)
    rows: Any = tuple(map(tuple, INERTIA.tolist())), tuple(map(tuple, inverse.tolist()))
    return RigidLoad(10.0, *rows, ATTACHMENT)


def base() -> Base:
    """Return the base that moves as SEA says."""
    keys = ("amplitude", "frequency", "phase")
    terms = np.array([[SEA.get(axis, {}).get(key, 0.0) for key in keys] for axis in AXES])
    return Base(np.zeros(6), *(np.ascontiguousarray(column[:, None]) for column in terms.T))


def radial(x: Any, z: Any) -> Point:
    """Return a point of the support's plane at yaw 0."""
    return x, mpf(0), z


def along(angle: Any, distance: Any) -> Point:
    """Return the point at a distance along a boom of this elevation."""
    return radial(distance * mpmath.cos(angle), distance * mpmath.sin(angle))


def tower_places(q: Any) -> tuple[list[tuple[Any, Point]], Point]:
    """Return (points, tip) of the tower crane at yaw 0, its ring apart."""
    trolley = radial(q[1], mpf(0))
    return [(mpf(8), trolley)], trolley


def mobile_places(q: Any) -> tuple[list[tuple[Any, Point]], Point]:
    """Return (points, tip) of the telescopic boom at yaw 0, its ring apart."""
    foot = radial(mpf("0.5"), mpf("1.2"))
    sections = [*rod_points(5.0, 4.0, mpf(2)), *rod_points(3.0, 2.0, q[2] - mpf("1.5"))]
    return [(m, plus(foot, along(q[1], s))) for m, s in sections], plus(foot, along(q[1], q[2]))


def knuckle_places(q: Any) -> tuple[list[tuple[Any, Point]], Point]:
    """Return (points, tip) of the knuckle boom at yaw 0, its ring apart."""
    elbow = along(q[1], mpf(5))
    points = [(m, along(q[1], s)) for m, s in rod_points(2.0, 4.2, mpf("2.5"))]
    points += [(m, plus(elbow, along(q[2], s))) for m, s in rod_points(3.0, 4.0, mpf(2))]
    return points, plus(elbow, along(q[2], mpf(4)))


PLACES = {
    "tower": (50.0, tower_places),
    "mobile": (30.0, mobile_places),
    "knuckle": (8.0, knuckle_places),
}


def support_places(name: str, q: Any) -> tuple[list[tuple[Any, Point]], Point]:
    """Return (points of the support, its tip), relative to the base."""
    inertia, places = PLACES[name]
    points, tip = places(q)
    return [*ring_points(inertia, q[0]), *((m, rotate(2, q[0], r)) for m, r in points)], rotate(
        2, q[0], tip
    )


def direction(angles: Any) -> Point:
    """Return the unit vector with azimuth and inclination from the downward vertical."""
    s = mpmath.sin(angles[1])
    return s * mpmath.cos(angles[0]), s * mpmath.sin(angles[0]), -mpmath.cos(angles[1])


def turn(angles: Any, r: Any) -> Point:
    """Return a vector of the body, turned by yaw, pitch and roll."""
    return rotate(2, angles[0], rotate(1, angles[1], rotate(0, angles[2], r)))


def attitude(angles: Any) -> list[Any]:
    """Return the quaternion of yaw, pitch and roll."""
    (sa, ca), (sb, cb), (sc, cc) = ((mpmath.sin(a / 2), mpmath.cos(a / 2)) for a in angles)
    first = [ca * cb * cc + sa * sb * sc, ca * cb * sc - sa * sb * cc, ca * sb * cc + sa * cb * sc]
    return [*first, sa * cb * cc - ca * sb * sc]


def crane_places(name: str, rigid: bool, sea: bool) -> Any:
    """Return the places of all points as a function of (t, coordinates).

    The coordinates are support, length, links' angles, attitude.
    """
    ns = len(START[name])
    shape = body_points(10.0, INERTIA) if rigid else []

    def places(t: Any, q: Any) -> list[tuple[Any, Point]]:
        points, node = support_places(name, q)
        for k in range(3):
            n, length = (
                direction(q[ns + 1 + 2 * k : ns + 3 + 2 * k]),
                q[ns] if k == 0 else mpf(LENGTHS[k]),
            )
            node = plus(node, tuple(length * a for a in n))
            if k < 2 or not rigid:
                points.append((mpf(MASSES[k]), node))
        if rigid:
            centre = plus(node, turn(q[ns + 7 :], tuple(-mpf(x) for x in ATTACHMENT)))
            points += [(m, plus(centre, turn(q[ns + 7 :], r))) for m, r in shape]
        return [(m, on_base(SEA, t, r)) for m, r in points] if sea else points

    return places


def pressure_point(t: Any, q: Any) -> Point:
    """Return the place in the world of the tower crane's load where the wind presses."""
    _, node = support_places("tower", q)
    for k in range(3):
        length = q[2] if k == 0 else mpf(LENGTHS[k])
        node = plus(node, tuple(length * a for a in direction(q[3 + 2 * k : 5 + 2 * k])))
    arm = tuple(mpf(p) - mpf(a) for p, a in zip(PRESSED, ATTACHMENT, strict=True))
    return on_base(SEA, t, plus(node, turn(q[9:], arm)))


def press(velocity: Any) -> Any:
    """Return the wind's force [N] on 3 m² with the coefficient 1.3, at a velocity [m/s]."""
    flow = [mpf(w) - v for w, v in zip((*WIND, 0.0), velocity, strict=True)]
    return [mpf(1.2) / 2 * mpf(1.3) * 3 * mpmath.norm(flow) * a for a in flow]


def joints_of(name: str, q: Any) -> Any:
    """Return the crane's joint coordinates of those of the reference, in multiple precision."""
    ns = len(START[name])
    n = direction(q[ns + 1 : ns + 3])
    x, y, z = rotate(2, -q[0], n)
    out = [*q[:ns], q[ns], mpmath.atan2(y, -z), mpmath.asin(x)]
    out += [*direction(q[ns + 3 : ns + 5]), *direction(q[ns + 5 : ns + 7])]
    if len(q) > ns + 7:
        out += attitude(q[ns + 7 :])
    return out


def mapped(name: str, q: Any, v: Any, a: Any) -> tuple[Any, Any, Any]:
    """Return the crane's joint coordinates with their first and second derivatives."""
    with mp.workdps(60):
        h, (q, v, a) = mpf(10) ** -18, ([mpf(float(x)) for x in row] for row in (q, v, a))
        low, middle, high = (
            joints_of(name, [x + s * y + s * s * z / 2 for x, y, z in zip(q, v, a, strict=True)])
            for s in (-h, 0, h)
        )
        first = [(x - y) / (2 * h) for x, y in zip(high, low, strict=True)]
        second = [(x - 2 * y + z) / h**2 for x, y, z in zip(high, middle, low, strict=True)]
        return tuple(np.array([float(x) for x in row]) for row in (middle, first, second))


@pytest.mark.parametrize("sea", [False, True], ids=["at rest", "at sea"])
@pytest.mark.parametrize("rigid", [False, True], ids=["point", "body"])
@pytest.mark.parametrize("name", SUPPORTS)
def test_accelerations_are_those_of_point_masses(name: str, rigid: bool, sea: bool) -> None:
    """All joint accelerations agree with virtual work of point masses, in any posture.

    This holds on a moving base, too.

    The tower crane at sea has a body in the wind, which presses beside its centre.
    """
    rng, ns, t = np.random.default_rng(5), len(START[name]), 1.3
    q = np.array(
        [
            *START[name],
            LENGTHS[0],
            0.7,
            0.4,
            -1.1,
            0.5,
            2.0,
            0.3,
            *([0.5, -0.4, 0.8] if rigid else []),
        ]
    )
    v = rng.uniform(-0.6, 0.6, len(q))
    drives = rng.uniform(-20.0, 20.0, ns)
    winch, added = -120.0, np.zeros(len(q))
    added[ns] = 1.5
    efforts = np.concatenate([drives, [winch], np.zeros(len(q) - ns - 1)])
    extras = (
        Extras(added, None, pressure_point, press)
        if rigid and sea and name == "tower"
        else Extras(added)
    )
    expected = accelerations(crane_places(name, rigid, sea), t, q, v, efforts, extras)
    load = body() if rigid else PointLoad(MASSES[-1])
    cable = Chain(np.array(MASSES), np.array(LENGTHS))
    crane = SuspendedCrane(
        Support(SUPPORTS[name]), cable, load, ForceHoist(1.5), base=base() if sea else None
    )
    if extras.pushed is not None:
        load = body()._replace(windage=Windage(3.0, 1.3), pressure_centre=PRESSED)
        steady = Wind(
            hypot(*WIND),
            10.0,
            None,
            (WIND[0] / hypot(*WIND), WIND[1] / hypot(*WIND)),
            0.0,
            1.2,
            NO_GUSTS,
        )
        crane = crane._replace(load=load, wind=steady)
    joints, rates, second = mapped(name, q, v, expected)
    state = system.state(crane, t, joints, rates)
    read = system.joints(crane, state)
    np.testing.assert_allclose(read[0], joints, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(read[1], rates, rtol=0.0, atol=1e-14)  # rounding of rates below 1
    got = system.acceleration(crane, t, state, (*map(float, drives), winch))
    # rounding, 50 terms
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-12 * max(1.0, abs(second).max()))


@pytest.mark.parametrize(
    "swing", [None, LinearFriction(3.0, 2.0), QuadraticFriction(3.0, 2.0)], ids=str
)
def test_one_link_and_a_point_mass_are_the_crane_with_one_rope(swing: Any) -> None:
    """Below a boom, both models have the same accelerations and tension.

    This holds by a winch's force and by imposed motion.
    """
    q, v = (0.3, 0.6, -0.2, 2.5, 0.4, -0.3), (0.2, -0.1, 0.3, 0.2, -0.5, 0.4)
    for rope, hoist, winch in (
        (ForceRope(), MasslessHoist(), -14.0),
        (MotionRope(0.4), MotionHoist(0.4), 0.3),
    ):
        simple = Crane(
            SUPPORTS["knuckle"], rope, PointLoad(1.4), drag=PayloadDrag(0.3), base=base()
        )
        simple = simple._replace(swing_friction=swing)
        cable = Chain(np.array([1.4]), np.array([2.5]))
        crane = SuspendedCrane(
            Support(simple.support), cable, simple.load, hoist, drag=simple.drag, base=simple.base
        )
        crane = crane._replace(swing_friction=swing)
        u, results = (3.0, 40.0, 15.0, winch), []
        for p in (simple, crane):
            x, tensions = system.state(p, 0.7, np.array(q), np.array(v)), np.empty((1, 1))
            system.tensions(p, 0.7, x, u, tensions, 0, 0)
            energies = system.kinetic(p, x), system.potential(p, x), *system.base_energy(p, 0.7, x)
            powers = (system.power(p, 0.7, x, u),)
            results.append(
                np.array([*system.acceleration(p, 0.7, x, u), tensions[0, 0], *energies, *powers])
            )
        # rounding of some 50 terms
        np.testing.assert_allclose(results[1], results[0], rtol=1e-12, atol=1e-12)


DRY = Friction(3.0, 5.0, 0.7)
STUCK = {
    "trolley": ("tower", (1,)),
    "boom": ("mobile", (1,)),
    "two": ("mobile", (0, 2)),
    "slew and boom": ("knuckle", (0, 1)),
}
MOTORS = (40.0, 7.0, 9.0)


@pytest.mark.parametrize(("case", "sea"), [(case, i % 2 == 0) for i, case in enumerate(STUCK)])
def test_joints_that_stick_are_constraints_of_virtual_work(case: str, sea: bool) -> None:
    """All accelerations are those of point masses, with friction and motors.

    Friction holds some joints; the others have motors and friction.

    The reference leaves the coordinates of the joints that stick out. What these hold is the effort
    that keeps them from accelerating where nothing holds them.
    """
    (name, held), t, rng = STUCK[case], 1.3, np.random.default_rng(8)
    ns = len(START[name])
    q = np.array([*START[name], LENGTHS[0], 0.7, 0.4, -1.1, 0.5, 2.0, 0.3])
    v = rng.uniform(-0.6, 0.6, len(q))
    v[list(held)] = 0.0
    drives, motors, winch = rng.uniform(-20.0, 20.0, ns), np.array(MOTORS[:ns]), -120.0
    slips = np.sign(v[:ns])
    free = [i for i in range(len(q)) if i not in held]
    efforts = np.array([*(drives - slips * 3.0 - 0.7 * v[:ns]), winch, *np.zeros(len(q) - ns - 1)])
    added = np.array([*motors, 1.5, *np.zeros(len(q) - ns - 1)])

    def places(t: Any, part: Any) -> Any:
        whole = [mpf(float(x)) for x in q]
        for i, x in zip(free, part, strict=True):
            whole[i] = x
        return crane_places(name, False, sea)(t, whole)

    expected = np.zeros(len(q))
    expected[free] = accelerations(places, t, q[free], v[free], efforts[free], Extras(added[free]))
    support = Support(SUPPORTS[name], tuple(motors.tolist()), (DRY,) * ns)
    cable, sea_base = Chain(np.array(MASSES), np.array(LENGTHS)), base() if sea else None
    crane = SuspendedCrane(support, cable, PointLoad(MASSES[-1]), ForceHoist(1.5), base=sea_base)
    joints, rates, second = mapped(name, q, v, expected)
    x, u = system.state(crane, t, joints, rates), (*map(float, drives), winch)
    assert list(x[-ns:]) == list(slips)
    got = system.acceleration(crane, t, x, u)
    # rounding, 50 terms
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-12 * max(1.0, abs(second).max()))
    assert not got[list(held)].any()
    loose, forces = (
        crane._replace(support=support._replace(frictions=None)),
        np.array([*efforts[:ns], winch]),
    )
    forces[list(held)] -= [constraint_effort(crane, t, x, u, i) for i in held]
    freed = system.acceleration(loose, t, x[:-ns], tuple(map(float, forces)))
    # as above
    np.testing.assert_allclose(freed, second, rtol=0.0, atol=1e-12 * max(1.0, abs(second).max()))


def constraint_effort(crane: SuspendedCrane, t: float, x: Any, u: Any, joint: int) -> float:
    """Return the effort that friction holds on a joint that sticks."""
    work = system.workspace(crane)
    solved = solve_dynamics(crane, t, x, u, work)
    moved = solved.support
    return float(constraint_effort_of(moved.dynamics, moved.net, moved.accelerations, joint))


def test_a_knuckle_boom_held_in_line_is_a_telescopic_boom() -> None:
    """Boom and jib that friction holds in line accelerate as a boom and telescope held so.

    The cranes are at sea.
    """
    q, v = [0.4, 2.5, 0.4, -0.3, 0.6, 0.0, -0.8], [0.3, 0.1, -0.5, 0.4, 0.0, 0.7, 0.0]
    bars = BaseSection(2.0, 2.5, 4.2), TelescopedSection(3.0, 2.0, 4.0)
    cases = {
        "knuckle": (SUPPORTS["knuckle"], [0.6, 0.6]),
        "mobile": (TelescopicBoom(Superstructure(8.0), *bars), [0.6, 9.0]),
    }
    cable, results = Chain(np.array([2.0, 14.0]), np.array([2.5, 1.2])), []
    for support, posture in cases.values():
        held = Support(support, None, (None, DRY, DRY))
        crane = SuspendedCrane(held, cable, PointLoad(14.0), ForceHoist(1.5), base=base())
        x = system.state(
            crane, 0.7, np.array([q[0], *posture, *q[1:]]), np.array([v[0], 0.0, 0.0, *v[1:]])
        )
        results.append(system.acceleration(crane, 0.7, x, (3.0, 0.0, 0.0, -110.0)))
    np.testing.assert_allclose(*results, rtol=0.0, atol=1e-12)  # rounding of some 50 terms


DRIVES = {"by acceleration": None, "by a servo": Servo(4.0, 3.0)}
MOVES = (0.3, -0.2, 0.25), (0.7, 1.1, -0.6)  # m/s, m/s², of a driven point


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("rigid", [False, True], ids=["point", "body"])
def test_cables_below_a_driven_point_are_those_of_point_masses(rigid: bool, drive: str) -> None:
    """Below a point moving on a moving base, three links and a load agree with virtual work.

    The accelerations are compared.

    The reference has the point's place as a function of time, with the velocity and acceleration of
    this instant.
    """
    rng, now, tip = np.random.default_rng(5), 1.3, (0.4, 6.0, 1.0)
    q = np.array([0.7, 0.4, -1.1, 0.5, 2.0, 0.3, *([0.5, -0.4, 0.8] if rigid else [])])
    v, shape = rng.uniform(-0.6, 0.6, len(q)), body_points(10.0, INERTIA) if rigid else []

    def places(t: Any, q: Any) -> list[tuple[Any, Point]]:
        s, points = t - mpf(now), []
        node = tuple(
            mpf(x) + s * mpf(u) + s * s / 2 * mpf(a) for x, u, a in zip(tip, *MOVES, strict=True)
        )
        for k in range(3):
            node = plus(node, tuple(mpf(LENGTHS[k]) * a for a in direction(q[2 * k : 2 * k + 2])))
            if k < 2 or not rigid:
                points.append((mpf(MASSES[k]), node))
        centre = plus(node, turn(q[6:], tuple(-mpf(x) for x in ATTACHMENT))) if rigid else node
        points += [(m, plus(centre, turn(q[6:], r))) for m, r in shape]
        return [(m, on_base(SEA, t, r)) for m, r in points]

    expected = accelerations(places, now, q, v, np.zeros(len(q)))
    joints, rates, second = directed(q, v, expected)
    servo = DRIVES[drive]
    u = [
        a if servo is None else x + (a + servo.kd * w) / servo.kp
        for x, w, a in zip(tip, *MOVES, strict=True)
    ]
    load = body() if rigid else PointLoad(MASSES[-1])
    cable = Chain(np.array(MASSES), np.array(LENGTHS))
    crane = SuspendedCrane(Support(DrivenPoint(servo, Lift())), cable, load, base=base())
    x = system.state(crane, now, np.array([*tip, *joints]), np.array([*MOVES[0], *rates]))
    got = system.acceleration(crane, now, x, (u[0], u[1], u[2]))
    bound = 1e-12 * max(1.0, abs(second).max())  # rounding, 50 terms
    np.testing.assert_allclose(got, [*MOVES[1], *second], rtol=0.0, atol=bound)


def directed(q: Any, v: Any, a: Any) -> Any:
    """Return unit vectors and quaternion of the reference's angles, with two derivatives."""
    with mp.workdps(60):
        h, (q, v, a) = mpf(10) ** -18, ([mpf(float(x)) for x in row] for row in (q, v, a))
        rows = []
        for s in (-h, 0, h):
            angles = [x + s * y + s * s * z / 2 for x, y, z in zip(q, v, a, strict=True)]
            links = [
                component for k in range(3) for component in direction(angles[2 * k : 2 * k + 2])
            ]
            rows.append([*links, *(attitude(angles[6:]) if len(angles) > 6 else [])])
        low, middle, high = rows
        first = [(x - y) / (2 * h) for x, y in zip(high, low, strict=True)]
        second = [(x - 2 * y + z) / h**2 for x, y, z in zip(high, middle, low, strict=True)]
        return tuple(np.array([float(x) for x in row]) for row in (middle, first, second))


def test_one_link_and_a_point_mass_below_a_driven_point_are_the_simple_pendulum() -> None:
    """Below a point that a servo drives at sea, both models agree.

    They have the same accelerations, tension, energies and power.
    """
    q, v = (0.3, 0.6, -0.2, 0.36, 0.48, -0.8), (0.2, -0.1, 0.3, 0.8, -0.6, 0.0)
    support, load, u, results = (
        DrivenPoint(Servo(4.0, 3.0), Lift()),
        PointLoad(1.4),
        (0.5, 0.2, 0.1),
        [],
    )
    cable = Chain(np.array([1.4]), np.array([2.5]))
    for p in (
        Crane(support, LockedRope(2.5), load, drag=PayloadDrag(0.3), base=base()),
        SuspendedCrane(Support(support), cable, load, drag=PayloadDrag(0.3), base=base()),
    ):
        x, tensions = system.state(p, 0.7, np.array(q), np.array(v)), np.empty((1, 1))
        system.tensions(p, 0.7, x, u, tensions, 0, 0)
        energies = system.kinetic(p, x), system.potential(p, x), *system.base_energy(p, 0.7, x)
        power = system.power(p, 0.7, x, u)
        results.append(
            np.array([*system.acceleration(p, 0.7, x, u), tensions[0, 0], *energies, power])
        )
    # rounding of some 50 terms
    np.testing.assert_allclose(results[1], results[0], rtol=1e-12, atol=1e-12)


def test_hook_and_load_below_a_driven_point_have_two_modes() -> None:
    """The frequencies of a hanging double pendulum are those of its characteristic equation.

    With R the ratio of load to hook: ω⁴ - g (1 + R)(1/a + 1/b) ω² + g² (1 + R) / (a b) = 0 for
    lengths a, b.
    """
    hook, load, a, b, g = 60.0, 180.0, 4.0, 1.5, 9.81
    p = SuspendedCrane(
        Support(DrivenPoint()), Chain(np.array([hook, load]), np.array([a, b])), PointLoad(load)
    )
    q = np.array([0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, -1.0])
    jacobian, _ = system.compute_jacobian(p, 0.0, system.state(p, 0.0, q, np.zeros(9)), (0.0, 0.0))
    stiffness = -jacobian[np.ix_([12, 15], [3, 6])]  # of the links along x; rates begin at 9
    half, product = (
        0.5 * g * (1 + load / hook) * (1 / a + 1 / b),
        g * g * (1 + load / hook) / (a * b),
    )
    squares = half + np.array([-1.0, 1.0]) * np.sqrt(half * half - product)
    found = np.sort(np.linalg.eigvals(stiffness).real)
    np.testing.assert_allclose(found, squares, rtol=1e-12)  # some thousand roundings
