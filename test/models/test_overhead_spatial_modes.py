"""How the overhead crane in space sticks and slips, drops its payload, hoists, and ends."""

from typing import Any

import numpy as np
import pytest
from spatial_scenes import REFERENCE, error_in_tolerances, sine, turned

import crane_sim
from crane_sim.simulation.plant import SimulationError
from crane_sim.simulation.rollout import simulate


def rubbing(name: str, axis: str, friction: Any, **groups: Any) -> crane_sim.Scene:
    """Return a planar reference along one axis of a crane whose axes have both friction."""
    spec, azimuth = REFERENCE[name]["spec"], {"trolley": 0.0, "bridge": 0.5 * np.pi}[axis]
    scene = turned(name, azimuth, friction={"trolley": friction, "bridge": friction}, **groups)
    document = scene.to_dict()
    if axis == "bridge":  # what moves along y is bridge and trolley together
        document["trolley"]["mass"] = 0.25 * spec["trolley_mass"]
        document["bridge"]["mass"] = 0.75 * spec["trolley_mass"]
    return crane_sim.load_scene(document)


@pytest.mark.long
@pytest.mark.parametrize("axis", ["trolley", "bridge"])
def test_stick_and_slip_on_either_axis(axis: str) -> None:
    """Trolley and bridge stick and slip as the planar reference, while the other axis sticks."""
    name = "19b_stick_slip_N3"
    run = simulate(
        rubbing(name, axis, REFERENCE[name]["spec"]["friction"]), sample_times=REFERENCE[name]["t"]
    )
    assert error_in_tolerances(run, name, 0.0 if axis == "trolley" else 0.5 * np.pi) < 1.0
    events = run.summary["events"]
    assert all(axis in event["what"] for event in events)
    times = np.array([event["t"] for event in events])
    expected = REFERENCE[name]["event_times"]
    # s, as the positions
    assert len(times) == len(expected) and np.max(np.abs(times - expected)) < 1e-9
    assert run.summary["energy_audit_error"] < 1e-10  # what friction takes is metered


def test_a_payload_that_drops() -> None:
    """Losing 99 % of the payload in mid-swing meets the reference in any plane.

    Friction of size zero does nothing.
    """
    name, azimuth = "13_payload_drop_N2", 0.7
    none = {"coulomb": 0.0, "static": 0.0, "viscous": 0.0}
    drop = {
        "events": [{"at": 1.0, "set": {"payload": {"mass": 1.0}}}],
        "friction": {"trolley": none, "bridge": none},
    }
    run = simulate(turned(name, azimuth, **drop), sample_times=REFERENCE[name]["t"])
    assert error_in_tolerances(run, name, azimuth) < 1.0
    assert run.summary["energy_audit_error"] < 1e-10


def wound(azimuth: float, **groups: Any) -> crane_sim.Scene:
    """Return the reference with a force-driven hoist in the plane at an azimuth."""
    spec = REFERENCE["08b_force_winch_N2"]["spec"]
    inputs = {"trolley": sine(), "bridge": sine(), "hoist": sine(spec["F_1"])}
    hoist = {"drive": "force", "inertia": spec["winch_inertia"]}
    start = turned("08b_force_winch_N2", azimuth).to_dict()["initial"] | {
        "length_rate": spec["l1dot0"]
    }
    return turned(
        "08b_force_winch_N2",
        azimuth,
        **({"inputs": inputs, "hoist": hoist, "initial": start} | groups),
    )


@pytest.mark.parametrize(
    ("groups", "message"),
    [
        (
            {"bridge": {"drive": "force", "mass": 0.0, "limits": [-0.2, 0.2]}},
            "the bridge reached its travel limit",
        ),
        (
            {
                "hoist": {"drive": "force", "inertia": 15.0, "push": True},
                "inputs": {"trolley": sine(), "bridge": sine(), "hoist": sine({"offset": 200.0})},
            },
            "went slack",
        ),
    ],
    ids=["limit", "slack"],
)
def test_what_ends_a_run(groups: dict[str, Any], message: str) -> None:
    """A bridge at its limit and a slack link end the run and are named."""
    cable = {"model": "rigid", "lengths": [3.0, 1.0], "node_masses": [0.5, 10.0], "slack": "stop"}
    with pytest.raises(SimulationError, match=message):
        # a plane in which only the bridge moves
        simulate(wound(0.5 * np.pi, cable=cable, **groups))
