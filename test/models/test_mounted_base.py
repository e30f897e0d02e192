"""A crane somewhere on a vessel: its base moves as a point of a rigid body that turns."""

from typing import Any

import mpmath
import numpy as np
import pytest

import crane_sim
from crane_sim import load_scene
from crane_sim.files.errors import SceneError
from crane_sim.recording.base_frame import base_rotations
from crane_sim.scenes.averaging import average
from crane_sim.simulation.base_state import base_state
from crane_sim.trajectories.base_motion import base_positions

MOTION = {
    "surge": {"amplitude": 0.4, "frequency": 0.5},
    "heave": {"amplitude": 0.8, "frequency": 0.7, "phase": 0.3},
    "roll": {"amplitude": "6 deg", "frequency": 0.9},
    "pitch": {"amplitude": "4 deg", "frequency": 0.6, "phase": 1.0},
    "yaw": {"amplitude": "3 deg", "frequency": 0.3, "offset": "20 deg"},
}
MOUNT = {"position": [12.0, -3.5, 4.0], "roll": "3 deg", "pitch": "-2 deg", "yaw": "90 deg"}
SEA = {
    "sea": {
        "significant_height": 2.0,
        "peak_period": 7.0,
        "components": 5,
        "response": {"heave": 1.0, "roll": 0.05},
    }
}


def on_ship(scene: str, motion: dict[str, Any], duration: float = 1.0) -> crane_sim.Scene:
    """Return a scene of the catalogue on a base that moves so."""
    return load_scene(scene, {"base_motion": motion, "duration": duration})


def turn(angles: Any) -> Any:
    """Return Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch, yaw."""
    (sr, sp, sy), (cr, cp, cy) = map(mpmath.sin, angles), map(mpmath.cos, angles)
    rz = mpmath.matrix([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    ry = mpmath.matrix([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    return rz * ry * mpmath.matrix([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])


def axes_at(base: Any, t: Any) -> list[Any]:
    """Return the six axes of sinusoids at time t."""
    rows = zip(base.offsets, base.amplitudes, base.frequencies, base.phases, strict=True)
    return [
        mpmath.mpf(o)
        + sum(
            mpmath.mpf(a) * mpmath.sin(mpmath.mpf(w) * t + mpmath.mpf(p))
            for a, w, p in zip(*r, strict=True)
        )
        for o, *r in rows
    ]


def differentiated(base: Any, gravity: float, t: float) -> list[np.ndarray]:
    """Return the fields of `BaseState`, differentiating the base's place and axes.

    It is done with 40 digits.
    """
    vessel = getattr(base, "vessel", base)
    arm = mpmath.matrix(getattr(base, "position", (0, 0, 0)))
    mount = mpmath.matrix(getattr(base, "rows", [[1, 0, 0], [0, 1, 0], [0, 0, 1]]))

    def axes(s: Any) -> Any:
        return turn(axes_at(vessel, s)[3:]) * mount

    def origin(s: Any) -> Any:
        x = axes_at(vessel, s)
        return mpmath.matrix(x[:3]) + turn(x[3:]) * arm

    def derivative(f: Any, n: int) -> Any:
        size = (f(t).rows, f(t).cols)
        parts = [
            [mpmath.diff(lambda s, i=i, j=j: f(s)[i, j], t, n) for j in range(size[1])]
            for i in range(size[0])
        ]
        return mpmath.matrix(parts)

    def vector(skew: Any) -> Any:
        return mpmath.matrix([skew[2, 1], skew[0, 2], skew[1, 0]])

    with mpmath.workdps(40):
        rotation, first = axes(t), derivative(axes, 1)
        inverse = rotation.T
        rate = inverse * first  # the skew matrix of the angular velocity, in the axes of the base
        second = inverse * derivative(axes, 2) - rate * rate  # of its derivative
        force = inverse * (derivative(origin, 2) + mpmath.matrix([0, 0, gravity]))
        fields = [origin(t), inverse * derivative(origin, 1), vector(rate), force, vector(second)]
        return [np.array(field.tolist(), dtype=float) for field in (rotation, *fields)]


@pytest.mark.parametrize(
    "motion", [MOTION, MOTION | {"mount": MOUNT}, SEA | {"mount": MOUNT}], ids=str
)
def test_velocities_and_accelerations_are_the_derivatives_of_the_place(
    motion: dict[str, Any],
) -> None:
    """Velocity, turning and specific force, also on a mount, are derivatives in 40 digits.

    They are the derivatives of the base's place and axes.
    """
    scene = on_ship("knuckle_setpoint", motion)
    for t in (0.0, 0.7, 13.1):
        state = base_state(scene, t)
        for actual, expected in zip(
            state, differentiated(scene.model.base, scene.model.gravity, t), strict=True
        ):
            # rounding at up to 25 m, 10 m/s²
            assert actual == pytest.approx(expected.reshape(actual.shape), abs=1e-13)


def test_a_mount_at_the_reference_point_changes_nothing() -> None:
    """A mount without lever arm and turn is the vessel's own motion."""
    plain, mounted = (
        crane_sim.simulate(on_ship("knuckle_setpoint", MOTION | more))
        for more in ({}, {"mount": {}})
    )
    assert mounted.q == pytest.approx(plain.q, abs=1e-12)  # rounding of sums in another order


@pytest.mark.parametrize("name", ["tower_gust", "knuckle_sea"])
def test_the_energy_audit_holds_on_a_mount(name: str) -> None:
    """What a mounted base gives a crane is what its energy gains, for each kind of crane."""
    run = crane_sim.simulate(on_ship(name, MOTION | {"mount": MOUNT}, 0.1))
    assert run.summary["energy_audit_max"] < 1e-9  # the solver's tolerance


def test_recordings_place_a_mounted_base() -> None:
    """The six axes of a mounted base are its place and turn, also beyond half a turn of yaw.

    Recordings draw these axes.
    """
    scene = on_ship("knuckle_setpoint", MOTION | {"mount": MOUNT | {"yaw": "170 deg"}})
    times = np.linspace(0.0, 9.0, 40)
    positions = base_positions(scene.model.base, times)
    assert np.abs(np.diff(positions[:, 5])).max() < 0.1  # no jump by a whole turn
    for t, row, turned in zip(times, positions, base_rotations(positions), strict=True):
        state = base_state(scene, t)
        assert row[:3] == pytest.approx(state.position, abs=1e-13)  # rounding
        assert turned == pytest.approx(state.rotation, abs=1e-14)


def test_the_mean_of_a_mounted_base_keeps_its_mount() -> None:
    """The mean over time, of which laws make their model, is the mount at the vessel's mean."""
    base = on_ship("knuckle_setpoint", MOTION | {"mount": MOUNT}).model.base
    mean = average(base)
    assert (mean.position, mean.rows) == (base.position, base.rows)
    assert base_positions(mean.vessel, np.zeros(1))[0] == pytest.approx(
        [0, 0, 0, 0, 0, np.radians(20.0)]
    )


@pytest.mark.parametrize(
    "mount", [{"position": [1.0, 0.5, 0.0]}, {"roll": 0.1}, {"yaw": "5 deg"}], ids=str
)
def test_a_mount_out_of_the_plane_of_a_crane_is_refused(mount: dict[str, Any]) -> None:
    """A crane in the plane stands in its plane."""
    with pytest.raises(SceneError, match=r"base_motion.mount: leaves the plane"):
        on_ship("overhead_energy", {"heave": {"amplitude": 0.1, "frequency": 1.0}, "mount": mount})
