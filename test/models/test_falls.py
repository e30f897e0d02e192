"""A rigid load on elastic falls, against virtual work of point masses and closed forms."""

from dataclasses import replace
from math import atan, pi, sqrt
from typing import Any

import numpy as np
import pytest
from point_masses import Extras, accelerations, body_points, mp, mpf, mpmath, on_base, plus, ring_points, rotate
from test_suspended import INERTIA, SEA, attitude, base, turn

from crane_sim import system
from crane_sim.models.falls.crane import Falls, FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.supports.bridge import Bridge, DrivenAxis
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.tower_crane import JibTrolley, Slew, TowerCrane
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.plant import Plant

pytestmark = pytest.mark.interpreted

TOP = np.array([[1.2, 0.9, 0.0], [1.1, -0.8, 0.1], [-1.0, 0.9, 0.0], [-1.2, -0.7, -0.1]])
BOTTOM = np.array([[0.7, 0.6, 0.5], [0.6, -0.5, 0.6], [-0.7, 0.5, 0.5], [-0.6, -0.6, 0.4]])
STIFFNESS = np.array([4e3, 5e3, 4.5e3, 5.5e3])
SUPPORTS = {"bridge": Bridge(DrivenAxis(8.0), DrivenAxis(12.0)), "tower": TowerCrane(Slew(50.0), JibTrolley(8.0))}


def rigid(inertia: Any = INERTIA, mass: float = 10.0) -> RigidLoad:
    """Return a load with this inertia."""
    matrices: list[Any] = [tuple(map(tuple, np.array(m).tolist())) for m in (inertia, np.linalg.inv(inertia))]
    return RigidLoad(mass, matrices[0], matrices[1], (0.0, 0.0, 0.0))


def falls(relaxation: float = 0.0) -> Falls:
    """Return four falls that are fastened apart at both ends."""
    return Falls(TOP, BOTTOM, 2.0, np.array([0.0, 0.01, -0.02, 0.0]), STIFFNESS, np.full(4, relaxation))


def ends(name: str, q: Any, i: int) -> tuple[Any, Any]:
    """Return both ends of a fall, relative to the base; q: support, length, centre, angles."""
    top, bottom = tuple(map(mpf, TOP[i].tolist())), tuple(map(mpf, BOTTOM[i].tolist()))
    lower = plus(tuple(q[3:6]), turn(q[6:], bottom))
    if name == "bridge":
        return plus((q[0], q[1], mpf(0)), top), lower
    return rotate(2, q[0], plus((q[1], mpf(0), mpf(0)), top)), lower


def places(name: str, sea: bool) -> Any:
    """Return the places of all points as a function of (t, q)."""
    shape = body_points(10.0, INERTIA)

    def at(t: Any, q: Any) -> Any:
        points = [(m, plus(tuple(q[3:6]), turn(q[6:], r))) for m, r in shape]
        if name == "bridge":
            points += [(mpf(8), (q[0], q[1], mpf(0))), (mpf(12), (mpf(0), q[1], mpf(0)))]
        else:
            points += [*ring_points(50.0, q[0]), (mpf(8), rotate(2, q[0], (q[1], mpf(0), mpf(0))))]
        return [(m, on_base(SEA, t, r)) for m, r in points] if sea else points

    return at


def strain_energy(name: str) -> Any:
    """Return the energy of the falls as a function of (t, q)."""
    offsets = falls().offset.tolist()

    def at(_: Any, q: Any) -> Any:
        energy = mpf(0)
        for i in range(4):
            a, b = ends(name, q, i)
            rest = q[2] + mpf(offsets[i])
            stretch = mpmath.sqrt(sum((x - y) ** 2 for x, y in zip(a, b, strict=True))) - rest
            energy += mpf(STIFFNESS[i]) * stretch**2 / (2 * rest)
        return energy

    return at


def mapped(q: Any, v: Any, a: Any) -> Any:
    """Return the crane's joint coordinates with their first and second derivatives."""
    with mp.workdps(60):
        h, (q, v, a) = mpf(10) ** -18, ([mpf(float(x)) for x in row] for row in (q, v, a))
        rows = []
        for s in (-h, mpf(0), h):
            moved = [x + s * y + s * s * z / 2 for x, y, z in zip(q, v, a, strict=True)]
            rows.append([*moved[:6], *attitude(moved[6:])])
        low, middle, high = rows
        first = [(x - y) / (2 * h) for x, y in zip(high, low, strict=True)]
        second = [(x - 2 * y + z) / h**2 for x, y, z in zip(high, middle, low, strict=True)]
        return tuple(np.array([float(x) for x in row]) for row in (middle, first, second))


@pytest.mark.parametrize("sea", [False, True], ids=["at rest", "at sea"])
@pytest.mark.parametrize("name", SUPPORTS)
def test_accelerations_are_those_of_point_masses(name: str, sea: bool) -> None:
    """With all falls taut, the accelerations agree with virtual work of point masses and springs, at sea too."""
    rng, t = np.random.default_rng(3), 0.9
    start = (0.8, 1.1) if name == "bridge" else (0.3, 6.0)
    x, y = start if name == "bridge" else (6.0 * np.cos(0.3), 6.0 * np.sin(0.3))
    q = np.array([*start, 2.0, x + 0.3, y + 0.2, -2.9, 0.35, 0.05, -0.04])
    v = rng.uniform(-0.3, 0.3, len(q))
    efforts, added = np.zeros(len(q)), np.zeros(len(q))
    efforts[:3], added[2] = (15.0, -8.0, -120.0), 1.5
    expected = accelerations(places(name, sea), t, q, v, efforts, Extras(added, strain_energy(name)))
    crane = FallsCrane(SUPPORTS[name], falls(), rigid(), ForceHoist(1.5), base=base() if sea else None)
    joints, rates, second = mapped(q, v, expected)
    state = system.state(crane, t, joints, rates)
    assert state[-4:].tolist() == [1.0] * 4
    got = system.acceleration(crane, t, state, (15.0, -8.0, -120.0))
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-11 * abs(second).max())  # rounding of stiff springs


def test_bifilar_yaw() -> None:
    """Two parallel falls at distance s carry a weight W with the yaw stiffness W (s/2)² / L of a bifilar pendulum."""
    length, spacing, mass, yaw = 12.0, 3.0, 500.0, 1e-4
    top = np.array([[0.0, 0.5 * spacing, 0.0], [0.0, -0.5 * spacing, 0.0]])
    ropes = Falls(top, top.copy(), length, np.zeros(2), np.full(2, 1e9), np.zeros(2))
    crane = FallsCrane(Bridge(DrivenAxis(1e3), DrivenAxis(1e3)), ropes, rigid(np.diag([300.0, 200.0, 400.0]), mass))
    weight = mass * 9.81
    down = length * (1.0 + 0.5 * weight / 1e9)
    lift = (0.5 * spacing * yaw) ** 2 / (2.0 * down)  # of the turned load, so that the tension is unchanged
    q = np.array([0.0, 0.0, 0.0, 0.0, -down + lift, np.cos(0.5 * yaw), 0.0, 0.0, np.sin(0.5 * yaw)])
    x = system.state(crane, 0.0, q, np.zeros(9))
    acceleration = 2.0 * system.acceleration(crane, 0.0, x, (0.0, 0.0))[8]  # of the yaw, of a small angle
    assert acceleration / yaw == pytest.approx(-weight * (0.5 * spacing) ** 2 / down / 400.0, rel=1e-3)  # 0.1 %


def test_peak_of_a_rope_that_goes_taut() -> None:
    """A load that falls by h goes taut at v = √(2 g h), and the tension's peak is W (1 + √(1 + (v/g)² k/m))."""
    height, k, m, g = 0.2, 2e4, 100.0, 9.81
    speed, omega = sqrt(2.0 * g * height), sqrt(k / m)
    peak = 1.0 + sqrt(1.0 + (speed * omega / g) ** 2)
    duration = speed / g + (pi - atan(speed * omega / g)) / omega  # until e = g/ω² (1 - cos) + v/ω sin is largest
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
