"""Trolley and bridge driven by a force, prescribed or fixed: the same keys on all cranes."""

import math
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.description.falls import portal_of
from crane_sim.description.suspended import bridge_reach
from crane_sim.files.errors import SceneError
from crane_sim.recording.layout import layout_of_scene

MOTION = {"kind": "sine", "amplitude": 0.3, "frequency": 2.0}
PUSH = {"kind": "sine", "amplitude": 60.0, "frequency": 3.0}
DRY = {"coulomb": 3.0, "static": 5.0, "viscous": 2.0}
COMMON = {"duration": 1.0, "integrator": {"method": "dop853", "rtol": 1e-10, "atol": 1e-12}}
SWUNG = (0.3, 0.2)  # rad, tangential and radial
ROPE = {"rope": {"drive": "locked"}, "payload": {"mass": 5.0}}
FALLS = {
    "payload": {"mass": 5.0, "inertia": [0.5, 0.6, 0.7], "attachment": [0.0, 0.0, 0.3]},
    "falls": {
        "top": [[0.3, 0.3, 0.0], [-0.3, 0.3, 0.0], [-0.3, -0.3, 0.0], [0.3, -0.3, 0.0]],
        "bottom": [[0.3, 0.3, 0.3], [-0.3, 0.3, 0.3], [-0.3, -0.3, 0.3], [0.3, -0.3, 0.3]],
        "axial_stiffness": 1e5,
    },
}
AXES: dict[str, dict[str, Any]] = {
    "driven": {"trolley": {"mass": 8.0}, "bridge": {"mass": 3.0}},
    "fixed bridge": {"trolley": {"mass": 8.0}, "bridge": {"drive": "fixed"}},
    "fixed trolley": {"trolley": {"drive": "fixed", "mass": 8.0}, "bridge": {"mass": 3.0}},
    "both fixed": {"trolley": {"drive": "fixed"}, "bridge": {"drive": "fixed"}},
    "moved trolley": {
        "trolley": {"drive": "prescribed", "mass": 8.0, "motion": MOTION},
        "bridge": {"mass": 3.0},
    },
    "moved bridge": {"trolley": {"mass": 8.0}, "bridge": {"drive": "prescribed", "motion": MOTION}},
    "dry": {
        "trolley": {"mass": 8.0},
        "bridge": {"mass": 3.0},
        "friction": {"trolley": DRY, "bridge": DRY},
    },
}


def simulate(kind: str, axes: dict[str, Any]) -> Any:
    """Return a run of a mass on 2 m of rope or a body on a `gantry`'s falls, pushed if possible."""
    driven = [name for name in ("trolley", "bridge") if axes[name].get("drive", "force") == "force"]
    document: dict[str, Any] = COMMON | axes | {"crane": kind}
    if driven:
        document["inputs"] = dict.fromkeys(driven, PUSH)
    (s1, s2), (c1, c2) = np.sin(SWUNG), np.cos(SWUNG)
    if kind == "overhead":
        cable = {"lengths": [2.0], "node_masses": [5.0]}
        document |= {
            "dimensions": 3,
            "cable": cable,
            "initial": {"directions": [[s2, c2 * s1, -c2 * c1]]},
        }
    elif kind == "bridge":
        document |= ROPE | {"initial": {"q": [0.0, 0.0, 2.0, *SWUNG]}}
    else:
        document |= FALLS | {
            "hoist": {"drive": "rate"},
            "initial": {"length": 2.0, "velocity": [0.3, 0.1, 0.0]},
        }
    return crane_sim.simulate(document)


@pytest.mark.parametrize("case", AXES)
def test_overhead_and_bridge_are_one_crane(case: str) -> None:
    """The same trolley and bridge carry the same load along the same path, whatever drives them."""
    overhead, bridge = (simulate(kind, AXES[case]) for kind in ("overhead", "bridge"))
    assert overhead.scene.actuated == bridge.scene.actuated
    # rounding of 100 steps
    np.testing.assert_allclose(bridge.payload, overhead.payload, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(bridge.q[:, :2], overhead.q[:, :2], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("case", ["both fixed", "moved trolley", "fixed bridge"])
def test_a_gantry_has_these_axes_too(case: str) -> None:
    """Below axes that move as prescribed, or stay, a gantry's energy is what its drives supply."""
    run = simulate("gantry", AXES[case])
    for i, name in enumerate(("trolley", "bridge")):
        motion = 0.3 * np.sin(2.0 * run.t) if AXES[case][name].get("drive") == "prescribed" else 0.0
        if name not in run.scene.actuated:
            np.testing.assert_allclose(run.q[:, i], motion, rtol=0.0, atol=1e-9)
    assert run.summary["energy_audit_error"] < 1e-8


def test_a_law_moves_the_joint_that_is_driven() -> None:
    """With a fixed trolley laws move the bridge to its target or hold it; a picture is drawn."""
    follow = {
        "drive": "velocity",
        "servo": {"gain": math.inf, "max_speed": 1.0, "max_acceleration": 0.5},
    }
    law = {
        "control": {"law": "anti_swing", "period": 0.1, "damping": 0.1},
        "actuators": {"bridge": follow},
    }
    axes = {"trolley": {"drive": "fixed"}, "bridge": {"mass": 30.0}, "reference": {"q": [2.0, 2.0]}}
    document = (
        COMMON
        | ROPE
        | axes
        | law
        | {"crane": "bridge", "initial": {"q": [0.5, 0.0, 2.0, 0.0, 0.0]}}
    )
    run = crane_sim.simulate(
        document | {"duration": 3.0, "integrator": {"method": "rk4", "step": 0.1}}
    )
    assert run.q[-1, 0] == 0.5
    assert 0.5 < run.q[-1, 1] < 2.0
    assert layout_of_scene(run.scene, "").framing.size > 0.0
    follow_path = document | {
        "control": {"law": "joint_trajectory", "period": 0.1},
        "duration": 0.1,
    }
    assert crane_sim.simulate(follow_path | {"reference": None}).q[-1, 1] == pytest.approx(
        0.0, abs=1e-3
    )


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "input": (
        {"inputs": {"bridge": PUSH}},
        "inputs.bridge: drives nothing, bridge.drive = 'fixed'",
    ),
    "friction": ({"friction": {"bridge": DRY}}, "friction.bridge: belongs to a drive by force"),
    "speed": (
        {"initial": {"q": [0, 0, 2, 0, 0], "v": [0, 1, 0, 0, 0]}},
        r"initial.v\[1\] = 1: a fixed bridge",
    ),
    "target": (
        {"reference": {"q": [1.0, 2.0, 2.0]}},
        r"reference.q: has 3 values, actuated are \('trolley', 'rope'\)",
    ),
    "length": ({"reference": {"q": [1.0, 0.0]}}, r"reference.q\[1\] = 0: is a length"),
    "massless": ({"trolley": {"mass": 0.0}}, "trolley.mass = 0.0: .* must be greater than 0"),
    "mass": ({"bridge": {"drive": "fixed", "mass": 3.0}}, "bridge.mass = 3.0: nothing moves it"),
    "no motion": ({"bridge": {"drive": "prescribed"}}, "bridge.motion: is missing"),
    "start": (
        {"bridge": {"drive": "prescribed", "motion": MOTION | {"offset": 1.0}}},
        "the bridge is at 0 m, bridge.motion starts at 1 m",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_contradicts_an_axis_is_named(case: str) -> None:
    """What a fixed or a prescribed axis cannot have is refused in one line."""
    groups, match = REFUSED[case]
    document = (
        COMMON
        | ROPE
        | AXES["fixed bridge"]
        | {"crane": "bridge", "initial": {"q": [0, 0, 2, 0, 0]}}
        | groups
    )
    with pytest.raises(SceneError, match=match):
        crane_sim.load_scene(document)


@pytest.mark.parametrize("links", [0, 1], ids=["one rope", "a further link"])
def test_friction_of_the_swing_takes_its_energy(links: int) -> None:
    """Friction of swing joints damps a body on rope and links; the energy balance holds."""
    friction = {"swing_friction": {"model": "linear", "tangential": 4.0, "radial": 6.0}}
    chain = {
        "payload": FALLS["payload"],
        "rope": {"drive": "locked"},
        "links": [{"mass": 2.0, "length": 0.5}] * links,
    }
    axes = AXES["driven"] | {"crane": "bridge", "initial": {"q": [0.0, 0.0, 2.0, *SWUNG]}}
    run, free = (crane_sim.simulate(COMMON | axes | chain | more) for more in (friction, {}))
    assert run.energy[-1] < free.energy[-1] - 0.1
    assert run.summary["energy_audit_max"] < 1e-9  # of the tolerance of 1e-10 a step


PLAY = {"inertia": 5.0, "play": 0.02, "stiffness": 1e5, "damping": 100.0}
SERVO = {
    "gain": 400.0,
    "integral_time": 0.2,
    "max_speed": 0.6,
    "max_acceleration": 0.3,
    "max_jerk": 2.0,
}
DRIVEN: dict[str, dict[str, Any]] = {
    "inputs": {"inputs": {"trolley": PUSH}, "rope": {"drive": "locked"}},
    "rope": {
        "inputs": {"trolley": PUSH, "rope": {"kind": "constant", "value": 0.2}},
        "rope": {"drive": "rate", "time_constant": 0.2},
    },
    "servo": {
        "rope": {"drive": "rate", "time_constant": 0.2},
        "inputs": {"trolley": {"kind": "constant", "value": 0.3}},
        "actuators": {"trolley": {"drive": "velocity", "servo": SERVO}},
    },
}


def as_bridge(groups: Any) -> Any:
    """Return groups of a driven trolley as those of a driven bridge."""
    if not isinstance(groups, dict):
        return groups
    return {
        "bridge" if key == "trolley" else key: as_bridge(value) for key, value in groups.items()
    }


@pytest.mark.parametrize("case", DRIVEN)
def test_drives_with_play_are_those_of_their_own_axis(case: str) -> None:
    """A fixed trolley on a driven bridge with play moves as a trolley with the mass of both."""
    groups = DRIVEN[case] | {"backlash": {"trolley": [PLAY]}}
    common = COMMON | {
        "crane": "bridge",
        "payload": {"mass": 5.0},
        "initial": {"q": [0.0, 0.0, 2.0, 0.0, 0.0]},
    }
    straight = crane_sim.simulate(
        common | groups | {"trolley": {"mass": 11.0}, "bridge": {"drive": "fixed"}}
    )
    across = crane_sim.simulate(common | as_bridge(groups) | AXES["fixed trolley"])
    # of the tolerance
    np.testing.assert_allclose(across.q[:, [1, 2]], straight.q[:, [0, 2]], rtol=0.0, atol=1e-9)
    assert np.ptp(straight.q[:, 0]) > 0.01 and across.summary["energy_audit_error"] < 1e-8


@pytest.mark.parametrize("kind", ["bridge", "gantry"])
def test_a_girder_is_below_all_that_its_trolley_comes_to(kind: str) -> None:
    """A prescribed motion is in the picture: girder or portal reach as far as the trolley."""
    axes = {
        "trolley": {"drive": "prescribed", "motion": MOTION | {"amplitude": 30.0}},
        "bridge": {"mass": 3.0},
    }
    hanging = ROPE | {"initial": {"q": [0.0, 0.0, 2.0, 0.0, 0.0]}}
    if kind == "gantry":
        hanging = FALLS | {"hoist": {"drive": "rate"}, "initial": {"length": 2.0}}
    else:
        hanging["initial"]["v"] = [60.0, 0.0, 0.0, 0.0, 0.0]
    scene = crane_sim.load_scene(COMMON | axes | hanging | {"crane": kind})
    left, right = bridge_reach(scene, 2.0) if kind == "bridge" else portal_of(scene).ends
    assert left < scene.initial_q[0] < 29.9 < right
