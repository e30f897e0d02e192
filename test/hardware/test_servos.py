"""Servo drives by closed forms: references within limits, speed loop, its limits, position loop."""

from itertools import pairwise
from math import inf, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hardware_scenes import PERIOD
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from crane_sim import orchestration, read_recording
from crane_sim.files.errors import SceneError
from crane_sim.hardware.reference_profiles import PHASES, Bounds, plan_position, plan_velocity
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate

MASS, GAIN, TIME = 1200.0, 6000.0, 0.4  # kg, N s/m, s
PI = {"gain": GAIN, "integral_time": TIME}
RAMP = {"max_speed": 0.8, "max_acceleration": 0.5, "max_jerk": 2.0}


def trolley(
    servo: dict[str, Any], drive: str = "velocity", payload: float = 1e-9, **groups: Any
) -> Scene:
    """Return the scene of a trolley with a servo drive; its payload weighs nothing by default."""
    actuator = {"drive": drive, "servo": servo} | groups.pop("actuator", {})
    document = {
        "crane": "overhead",
        "duration": 3.0,
        "trolley": {"mass": MASS},
        "cable": {"lengths": 4.0, "node_masses": payload},
        "actuators": {"trolley": actuator},
        "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-13},
    }
    return load_scene(document | groups)


def under(scene: Scene, commands: Any, times: Any = None) -> Any:
    """Return the run under commands, a function of time [s]."""
    return simulate(scene, law=lambda t, q, v: (commands(t),), sample_times=times)


def error_after_step(t: Any, gain: float = GAIN) -> Any:
    """Return the speed's deviation after a unit step, from rest.

    m e' = -K (e + integral of e / T), e(0) = 1.
    """
    decay = 0.5 * gain / MASS
    w = sqrt(gain / TIME / MASS - decay**2)
    return np.exp(-decay * t) * (np.cos(w * t) - decay / w * np.sin(w * t))


def test_a_speed_step_is_that_of_a_second_order_system() -> None:
    """A mass under the PI loop answers a speed step as mass, damper and spring do."""
    times = np.linspace(0.0, 3.0, 401)
    run = under(trolley(PI), lambda t: 0.5, times)
    expected = 0.5 * (1.0 - error_after_step(times))
    assert np.max(np.abs(run.v[:, 0] - expected)) < 1e-11  # of the method's tolerance
    assert run.summary["energy_audit_error"] < 1e-12
    # the effort that is shown is the loop's: m v' of the closed form
    slope = np.gradient(expected, times)
    # N of 3000: of the differences
    assert np.max(np.abs(run.u[2:-2, 0] - MASS * slope[2:-2])) < 1.0


def motion(phases: Any, times: Any) -> Any:
    """Return (position, velocity, acceleration) (m, 3) of the first joint, phase by phase."""
    rows = []
    for t in times:
        x, begin = 0.0, 0.0
        for duration, v, a, jerk in phases[0]:
            s = min(t - begin, duration)
            x += v * s + a * s**2 / 2.0 + jerk * s**3 / 6.0
            begin += duration
            if t <= begin:
                rows.append((x, v + a * s + jerk * s**2 / 2.0, a + jerk * s))
                break
    return np.array(rows)


def check_profile(phases: Any, bounds: Bounds, start: tuple[float, float]) -> Any:
    """Check that a profile goes on from (v, a) without jumps, within its bounds.

    It returns the motion at the end.
    """
    assert np.all(phases[0, :, 0] >= 0.0) and phases[0, -1, 0] == inf
    duration = float(np.sum(phases[0, :-1, 0][np.isfinite(phases[0, :-1, 0])]))
    v, a = start
    for row in phases[0]:
        if not 0.0 < row[0] < inf:
            continue
        assert abs(row[1] - v) < 1e-9  # the rounding of the bisection over a short phase
        assert bounds.jerk == inf or abs(row[2] - a) < 1e-7
        v, a = row[1] + row[2] * row[0] + 0.5 * row[3] * row[0] ** 2, row[2] + row[3] * row[0]
    fine = motion(phases, np.linspace(0.0, duration, 400))
    assert np.max(np.abs(fine[:, 2])) <= bounds.acceleration * (1.0 + 1e-9)
    assert np.max(np.abs(phases[0, :, 3])) <= bounds.jerk
    return motion(phases, [duration])[0]


@pytest.mark.parametrize("target", [0.7, 0.02, -0.4])
def test_a_ramp_takes_the_least_time(target: float) -> None:
    """From rest a ramp lasts v / A + A / J, or 2 sqrt(v / J), and covers half v × time.

    The second holds where it does not reach A.
    """
    phases, bounds = np.zeros((1, PHASES, 4)), Bounds(inf, 0.5, 2.0)
    plan_velocity(phases, 0, 0.0, 0.0, target, bounds)
    size = abs(target)
    duration = size / 0.5 + 0.5 / 2.0 if size > 0.5**2 / 2.0 else 2.0 * sqrt(size / 2.0)
    assert np.sum(phases[0, :3, 0]) == pytest.approx(duration, rel=1e-14)
    end = check_profile(phases, bounds, (0.0, 0.0))
    assert end[:2] == pytest.approx([0.5 * target * duration, target], abs=1e-14)


@pytest.mark.parametrize("jerk", [inf, 2.0])
@pytest.mark.parametrize("acceleration", [0.5, inf])
def test_profiles_go_on_from_any_motion(jerk: float, acceleration: float) -> None:
    """Profiles from random motions reach speed or position in all bounds, without jumps.

    They begin with random speeds and accelerations.
    """
    rng = np.random.default_rng(4)
    bounds = Bounds(0.8, acceleration, jerk)
    for _ in range(60):
        v, a = rng.uniform(-0.8, 0.8), rng.uniform(-0.5, 0.5) if jerk < inf else 0.0
        phases, target = np.zeros((1, PHASES, 4)), rng.uniform(-0.8, 0.8)
        plan_velocity(phases, 0, v, a, target, bounds)
        if acceleration == inf == jerk:  # it jumps
            assert phases[0, -1].tolist() == [inf, target, 0.0, 0.0] and not np.any(
                phases[0, :3, 0]
            )
            continue
        end = check_profile(phases, bounds, (v, a))
        assert end[1] == pytest.approx(target, abs=1e-12) and (jerk == inf or abs(end[2]) < 1e-7)
        distance = rng.uniform(-4.0, 4.0) * rng.choice([1.0, 0.05])
        plan_position(phases, 0, v, a, distance, bounds)
        end = check_profile(phases, bounds, (v, a))
        assert (
            abs(end[0] - distance) < 1e-12
            and abs(end[1]) < 1e-7
            and (jerk == inf or abs(end[2]) < 1e-7)
        )


@pytest.mark.parametrize("speed", [0.8, 1.0, 1.5, 3.0])
@pytest.mark.parametrize("distance", [0.05, 0.6, 3.0, -3.0])
def test_a_way_that_is_planned_anew_takes_no_longer(speed: float, distance: float) -> None:
    """Planned anew at any instant, the rest of a way takes the rest of the time."""
    bounds, phases, again = (
        Bounds(speed, 0.5, 2.0),
        np.zeros((1, PHASES, 4)),
        np.zeros((1, PHASES, 4)),
    )
    plan_position(phases, 0, 0.0, 0.0, distance, bounds)
    duration = float(np.sum(phases[0, :-1, 0]))
    for t in np.linspace(0.0, 0.97 * duration, 40):
        ((x, v, a),) = motion(phases, [t])
        plan_position(again, 0, v, a, distance - x, bounds)
        ((end, speed_there, _),) = motion(again, [duration - t])
        # rounding of the distance, 1e-16, makes a cruise of a size like that, in the ramp's last
        # bit a speed of 1e-8
        assert abs(end - (distance - x)) < 1e-12 and abs(speed_there) < 1e-6


def test_a_way_from_rest_takes_the_least_time() -> None:
    """From rest to a position: d / V + V / A + A / J, or without a jerk limit 2 sqrt(d / A).

    In the first case all limits bind.
    """
    phases = np.zeros((1, PHASES, 4))
    plan_position(phases, 0, 0.0, 0.0, 3.0, Bounds(0.8, 0.5, 2.0))
    assert np.sum(phases[0, :-1, 0]) == pytest.approx(3.0 / 0.8 + 0.8 / 0.5 + 0.5 / 2.0, rel=1e-13)
    plan_position(phases, 0, 0.0, 0.0, -0.3, Bounds(0.8, 0.5, inf))
    assert np.sum(phases[0, :-1, 0]) == pytest.approx(2.0 * sqrt(0.3 / 0.5), rel=1e-13)


@pytest.mark.long
def test_the_loop_follows_its_ramp_with_the_linear_lag() -> None:
    """Behind a ramp with jerk limits the speed is the convolution of step responses.

    The ramp's command changes midway.
    """
    times = np.linspace(0.0, 3.0, 301)
    run = under(trolley(PI | RAMP), lambda t: 0.6 if t < 0.645 else -0.3, times)
    # v(0.65 s) = 0.2625 m/s at 0.5 m/s², which turns to -0.5 within 0.5 s and leaves 0.5 s × 1 m/s
    # for the hold
    knots, slopes = [0.0, 0.25, 0.65, 1.15, 2.15, 2.4], [0.0, 0.5, 0.5, -0.5, -0.5, 0.0]
    nodes, weights = np.polynomial.legendre.leggauss(40)
    expected = np.zeros(len(times))
    # Duhamel: v(t) = integral of v_r'(s) (1 - e(t - s)) ds, by Gauss-Legendre between the knots of
    # v_r'
    for low, high in pairwise(knots):
        for i in np.flatnonzero(times > low):
            half = 0.5 * (min(high, times[i]) - low)
            s = low + half * (nodes + 1.0)
            answer = 1.0 - error_after_step(times[i] - s)
            expected[i] += half * np.sum(weights * np.interp(s, knots, slopes) * answer)
    assert np.max(np.abs(run.v[:, 0] - expected)) < 1e-9
    assert run.summary["energy_audit_error"] < 1e-12


def test_a_torque_limit_binds_and_the_integral_does_not_wind_up() -> None:
    """At its limit the drive accelerates with F / m.

    Behind it the speed overshoots less than the linear loop does.
    """
    scene = trolley(PI, actuator={"limit": 300.0})
    run = under(scene, lambda t: 0.5)
    bound = run.u[:, 0] == 300.0
    # the proportional part falls below the limit 0.05 m/s before the command is reached
    held = int(np.argmin(bound))
    assert run.v[held, 0] == pytest.approx(0.45, abs=300.0 / MASS * PERIOD)
    assert np.max(np.abs(run.v[:held, 0] - 300.0 / MASS * run.t[:held])) < 1e-9
    assert np.max(np.abs(run.u)) == 300.0 and run.summary["saturated_steps"] == held
    free = np.max(-error_after_step(run.t))  # overshoot of the linear loop, of 1
    assert np.max(run.v[:, 0]) - 0.5 < 0.05 * free + 300.0 / MASS * PERIOD
    assert run.summary["energy_audit_error"] < 1e-9


def test_a_position_drive_is_a_sampled_cascade() -> None:
    """A position drive without acceleration limits answers steps as the sampled cascade does.

    The cascade is linear.
    """
    speed, target, gain = 0.8, 1.2, 1.5  # m/s, m, 1/s
    servo = PI | {"max_speed": speed, "position_gain": gain}
    run = under(trolley(servo, "position"), lambda t: target)
    k, s = GAIN / MASS, GAIN / MASS / TIME
    # x' = v, v' = k (v_r + d - v) + s (x_r + c - x), x_r' = v_r, c' = d in the state (x, v, x_r,
    # v_r, c, d)
    rates = np.zeros((6, 6))
    rates[0, 1] = rates[2, 3] = rates[4, 5] = 1.0
    rates[1] = [-s, -k, s, k, s, k]
    period, expected, z = expm(PERIOD * rates), [], np.zeros(6)
    for i in range(len(run.t)):
        z[3], z[5] = speed if i < round(target / speed / PERIOD) else 0.0, gain * (z[2] - z[0])
        expected.append(z[:2].copy())
        z = period @ z
    assert np.max(np.abs(np.column_stack([run.q[:, 0], run.v[:, 0]]) - expected)) < 1e-10
    assert run.summary["energy_audit_error"] < 1e-12


def test_a_position_drive_arrives_within_its_limits() -> None:
    """With a payload and limits a position drive rests at its target, and the audit holds.

    The limits are those of its reference.
    """
    servo = PI | RAMP | {"gain": 10.0 * GAIN, "position_gain": 1.5}
    run = under(trolley(servo, "position", payload=200.0, duration=10.0), lambda t: 1.2)
    # the payload, which swings on below, moves it by its pull over the loop's stiffness, some 300 N
    # / 150 kN/m
    assert abs(run.q[-1, 0] - 1.2) < 2e-3 and np.max(run.v[:, 0]) < 0.85
    assert run.summary["energy_audit_error"] < 1e-9


EXACT = RAMP | {"gain": inf}
EXACT_SPEED = {"drive": "velocity", "servo": {"gain": inf, "max_acceleration": 0.2}}
STICKING = {"coulomb": 500.0, "static": 900.0}


@pytest.mark.long(cases=["position"])
@pytest.mark.parametrize("drive", ["velocity", "position"])
def test_an_infinite_gain_is_exact(drive: str) -> None:
    """With infinite gain the trolley follows its reference, as a prescribed motion would.

    The payload swings as with that motion.
    """
    command = 0.6 if drive == "velocity" else 0.9
    run = under(trolley(EXACT, drive, payload=3000.0, duration=4.0), lambda t: command)
    if drive == "velocity":  # ramp to 0.6 m/s: 0.25 s, 0.95 s and 0.25 s
        phases = [(0.25, 2.0), (0.95, 0.0), (0.25, -2.0), (9.0, 0.0)]
    else:  # ramp up to the cruise speed and down again, V is not reached
        speed = 0.5 * (sqrt(0.25**2 * 0.5**2 + 4.0 * 0.9 * 0.5) - 0.25 * 0.5)  # of v²/A + v A/J = d
        hold = speed / 0.5 - 0.25
        ramp = [(0.25, 2.0), (hold, 0.0), (0.25, -2.0)]
        phases = [*ramp, *[(duration, -jerk) for duration, jerk in ramp], (9.0, 0.0)]
    expected = integrated(phases, run.t)
    assert np.max(np.abs(np.column_stack([run.q[:, 0], run.v[:, 0]]) - expected)) < 1e-9
    assert run.summary["energy_audit_error"] < 1e-9

    # the swing is that below a prescribed motion: l a'' = -g sin a - x'' cos a, by another
    # integrator
    def rates(t: float, y: Any) -> Any:
        slope = np.interp(t, *acceleration_knots(phases))
        return [y[1], -(9.81 * np.sin(y[0]) + slope * np.cos(y[0])) / 4.0]

    edges = np.concatenate([[0.0], np.cumsum([d for d, _ in phases])])
    y = np.zeros(2)
    for low, high in pairwise(np.minimum(edges, 4.0)):
        if high > low:
            y = solve_ivp(rates, (low, high), y, "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert abs(run.q[-1, 1] - y[0]) < 1e-9 and abs(run.v[-1, 1] - y[1]) < 1e-9
    assert np.max(np.abs(run.q[:, 1])) > 0.03


def integrated(phases: list[tuple[float, float]], times: Any) -> Any:
    """Return (position, velocity) (m, 2) at the times from rest under phases (duration, jerk)."""
    rows = []
    for t in times:
        x = v = a = 0.0
        for duration, jerk in phases:
            s = min(duration, t)
            x, v, a = (
                x + v * s + a * s**2 / 2.0 + jerk * s**3 / 6.0,
                v + a * s + jerk * s**2 / 2.0,
                a + jerk * s,
            )
            t -= s
        rows.append((x, v))
    return np.array(rows)


def acceleration_knots(phases: list[tuple[float, float]]) -> tuple[Any, Any]:
    """Return (times, accelerations) between which phases' acceleration is linear.

    `phases` are (duration, jerk).
    """
    durations, jerks = np.array(phases).T
    return np.concatenate([[0.0], np.cumsum(durations)]), np.concatenate(
        [[0.0], np.cumsum(durations * jerks)]
    )


def test_a_brake_takes_over_and_gives_back() -> None:
    """While the brake holds, the drive is off; released, it accelerates from the joint's speed."""
    plant = Plant(trolley(PI | RAMP, brake={"capacity": [2000.0]}))
    for braking, periods in ((False, 150), (True, 100)):
        plant.braking = braking
        for _ in range(periods):
            plant.advance((0.4,))
    assert abs(plant.v[0]) < 1e-3
    plant.braking = False
    plant.advance((0.4,))
    # jerk limit from rest: after one period the reference has J T² / 2 = 1e-4 m/s
    assert abs(plant.v[0]) < 1e-3 and abs(plant.applied[0]) < 50.0
    for _ in range(500):
        plant.advance((0.4,))
    # the loop's poles have real parts of -2.5 / s
    assert plant.v[0] == pytest.approx(0.4, abs=1e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"drive": "speed"}, "actuators.trolley.drive = 'speed'"),
        ({"servo": None}, "drive = 'velocity': needs its gain, in actuators.trolley.servo"),
        ({"servo": {}}, "actuators.trolley.servo.gain"),
        (
            {"drive": "effort"},
            "actuators.trolley.servo: belongs to a drive with drive = 'velocity' or 'position'",
        ),
        ({"lag": 0.1}, "actuators.trolley.lag = 0.1: not with drive = 'velocity'"),
        (
            {"servo": PI | {"position_gain": 1.0}},
            "position_gain = 1: belongs to drive = 'position'",
        ),
        ({"drive": "position"}, "servo.max_speed: is missing, drive = 'position' needs one"),
        (
            {"drive": "position", "servo": PI | RAMP},
            "servo.position_gain: is missing, drive = 'position' needs one",
        ),
        ({"servo": {"gain": inf}}, "servo.max_acceleration: is missing, gain = inf needs one"),
        (
            {"servo": EXACT | {"integral_time": 0.4}},
            "servo.integral_time = 0.4: not with gain = inf",
        ),
        ({"servo": EXACT, "limit": 9.0}, "trolley.limit: limits the effort, and servo.gain = inf"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value[:24],
)
def test_contradictions_are_reported_in_one_line(changes: dict[str, Any], message: str) -> None:
    """A drive's keys that contradict each other are a single-line error with the key."""
    with pytest.raises(SceneError) as caught:
        trolley(PI, actuator=changes)
    assert message in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        (
            {"events": [{"at": 1.0, "set": {"payload": {"mass": 900.0}}}]},
            "events: an exchange of the load jerks",
        ),
        (
            {"backlash": {"trolley": [{"inertia": 90.0, "play": 0.01, "stiffness": 1e6}]}},
            "backlash.trolley: a joint",
        ),
        (
            {"actuators": {"rope": EXACT_SPEED}, "rope": {"drive": "force", "friction": STICKING}},
            "rope.friction: a winch that may stick",
        ),
    ],
)
def test_what_jerks_or_holds_a_joint_excludes_exact_drives(
    groups: dict[str, Any], message: str
) -> None:
    """An infinite gain excludes what jumps velocities, or holds what has to move.

    It keeps accelerations.
    """
    with pytest.raises(SceneError, match=message):
        load_scene(
            "bridge_speed_drive", {"control": None, "actuators": {"trolley": EXACT_SPEED}} | groups
        )


@pytest.mark.long
def test_a_torque_limit_shows_in_applied_effort(domain_id: int, tmp_path: Path) -> None:
    """Over DDS recorded efforts equal those of `simulate`, the limit at first.

    They are those of `applied_effort`.
    """
    limit = 150.0  # N; the ramp of 0.16 m/s² wants 192 N for the trolley alone
    scene = load_scene("bridge_speed_drive", {"duration": 4.0, "actuators.trolley.limit": limit})
    orchestration.run(scene, record=tmp_path / "run.rrd", domain_id=domain_id)
    there, here = read_recording(tmp_path / "run.rrd").u, simulate(scene).u
    assert np.array_equal(there, here[:-1])  # the last row is the state at the end
    assert np.max(np.abs(there[:, 0])) == limit and np.count_nonzero(there[:, 0] == limit) > 10
