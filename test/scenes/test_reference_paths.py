"""Paths of a scene file: shaped against swing, read from tables, rejected by single-line errors."""

from math import pi, sqrt
from pathlib import Path as File
from typing import Any

import numpy as np
import pytest
import yaml
from pydantic import TypeAdapter
from scipy.integrate import solve_ivp

import crane_sim
from crane_sim.scenes.scene import load_scene
from crane_sim.trajectories.joint_trajectory import Waypoints
from crane_sim.trajectories.minimum_jerk import MinimumJerk
from crane_sim.trajectories.point_to_point import PointToPoint
from crane_sim.trajectories.polynomials import PiecewisePolynomial, evaluate
from crane_sim.trajectories.shaping import apply_input_shaper, impulses
from crane_sim.trajectories.trajectory import sample_trajectory

ROUNDING = 1e-12  # of numbers of the size of one
SWING = sqrt(9.81 / 1.255)  # rad/s
MOVE = PointToPoint((0.0,), (1.0,), 0.5, 0.8).to_polynomials()
FINE = {"rtol": 1e-11, "atol": 1e-13, "method": "DOP853", "max_step": 0.05}


def swing_after(polynomials: PiecewisePolynomial, frequency: float, damping: float) -> float:
    """Return the amplitude of s'' + 2 D w s' + w² s = -r'' once the reference r is at rest."""

    def rates(t: float, x: np.ndarray) -> list[float]:
        push = evaluate(polynomials, np.array([t]), 2)[0, 0]
        return [x[1], -push - 2.0 * damping * frequency * x[1] - frequency**2 * x[0]]

    x = np.zeros(2)
    for first, last in zip(
        polynomials.starts[:-1], polynomials.starts[1:], strict=True
    ):  # the acceleration jumps in between
        x = solve_ivp(rates, (first, np.nextafter(last, first)), x, **FINE).y[:, -1]
    return float(
        np.hypot(x[0], (x[1] + damping * frequency * x[0]) / (frequency * sqrt(1.0 - damping**2)))
    )


@pytest.mark.parametrize("damping", [0.0, 0.1])
@pytest.mark.parametrize("kind", ["zv", "zvd"])
def test_a_shaped_reference_leaves_no_swing(kind: Any, damping: float) -> None:
    """An oscillator that swings after the plain reference rests after the shaped one (scipy)."""
    assert swing_after(MOVE, SWING, damping) > 1e-3
    assert (
        swing_after(apply_input_shaper(MOVE, kind, SWING, damping), SWING, damping) < 1e-9
    )  # the integrator's tolerance, summed


def test_zvd_is_flat_where_zv_is_not() -> None:
    """The residue grows with the frequency's error: its square after ZVD, itself after ZV."""

    def residue(kind: Any, error: float) -> float:
        weights, delays = impulses(kind, SWING, 0.05)
        w, root = SWING * (1.0 + error), sqrt(1.0 - 0.05**2)
        # each impulse's swing, seen from t = 0
        turns = np.exp((0.05 + 1j * root) * w * np.array(delays))
        return abs(np.dot(weights, turns))

    # terms of the next order
    assert residue("zv", 0.002) / residue("zv", 0.001) == pytest.approx(2.0, rel=0.01)
    assert residue("zvd", 0.002) / residue("zvd", 0.001) == pytest.approx(4.0, rel=0.01)
    assert residue("zv", 0.0) < ROUNDING and residue("zvd", 0.0) < ROUNDING


def test_a_shaped_path_ends_where_the_plain_one_does() -> None:
    """Shaping a path of two coordinates delays it by half a swing, with the same ends.

    No velocity is added.
    """
    plain = MinimumJerk(((0.0, 1.0), (2.0, -1.0), (3.0, 0.0)), (1.0, 3.0, 4.0)).to_polynomials()
    late = apply_input_shaper(plain, "zv", SWING, 0.0)
    t = np.linspace(0.0, 7.0, 141)
    expected = 0.5 * (evaluate(plain, t) + evaluate(plain, t - pi / SWING))
    assert np.max(np.abs(evaluate(late, t) - expected)) < ROUNDING
    assert late.starts[-1] == pytest.approx(4.0 + pi / SWING, abs=ROUNDING)


def path_scene(**path: Any) -> crane_sim.Scene:
    """Return the knuckle-boom scene with a path."""
    return load_scene("knuckle_setpoint", {"reference.path": path, "control": None})


POINTS = [
    {
        "positions": [0.5, 1.0],
        "velocities": [0.0, 0.0],
        "time_from_start": {"sec": 1, "nanosec": 500_000_000},
    },
    {
        "positions": [1.0, 2.0],
        "velocities": [0.0, 0.0],
        "time_from_start": {"sec": 3, "nanosec": 0},
    },
]
TABLE: dict[str, Any] = {"kind": "trajectory", "joint_names": ["y", "x"], "points": POINTS}
CSV = "time,y,x,y_velocity,x_velocity\n1.5,0.5,1,0,0\n3,1,2,0,0\n"


@pytest.mark.parametrize("ending", ["yaml", "csv"])
def test_files_say_what_the_scene_could(tmp_path: File, ending: str) -> None:
    """An echoed message or a table gives the path of its points in the scene, joints sorted."""
    file, t = tmp_path / f"way.{ending}", np.linspace(0.0, 4.0, 41)
    file.write_text(CSV if ending == "csv" else yaml.safe_dump({"header": {}} | TABLE) + "---\n")
    written, read = (
        path_scene(**TABLE).trajectory,
        path_scene(kind="trajectory", file=str(file)).trajectory,
    )
    assert np.array_equal(sample_trajectory(written, t), sample_trajectory(read, t))
    assert sample_trajectory(read, np.array([9.0]))[0, 0] == pytest.approx([2.0, 1.0], abs=ROUNDING)


def test_shaping_takes_its_frequency_from_the_rope() -> None:
    """`auto` is the frequency of a pendulum of the scene's rope."""
    scene = path_scene(**TABLE, shaping={"kind": "zvd"})
    end = 3.0 + 2.0 * pi / sqrt(scene.model.gravity / scene.initial_q[3])
    assert scene.trajectory.starts[-1] == pytest.approx(end, abs=ROUNDING)


@pytest.mark.parametrize("lengths", [2.0, 3.0])
def test_shaping_takes_its_frequency_from_the_hoist_s_rope(lengths: float) -> None:
    """`auto` is the frequency of the rope at the start, whatever the length of the cable."""
    way = {
        "kind": "point_to_point",
        "of": "joints",
        "from": [0, 3],
        "to": [2, 3],
        "velocity": 1,
        "acceleration": 1,
    }
    changes = {
        "cable.lengths": [lengths],
        "initial.length": 3.0,
        "control": {"law": "lqr"},
        "reference": {"path": way},
    }
    plain, shaped = (
        load_scene("overhead_hoist_energy", changes | {"reference.path.shaping": shaping})
        for shaping in (None, {"kind": "zv"})
    )
    half = pi / sqrt(plain.model.gravity / 3.0)
    assert shaped.trajectory.starts[-1] - plain.trajectory.starts[-1] == pytest.approx(
        half, abs=ROUNDING
    )


ARC = {"kind": "arc", "centre": [0, 0], "radius": 1.0, "from": 0, "to": "90 deg", "duration": 2.0}
LINE = {"kind": "line", "from": [0, 0], "to": [1, 1], "duration": 1.0}
WAY = {"kind": "minimum_jerk", "points": [[0, 0], [1, 1], [2, 1]]}
AROUND = {
    "kind": "obstacle",
    "from": [0, 0],
    "to": [2, 0],
    "centre": [1, 0],
    "radius": 0.3,
    "clearance": 0.1,
}
SWIFT = {"kind": "point_to_point", "from": [0, 0], "to": [1, 1], "velocity": 1, "acceleration": 1}
RISE = {
    "kind": "line",
    "of": "joints",
    "from": [0, 0, 0, 1],
    "to": ["45 deg", "45 deg", 0, 1.5],
    "duration": 2,
}
BAD: list[tuple[Any, str]] = [
    (3, "reference.path = 3: must be a group of keys, with kind: line | arc | point_to_point"),
    ([], "reference.path = []: must be a group of keys, with kind: line"),
    (
        {"kind": "spiral"},
        "kind 'spiral' is unknown; possible: line, arc, point_to_point, minimum_jerk, obstacle",
    ),
    ({}, "reference.path: kind is missing; possible: line, arc, point_to_point"),
    (ARC | {"radus": 1}, "reference.path: unknown key 'radus', did you mean 'radius'?"),
    (ARC | {"radius": -1}, "reference.path.radius = -1: must be greater than 0"),
    (ARC | {"to": "up"}, "to = 'up': an angle is a number of radians"),
    (ARC | {"duration": 0}, "reference.path.duration = 0: must be greater than 0"),
    (
        ARC | {"of": "joints"},
        "reference.path: has 2 coordinates, joints of this crane: slew, boom, jib, rope",
    ),
    (ARC | {"of": "hook"}, "reference.path.of = 'hook': must be 'payload' or 'joints'"),
    (ARC | {"start": 1e20}, "reference.path.start = 1e+20: so large that the motion takes no time"),
    (LINE | {"to": [1]}, "reference.path: to needs as many coordinates as from, here are 1 and 2"),
    (
        LINE | {"from": [0] * 4, "to": [1] * 4},
        "reference.path: has 4 coordinates, payload of this crane: x, y, z",
    ),
    (LINE | {"to": [1, "up"]}, "reference.path: to[1] = 'up': an angle is a number of radians"),
    (LINE | {"profile": "jump"}, "reference.path.profile = 'jump': must be 'sine' or 'smooth'"),
    (WAY, "needs times, or limits: velocity, acceleration, jerk"),
    (WAY | {"times": [0, 1]}, "needs as many times as points, here are 2 and 3"),
    (WAY | {"times": [0, 2, 1]}, "times must increase"),
    (WAY | {"times": [0, 1, 2], "velocity": 1}, "times leave nothing to start and limits"),
    (
        WAY | {"points": [[0, 0], [0, 0]], "velocity": 1},
        "two points that follow each other are the same",
    ),
    (
        WAY | {"points": [[0, 0], [1]], "velocity": 1},
        "points[1] needs as many coordinates as points[0]",
    ),
    (
        WAY | {"points": [[0, 0], [1]], "times": [0, 1]},
        "points[1] needs as many coordinates as points[0]",
    ),
    (WAY | {"points": []}, "reference.path.points = []: needs at least 2 points"),
    (
        WAY | {"velocity": 1e30},
        "reference.path: limits so large that the motion, or a part of it, takes no time",
    ),
    (
        SWIFT | {"velocity": [1, 1, 1]},
        "reference.path: velocity needs as many coordinates as from, here are 3 and 2",
    ),
    (SWIFT | {"velocity": "fast"}, "reference.path.velocity = 'fast': must be a number or a list"),
    (SWIFT | {"velocity": -1}, "reference.path.velocity = -1: must be greater than 0"),
    (SWIFT | {"velocity": [1, -1]}, "reference.path.velocity[1] = -1: must be greater than 0"),
    (SWIFT | {"velocity": []}, "reference.path.velocity = []: needs at least one value"),
    (SWIFT | {"acceleration": 0}, "reference.path.acceleration = 0: must be greater than 0"),
    (
        SWIFT | {"acceleration": 1e30},
        "reference.path: limits so large that the motion, or a part of it, takes no time",
    ),
    (
        AROUND | {"velocity": 1e30},
        "reference.path: limits so large that the motion, or a part of it, takes no time",
    ),
    (
        AROUND | {"duration": 5, "side": "up"},
        "reference.path.side = 'up': must be 'left', 'right' or 'shorter'",
    ),
    (AROUND, "needs one of both: duration, or limits"),
    (
        AROUND | {"duration": 5, "clearance": 0.8},
        "from is 1 m from the centre, within radius + clearance = 1.1 m",
    ),
    (
        TABLE | {"joint_names": ["x", "q"]},
        "reference.path: joint_names = x, q: must be x, y, in any order",
    ),
    (TABLE | {"points": POINTS[::-1]}, "points[1].time_from_start = 1.5: times must increase"),
    (
        TABLE | {"points": [POINTS[0] | {"velocities": [1, 0]}]},
        "points[0].velocities = [1.0, 0.0]: a path is at rest",
    ),
    (
        TABLE | {"points": [POINTS[0] | {"positions": [1]}]},
        "points[0].positions has 1 values, not 2",
    ),
    (TABLE | {"points": []}, "reference.path.points = []: needs at least one point"),
    (TABLE | {"points": [5]}, "points[0] = 5: must be a group of keys: positions, time_from_start"),
    (
        TABLE | {"points": [POINTS[0] | {"at": 1}]},
        "points[0]: unknown key 'at' (known: positions, time_from_start",
    ),
    (
        TABLE | {"points": [POINTS[0] | {"time_from_start": {"sec": "abc"}}]},
        "must be seconds, or sec and nanosec",
    ),
    (
        TABLE | {"file": "way.csv"},
        "reference.path: file gives joint_names, too; leave out one of the two",
    ),
    ({"kind": "trajectory", "file": 5}, "reference.path: file = 5: must be text"),
    ({"kind": "trajectory", "file": ""}, "does not exist"),
    ({"kind": "trajectory", "file": "nowhere.csv"}, "file nowhere.csv: does not exist"),
    (
        ARC | {"shaping": {"kind": "zvdd"}},
        "reference.path.shaping.kind = 'zvdd': must be 'zv' or 'zvd'",
    ),
    (
        ARC | {"shaping": {"kind": "zv", "damping": 1}},
        "reference.path.shaping.damping = 1: must be less than 1",
    ),
    (
        ARC | {"shaping": {"kind": "zv", "frequency": "low"}},
        "shaping.frequency = 'low': must be a number or 'auto'",
    ),
    (
        ARC | {"shaping": 3},
        "reference.path.shaping = 3: must be a group of keys: kind, frequency, damping",
    ),
    (ARC, "reference.path: control.law = 'energy' follows no path"),
    (
        RISE | {"to": [0, 0, 0, 1.5]},
        "reference.q = [0.7853981633974483, 0.7853981633974483, 0.0, 1.5]: the path of",
    ),
    (RISE, "reference.path: control.law = 'energy' follows no path"),
]


@pytest.mark.parametrize(("path", "line"), BAD, ids=lambda case: str(case)[:50])
def test_a_bad_path_is_a_single_line_error(path: Any, line: str) -> None:
    """Every mistake is a one-line error with the key, its value and the possible ones."""
    with pytest.raises(crane_sim.SceneError) as caught:
        load_scene("knuckle_setpoint", {"reference.path": path})
    assert line in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("law", ["energy", "lqr"])
def test_a_law_that_would_not_follow_a_path_refuses_it(law: str) -> None:
    """Neither the energy law nor LQR drops the payload's path silently."""
    changes = {"control": {"law": law}, "reference.path": LINE | {"from": [0], "to": [1]}}
    with pytest.raises(
        crane_sim.SceneError, match=rf"reference\.path.*control\.law = '{law}' follows"
    ):
        load_scene("overhead_energy", changes)


def test_a_path_of_the_joints_has_its_end_for_a_target() -> None:
    """Without `q` the target of the joints is the end of their path."""
    changes = {"control": None, "reference": {"path": RISE}}
    assert load_scene("knuckle_setpoint", changes).reference == pytest.approx(
        (pi / 4, pi / 4, 0.0, 1.5), abs=ROUNDING
    )


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("way.csv", CSV.replace("3,1", "3,one"), r"row 3, y = 'one': must be a number"),
        ("way.csv", CSV.replace("1.5,", "\n1.5,nan"), r"row 3, y = 'nan0.5': must be a number"),
        ("way.csv", CSV + "4,1\n", r"row 4 has 2 values, the header names 5 columns"),
        ("way.csv", CSV.replace("y_velocity", "x"), r"column 'x' stands twice"),
        ("way.csv", "", r"its head line begins with time"),
        ("way.yaml", "- 1", r"has no key joint_names"),
        ("way.yaml", "joint_names: [x]", r"has no key points"),
        ("way.yaml", "", r"has no key joint_names"),
    ],
)
def test_an_invalid_file_is_a_single_line_error(
    tmp_path: File, name: str, text: str, line: str
) -> None:
    """An error about an invalid trajectory file has its name, the row and its text."""
    (tmp_path / name).write_text(text)
    with pytest.raises(crane_sim.SceneError, match=rf"{name}: is no trajectory: {line}") as caught:
        path_scene(kind="trajectory", file=str(tmp_path / name))
    assert "\n" not in str(caught.value)


def test_byte_order_marks_and_empty_lines_are_ignored(tmp_path: File) -> None:
    """A byte order mark and empty lines change nothing."""
    (tmp_path / "way.csv").write_text("\ufeff" + CSV.replace("\n3", "\n\n3") + "\n\n")
    path, t = (
        path_scene(kind="trajectory", file=str(tmp_path / "way.csv")).trajectory,
        np.linspace(0.0, 4.0, 9),
    )
    assert np.array_equal(
        sample_trajectory(path, t), sample_trajectory(path_scene(**TABLE).trajectory, t)
    )


ROWS = {
    "positions": [[0.0, 1.0], [1.0, 3.0]],
    "velocities": [[0.0, 0.0], [0.0, 0.0]],
    "accelerations": [[1, 0], [0, 2]],
}


def table(kinds: int) -> dict[str, Any]:
    """Return a trajectory from t = 1 s to 3 s with `kinds` kinds of rows."""
    points = [
        {name: rows[i] for name, rows in list(ROWS.items())[:kinds]}
        | {"time_from_start": 1.0 + 2.0 * i}
        for i in range(2)
    ]
    return {"joint_names": ["x", "y"], "points": points}


@pytest.mark.parametrize(
    ("kinds", "halfway"), [(1, [0.5, 2.0]), (2, [0.5, 2.0]), (3, [0.5625, 2.125])]
)
def test_tables_are_interpolated_as_controllers_do(kinds: int, halfway: list[float]) -> None:
    """Linear, cubic or quintic as given; halfway, a quintic adds h² (a0 + a1) / 64 to the mean."""
    polynomials = TypeAdapter(Waypoints).validate_python(table(kinds)).to_polynomials()
    assert polynomials.coefficients.shape[2] == 2 * kinds
    assert evaluate(polynomials, np.array([2.0]))[0] == pytest.approx(halfway, abs=ROUNDING)
    for k, name in enumerate(list(ROWS)[:kinds]):
        ends = evaluate(polynomials, np.array([1.0, np.nextafter(3.0, 0.0)]), k)
        assert np.max(np.abs(ends - np.array(ROWS[name]))) < ROUNDING


def test_the_deprecated_name_of_a_scenes_trajectory_works() -> None:
    """`Scene.path` is `Scene.trajectory`, with a warning that names it."""
    scene = path_scene(**TABLE)
    with pytest.warns(DeprecationWarning, match="Scene.path is now Scene.trajectory"):
        assert scene.path is scene.trajectory
