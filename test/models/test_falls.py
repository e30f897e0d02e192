"""A rigid load on elastic falls, against virtual work of point masses and closed forms."""

from dataclasses import replace
from math import atan, pi, sqrt
from typing import Any

import numpy as np
import pytest
import test_flexible
from point_masses import Extras, accelerations, body_points, mp, mpf, mpmath, on_base, plus, rotate
from test_suspended import INERTIA, MOVES, SEA, START, attitude, base, support_places, turn
from test_suspended import SUPPORTS as SLEWING

from crane_sim import system
from crane_sim.models.falls.crane import Falls, FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.supports.bridge import Bridge, BridgeAxis
from crane_sim.models.supports.driven_point import DrivenPoint, Lift
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.support import Support
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.plant import Plant

TOP = np.array([[1.2, 0.9, 0.0], [1.1, -0.8, 0.1], [-1.0, 0.9, 0.0], [-1.2, -0.7, -0.1]])
BOTTOM = np.array([[0.7, 0.6, 0.5], [0.6, -0.5, 0.6], [-0.7, 0.5, 0.5], [-0.6, -0.6, 0.4]])
STIFFNESS = np.array([4e3, 5e3, 4.5e3, 5.5e3])
BOTH = (True, True)
BENT = {"tower that bends": "tower", "mobile that bends": "mobile"}
SUPPORTS: dict[str, Any] = SLEWING | {"bridge": Bridge(BridgeAxis(8.0), BridgeAxis(12.0))}
SUPPORTS |= {name: test_flexible.support(rigid, BOTH) for name, rigid in BENT.items()}
STARTS: dict[str, Any] = START | {"bridge": (0.8, 1.1)}
STARTS |= {name: (*test_flexible.OWN[rigid], *test_flexible.BENT) for name, rigid in BENT.items()}


def rigid(inertia: Any = INERTIA, mass: float = 10.0) -> RigidLoad:
    """Return a load with this inertia."""
    matrices: list[Any] = [
        tuple(map(tuple, np.array(m).tolist())) for m in (inertia, np.linalg.inv(inertia))
    ]
    return RigidLoad(mass, matrices[0], matrices[1], (0.0, 0.0, 0.0))


def falls(relaxation: float = 0.0) -> Falls:
    """Return four falls that are fastened apart at both ends."""
    return Falls(
        TOP, BOTTOM, 2.0, np.array([0.0, 0.01, -0.02, 0.0]), STIFFNESS, np.full(4, relaxation)
    )


def places_of(name: str, q: Any) -> tuple[list[Any], Any, Any]:
    """Return (points of the support, its tip, its yaw) relative to the base; q: support first."""
    if name == "bridge":
        return (
            [(mpf(8), (q[0], q[1], mpf(0))), (mpf(12), (mpf(0), q[1], mpf(0)))],
            (q[0], q[1], mpf(0)),
            mpf(0),
        )
    if name in BENT:
        reference = test_flexible.Reference(BENT[name], BOTH)
        # without its hook and load
        return reference.places(q)[:-2], reference.nodes(q)[0], reference.axis(q)[0]
    return (*support_places(name, q), q[0])


def strain_energy(tip_of: Any, length_of: Any, load_of: Any) -> Any:
    """Return the energy of the falls as a function of (t, q); arguments: functions of it.

    Args:
        tip_of: (tip, yaw).
        length_of: the falls' common length.
        load_of: (centre, angles).
    """
    offsets = falls().offset.tolist()

    def at(t: Any, q: Any) -> Any:
        energy, (tip, yaw), (centre, angles) = mpf(0), tip_of(t, q), load_of(q)
        for i in range(4):
            top, bottom = tuple(map(mpf, TOP[i].tolist())), tuple(map(mpf, BOTTOM[i].tolist()))
            a, b = plus(tip, rotate(2, yaw, top)), plus(centre, turn(angles, bottom))
            rest = length_of(q) + mpf(offsets[i])
            stretch = mpmath.sqrt(sum((x - y) ** 2 for x, y in zip(a, b, strict=True))) - rest
            energy += mpf(STIFFNESS[i]) * stretch**2 / (2 * rest)
        return energy

    return at


def moved(q: Any, v: Any, a: Any, at: int) -> Any:
    """Return coordinates and two derivatives, three angles from `at` on as a quaternion."""
    with mp.workdps(60):
        h, (q, v, a) = mpf(10) ** -18, ([mpf(float(x)) for x in row] for row in (q, v, a))
        rows = []
        for s in (-h, mpf(0), h):
            now = [x + s * y + s * s * z / 2 for x, y, z in zip(q, v, a, strict=True)]
            rows.append([*now[:at], *attitude(now[at:])])
        low, middle, high = rows
        first = [(x - y) / (2 * h) for x, y in zip(high, low, strict=True)]
        second = [(x - 2 * y + z) / h**2 for x, y, z in zip(high, middle, low, strict=True)]
        return tuple(np.array([float(x) for x in row]) for row in (middle, first, second))


@pytest.mark.parametrize(("name", "sea"), [(name, i % 2 == 0) for i, name in enumerate(SUPPORTS)])
def test_accelerations_are_those_of_point_masses(name: str, sea: bool) -> None:
    """With taut falls the accelerations agree with virtual work of points and springs.

    This holds at sea, too.
    """
    rng, t, ns, shape = np.random.default_rng(3), 0.9, len(STARTS[name]), body_points(10.0, INERTIA)
    x, y, z = (float(a) for a in places_of(name, [*map(mpf, STARTS[name]), *(mpf(1),) * 7])[1])
    q = np.array([*STARTS[name], 2.0, x + 0.3, y + 0.2, z - 2.9, 0.35, 0.05, -0.04])
    v = rng.uniform(-0.3, 0.3, len(q))
    bends = 2 if name in BENT else 0
    commands = (*[15.0, -8.0, 20.0][: ns - bends], -120.0)
    efforts, added = np.zeros(len(q)), np.zeros(len(q))
    efforts[: ns - bends], efforts[ns], added[ns] = commands[:-1], -120.0, 1.5
    efforts[ns - bends : ns] = -np.array(test_flexible.DAMPING[:bends]) * v[ns - bends : ns]

    def places(t: Any, q: Any) -> Any:
        points = [*places_of(name, q)[0]]
        points += [(m, plus(tuple(q[ns + 1 : ns + 4]), turn(q[ns + 4 :], r))) for m, r in shape]
        return [(m, on_base(SEA, t, r)) for m, r in points] if sea else points

    strain = strain_energy(
        lambda t, q: places_of(name, q)[1:],
        lambda q: q[ns],
        lambda q: (tuple(q[ns + 1 : ns + 4]), q[ns + 4 :]),
    )
    bent = test_flexible.Reference(BENT[name], BOTH) if bends else None
    extras = Extras(added, lambda t, q: strain(t, q) + (bent.springs(q) if bent else 0))
    expected = accelerations(places, t, q, v, efforts, extras)
    crane = FallsCrane(
        Support(SUPPORTS[name]), falls(), rigid(), ForceHoist(1.5), base=base() if sea else None
    )
    rows = moved(q, v, expected, ns + 4)
    own = ns - bends
    joints, rates, second = (np.concatenate([row[:own], row[ns:], row[own:ns]]) for row in rows)
    state = system.state(crane, t, joints, rates)
    assert state[-4:].tolist() == [1.0] * 4
    assert all(
        np.array_equal(a, b)
        for a, b in zip(system.joints(crane, state), (joints, rates), strict=True)
    )
    got = system.acceleration(crane, t, state, commands)
    # rounding of stiff springs
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-11 * abs(second).max())


def test_falls_below_a_driven_point_are_those_of_point_masses() -> None:
    """Below a point that moves on a moving base, the load's accelerations agree with virtual work.

    The reference has the point's place as a function of time, with the velocity and acceleration of
    this instant.
    """
    now, tip, shape = 1.3, (0.4, 6.0, 1.0), body_points(10.0, INERTIA)
    q = np.array([0.7, 6.2, -1.9, 0.35, 0.05, -0.04])
    v = np.random.default_rng(5).uniform(-0.3, 0.3, len(q))

    def point(t: Any) -> Any:
        s = t - mpf(now)
        return tuple(
            mpf(x) + s * mpf(u) + s * s / 2 * mpf(a) for x, u, a in zip(tip, *MOVES, strict=True)
        )

    def places(t: Any, q: Any) -> Any:
        return [(m, on_base(SEA, t, plus(tuple(q[:3]), turn(q[3:], r)))) for m, r in shape]

    strain = strain_energy(
        lambda t, q: (point(t), mpf(0)), lambda q: mpf(2), lambda q: (tuple(q[:3]), q[3:])
    )
    joints, rates, second = moved(
        q, v, accelerations(places, now, q, v, np.zeros(6), Extras(potential=strain)), 3
    )
    crane = FallsCrane(Support(DrivenPoint(None, Lift())), falls(), rigid(), base=base())
    x = system.state(crane, now, np.array([*tip, *joints]), np.array([*MOVES[0], *rates]))
    assert x[-4:].tolist() == [1.0] * 4
    got = system.acceleration(crane, now, x, MOVES[1])
    bound = 1e-11 * abs(second).max()  # rounding of stiff springs
    np.testing.assert_allclose(got, [*MOVES[1], *second], rtol=0.0, atol=bound)


def test_bifilar_yaw() -> None:
    """Two parallel falls at distance s under W have the bifilar yaw stiffness W (s/2)² / L."""
    length, spacing, mass, yaw = 12.0, 3.0, 500.0, 1e-4
    top = np.array([[0.0, 0.5 * spacing, 0.0], [0.0, -0.5 * spacing, 0.0]])
    ropes = Falls(top, top.copy(), length, np.zeros(2), np.full(2, 1e9), np.zeros(2))
    bridge = Support(Bridge(BridgeAxis(1e3), BridgeAxis(1e3)))
    crane = FallsCrane(bridge, ropes, rigid(np.diag([300.0, 200.0, 400.0]), mass))
    weight = mass * 9.81
    down = length * (1.0 + 0.5 * weight / 1e9)
    # of the turned load, so that the tension is unchanged
    lift = (0.5 * spacing * yaw) ** 2 / (2.0 * down)
    q = np.array([0.0, 0.0, 0.0, 0.0, -down + lift, np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)])
    x = system.state(crane, 0.0, q, np.zeros(9))
    # of the yaw, of a small angle
    acceleration = 2.0 * system.acceleration(crane, 0.0, x, (0.0, 0.0))[8]
    # 0.1 %
    assert acceleration / yaw == pytest.approx(
        -weight * (0.5 * spacing) ** 2 / down / 400.0, rel=1e-3
    )


def test_peak_of_a_rope_that_goes_taut() -> None:
    """A load that falls by h goes taut at v = √(2 g h) with the closed form's peak tension.

    The peak is W (1 + √(1 + (v/g)² k/m)).
    """
    height, k, m, g = 0.2, 2e4, 100.0, 9.81
    speed, omega = sqrt(2.0 * g * height), sqrt(k / m)
    peak = 1.0 + sqrt(1.0 + (speed * omega / g) ** 2)
    # until e = g/ω² (1 - cos) + v/ω sin is largest
    duration = speed / g + (pi - atan(speed * omega / g)) / omega
    scene: dict[str, Any] = {
        "crane": "gantry",
        "duration": duration,
        "trolley": {"mass": 1e9},
        "bridge": {"mass": 1e9},
        "falls": {"top": [[0, 0, 0]], "bottom": [[0, 0, 0]], "axial_stiffness": 5.0 * k},
        "payload": {"mass": m, "inertia": [1, 1, 1]},
        "initial": {"length": 5.0, "position": [0, 0, -5.0 + height]},
        "inputs": {},
        "control": None,
        "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-13},
    }
    loaded = load_scene(scene)
    plant = Plant(replace(loaded, period=duration / 40, duration=duration))
    for _ in range(40):
        plant.advance(None)
    (event,) = plant.summary()["events"]
    assert event["t"] == pytest.approx(speed / g, rel=0.0, abs=1e-9)
    tensions = np.empty((1, 1))
    state = system.state(loaded.model, duration, np.array(plant.q), np.array(plant.v))
    system.tensions(loaded.model, duration, state, (0.0, 0.0, 0.0), tensions, 0, 0)
    assert tensions[0, 0] / (m * g) == pytest.approx(peak, rel=1e-9)  # the tolerance of the steps
