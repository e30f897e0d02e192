"""A payload below a driven point: printed equations, closed forms and inertial space."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.special import ellipk
from ship_motion import SHIP

import crane_sim
from crane_sim.files.errors import SceneError
from crane_sim.trajectories.base_motion import AXES, SplineBase

LENGTH, MASS, GRAVITY = 1.255, 4.0, 9.81
SCENE: dict[str, Any] = {
    "crane": "pendulum",
    "duration": 5.0,
    "rope": {"length": LENGTH},
    "payload": {"mass": MASS},
    "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-12},
}
TIP = (1.35, -0.4, 0.7)


def scene_of(**groups: Any) -> crane_sim.Scene:
    """Return the scene with further groups."""
    return crane_sim.load_scene(SCENE | groups)


def ship(t: Any, only: tuple[str, ...] = AXES) -> list[Any]:
    """Return (surge, sway, heave, roll, pitch, yaw) of SHIP at the symbol t, as defined."""
    return [
        wave.get("offset", 0)
        + wave["amplitude"] * sp.sin(wave["frequency"] * t + wave.get("phase", 0))
        if name in only
        else sp.Integer(0)
        for name, wave in SHIP.items()
    ]


def rotation_matrix(roll: Any, pitch: Any, yaw: Any) -> sp.Matrix:
    """Return Rz(yaw) Ry(pitch) Rx(roll)."""
    return sp.rot_ccw_axis3(yaw) * sp.rot_ccw_axis2(pitch) * sp.rot_ccw_axis1(roll)


def in_world(r: Any) -> Callable[[float], Any]:
    """Return a function of time: motion (3, 3) in the world of a point r (3,) of the ship.

    Its rows are position, velocity and acceleration.
    """
    t = sp.Symbol("t")
    surge = ship(t)
    at = sp.Matrix(surge[:3]) + rotation_matrix(*surge[3:]) * sp.Matrix(r)
    derivatives = sp.lambdify(t, sp.Matrix.hstack(at, at.diff(t), at.diff(t, 2)), cse=True)
    return lambda now: np.array(derivatives(now)).T


def spherical(angles: Any, rates: Any, drive: Any, gravity: float, force: Any) -> np.ndarray:
    """Return the swing angles' second derivatives, eqs. (34) and (35) of the offshore paper."""
    (sx, cx), (sy, cy) = ((sin(a), cos(a)) for a in angles)
    x = -drive[1] * cx / LENGTH + 2.0 * rates[0] * rates[1] * sy - gravity / LENGTH * sx
    y = (
        drive[0] * cy / LENGTH
        + drive[1] * sx * sy / LENGTH
        - rates[0] ** 2 * sy * cy
        - gravity / LENGTH * cx * sy
    )
    x, y = (
        x + cx * force[1] / (MASS * LENGTH),
        y - (cy * force[0] + sx * sy * force[1]) / (MASS * LENGTH),
    )
    return np.array([x / cy, y])


def direction(angles: Any, rates: Any, seconds: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the rope's direction, eq. (36), n = (-sy, sx cy, -cx cy), and two derivatives."""
    (sx, cx), (sy, cy) = ((sin(a), cos(a)) for a in angles)
    (a, b), (c, d) = rates, seconds
    n, by_x, by_y = np.array(
        [[-sy, sx * cy, -cx * cy], [0.0, cx * cy, sx * cy], [-cy, -sx * sy, cx * sy]]
    )
    xx, xy = np.array([[0.0, -sx * cy, cx * cy], [0.0, -cx * sy, -sx * sy]])
    return n, by_x * a + by_y * b, by_x * c + by_y * d + xx * a * a + 2.0 * xy * a * b - n * b * b


@pytest.mark.parametrize("moving", [False, True], ids=["fixed", "pushed on a moving base"])
def test_accelerations_are_those_of_the_paper(moving: bool) -> None:
    """Forward dynamics equal the printed equations for any swing, drive and force.

    A swaying base adds to y0'' and g.
    """
    only, force, t = AXES[:3], (3.0, -5.0, 2.0), sp.Symbol("t")
    push = {
        axis: {"kind": "constant", "value": value} for axis, value in zip("xyz", force, strict=True)
    }
    groups = {"base_motion": {name: SHIP[name] for name in only}, "payload_force": push}
    scene = scene_of(**(groups if moving else {}))
    base = sp.lambdify(t, [x.diff(t, 2) for x in ship(t, only)])
    rng = np.random.default_rng(2)
    for _ in range(20):
        now = rng.uniform(0.0, 10.0)
        angles, rates, drive = (
            rng.uniform(-1.2, 1.2, 2),
            rng.normal(size=2),
            rng.normal(size=2) * 3.0,
        )
        x, y, z = base(now)[:3] if moving else (0.0, 0.0, 0.0)
        given = force if moving else (0.0, 0.0, 0.0)
        seconds = spherical(angles, rates, drive + (x, y), GRAVITY + z - given[2] / MASS, given)
        n, n1, n2 = direction(angles, rates, seconds)
        q, v = (*rng.normal(size=3), *n), (*rng.normal(size=2), 0.0, *n1)
        actual = crane_sim.acceleration(scene, q, v, drive, now)
        # rounding, at accelerations of 1e1
        assert actual == pytest.approx([*drive, 0.0, *n2], rel=1e-12, abs=1e-11)


def test_swings_take_as_long_as_elliptic_integrals_say() -> None:
    """Swings, small, to 170 degrees and over the top, are back after their periods.

    So no direction is singular.
    """
    small = sqrt(LENGTH / GRAVITY)
    for angle, spin in ((0.01, 0.0), (170.0 * pi / 180.0, 0.0), (0.0, 2.2 / small)):
        initial = {"direction": [sin(angle), 0.0, -cos(angle)], "direction_rate": [spin, 0.0, 0.0]}
        scene = scene_of(initial=initial)
        period = (
            4.0 * small * ellipk(sin(0.5 * angle) ** 2)
            if angle
            else 4.0 / spin * ellipk((2.0 / small / spin) ** 2)
        )
        run = crane_sim.simulate(scene, duration=period + 0.1, sample_times=[0.5 * period, period])
        # ten steps' tolerance, grown near the top
        assert run.q[1] == pytest.approx(scene.initial_q, abs=1e-9)
        assert run.q[0, 5] == pytest.approx(1.0 if spin else -cos(angle), abs=1e-9)
        assert run.summary["energy_audit_error"] < 1e-10  # what 1e-12 a step allows


@pytest.mark.long
def test_a_ship_is_what_newton_sees_from_the_world() -> None:
    """On a base that moves in six ways, payload and tension are those of a pendulum.

    The pendulum is integrated in the world.
    """
    start = np.array([0.28, 0.0, -0.96])
    scene = scene_of(base_motion=SHIP, initial={"tip": TIP, "direction": list(start)})
    run = crane_sim.simulate(scene, sample_times=np.linspace(0.5, 5.0, 10))
    tip = in_world(TIP)

    def newton(t: float, y: Any) -> tuple[Any, Any]:
        """Return the payload's acceleration and the rope's pull over mass and length.

        The pull keeps the length.
        """
        place, rate, second = tip(t)
        line, moving = y[:3] - place, y[3:] - rate
        fall = np.array([0.0, 0.0, -GRAVITY])
        pull = (line @ (fall - second) + moving @ moving) / LENGTH**2
        return fall - pull * line, pull

    place, rate, _ = in_world(np.array(TIP) + LENGTH * start)(0.0)
    solved = solve_ivp(
        lambda t, y: [*y[3:], *newton(t, y)[0]],
        (0.0, 5.0),
        [*place, *rate],
        "DOP853",
        run.t,
        rtol=1e-12,
        atol=1e-12,
    )
    # both keep 1e-12 a step, over hundreds of steps
    assert np.max(np.abs(run.payload - solved.y[:3].T)) < 1e-9
    pulls = [MASS * LENGTH * newton(t, y)[1] for t, y in zip(run.t, solved.y.T, strict=True)]
    assert run.tension == pytest.approx(pulls, rel=1e-9)  # as above
    assert run.summary["energy_audit_error"] < 1e-10  # what 1e-12 a step allows
    # m: the tip, which stands still on the base, is shown in the world
    assert np.ptp(run.tip, axis=0).min() > 0.2


def still(scene: crane_sim.Scene, drift: tuple[float, ...]) -> crane_sim.Scene:
    """Return the scene on a base that drifts (6,) [m/s, rad/s] by a spline."""
    coefficients = np.zeros((6, 2, 6))
    coefficients[:, 0, 1] = coefficients[:, 1, 1] = drift
    coefficients[:, 1, 0] = drift  # the second piece begins after one second
    base = SplineBase(np.array([0.0, 1.0, 2.0]), coefficients)
    return replace(scene, model=scene.model._replace(base=base))


def test_the_servo_is_a_second_order_lag() -> None:
    """A servo takes the tip to the demand as its two gains say, in every axis, with any load."""
    kp, kd, t = 49.4, 2.0, np.linspace(0.1, 2.0, 5)
    demanded, start = (0.5, -0.3, 0.2), (0.1, 0.0, 0.0)
    servo = {"drive": "servo", "kp": kp, "kd": kd, "height": "driven"}
    names = ("tip_x", "tip_y", "tip_z")
    inputs = {
        name: {"kind": "constant", "value": value}
        for name, value in zip(names, demanded, strict=True)
    }
    scene = scene_of(suspension=servo, initial={"tip": start}, inputs=inputs)
    run = crane_sim.simulate(scene, sample_times=t)
    w = sqrt(kp - 0.25 * kd * kd)
    left = np.exp(-0.5 * kd * t) * (np.cos(w * t) + 0.5 * kd / w * np.sin(w * t))
    for axis in range(3):
        way = start[axis] - demanded[axis]
        # 1e-12 a step
        assert run.q[:, axis] == pytest.approx(demanded[axis] + way * left, abs=1e-10)
    assert run.summary["energy_audit_error"] < 1e-10  # what the servo gives is metered


@pytest.mark.parametrize(
    ("group", "message"),
    [
        ({"suspension": {"drive": "servo", "kp": 10.0}}, "suspension.kd: is missing"),
        ({"suspension": {"kp": 10.0}}, "suspension.kp: only a servo has one"),
        (
            {"initial": {"direction": [0.0, 0.0, -2.0]}},
            "initial.direction = [0.0, 0.0, -2.0]: must be a unit vector",
        ),
        (
            {"initial": {"direction_rate": [0.0, 0.0, 1.0]}},
            "initial.direction_rate = [0.0, 0.0, 1.0]: must be across",
        ),
        (
            {"initial": {"tip_velocity": [0.0, 0.0, 1.0]}},
            "initial.tip_velocity[2] = 1.0: must be 0",
        ),
        (
            {"inputs": {"tip_z": {"kind": "constant"}}},
            "inputs.tip_z: drives nothing, suspension.height = 'fixed'",
        ),
        ({"reference": {"q": [1.0, 2.0, 3.0]}}, "reference.q: has 3 values"),
    ],
)
def test_a_scene_that_is_not_possible_is_a_single_line_error(
    group: dict[str, Any], message: str
) -> None:
    """Every setting that contradicts another is named with its value."""
    with pytest.raises(SceneError) as caught:
        scene_of(**group)
    assert message in str(caught.value) and "\n" not in str(caught.value)
