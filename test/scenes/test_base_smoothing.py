"""Recorded base motions with noise: the rows' low pass, and the accelerations that they mean."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

import crane_sim
from crane_sim.scenes.schema.base_smoothing import smooth
from crane_sim.scenes.schema.recorded_motion import peak_accelerations, spline_base
from crane_sim.trajectories.base_motion import AXES

CUT_OFF = 0.5  # Hz
RANDOM = np.random.default_rng(5)
EVEN = np.arange(0.0, 100.0, 0.02)
UNEVEN = EVEN + RANDOM.uniform(-0.008, 0.008, len(EVEN))


def left_of(times: np.ndarray[Any, Any], frequency: float) -> complex:
    """Return amplitude and lead that the low pass leaves of a sinusoid [Hz], away from the ends."""
    w, middle = 2.0 * np.pi * frequency, (times > 25.0) & (times < 75.0)
    rows = smooth(times, np.cos(w * times)[:, None], CUT_OFF)[middle, 0]
    columns = np.stack([np.cos(w * times[middle]), -np.sin(w * times[middle])], axis=1)
    fitted = np.linalg.lstsq(columns, rows)[0]
    return complex(*fitted)


@pytest.mark.parametrize("times", [EVEN, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("ratio", [0.1, 0.5, 1.0, 2.0, 4.0])
def test_the_response_of_the_low_pass(times: np.ndarray[Any, Any], ratio: float) -> None:
    """A sinusoid at `ratio` times the cut-off keeps 1 / (1 + ratio⁴), in phase, on any rows.

    The rows are even or uneven in time.
    """
    # rows of 0.02 s sample a wave of 0.5 s, the shortest, 25 times: their sums are integrals to
    # 1e-3 and better
    assert abs(left_of(times, ratio * CUT_OFF) - 1.0 / (1.0 + ratio**4)) < 1e-3


def test_a_drift_stays_as_it_is() -> None:
    """The low pass leaves constants and straight lines unchanged, up to the very ends."""
    line = np.stack([3.0 + 0.2 * UNEVEN, -7.0 - 0.01 * UNEVEN], axis=1)
    assert np.max(np.abs(smooth(UNEVEN, line, 0.02) - line)) < 1e-11  # rounding of values up to 23


def written(folder: Path, noise: float, **columns: Any) -> str:
    """Return the path of a file with these columns over EVEN, and noise [m, rad] on each."""
    file = folder / "motion.csv"
    rows = [
        EVEN,
        *(column + noise * RANDOM.standard_normal(len(EVEN)) for column in columns.values()),
    ]
    np.savetxt(
        file,
        np.stack(rows, axis=1),
        delimiter=",",
        header=",".join(("time", *columns)),
        comments="",
        fmt="%.17g",
    )
    return str(file)


def on_base(dimensions: int = 2, **base_motion: Any) -> crane_sim.Scene:
    """Return a scene on a base that moves."""
    document = {
        "crane": "overhead",
        "dimensions": dimensions,
        "duration": 60.0,
        "trolley": {"drive": "fixed"},
    }
    cable = {"lengths": [5.0], "node_masses": [10.0]}
    return crane_sim.load_scene(document | {"cable": cable, "base_motion": base_motion})


def test_without_a_cut_off_the_spline_goes_through_the_rows(tmp_path: Path) -> None:
    """Without a low pass a file's numbers are those of the quintic spline, to the last bit."""
    file = written(tmp_path, 1e-3, heave=0.5 * np.sin(0.6 * EVEN))
    values = np.zeros((len(EVEN), len(AXES)))
    values[:, 2] = np.loadtxt(file, delimiter=",", skiprows=1)[:, 1]
    spline, base = make_interp_spline(EVEN, values, k=5), spline_base(file, 60.0)
    assert np.array_equal(base.coefficients[:, :, 0], spline(base.knots[:-1]).T)
    assert np.array_equal(base.coefficients[:, :, 2], spline(base.knots[:-1], nu=2).T / 2.0)


def test_noise_is_named_and_a_cut_off_takes_it_away(tmp_path: Path) -> None:
    """Millimetres of noise warn of their acceleration and name `cut_off`, which keeps motions."""
    file = written(tmp_path, 1e-3, heave=0.5 * np.sin(0.6 * EVEN), pitch=0.02 * np.sin(0.5 * EVEN))
    noisy = on_base(file=file).notes
    assert noisy["peak_base_acceleration"] > 10.0 and len(noisy["warnings"]) == 2
    assert all("motion.csv" in line and "cut_off" in line for line in noisy["warnings"])
    scene = on_base(file=file, cut_off=CUT_OFF)
    # of 1 mm at 50 Hz, 0.7 mm/s² rms are left behind this low pass, at the peaks four times that;
    # beside the ends more
    assert scene.notes["peak_base_acceleration"] == pytest.approx(0.5 * 0.6**2, abs=5e-3)
    assert scene.notes["peak_base_angular_acceleration"] == pytest.approx(0.02 * 0.5**2, abs=5e-3)
    assert "warnings" not in scene.notes
    # axes that the file does not name stay at rest
    assert not scene.model.base.coefficients[[1, 3, 5]].any()


def test_the_largest_acceleration_is_the_motions_own(tmp_path: Path) -> None:
    """The notes have the largest linear and angular acceleration within the run, by norm."""
    columns = {
        "surge": 0.3 * np.cos(EVEN),
        "heave": 0.4 * np.cos(EVEN),
        "roll": 0.1 * np.sin(2.0 * EVEN),
    }
    peaks, times = peak_accelerations(spline_base(written(tmp_path, 0.0, **columns), 60.0), 60.0)
    # between the nine looks at a piece of 0.02 s less than 1e-6 is missed; a quintic's second
    # derivative errs by h⁴
    assert peaks == pytest.approx([0.5, 0.4], rel=1e-5)
    assert np.abs(np.sin(times[0])) < 0.05 and np.abs(np.cos(2.0 * times[1])) < 0.05


@pytest.mark.parametrize(
    ("cut_off", "line"),
    [
        (0.0, "base_motion.cut_off = 0.0: must be greater than 0"),
        (
            1e-3,
            "base_motion.cut_off = 0.001: must be 0.01 to 25 Hz: the file covers 99.98 s, 50 rows "
            "a second",
        ),
        (30.0, "base_motion.cut_off = 30: must be 0.01 to 25 Hz"),
    ],
)
def test_a_cut_off_out_of_range_is_rejected(cut_off: float, line: str, tmp_path: Path) -> None:
    """A low pass that leaves everything, or only a line, is refused with what is possible."""
    with pytest.raises(crane_sim.SceneError) as caught:
        on_base(file=written(tmp_path, 0.0, heave=np.sin(EVEN)), cut_off=cut_off)
    assert line in str(caught.value) and "\n" not in str(caught.value)


def test_a_cut_off_without_a_file_is_rejected() -> None:
    """Sinusoids have no rows to be smoothed: a cut-off beside them is refused by name."""
    with pytest.raises(
        crane_sim.SceneError,
        match=r"base_motion.cut_off = 1: smooths the rows of a file, and there is",
    ):
        on_base(heave={"amplitude": 0.1, "frequency": 1.0}, cut_off=1.0)
