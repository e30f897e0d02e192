"""A crane's disturbances at their mean, for LQR and brakes, independent of t = 0."""

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hardware_scenes import ROD

import crane_sim
from crane_sim.models.effects import PayloadForce
from crane_sim.models.supports.hoist import PrescribedHoist
from crane_sim.models.supports.rails import PrescribedAxis
from crane_sim.scenes.averaging import average, average_scene
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.hardware import joint_mechanics
from crane_sim.simulation.rollout import simulate
from crane_sim.trajectories.base_motion import Base, base_motion_at, base_positions
from crane_sim.trajectories.inputs import Constant, Polynomial, Sine, Table
from crane_sim.trajectories.profiles import SineMotion

SWING = {"frequency": 0.7, "phase": "90 deg"}  # most of the acceleration at t = 0
LIST = {"roll": {"amplitude": 0.0, "frequency": 0.7, "offset": "3 deg"}}


def test_forces_are_at_their_mean() -> None:
    """Constants stay, sines leave their offset, tables their mean, others none; types stay."""
    cases: tuple[tuple[Any, Any], ...] = (
        (Constant(2.0), Constant(2.0)),
        (Sine(3.0, 0.7, 1.5, pi / 2), Sine(0.0, 0.0, 1.5)),
        (Sine(3.0, 0.0, 1.5, pi / 2), Sine(0.0, 0.0, 4.5)),
        (Polynomial((2.0, 0.0)), Polynomial((2.0, 0.0))),
        (Polynomial((2.0, 1.0)), Polynomial((0.0, 0.0))),
        (Table((0.0, 1.0), (3.0, 3.0)), Table((0.0, 1.0), (3.0, 3.0))),
        (
            Table((0.0, 1.0, 4.0), (2.0, 4.0, 0.0)),
            Table((0.0, 1.0, 4.0), (2.25, 2.25, 2.25)),
        ),  # (3 + 6) / 4
    )
    for force, mean in cases:
        assert average(force) == mean and type(average(force)) is type(force)
        assert average(PayloadForce(y=force)) == PayloadForce(y=mean)


@pytest.mark.parametrize("drive", [PrescribedAxis, PrescribedHoist])
def test_prescribed_drives_rest(drive: Any) -> None:
    """A drive whose motion is given has no acceleration, at any time."""
    motion = average(drive(SineMotion(0.2, 1.0, 1.8, pi / 2).motion()))[0]
    assert not motion.coefficients[:, 1:].any() and motion.amplitude == 0.0


def test_a_base_rests_at_the_mean_of_its_motion(tmp_path: Path) -> None:
    """Sinusoids leave their offsets, a record its mean, neither a velocity nor an acceleration."""
    t = np.linspace(0.0, 10.0, 101)
    roll = 0.1 + 0.05 * np.sin(0.2 * pi * t) + 0.002 * t**2
    np.savetxt(
        tmp_path / "roll.csv",
        np.column_stack([t, roll]),
        delimiter=",",
        header="time,roll",
        comments="",
    )
    still = {"amplitude": 0.3, "frequency": 0.0, "phase": pi / 2}
    # of t² over 10 s
    record, mean = {"file": str(tmp_path / "roll.csv")}, 0.1 + 0.002 * 100.0 / 3.0
    moving = {
        "heave": SWING | {"amplitude": 2.0},
        "roll": [SWING | {"amplitude": 0.1, "offset": 0.2}, still],
    }
    for motion, expected in ((moving, 0.5), (record, mean)):
        base = average_scene(
            load_scene("knuckle_setpoint", {"base_motion": motion, "duration": 5.0})
        ).model.base
        positions = base_positions(base, np.array([0.0, 3.0]))
        # the spline's own error: (0.2 pi 0.1 s)^6, and some digits of rounding
        assert np.allclose(positions, [[0.0, 0.0, 0.0, expected, 0.0, 0.0]] * 2, rtol=0, atol=1e-8)
        _, v, a = (np.array(part) for part in motion_at(base, 2.0))
        assert not v.any() and not a.any()


def bases_in(part: Any) -> list[Base]:
    """Return the moving bases anywhere in a model."""
    if isinstance(part, Base):
        return [part]
    return [base for each in part for base in bases_in(each)] if isinstance(part, tuple) else []


@pytest.mark.parametrize(
    "name", ["set_down_on_deck", "spreader_pick_up", "knuckle_sea", "tower_gust"]
)
def test_nothing_in_a_model_moves_at_the_mean(name: str) -> None:
    """Every moving base in a model, below the crane or a deck, becomes a base at rest."""
    scene = load_scene(name)
    moving, still = (bases_in(each.model) for each in (scene, average_scene(scene)))
    assert len(moving) == len(still) and not any(base.amplitudes.any() for base in still)
    assert not bases_in(scene.model) or any(base.amplitudes.any() for base in moving)


@crane_sim.numerics.jit.entry_point
def motion_at(base: Any, t: float) -> Any:
    """Compiled `base_motion_at` for calls from Python."""
    return base_motion_at(base, t)


def numbers_of(law: Any) -> np.ndarray:
    """Return all numbers of an LQR law in one vector: target, efforts and gains."""
    numbers = [law.target]
    for row in law.rows:
        numbers += [[row.effort], row.gain]
    return np.concatenate(numbers)


PITCHED = {
    "base_motion": {"pitch": SWING | {"amplitude": "3 deg"}},
    "forces": [{"node": 1, "axis": "x", "force": SWING | {"kind": "sine", "amplitude": 10.0}}],
}
WINDAGE = {"payload.windage": {"area": 0.02, "drag_coefficient": 1.2}}
BREEZE = {"wind": {"speed": 5.0, "direction": 0.5}}
GUSTY = {"wind": BREEZE["wind"] | {"gusts": {"spectrum": "dryden", "intensity": 0.5}}}
CASES: dict[str, tuple[str, dict[str, Any], dict[str, Any]]] = {
    "surge": ("knuckle_lqr", {"base_motion": {"surge": SWING | {"amplitude": 0.5}}}, {}),
    "roll": ("knuckle_lqr", {"base_motion": {"roll": SWING | {"amplitude": "5 deg"}}}, {}),
    "sea": (
        "knuckle_lqr",
        {"base_motion": {"sea": {"significant_height": 2.0, "peak_period": 9.0}}},
        {},
    ),
    "list": (
        "knuckle_lqr",
        {"base_motion": {"roll": SWING | {"amplitude": "2 deg", "offset": "3 deg"}}},
        {"base_motion": LIST},
    ),
    "gusts": ("knuckle_lqr", WINDAGE | GUSTY, WINDAGE | BREEZE),
    "wind": (
        "knuckle_lqr",
        {"payload_force": {"x": SWING | {"kind": "sine", "amplitude": 3.0}}},
        {},
    ),
    "pitch and gusts": ("overhead_lqr", PITCHED, {}),
}


@pytest.mark.parametrize("case", CASES, ids=lambda name: name.replace(" ", "-"))
def test_lqr_is_computed_at_the_mean(case: str) -> None:
    """LQR on a moving base, under a varying force, is that of a base at rest without the force."""
    name, disturbed, mean = CASES[case]
    law, at_mean = (load_scene(name, changes).law for changes in (disturbed, mean))
    expected = numbers_of(at_mean)
    # one mean in two types of model: rounding over the differences' step, 1e-11, and what Riccati
    # equations lose
    assert np.allclose(numbers_of(law), expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


@pytest.mark.long
def test_lqr_holds_the_target_on_a_surging_base() -> None:
    """LQR ends as near to its target with the base in its nominal scene as without."""
    moving = {"base_motion": {"surge": SWING | {"amplitude": 0.5}}, "control.period": 0.1}
    own, ignoring = (
        simulate(load_scene("knuckle_lqr", moving | {"control.nominal": nominal}), duration=30.0)
        for nominal in ({}, {"base_motion": None})
    )
    # swung by the base; 0.35 about t = 0
    assert max(map(abs, own.summary["final_error"].values())) < 0.1
    # two laws that differ by 1e-6 of their gains, see above
    assert np.allclose(own.q, ignoring.q, rtol=0, atol=1e-5)


def test_default_brakes_do_not_depend_on_the_instant() -> None:
    """Brakes are computed with a base at rest, independent of the base's motion at t = 0."""
    still, pitching = (
        joint_mechanics(load_scene(ROD | changes))
        for changes in ({}, {"base_motion": PITCHED["base_motion"]})
    )
    for one, other in zip(still, pitching, strict=True):
        # of two models of one crane: rounding, over a small velocity
        assert np.allclose(one, other, rtol=1e-9)
