"""Impossible inputs, and those probably in another unit: rejected, or named in the summary."""

import math
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import crane_sim
from crane_sim.cli import report
from crane_sim.models.supports.knuckle_boom import Rod
from crane_sim.scenes.scene import load_scene
from crane_sim.scenes.schema.rods import check_rods
from crane_sim.trajectories.waves import BREAKING_STEEPNESS, Sea, max_observed_steepness, steepness

PLANE = {
    "crane": "overhead",
    "duration": 1.0,
    "trolley": {"mass": 5.0},
    "cable": {"lengths": [1.0, 1.0], "node_masses": [1.0, 2.0]},
}
SPACE = PLANE | {"dimensions": 3, "bridge": {"mass": 3.0}}
ELASTIC = PLANE | {
    "cable": {
        "model": "elastic",
        "stiffness": 1e4,
        "lengths": [1.0, 1.0],
        "node_masses": [1.0, 2.0],
    }
}
DOWN = [0.0, 0.0, -1.0]
INCLINED = [0.6, 0.0, -0.8]
ROD = {"length": 5.0, "mass": 2.0, "inertia": 4.0}


def sea(height: float, period: float) -> dict[str, Any]:
    """Return the changes of a scene by a sea with this height [m] and peak period [s]."""
    return {"base_motion": {"sea": {"significant_height": height, "peak_period": period}}}


def positions(*rows: tuple[float, float]) -> dict[str, Any]:
    """Return the changes of a scene by these initial positions of an elastic cable's nodes."""
    return {"initial": {"x": 0.5, "positions": rows}}


REJECTED: list[tuple[Any, dict[str, Any], str]] = [
    (
        PLANE,
        {"initial.angles": [45]},
        "initial.angles[0] = 45: as radians more than half a turn; did you mean '45 deg'?",
    ),
    (
        PLANE,
        {"initial.angles": -4.0},
        "initial.angles[0] = -4.0: as radians more than half a turn; did you mean '-4 d",
    ),
    (PLANE, {"initial.angles": ["45"]}, "did you mean '45 deg'? (or '45 rad')"),
    (PLANE, {"initial.angles": [10**400]}, "as radians more than half a turn"),
    (PLANE, {"reference.q": ["2 deg"]}, "reference.q[0] = '2 deg': must be a number"),
    (
        PLANE,
        {"base_motion": {"pitch": {"amplitude": 5, "frequency": 1}}},
        "amplitude = 5: as radians more than an eighth",
    ),
    (
        PLANE,
        {"base_motion": {"pitch": {"amplitude": 3, "frequency": 1}}},
        "as radians more than an eighth of a turn",
    ),
    (
        PLANE,
        {"base_motion": {"pitch": {"amplitude": 0, "frequency": 1, "offset": 1.0}}},
        "did you mean '1 deg'?",
    ),
    (
        SPACE,
        {"base_motion": {"yaw": {"amplitude": 5, "frequency": 1}}},
        "amplitude = 5: as radians more than half",
    ),
    (
        PLANE,
        {"base_motion": {"heave": {"amplitude": 1, "frequency": 1, "phase": 90}}},
        "did you mean '90 deg'?",
    ),
    (
        PLANE,
        {"inputs": {"trolley": {"kind": "sine", "amplitude": 1, "frequency": 1, "phase": 90}}},
        "phase = 90: as",
    ),
    (
        "knuckle_setpoint",
        {"initial.q": [0, 45, -45, 2, 0, 0]},
        "initial.q[1] = 45: as radians more than a turn",
    ),
    (
        "knuckle_setpoint",
        {"initial.q": [0, 1, -1, 2, 5, 0]},
        "initial.q[4] = 5: as radians more than half a turn",
    ),
    (
        "knuckle_setpoint",
        {"reference.q": [90, 1, -1, 2]},
        "reference.q[0] = 90: as radians more than a turn",
    ),
    (
        "knuckle_springs",
        {"springs.jib.rest": -60},
        "springs.jib.rest = -60: as radians more than a turn",
    ),
    (
        "knuckle_setpoint",
        {"boom.axial_inertia": 9.0},
        "boom.axial_inertia = 9: no rigid body has more than twice its",
    ),
    (
        "knuckle_setpoint",
        {"jib": ROD | {"axial_inertia": 8.1}},
        "jib.axial_inertia = 8.1: no rigid body has more than",
    ),
    (
        "knuckle_setpoint",
        {"jib.mass": 0, "jib.inertia": 0},
        "jib.mass = 0: nothing resists the jib's effort; give it",
    ),
    (
        "knuckle_setpoint",
        {"boom.mass": 0, "boom.inertia": 0, "jib.inertia": 0},
        "boom.mass = 0: with boom and jib in line nothing resists",
    ),
    ("spreader_skew", {"falls.parts": True}, "falls.parts = True: must be a number"),
    (PLANE, {"cable.links": True}, "cable.links = True: must be a number"),
    (
        PLANE,
        {"forces": [{"node": True, "axis": "x", "force": {"kind": "constant", "value": 1.0}}]},
        "forces[0].node = True: must be a number",
    ),
    (
        PLANE,
        {
            "base_motion": {
                "sea": {
                    "significant_height": 1.0,
                    "peak_period": 8.0,
                    "response": {
                        "heave": {"frequencies": [0.1, 1.0], "amplitudes": [1.0, 0.5], "phases": []}
                    },
                }
            }
        },
        "base_motion.sea.response.heave.phases: has 0 values, frequencies has 2",
    ),
    (
        PLANE,
        sea(9.0, 6.0),
        "significant_height = 9: such waves break; at a peak period of 6 s at most 8.03 m are",
    ),
    (
        SPACE,
        {"initial": {"directions": [DOWN], "rates": [[0.1, 0.0, 0.2]]}},
        "initial.rates[0] = [0.1, 0.0, 0.2]: -0.2 of it is along link 1; the rate of a direction "
        "must be across it: "
        "[0.1, 0.0, 0.0]",
    ),
    (
        SPACE,
        {"initial": {"directions": [DOWN, INCLINED], "rates": [[0.1, 0.0, 0.0], [1.0, 0.0, 0.0]]}},
        "initial.rates[1] = [1.0, 0.0, 0.0]: 0.6 of it is along link 2",
    ),
    (
        ELASTIC,
        positions((0.5, -1.0), (0.5, -1.0)),
        "initial.positions[1] = [0.5, -1.0]: node 2 is at the position of node 1",
    ),
    (
        ELASTIC,
        positions((0.5, 0.0), (0.5, -1.0)),
        "initial.positions[0] = [0.5, 0.0]: node 1 is at the position of the tr",
    ),
    (
        PLANE,
        {"integrator": {"method": "dop853", "rtol": 1e-30}},
        "integrator.rtol = 1e-30: must be at least 2.3e-14",
    ),
    (
        PLANE,
        {"integrator": {"method": "dopri5", "atol": 0}},
        "integrator.atol = 0: must be greater than 0",
    ),
]


@pytest.mark.parametrize(
    ("scene", "changes", "line"), REJECTED, ids=[line[:40] for _, _, line in REJECTED]
)
def test_an_unlikely_input_is_a_single_line_error(
    scene: Any, changes: dict[str, Any], line: str
) -> None:
    """Values that no crane has, or of another unit, are rejected with key, value and options."""
    with pytest.raises(crane_sim.SceneError) as caught:
        load_scene(scene, changes)
    message = str(caught.value)
    assert line in message and "\n" not in message


@pytest.mark.parametrize(
    ("scene", "changes"),
    [
        (PLANE, {"initial.angles": [3.1416, "720 deg"]}),
        (PLANE, {"initial.angles": "45 rad"}),
        (PLANE, {"reference.q": [45.0]}),
        (
            PLANE,
            {
                "reference": {
                    "path": {"of": "joints", "kind": "line", "from": [9], "to": [45], "duration": 1}
                }
            },
        ),
        ("pendulum_free", {"reference.q": [45.0, -45.0]}),
        ("knuckle_setpoint", {"reference.q": ["450 deg", 0.5, -0.5, 45.0]}),
        ("knuckle_setpoint", {"boom.inertia": 4.0, "boom.axial_inertia": 8.0}),
        ("knuckle_setpoint", {"boom.mass": 0, "boom.inertia": 0}),
        (SPACE, {"initial": {"directions": [INCLINED], "rates": [[0.8, 1.0, 0.6]]}}),
        (
            SPACE,
            {
                "initial": {
                    "directions": [[0.19866933, 0.0, -0.98006658]],
                    "rates": [[0.98006658, 0, 0.19866933]],
                }
            },
        ),
        (ELASTIC, positions((0.5, -0.1), (0.5, 0.0))),
        (PLANE, {"integrator": {"method": "dop853", "rtol": 1e-13, "atol": 1e-14}}),
    ],
    ids=str,
)
def test_unusual_values_are_accepted(scene: Any, changes: dict[str, Any]) -> None:
    """Metres of any size, angles with unit, thin rods, rates almost across links are accepted."""
    assert load_scene(scene, changes).notes.get("warnings") is None


def inertia_matrix(boom: Rod, jib: Rod, angle: float) -> np.ndarray[Any, Any]:
    """Return the inertia matrix (2, 2) [kg m²] of boom and jib at a relative angle [rad]."""
    coupling = 0.5 * jib.mass * boom.length * jib.length * math.cos(angle)
    first = boom.inertia + (0.25 * boom.mass + jib.mass) * boom.length**2
    return np.array([[first, coupling], [coupling, jib.inertia + 0.25 * jib.mass * jib.length**2]])


@pytest.mark.parametrize(
    "masses",
    [(b, i, j, k) for b in (0, 1) for i in (0, 2) for j in (0, 3) for k in (0, 4)],
    ids=str,
)
def test_rods_of_singular_inertia_are_rejected(masses: tuple[float, ...]) -> None:
    """Boom and jib are rejected exactly if their inertia matrix is singular in some posture.

    The matrix is computed here.
    """
    boom, jib = Rod(5.0, masses[0], masses[1]), Rod(4.0, masses[2], masses[3])
    # of numbers like 1
    singular = min(np.linalg.det(inertia_matrix(boom, jib, angle)) for angle in (0.0, 1.0)) < 1e-9
    if singular:
        with pytest.raises(crane_sim.SceneError, match="mass = 0"):
            check_rods(boom, jib)
    else:
        check_rods(boom, jib)


@pytest.mark.parametrize(
    ("duration", "period", "steps"),
    [(1.015, 0.01, 101), (1.017, 0.01, 102), (0.0149, 0.01, 1), (2.0, 0.03, 67)],
)
def test_a_duration_is_rounded_to_whole_periods_with_a_note(
    duration: float, period: float, steps: int
) -> None:
    """A duration that is no multiple of the period is rounded to one; notes have both."""
    scene = load_scene("knuckle_setpoint", {"duration": duration, "control.period": period})
    assert scene.steps == steps and scene.duration == steps * period
    assert scene.notes["rounded"] == [f"duration: {duration:g} s is taken as {steps * period:g} s"]


@pytest.mark.parametrize(
    ("duration", "period"),
    [(0.3, 0.1), (40.0, 0.01), (1e5, 0.001), (10.0, 1.0 / 30.0), (0.7, 0.07)],
)
def test_whole_periods_are_not_rounded(duration: float, period: float) -> None:
    """A duration of whole periods, up to the rounding of doubles, is unchanged, without a note."""
    scene = load_scene("knuckle_setpoint", {"duration": duration, "control.period": period})
    assert scene.duration == duration and "rounded" not in scene.notes


def test_a_run_of_a_few_short_periods_is_possible() -> None:
    """A run below the default period is valid with a shorter one, also for the nominal model."""
    assert load_scene("knuckle_setpoint", {"duration": 0.005, "control.period": 0.001}).steps == 5


def test_notes_of_rounding_are_in_the_summary_and_at_the_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The notes on duration and delays are a list in a run's summary, printed a line each."""
    sensors = {"all": {"delay": 0.014}}
    scene = load_scene(
        "overhead_energy", {"duration": 0.055, "control.period": 0.01, "sensors": sensors}
    )
    lines = crane_sim.simulate(scene).summary["rounded"]
    assert (
        len(lines) == 2
        and lines[0].startswith("duration: 0.055 s")
        and lines[1].startswith("sensors")
    )
    report.print_notes({"rounded": lines, "warnings": ["steep"]}, Console())
    assert capsys.readouterr().out.splitlines() == [
        *(f"note:    {line}" for line in lines),
        "warning: steep",
    ]


def test_the_steepness_of_a_sea() -> None:
    """Steepness is height over the peak wave's g T² / (2 pi); steep seas warn, breaking fail."""
    length = 9.81 * 10.0**2 / (2.0 * math.pi)
    assert steepness(Sea(length / 20.0, 10.0)) == pytest.approx(1.0 / 20.0, rel=1e-14)  # rounding
    assert max_observed_steepness(4.0) == 1.0 / 15.0 and max_observed_steepness(20.0) == 1.0 / 25.0
    assert (
        "warnings"
        not in load_scene(PLANE, sea(0.99 * max_observed_steepness(10.0) * length, 10.0)).notes
    )
    (line,) = load_scene(PLANE, sea(0.99 * BREAKING_STEEPNESS * length, 10.0)).notes["warnings"]
    assert line.startswith(
        "base_motion.sea: its steepness is 1/7.07; at a peak period of 10 s measured seas stay "
        "below"
    )
    with pytest.raises(crane_sim.SceneError, match="such waves break"):
        load_scene(PLANE, sea(1.01 * BREAKING_STEEPNESS * length, 10.0))


def test_an_event_behind_the_end_is_a_warning() -> None:
    """A payload's change that the run does not reach is named, with the time of the run's end."""
    assert "warnings" not in load_scene("bridge_pick_up").notes
    late = load_scene("bridge_pick_up", {"duration": 1.0})
    count = len(late.document["events"])
    assert len(late.notes["warnings"]) == count > 0
    assert late.notes["warnings"][0].endswith("not reached, the run ends at 1 s")


@pytest.mark.parametrize(("duration", "at", "count"), [(10.004, 10.002, 1), (9.996, 9.998, 0)])
def test_events_are_compared_with_whole_periods(duration: float, at: float, count: int) -> None:
    """A duration is taken as whole periods, 10 s here: only what is before that is reached."""
    event = load_scene("bridge_pick_up").document["events"][0] | {"at": at}
    scene = load_scene("bridge_pick_up", {"duration": duration, "events": [event]})
    assert len(scene.notes.get("warnings", ())) == count
