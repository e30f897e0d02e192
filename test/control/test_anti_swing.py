"""The law `anti_swing`: its poles, its shaping and its feedback below drives that follow speeds."""

from dataclasses import replace
from math import acos, cos, inf, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest

from crane_control.anti_swing import swing_gains, swing_geometry
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.derived import derive_instant
from crane_sim.simulation.rollout import simulate

LENGTH = 4.0  # m
OMEGA = sqrt(9.81 / LENGTH)
PATH = {
    "kind": "point_to_point",
    "of": "joints",
    "from": [0.0],
    "to": [1.0],
    "velocity": 0.1,
    "acceleration": 0.1,
}
TABLE = {"trolley": {"times": [0.0, 0.5, 1.3], "values": [0.0, 0.0, 0.4]}}


def scene(control: dict[str, Any], **groups: Any) -> Scene:
    """Return the scene of a trolley whose drive follows speeds exactly, with a payload.

    The rope is 4 m long.
    """
    servo = {"gain": inf, "max_acceleration": 0.5, "max_jerk": 5.0}
    document = {
        "crane": "overhead",
        "duration": 10.0,
        "trolley": {"mass": 1200.0},
        "cable": {"lengths": LENGTH, "node_masses": 500.0},
        "actuators": {"trolley": {"drive": "velocity", "servo": servo | groups.pop("servo", {})}},
        "control": {"law": "anti_swing", "period": 0.01} | control,
        "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-13},
    }
    return load_scene(document | groups)


def test_the_poles_are_those_of_the_formula() -> None:
    """Below a prescribed velocity the law's poles and the swing are those of the formula.

    The law works by differences.
    """
    z, h = 0.3, 0.4
    law: Any = scene({"damping": z, "position_gain": h}, reference={"q": [0.0]}).law
    # x' = v(x, a) of the law, a'' = -(g sin a + x'' cos a) / l, linearised by central differences
    # of the law itself
    step = 1e-6
    by_x = (law(0.0, (step, 0.0), (0.0, 0.0))[0] - law(0.0, (-step, 0.0), (0.0, 0.0))[0]) / (
        2.0 * step
    )
    by_a = (law(0.0, (0.0, step), (0.0, 0.0))[0] - law(0.0, (0.0, -step), (0.0, 0.0))[0]) / (
        2.0 * step
    )
    state = np.array([[by_x, by_a, 0.0], [0.0, 0.0, 1.0], np.zeros(3)])
    speed = state[0]  # of x; its rate is by_x x' + by_a a'
    state[2] = (
        -(by_x * speed + by_a * np.array([0.0, 0.0, 1.0]) + 9.81 * np.array([0.0, 1.0, 0.0]))
        / LENGTH
    )
    poles = np.sort_complex(np.linalg.eigvals(state))
    k = 2.0 * z * sqrt(9.81 * LENGTH)
    expected = np.sort_complex(np.roots([LENGTH, LENGTH * h + k, 9.81, 9.81 * h]))
    assert np.max(np.abs(poles - expected)) < 1e-8  # of the differences
    assert np.all(poles.real < 0.0)


def decay(run: Any, start: float) -> tuple[float, float]:
    """Return (real part [1/s], frequency [rad/s]) of a free swing after a time [s].

    It is by the recurrence of the swing.
    """
    a = run.q[round(start / 0.01) :: 10, 1]
    columns = np.column_stack([a[1:-1], a[:-2]])
    (p, q), *_ = np.linalg.lstsq(columns, a[2:], rcond=None)
    pole = np.log(np.roots([1.0, -p, -q]).astype(complex)[0]) / 0.1
    return float(pole.real), abs(float(pole.imag))


@pytest.mark.long
def test_the_feedback_damps_the_swing_as_it_says() -> None:
    """Below an operator's zero speed a swing is damped with ratio z at its frequency.

    The frequency is that of the pendulum.
    """
    control = {"damping": 0.2, "speeds": {}}
    servo = {"max_acceleration": 50.0, "max_jerk": 1e6}
    run = simulate(scene(control, servo=servo, initial={"angles": 0.01}))
    real, frequency = decay(run, 0.5)
    # the speed is held for a period: 0.01 s × k of delay
    assert real == pytest.approx(-0.2 * OMEGA, rel=0.02)
    assert frequency == pytest.approx(OMEGA * sqrt(1.0 - 0.2**2), rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["zv", "zvd"])
def test_shaped_speeds_leave_no_swing(kind: str) -> None:
    """An operator's ramp of speed excites a full swing, the shaped one a small part of it."""
    servo = {"max_acceleration": 5.0, "max_jerk": 500.0}  # which bind nothing: the drive is linear
    plain = simulate(scene({"damping": 0.0, "speeds": TABLE}, servo=servo))
    shaped = simulate(
        scene({"damping": 0.0, "speeds": TABLE, "shaping": {"kind": kind}}, servo=servo)
    )
    rest = round((1.3 + 2.0 * pi / OMEGA + 0.1) / 0.01)
    residue = [
        np.max(np.hypot(run.q[rest:, 1], run.v[rest:, 1] / OMEGA)) for run in (plain, shaped)
    ]
    # delays are whole periods within 0.01 s: a phase of 0.016 rad, and the swing is not quite
    # linear
    assert residue[0] > 0.02 and residue[1] < 0.02 * residue[0]
    assert run_speed(plain) == pytest.approx(0.4, abs=1e-9) == run_speed(shaped)


@pytest.mark.parametrize(("kind", "sums"), [("zv", (0.5, 1.0)), ("zvd", (0.25, 0.75, 1.0))])
def test_speeds_that_begin_with_the_run_are_shaped(kind: str, sums: tuple[float, ...]) -> None:
    """A speed commanded from the start is passed on in impulses half a swing apart.

    Any other step is passed on so, too.
    """
    speeds = {"trolley": {"times": [0.0], "values": [0.4]}}
    law: Any = scene({"damping": 0.0, "speeds": speeds, "shaping": {"kind": kind}}).law
    commands = [law((i + 0.5) * pi / OMEGA, (0.0, 0.0), (0.0, 0.0))[0] for i in range(len(sums))]
    # rounding of the weights
    assert commands == pytest.approx([0.4 * part for part in sums], abs=1e-12)
    assert law(0.0, (0.0, 0.0), (0.0, 0.0))[0] == pytest.approx(0.4 * sums[0], abs=1e-12)


def run_speed(run: Any) -> float:
    """Return the trolley's speed [m/s] at the end."""
    return float(run.v[-1, 0])


def test_angles_ahead_of_every_joint() -> None:
    """In a bridge crane the trolley feels the swing along x, the bridge along y, the rope none."""
    length, gains = swing_gains(
        load_scene(
            "bridge_hook_and_sling",
            {"links": [], "payload": {"mass": 8000.0}, "initial.rigging": None},
        )
    )
    assert length == pytest.approx(4.0)
    names = load_scene("bridge_hook_and_sling").joint_names[3:5]
    assert names == ("swing_tangential", "swing_radial")
    assert np.abs(gains[:, 3:]) == pytest.approx(
        np.array([[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]), abs=1e-6
    )


POSTURES = {
    "knuckle_setpoint": ((0.0, 0.6, -0.5, 2.0, 0.0, 0.0), (0.7, 0.6, -0.5, 2.0, 0.0, 0.0)),
    "mobile_lift": (None,),
}


@pytest.mark.parametrize(
    ("name", "q"), [(name, q) for name, postures in POSTURES.items() for q in postures]
)
def test_joints_move_the_tip_by_the_offset_together(name: str, q: tuple[float, ...] | None) -> None:
    """All actuated joints together move the tip by the payload's offset.

    Boom and jib, or telescope, share the way.
    """
    loaded = load_scene(name)
    initial = np.array(loaded.initial_q if q is None else q)
    ahead, step = swing_geometry(replace(loaded, initial_q=tuple(initial))).ahead, 1e-4
    actuated = [loaded.joint_names.index(joint) for joint in loaded.actuated]
    for offset in np.eye(2):
        ways = np.zeros((2, len(initial)))
        ways[:, actuated] = np.outer((step, -step), ahead @ offset)
        still = [0.0] * len(initial)
        forward, back = (
            derive_instant(loaded, 0.0, (initial + way).tolist(), still).tip for way in ways
        )
        moved = (forward - back)[0, :2] / (2.0 * step)
        # of the differences: step² and rounding / step
        np.testing.assert_allclose(moved, offset, atol=1e-6)


def test_parallel_joints_that_span_one_direction() -> None:
    """With the tip on the slew's axis, boom and jib move it in one direction, none to infinity.

    Turned by 40 degrees on a ship that has drifted by 20 m, their directions differ by rounding.
    """
    drift = {"sway": {"amplitude": 20.0, "frequency": 0.01, "phase": "90 deg"}}
    loaded = load_scene("knuckle_setpoint", {"base_motion": drift, "control": None})
    boom, slew = 1.0, np.deg2rad(40.0)
    jib = acos(-5.0 * cos(boom) / 4.0)  # by the lengths of the scene
    ahead = swing_geometry(replace(loaded, initial_q=(slew, boom, jib, 2.0, 0.0, 0.0))).ahead
    way = 1.0 / np.hypot(5.0 * sin(boom), 4.0 * sin(jib))  # rad/m, the least of both for a metre
    across = np.array([-sin(slew), cos(slew)])
    assert np.linalg.norm(ahead) == pytest.approx(way, rel=1e-6)  # the differences: step²
    assert np.max(np.abs(ahead @ across)) < 1e-6


@pytest.mark.parametrize(
    ("control", "message"),
    [
        ({}, "control.speeds: is missing, and so is reference.q"),
        ({"speeds": {"bridge": TABLE["trolley"]}}, "control.speeds: unknown joint 'bridge'"),
        ({"speeds": TABLE, "damping": 2.0}, "control.damping = 2.0"),
        (
            {"law": "lqr", "nominal": {"reference": {"q": [1.0]}}},
            "control.law = 'lqr': commands effort of the trolley, whose drive takes velocity",
        ),
        (
            {"speeds": TABLE, "nominal": {"reference": {"path": PATH}}},
            "reference.path: control.law = 'anti_swing' follows no path",
        ),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value[:24],
)
def test_mistakes_are_reported_in_one_line(control: dict[str, Any], message: str) -> None:
    """What the law cannot do, as a path, and a law of other commands are single-line errors."""
    with pytest.raises(SceneError) as caught:
        scene(control)
    assert message in str(caught.value) and "\n" not in str(caught.value)
