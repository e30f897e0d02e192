"""Seas and recorded motions: spectra, their sums of sinusoids, responses, files."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import crane_sim
from crane_sim.numerics.jit import entry_point
from crane_sim.trajectories.base_motion import axis_at
from crane_sim.trajectories.waves import (
    ResponseAmplitudeOperator,
    Sea,
    SineSum,
    apply_response,
    density,
    sample_sea,
)

GAMMAS = [1.0, 3.3, 7.0]


@pytest.mark.parametrize("gamma", GAMMAS)
def test_a_spectrum_has_its_height_and_its_peak(gamma: float) -> None:
    """The integral is Hs²/16, the peak at the peak period; gamma = 1 is Pierson and Moskowitz.

    That one is a closed form.
    """
    sea, w = Sea(2.5, 9.0, gamma), np.linspace(0.1, 60.0, 400_000)
    s, peak = density(sea, w), 2.0 * np.pi / 9.0
    # the rule's error at this step, and the ends
    assert np.trapezoid(s, w) == pytest.approx(2.5**2 / 16.0, rel=1e-5)
    assert w[np.argmax(s)] == pytest.approx(peak, abs=2.0 * (w[1] - w[0]))
    if gamma == 1.0:
        closed = 5.0 / 16.0 * 2.5**2 * peak**4 * w**-5 * np.exp(-1.25 * (w / peak) ** -4)
        # 1.5e-6 of the energy is beyond what the normalisation sees
        assert np.max(np.abs(s - closed)) < 1e-5 * np.max(closed)


@pytest.mark.parametrize("gamma", GAMMAS)
def test_a_sampled_sea_has_the_spectrums_energy_where_the_spectrum_has_it(gamma: float) -> None:
    """The sum's variance over time is Hs²/16, its energy up to any frequency the spectrum's.

    It is so within some 1.5 of the sinusoids' shares.
    """
    sea, n = Sea(2.0, 8.0, gamma), 80
    waves = sample_sea(sea, n, 5)
    assert np.sum(waves.amplitudes**2) / 2.0 == pytest.approx(0.25, rel=1e-12)  # rounding
    t = np.arange(0.0, 40_000.0, 0.5)
    elevation = sum(a * np.sin(w * t + p) for a, w, p in zip(*waves, strict=True))
    # neighbours 0.005 rad/s apart and less beat over thousands of seconds: some per cent of the
    # variance remain
    assert np.var(elevation) == pytest.approx(0.25, rel=0.1)
    w = np.linspace(0.05, 40.0, 200_000)
    energy = np.cumsum(density(sea, w)) * (w[1] - w[0])
    below = np.interp(np.sort(waves.frequencies), w, energy) / 0.25
    # half a share, half one drawn in it, the cut
    assert np.max(np.abs(below - (np.arange(n) + 0.5) / n)) < 1.5 / n


def test_a_sea_does_not_repeat() -> None:
    """Within an hour the sea does not return to how it began.

    With equal steps in frequency it would.
    """
    waves = sample_sea(Sea(2.0, 8.0, 3.3), 60, 3)
    t = np.arange(10.0, 3600.0, 0.25)
    likeness = np.mean(np.cos(np.outer(t, waves.frequencies)), axis=1)  # its autocorrelation
    assert np.max(likeness[t > 120.0]) < 0.8


def test_a_response_is_interpolated_and_its_ends_are_held() -> None:
    """Amplitudes are linear between rows, phases the short way round; both are held beyond."""
    waves = SineSum(np.full(4, 2.0), np.array([0.1, 0.5, 0.75, 3.0]), np.zeros(4))
    table = ResponseAmplitudeOperator(
        (0.5, 1.0), (1.0, 0.5), (np.deg2rad(170.0), np.deg2rad(-170.0))
    )
    actual = apply_response(waves, table)
    assert actual.amplitudes == pytest.approx([2.0, 2.0, 1.5, 1.0], rel=1e-15)
    assert np.rad2deg(actual.phases) == pytest.approx([170.0, 170.0, 180.0, 190.0], rel=1e-14)
    assert np.array_equal(actual.frequencies, waves.frequencies)


def scene_of(**base_motion: Any) -> crane_sim.Scene:
    """Return a scene with a seed of 7 on a base that moves."""
    document = {
        "crane": "overhead",
        "dimensions": 3,
        "duration": 2.0,
        "seed": 7,
        "trolley": {"drive": "force", "mass": 5.0},
        "cable": {"lengths": [1.0], "node_masses": [1.0]},
        "base_motion": base_motion,
    }
    return crane_sim.load_scene(document)


SEA = {"significant_height": 2.0, "peak_period": 8.0}


def test_a_sea_takes_the_scenes_seed_unless_it_has_its_own() -> None:
    """A sea with the scene's seed moves the base as by the scene's own seed.

    Without a response the base heaves.
    """
    scenes = (scene_of(sea=SEA), scene_of(sea=SEA | {"seed": 7}), scene_of(sea=SEA | {"seed": 8}))
    own, same, other = (scene.model.base for scene in scenes)
    assert all(np.array_equal(a, b) for a, b in zip(own, same, strict=True))
    assert not np.array_equal(own.phases, other.phases)
    assert np.flatnonzero(own.amplitudes.any(axis=1)).tolist() == [2]
    waves = sample_sea(Sea(2.0, 8.0, 3.3), 60, 7)
    assert np.array_equal(own.amplitudes[2], waves.amplitudes) and np.array_equal(
        own.phases[2], waves.phases
    )


def test_sinusoids_and_a_sea_add_up() -> None:
    """An axis moves by its own sinusoids, its offset and the sea's together."""
    roll = [
        {"amplitude": "2 deg", "frequency": 0.7, "offset": 0.1},
        {"amplitude": 0.05, "frequency": 0.3},
    ]
    base = scene_of(roll=roll, sea=SEA | {"components": 3, "response": {"roll": 0.02}}).model.base
    assert base.offsets.tolist() == [0.0, 0.0, 0.0, 0.1, 0.0, 0.0]
    assert base.amplitudes[3] == pytest.approx(
        [np.deg2rad(2.0), 0.05, *[0.02 * 0.5 * np.sqrt(2.0 / 3.0)] * 3]
    )
    assert base.frequencies[3, :2].tolist() == [0.7, 0.3]


@entry_point
def motion(base, times, out):
    """Write (position, velocity, acceleration) of the six axes at times (n,) into out (n, 6, 3)."""
    for k in range(len(times)):
        for i in range(6):
            out[k, i, 0], out[k, i, 1], out[k, i, 2] = axis_at(base, times[k], i)


def test_a_recorded_motion_is_the_motion(tmp_path: Path) -> None:
    """A file's spline meets its rows, and between them the motion and its derivatives.

    Axes that it does not name rest.
    """
    t = np.linspace(-0.5, 2.5, 121)
    rows = np.stack([t, np.sin(2.0 * t), 0.3 * np.cos(3.0 * t)], axis=1)
    file = tmp_path / "motion.csv"
    np.savetxt(file, rows, delimiter=", ", header="time, yaw, heave", comments="", fmt="%.17g")
    base = scene_of(file=str(file)).model.base
    between = np.linspace(0.0, 2.0, 777)
    at_rows, actual = np.empty((len(t), 6, 3)), np.empty((len(between), 6, 3))
    motion(base, t, at_rows)
    motion(base, between, actual)
    # the spline's equations, solved in rounding
    assert at_rows[:, 5, 0] == pytest.approx(rows[:, 1], abs=1e-12)
    s, c = 0.3 * np.sin(3.0 * between), 0.3 * np.cos(3.0 * between)
    expected = np.stack([c, -3.0 * s, -9.0 * c], axis=1)
    # a quintic at steps of 25 ms: h⁶ 3⁶ of values, h⁴ 3⁶ of second derivatives
    errors = np.max(np.abs(actual[:, 2] - expected), axis=0)
    assert errors[0] < 1e-8 and errors[2] < 1e-4
    assert not actual[:, [0, 1, 3, 4]].any()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no column 'time'"),
        ("time,rol\n0,1\n", "unknown column 'rol', did you mean 'roll'?"),
        ("time,roll,roll\n0,1,1\n", "column 'roll' stands twice"),
        ("time,roll\n", "has 0 rows, a smooth motion needs at least 6"),
        ("time,roll\n0,1\n1\n", "row 3 has 1 values"),
        ("time,roll\n\n0,1\n1\n", "row 4 has 1 values"),
        ("time,roll\n0,1\n1,x\n", "row 3, roll = 'x': must be a number"),
        ("time,roll\n0,nan\n", "row 2, roll = 'nan': must be a finite number"),
        ("time,heave\n0,1\n1,1\n", "has 2 rows, a smooth motion needs at least 6"),
        ("time,roll,roll_deg\n0,1,1\n", "column 'roll' stands twice, in two units"),
        (
            "time,roll\n0,0.5\n1,-3\n",
            "row 3, roll = -3: as radians more than an eighth of a turn; did you mean degrees? ",
        ),
        ("time,pitch\n0,0.8\n", "row 2, pitch = 0.8: as radians more than an eighth of a turn"),
        ("time,yaw\n0,270\n", "name the column yaw_deg (or yaw_rad)"),
        ("time\n" + "\n".join("001234"), "row 3, time = 0: must be 1e-06 s after the row before"),
        (
            "time\n" + "\n".join(f"{0.1 * k}" for k in range(8)),
            "covers 0 to 0.7 s; the run goes from 0 to 2 s",
        ),
    ],
    ids=lambda text: str(text)[:30].replace("\n", " "),
)
def test_a_bad_file_is_a_single_line_error(text: str, message: str, tmp_path: Path) -> None:
    """Errors in a file have its name, the row and the possible values."""
    file = tmp_path / "motion.csv"
    file.write_text(text)
    with pytest.raises(crane_sim.SceneError) as caught:
        scene_of(file=str(file))
    assert (
        message in str(caught.value)
        and "motion.csv" in str(caught.value)
        and "\n" not in str(caught.value)
    )


@pytest.mark.parametrize(("unit", "factor"), [("deg", np.pi / 180.0), ("rad", 1.0)])
def test_angles_of_a_file_have_the_unit_of_their_column(
    unit: str, factor: float, tmp_path: Path
) -> None:
    """Columns in degrees, and in radians of any size, are the motion in radians."""
    t = np.linspace(0.0, 2.5, 26)
    rows = np.stack([t, 3.0 * np.sin(t), 4.0 * np.cos(t), 5.0 * t], axis=1)
    head = ",".join(["time", *(f"{axis}_{unit}" for axis in ("roll", "pitch", "yaw"))])
    np.savetxt(tmp_path / "motion.csv", rows, delimiter=",", header=head, comments="", fmt="%.17g")
    base = scene_of(file=str(tmp_path / "motion.csv")).model.base
    at_rows = np.empty((len(t), 6, 3))
    motion(base, t, at_rows)
    # the spline's equations, in rounding
    assert at_rows[:, 3:, 0] == pytest.approx(factor * rows[:, 1:], abs=1e-12)


def test_a_file_lies_beside_its_scene(tmp_path: Path) -> None:
    """A scene file names a motion relative to its own folder.

    The document that it becomes says so.
    """
    (tmp_path / "motion.csv").write_text("time,sway\n" + "".join(f"{k},{k}\n" for k in range(8)))
    scene_of(surge={"amplitude": 0.0, "frequency": 0.0}).dump(tmp_path / "scene.yaml")
    document = yaml.safe_load((tmp_path / "scene.yaml").read_text()) | {
        "base_motion": {"file": "motion.csv"}
    }
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(document))
    scene = crane_sim.load_scene(tmp_path / "scene.yaml")
    assert scene.to_dict()["base_motion"]["file"] == str(tmp_path / "motion.csv")
    assert scene.model.base.coefficients[1, 0, :2] == pytest.approx([0.0, 1.0], abs=1e-12)


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        ({"surge": {"amplitude": 1.0}}, "base_motion.surge[0].frequency: is missing"),
        (
            {"roll": [{"amplitude": 0.5, "frequency": 1.0, "phas": 1.0}]},
            "roll[0]: unknown key 'phas'",
        ),
        (
            {"sea": SEA | {"spectrum": "pierson_moskowitz", "gamma": 2.0}},
            "gamma = 2.0: belongs to jonswap",
        ),
        (
            {"sea": SEA | {"response": {"heave": {"frequencies": [1, 0.5], "amplitudes": [1, 2]}}}},
            "must increase",
        ),
        (
            {"sea": SEA | {"response": {"yaw": {"frequencies": [1, 2], "amplitudes": [1]}}}},
            "yaw.amplitudes: has 1",
        ),
        (
            {"sea": SEA | {"seed": -3}},
            "base_motion.sea.seed = -3: must be greater than or equal to 0",
        ),
        (
            {"sea": SEA | {"components": 10**9}},
            "sea.components = 1000000000: must be less than or equal to 1000",
        ),
        ({"sea": 5}, "base_motion.sea = 5: must be a group of keys: spectrum, significant_height"),
        ({"sea": SEA, "file": "motion.csv"}, "base_motion.sea: the file gives the whole motion"),
        ({"file": "nowhere.csv"}, "base_motion.file = 'nowhere.csv': cannot be read"),
    ],
    ids=lambda case: str(case)[:40],
)
def test_a_bad_motion_is_a_single_line_error(groups: Any, message: str) -> None:
    """Errors in the group have the key, its value and the possible values."""
    with pytest.raises(crane_sim.SceneError) as caught:
        scene_of(**groups)
    assert message in str(caught.value) and "\n" not in str(caught.value)
