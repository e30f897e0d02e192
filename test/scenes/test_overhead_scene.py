"""Scene files with an overhead crane: what is refused, and in which words."""

from typing import Any

import pytest

import crane_sim
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.gauss import Gauss
from crane_sim.integrators.rodas import Rodas
from crane_sim.scenes.schema.integrator import Auto, MethodRequirements, choose_method

BASE = {"crane": "overhead", "duration": 1.0, "trolley": {"mass": 5.0}}
CABLE = {"lengths": [1.0, 1.0], "node_masses": [1.0, 2.0]}
SPACE = {"dimensions": 3, "bridge": {"mass": 3.0}}
ELASTIC = {"model": "elastic", "stiffness": 1e4}
HOLLOW = {"node_masses": [0.0, 2.0]}
WINCH = {"drive": "force", "inertia": 2.0}
RUBS = {"coulomb": 1.0, "static": 2.0}
PUSH = {"node": 2, "axis": "x", "force": {"kind": "constant", "value": 1.0}}
WAVE = {"kind": "sine", "amplitude": 0.3, "frequency": 2.0}
RAISE = {"kind": "smooth", "from": 1.0, "to": 0.01, "duration": 0.5}
STEP = {"method": "rk4", "step": 0.01}


def imposed(**motion: Any) -> dict[str, Any]:
    """Return the groups of a trolley with a prescribed motion."""
    return {"trolley": {"drive": "prescribed", "motion": motion}}


def raised(**profile: Any) -> dict[str, Any]:
    """Return the groups of a hoist with a prescribed profile."""
    return {"hoist": {"drive": "prescribed", "profile": profile}}


BAD: list[tuple[dict[str, Any], str]] = [
    (
        {"trolley": {"drive": "acceleration"}},
        "trolley.drive = 'acceleration': is not possible; its integral, the speed ove",
    ),
    (
        {"actuators": {"trolley": {"drive": "acceleration"}}},
        "actuators.trolley.drive = 'acceleration': is not possible; i",
    ),
    (
        {"inputs": {"trolley": {"kind": "table", "times": [0, 1, 1], "values": [0, 0, 1]}}},
        "the times of a table must increase, here are [0.0, 1.0, 1.0]; a step is two times 1e-06 s "
        "apart",
    ),
    ({"trolley": {}}, "trolley.mass = None: a trolley driven by force has one"),
    (
        {
            "trolley": {"mass": 0},
            "cable": {"model": "elastic", "stiffness": 1e5, "lengths": 1, "node_masses": 1},
        },
        "trolley.mass = 0: belongs to rigid links; above an elastic cable a trolley has a mass",
    ),
    (
        {**SPACE, "trolley": {"drive": "fixed"}, "bridge": {}},
        "bridge.mass = None: a bridge driven by force",
    ),
    (
        {"trolley": {"mass": 1e300}},
        "trolley.mass = 1e+300: must be 0 or of a size of 1e-12 to 1e+12",
    ),
    ({"cable": {"lengths": [1e-320, 1.0]}}, "cable.lengths[0] = 1e-320: must be 0 or of a size"),
    ({"gravity": 1e200}, "gravity = 1e+200: must be 0 or of a size"),
    ({"initial": {"x": 1e300}}, "initial.x = 1e+300: must be within"),
    (
        {"integrator": {"method": "dop853", "rtol": 0.5}},
        "integrator.rtol = 0.5: must be at most 0.1",
    ),
    (
        {"integrator": {"method": "rk4", "step": 1e-10}},
        "integrator.step = 1e-10: must be at least 1e-09 s",
    ),
    ({"cable": HOLLOW, "hoist": WINCH}, "node 1 has no mass, which is not possible with hoist"),
    ({"cable": HOLLOW, "forces": [PUSH]}, "node 1 has no mass, which is not possible with forces"),
    (
        {"cable": HOLLOW, "joints": {"damping": 1.0}},
        "node 1 has no mass, which is not possible with joints",
    ),
    (
        {"cable": HOLLOW | {"inertia": 0.1}},
        "node 1 has no mass, which is not possible with cable.inertia",
    ),
    ({"bridge": {"mass": 3.0}}, "bridge: belongs to 3 dimensions, here are 2"),
    ({"friction": {"bridge": RUBS}}, "friction.bridge: belongs to 3 dimensions, here are 2"),
    ({"inputs": {"bridge": WAVE}}, "inputs.bridge: belongs to 3 dimensions, here are 2"),
    (
        {"inputs": {"hoist": WAVE}},
        "inputs.hoist: no force drives the hoist; driven by force: trolley",
    ),
    (
        {"trolley": {"drive": "fixed"}, "inputs": {"trolley": WAVE}},
        "inputs.trolley: no force drives the trolley",
    ),
    (
        {**SPACE, "bridge": None, "inputs": {"bridge": WAVE}},
        "inputs.bridge: no force drives the bridge",
    ),
    ({"trolley": {"drive": "fixed", "mass": 5.0}}, "trolley.mass = 5.0: nothing moves it"),
    ({**SPACE, "bridge": {"drive": "fixed", "mass": 5.0}}, "bridge.mass = 5.0: nothing moves it"),
    (
        {"trolley": {"drive": "fixed"}, "initial": {"v": 1.0}},
        "initial.v = 1.0: a fixed trolley is at rest",
    ),
    (
        {**SPACE, "bridge": None, "initial": {"vy": 1.0}},
        "initial.vy = 1.0: a fixed bridge is at rest",
    ),
    (
        {**imposed(**WAVE), "initial": {"x": 0.5}},
        "initial.x = 0.5: a prescribed trolley starts as trolley.motion",
    ),
    ({"initial": {"y": 1.0}}, "initial.y = 1.0: belongs to 3 dimensions"),
    (
        {"initial": {"length": 2.0}},
        "initial.length = 2.0: belongs to a hoist driven by force, here is none",
    ),
    (
        {**raised(**RAISE), "initial": {"length_rate": 1.0}},
        "initial.length_rate = 1.0: belongs to a hoist driven by",
    ),
    (
        {"initial": {"positions": [[0, -1], [0, -2]]}},
        "initial.positions: belong to cable.model: elastic",
    ),
    (
        {"cable": ELASTIC, "initial": {"positions": [[0, -1], [0, -2]], "angles": [0.1]}},
        "initial.angles: say the same",
    ),
    ({"initial": {"angles": []}}, "initial.angles"),
    (
        {**SPACE, "initial": {"directions": []}},
        "initial.directions = []: must have at least one entry",
    ),
    ({"initial": {"rates": [True, 0.0]}}, "initial.rates = [True, 0.0]: must be numbers"),
    ({"initial": {"rates": ["1.0", 0.0]}}, "initial.rates = ['1.0', 0.0]: must be numbers"),
    (
        {"cable": {"lengths": [2.0, 1.0]}, **raised(**RAISE)},
        "cable.lengths[0] = 2.0: hoist.profile starts at 1.0 m",
    ),
    (
        {"joints": {"damping": 1.0}, "cable": {"joints": {"damping": 1.0}}},
        "joints: stand also in cable.joints",
    ),
    ({"trolley": {"mass": 5.0, "limits": [1, -1]}}, "trolley.limits = [1.0, -1.0]: must increase"),
    ({"hoist": {**WINCH, "limits": [2, 1]}}, "hoist.limits = [2.0, 1.0]: must increase"),
    (
        {"trolley": {"mass": 5.0, "limits": [1, 2]}},
        "trolley.limits = [1.0, 2.0]: the trolley starts outside of them",
    ),
    (
        {"hoist": {**WINCH, "limits": [2, 3]}},
        "hoist.limits = [2.0, 3.0]: the hoist starts outside of them, at 1 m",
    ),
    (raised(**WAVE), "hoist.profile: starts at 0 m, must start greater than 0"),
    (
        imposed(**RAISE | {"duration": 1e-200}),
        "trolley.motion.duration = 1e-200: must be greater than or equal to",
    ),
    (
        imposed(kind="table", times=[0.0, 1e-200], values=[0, 1]),
        "times of a table must be at least 1e-06 s apart",
    ),
    (imposed(**RAISE | {"to": 1e308}), "trolley.motion: its values are too large"),
    (
        {"cable": ELASTIC | {"damping": 1e4}, "integrator": STEP},
        "integrator.step = 0.01: too large",
    ),
    ({"joints": {"damping": 50.0}, "integrator": STEP}, "integrator.step = 0.01: too large"),
    (
        {"friction": {"trolley": RUBS | {"viscous": 1e4}}, "integrator": STEP},
        "integrator.step = 0.01: too large",
    ),
    (
        {**raised(**RAISE), "integrator": {**STEP, "step": 0.05}},
        "integrator.step = 0.05: too large",
    ),
    (
        {"trolley": {"drive": "prescribed"}},
        "trolley.motion: is missing, a prescribed drive needs one",
    ),
    ({"hoist": {"drive": "prescribed"}}, "hoist.profile: is missing, a prescribed drive needs one"),
    (
        {"trolley": {"mass": 5.0, "motion": WAVE}},
        "trolley.motion: belongs to a prescribed drive, here it is 'force'",
    ),
    (imposed(kind="smooth", begin=0.0, end=1.0), "unknown key"),
    (imposed(kind="smooth", to=1.0), "from: is missing"),
    (imposed(kind="smooth", **{"from": 0.0, "to": "far"}), "to = 'far': must be a number"),
    ({"forces": [PUSH, PUSH | {"node": 3}]}, "forces[1].node = 3: the cable has nodes 1 .. 2"),
    ({"forces": [PUSH | {"axis": "y"}]}, "forces[0].axis = 'y': leaves the plane"),
    (
        {
            "reference": {"q": [1.0]},
            "control": {"law": "lqr", "nominal": {"trolley": {"mass": None}}},
        },
        "control.nominal: trolley.mass = None: a trolley driven by force",
    ),
]


def scene_of(groups: dict[str, Any]) -> crane_sim.Scene:
    """Return the scene of two links below a 5 kg trolley, changed by groups; `cable` adds to it."""
    return crane_sim.load_scene(BASE | groups | {"cable": CABLE | groups.get("cable", {})})


@pytest.mark.parametrize(("groups", "line"), BAD, ids=lambda case: str(case)[:50])
def test_a_bad_scene_is_a_single_line_error(groups: dict[str, Any], line: str) -> None:
    """Contradictory, ignored or uncomputable settings are single-line errors that name them."""
    with pytest.raises(crane_sim.SceneError) as caught:
        scene_of(groups)
    assert line in str(caught.value) and "\n" not in str(caught.value)


def test_without_gravity_a_fixed_step_is_not_bounded() -> None:
    """A cable at rest that nothing pulls has no frequency, and any step is safe."""
    assert scene_of({"gravity": 0.0, "integrator": STEP}).method.step == 0.01


def test_a_stiff_cable_under_a_continuous_law_is_not_given_a_method_that_cannot_run_it() -> None:
    """Method auto takes the stiff method, or dop853 where that one would be refused."""
    stiff = MethodRequirements(
        frequency=1e6, swing_angle=1.0, elastic=True, smooth=True, duration=1.0
    )
    assert isinstance(choose_method(Auto(), stiff)[0], Rodas)
    assert isinstance(choose_method(Auto(), stiff._replace(continuous=True))[0], DOP853)


@pytest.mark.parametrize(
    "groups",
    [
        {"trolley": {"mass": 2.0, "limits": [-9.0, 9.0]}},
        {"cable": {"slack": "stop"}},
        {"hoist": WINCH},
    ],
    ids=["limits", "slack", "hoist"],
)
def test_a_long_run_that_may_switch_is_not_given_a_symmetric_method(groups: dict[str, Any]) -> None:
    """Method auto takes Gauss for a long horizon only where nothing can switch or end the run."""
    long = {"duration": 10_000.0, "integrator": {"method": "auto"}}
    assert isinstance(scene_of(long).method, Gauss)
    assert isinstance(scene_of(long | groups).method, DOP853)
