"""What ends a run: travel limits, ropes that push or have zero length; hoists only pull."""

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import crane_sim
from crane_sim import SceneError, load_scene, orchestration, simulate_batch
from crane_sim.simulation.batch_metrics import run_with_metrics
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.status import SimulationError

FIXED = {"method": "rk4", "step": 0.005}
DIGITS = 1e-5  # s: times in messages have six digits

PUSHED: dict[str, Any] = {  # the point reaches its limit after one second: x = t² / 2
    "duration": 1.2,
    "integrator": FIXED,
    "initial": {"direction": [0.0, 0.0, -1.0]},
    "inputs": {"tip_x": {"kind": "constant", "value": 1.0}},
    "suspension.limits": {"x": [-1.0, 0.5]},
}
ROCKED = {
    "base_motion": {
        "surge": {"amplitude": 0.3, "frequency": 2.0},
        "roll": {"amplitude": 0.1, "frequency": 1.0},
    }
}
LIFTED = {
    "suspension": {"height": "driven", "limits": {"z": [-0.5, 1.0]}},
    "inputs": {"tip_z": {"kind": "constant", "value": -1.0}},
}
POINT: dict[str, tuple[dict[str, Any], str]] = {
    "open loop": ({}, "x"),
    "height": (LIFTED | {"suspension.limits": {"z": [-0.5, 1.0]}}, "z"),
    "moving base": (ROCKED, "x"),
    "drives": ({"actuators": {"all": {"rate_limit": 100.0}}}, "x"),
}
FALLING = {"control": None, "reference": None, "integrator": FIXED, "duration": 1.5}
DRAWN = {
    "integrator": FIXED,
    "duration": 0.3,
    "boom.limits": ["29 deg", "46 deg"],
    "initial.v": [0, -0.5, 0, 0, 0, 0],
}
KNUCKLE: dict[str, tuple[str, dict[str, Any], int, tuple[float, float], str]] = {
    "boom": (
        "knuckle_setpoint",
        FALLING | {"boom.limits": [0.0, 1.0]},
        1,
        (0.0, 1.0),
        "boom reached its travel limit",
    ),
    "rope": (
        "knuckle_setpoint",
        FALLING | {"rope.limits": [1, 3]},
        3,
        (1, 3),
        "rope reached its longest length",
    ),
    "continuous law": (
        "knuckle_continuous",
        DRAWN,
        1,
        (np.radians(29.0), 1.0),
        "boom reached its travel limit",
    ),
    "drives": (
        "knuckle_setpoint",
        DRAWN | {"actuators": {"all": {"lag": 0.02}}, "duration": 1.0},
        1,
        (np.radians(29.0), 1.0),
        "boom reached its travel limit",
    ),
}
WOUND = {
    "integrator": FIXED,
    "duration": 4.0,
    "inputs": {"rope": {"kind": "constant", "value": -0.5}},
}
HANGING = {"initial.q": [0, "45 deg", "-15 deg", 2.0, 0, 0]}
HAULED = WOUND | HANGING | {"inputs": {"rope": {"kind": "constant", "value": -15.0}}}
ROD: dict[str, Any] = {
    "crane": "overhead",
    "duration": 1.0,
    "trolley": {"mass": 50.0},
    "cable": {"lengths": 2.0, "node_masses": 10.0},
    "integrator": FIXED,
}
DROP = {"kind": "smooth", "from": 2.0, "to": 20.0, "start": 0.0, "duration": 1.0}
DROPPED = ROD | {"hoist": {"drive": "prescribed", "profile": DROP}}


def hoist_scene(effort: float, **hoist: Any) -> dict[str, Any]:
    """Return a scene whose hoist is driven by a force."""
    return ROD | {
        "hoist": {"drive": "force"} | hoist,
        "inputs": {"hoist": {"kind": "constant", "value": effort}},
    }


WINDING: dict[str, tuple[Any, dict[str, Any]]] = {
    "rate": ("knuckle_winch", WOUND | {"rope": {"drive": "rate"}}),
    "rate, long steps": (
        "knuckle_winch",
        WOUND | {"rope": {"drive": "rate"}, "integrator": {"method": "dop853"}},
    ),
    "force": ("knuckle_winch", HAULED | {"rope": {"drive": "force", "limits": [0.0, 5.0]}}),
    "massless winch": (hoist_scene(-300.0), {}),
}
SWUNG = {"integrator": FIXED, "initial": {"direction_rate": [4.0, 0.0, 0.0]}, "duration": 1.0}
RUNNING_OUT = {
    "integrator": FIXED,
    "duration": 0.5,
    "inputs": {"rope": {"kind": "constant", "value": 12.0}},
}
PUSHING: dict[str, tuple[Any, dict[str, Any], str]] = {
    "pendulum": ("pendulum_free", SWUNG, "rope.slack"),
    "rate": ("knuckle_winch", RUNNING_OUT | {"rope": {"drive": "rate"}}, "rope.slack"),
    "overhead": (DROPPED, {}, "cable.slack"),
    "straight": (
        DROPPED
        | {"cable": {"model": "straight", "lengths": [2.0, 1.0], "node_masses": [0.01, 10.0]}},
        {},
        "cable.slack",
    ),
}
FAR_DOWN = {"integrator": FIXED, "duration": 0.3}
LQR = {"law": "lqr", "period": "continuous"}
WINCH = FAR_DOWN | {"hoist": {"drive": "force"}}
LAWS: dict[
    str, tuple[Any, dict[str, Any], int]
] = {  # laws in the equations that want the rope to push, and its joint
    "knuckle": (
        "knuckle_continuous",
        FAR_DOWN | {"reference.q": [0, "30 deg", "-10 deg", 40.0]},
        3,
    ),
    "lqr": ("overhead_hoist_energy", WINCH | {"reference.q": [0.0, 80.0], "control": LQR}, 1),
}


class Run:
    """A run and how it ended."""

    def __init__(self, error: str, run: crane_sim.Rollout) -> None:
        """Take the error's line and what the run has of every period."""
        self.error, self.q, self.v, self.u, self.tension = error, run.q, run.v, run.u, run.tension
        self.limited = run.summary["saturated_steps"]

    @property
    def end(self) -> float:
        """When the run ended early [s]."""
        match = re.match("stopped at t = ([-+.e0-9]+) s: ", self.error)
        assert match, self.error
        return float(match[1])


def run_to_end(scene: Any, changes: dict[str, Any]) -> Run:
    """Run a scene to its end, early or not."""
    try:
        run, error = crane_sim.simulate(load_scene(scene, changes)), ""
    except SimulationError as failure:
        run, error = failure.run, str(failure)
    return Run(error, run)


@cache
def pushing_run(name: str, slack: str) -> Run:
    """Return a run whose rope would push, by what is allowed."""
    scene, changes, key = PUSHING[name]
    return run_to_end(scene, changes | {key: slack})


@pytest.mark.long
@pytest.mark.parametrize("name", POINT)
def test_the_suspension_point_stops_at_its_limits(name: str) -> None:
    """A point that accelerates by 1 m/s² to a limit half a metre away ends the run at 1 s.

    A drive whose effort rises by 100 1/s from 0 reaches that acceleration after 10 ms, which costs
    half of that time.
    """
    changes, axis = POINT[name]
    run = run_to_end("pendulum_free", PUSHED | changes)
    assert run.end == pytest.approx(1.005 if name == "drives" else 1.0, abs=DIGITS)
    assert (
        f"the suspension point along {axis} reached its travel limit; change "
        f"suspension.limits.{axis}" in run.error
    )


@pytest.mark.parametrize("name", KNUCKLE)
def test_joints_of_a_knuckle_crane_stop_at_their_limits(name: str) -> None:
    """A joint that reaches its limit ends the run in that period, and the cause is named.

    This holds whatever drives it.
    """
    scene, changes, joint, (low, high), message = KNUCKLE[name]
    run = run_to_end(scene, changes)
    assert f": the {message}; change " in run.error
    q, v = run.q[:, joint], run.v[:, joint]
    assert np.all((q >= low) & (q <= high))
    way = min(q[-1] - low, high - q[-1])
    # what is left of a period of 10 ms, some acceleration allowed for
    assert way < 0.012 * abs(v[-1])


@pytest.mark.parametrize("name", WINDING)
def test_a_rope_that_is_reeled_in_ends_the_run(name: str) -> None:
    """A winch that reels in all its rope ends the run with that cause.

    This holds with any drive, with swing and without.
    """
    run = run_to_end(*WINDING[name])
    assert " is reeled in to zero length; " in run.error
    if name.startswith("rate"):  # 2 - t² / 4 m long
        assert run.end == pytest.approx(8.0**0.5, abs=0.012)  # the rope ends up to 10 ms ahead


@pytest.mark.parametrize("name", PUSHING)
def test_a_rigid_rope_pushes_only_where_it_may(name: str) -> None:
    """A run goes on with negative tension by `slack: allow`, ends before by `slack: stop`.

    `allow` is the default.
    """
    allowed, stopped = pushing_run(name, "allow"), pushing_run(name, "stop")
    assert allowed.error == "" and allowed.tension.min() < -1e-3
    assert "went slack, and a rigid" in stopped.error
    first = int(np.argmax(allowed.tension < 0.0))
    assert stopped.end <= 0.01 * first and np.all(stopped.tension[:-1] >= 0.0)
    # the guard changes nothing before it fails
    assert np.array_equal(stopped.q, allowed.q[: len(stopped.q)])


def test_a_rope_goes_slack_when_mechanics_say_so() -> None:
    """A pendulum thrown aside, and a load that drops, go slack at a closed form's time.

    The load drops faster than in free fall.
    """
    g, length, rate = 9.81, 1.255, 4.0  # tension 0: cos = (2 - rate² l / g) / 3
    top = np.arccos((2.0 - rate**2 * length / g) / 3.0)
    expected = quad(
        lambda a: 1.0 / np.sqrt(rate**2 - 2.0 * g / length * (1.0 - np.cos(a))), 0.0, top
    )[0]
    assert pushing_run("pendulum", "stop").end == pytest.approx(expected, abs=1e-4)  # steps of 5 ms
    drop = brentq(lambda t: 18.0 * (60.0 * t - 180.0 * t**2 + 120.0 * t**3) - g, 0.0, 0.1)
    assert pushing_run("overhead", "stop").end == pytest.approx(drop, abs=DIGITS)


def test_a_winch_without_inertia_only_pulls() -> None:
    """A demand that pays out is applied as zero and counted, unless `push` is given.

    The load falls freely.
    """
    pulled, pushed = (run_to_end(hoist_scene(500.0, push=push), {}) for push in (False, True))
    assert np.all(pulled.u[:-1, 1] == 0.0) and np.all(pushed.u[:-1, 1] == 500.0)
    assert pulled.tension.min() >= 0.0 and pushed.tension.max() < 0.0
    assert (pulled.limited, pushed.limited) == (100, 0)
    assert pulled.q[-1, 1] == pytest.approx(2.0 + 0.5 * 9.81, abs=1e-9)  # exact for a parabola
    assert pushed.q[-1, 1] > pulled.q[-1, 1] + 10.0


def test_a_drum_pays_out_by_its_motor() -> None:
    """A force that pays out turns a drum: M l'' = F + T - c l', m l'' = m g - T.

    This holds while the rope pulls.
    """
    cable = {"model": "straight", "lengths": [2.0, 2.0], "node_masses": [4.0, 6.0]}
    scene = hoist_scene(30.0, inertia=20.0) | {"trolley": {"drive": "fixed"}, "cable": cable}
    run = crane_sim.simulate(
        load_scene(scene, {"friction.hoist": {"coulomb": 0.0, "static": 0.0, "viscous": 2.0}})
    )
    rate, end = 2.0 / 30.0, (30.0 + 98.1) / 2.0  # 1/s, m/s: l' = end (1 - exp(-rate t))
    paid = end * (1.0 - (1.0 - np.exp(-rate)) / rate)
    # of steps of 5 ms
    assert run.q[-1, run.scene.joint_names.index("hoist")] == pytest.approx(2.0 + paid, abs=1e-8)
    assert run.summary["min_rope_tension"] > 30.0 and run.summary["saturated_steps"] == 0
    assert np.all(run.u == 30.0)


@pytest.mark.parametrize("name", LAWS)
def test_laws_in_the_equations_only_pull(name: str) -> None:
    """A continuous law that wants a winch to push has zero applied, which is counted."""
    scene, changes, joint = LAWS[name]
    run = run_to_end(scene, changes)
    assert run.error == "" and np.all(run.u[:, joint] <= 0.0) and np.any(run.u[:, joint] == 0.0)
    assert run.tension.min() >= 0.0 and run.limited == np.sum(run.u[:-1, joint] == 0.0)


def test_inputs_that_push_are_counted_in_every_kind_of_run() -> None:
    """Periods that begin with an input that wants to push are counted by all ways to run.

    They are `simulate`, a `Plant` and a batch.
    """
    sine = {"kind": "sine", "offset": -50.0, "amplitude": 100.0, "frequency": 10.0}
    scene = load_scene(hoist_scene(0.0) | {"inputs": {"hoist": sine}})
    demands, plant = -50.0 + 100.0 * np.sin(10.0 * 0.01 * np.arange(100)), Plant(scene)
    for _ in range(100):
        plant.advance()
    (batched,), _ = run_with_metrics([scene])
    counts = [
        plant.saturated,
        batched.metrics["saturated_steps"],
        crane_sim.simulate(scene).summary["saturated_steps"],
    ]
    assert counts == [np.sum(demands > 0.0)] * 3


SLACK_CHAINS: dict[str, tuple[dict[str, Any], list[float]]] = {
    "planar": ({"initial": {"angles": [0.1, 0.2]}}, [0.1, 3.0]),
    "spatial": (
        {"dimensions": 3, "bridge": {"mass": 5.0}, "initial": {"directions": [[0, 0, -1]] * 2}},
        [0.0, 0.0, -1.0, 0.0, 0.0, 1.0],
    ),
}


@pytest.mark.parametrize(("name", "hoist"), [("planar", "prescribed"), ("spatial", "force")])
def test_chains_see_every_link(name: str, hoist: str) -> None:
    """A chain whose lower link stands on its upper one is slack there, however hoisted.

    This holds in the plane and in space.
    """
    groups, links = SLACK_CHAINS[name]
    cable = {"lengths": 2.0, "links": 2, "node_masses": 10.0, "slack": "stop"}
    drive = {
        "prescribed": {"drive": "prescribed", "profile": DROP | {"to": 3.0}},
        "force": {"drive": "force", "inertia": 5.0},
    }[hoist]
    scene = load_scene(ROD | {"cable": cable, "hoist": drive} | groups)
    plant = Plant(scene)
    top = [0.0, 2.0] if name == "planar" else [0.0, 0.0, 2.0]
    with pytest.raises(
        SceneError, match="positions: link 2 went slack, and a rigid link must be taut there"
    ):
        plant.reset((*top, *links))
    plant.reset(scene.initial_q)


def test_batches_end_at_stops() -> None:
    """A batch reports which crane reached its limit and when, with the error of a single run."""
    scene = load_scene("pendulum_free", PUSHED)
    batch = simulate_batch(scene, {"inputs.tip_x.value": [0.1, 1.0, 4.0]})
    errors = batch.errors
    assert errors[0] is None
    for t, error in zip((1.0, 0.5), errors[1:], strict=True):
        match = re.match(
            "stopped at t = ([.0-9]+) s: the suspension point along x reached", error or ""
        )
        assert match and float(match[1]) == pytest.approx(t, abs=DIGITS)
    with pytest.raises(SimulationError) as run_to_end:
        crane_sim.simulate(scene)
    assert str(run_to_end.value) == errors[1] and run_to_end.value.run.summary["event_count"] == 1


def test_a_run_over_ros_ends_at_a_stop(tmp_path: Path) -> None:
    """The plant ends where the crane reaches its limit, and the summary says why.

    The recording has every step.
    """
    summary = orchestration.run(load_scene("pendulum_free", PUSHED), record=tmp_path / "stop.rrd")
    assert "the suspension point along x reached its travel limit" in summary["error"]
    assert summary["recorded_steps"] == summary["steps"] > 90 and summary["lost_steps"] == 0


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        (
            "knuckle_setpoint",
            {"boom.limits": [1, 0]},
            "boom.limits = [1, 0]: must be [low, high] with low < high",
        ),
        (
            "knuckle_setpoint",
            {"jib.limits": [0, 1]},
            "jib.limits = [0.0, 1.0]: the jib starts outside of them, at -0",
        ),
        (
            "knuckle_setpoint",
            {"tower.limits": [0, 0.1]},
            "reference: the slew should end at 0.785398 rad, outside of",
        ),
        (
            "knuckle_pole",
            {"rope.limits": [0, 3]},
            "rope.limits: belong to a rope that a winch moves, this drive is",
        ),
        (
            "knuckle_winch",
            {"initial.q": [0, 0, 0, 1e-4, 0, 0]},
            "initial.q[3] = 0.0001: a rope of drive: rate is at least",
        ),
        (
            "pendulum_free",
            {"suspension.limits": {"z": [-1, 1]}},
            "suspension.limits.z: the height is fixed; take susp",
        ),
        ("overhead_lqr", {"trolley.limits": [-50, 0.01]}, "reference: the trolley should end at"),
        (
            "overhead_hoist",
            {"hoist.push": True},
            "hoist.push = True: belongs to a drive by force, here it is 'prescri",
        ),
    ],
)
def test_bad_limits_are_rejected_by_name(name: str, changes: dict[str, Any], message: str) -> None:
    """Limits that start or target do not keep, or of nothing, are single-line errors."""
    with pytest.raises(SceneError, match=re.escape(message)):
        load_scene(name, changes)
