"""The kink of the mean wind at the lowest height of its profile: steps end at it.

This holds for any method and crane.
"""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_wind_load import CRANES, TIME, nodes_of, windy

import crane_sim
from crane_sim import load_scene, system
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.gauss16 import Gauss16
from crane_sim.models.wind_kink import BAND, height_above_kink

SWUNG: dict[str, Any] = {
    "crane": "pendulum",
    "duration": 10.0,
    "rope": {"length": 5.0},
    "payload": {"mass": 100.0, "windage": {"area": 2.0, "drag_coefficient": 1.2}},
    "wind": {
        "speed": 12.0,
        "origin_height": 7.2,
        "profile": {"law": "power", "exponent": 0.2, "lowest": 3.0},
    },
    "initial": {"direction": [0.5**0.5, 0.0, -(0.5**0.5)]},
}
END = [0.9470024362710641, -4.90949960644633]
"""x and z after 10 s, of SciPy's DOP853 at 1e-12 between crossings of the kink that are located."""
METHODS: dict[
    str, tuple[dict[str, Any], float]
] = {  # and errors: without location 1e-6, 1e-8, 1e-6
    "gauss16": ({"method": "gauss16", "rtol": 1e-9}, 1e-9),
    "dop853": ({"method": "dop853", "rtol": 1e-13, "atol": 1e-15}, 1e-12),
    "rk8": ({"method": "rk8", "step": 0.05}, 1e-12),
}


@pytest.mark.parametrize("name", METHODS)
def test_steps_end_at_the_kink(name: str) -> None:
    """A load that swings through the kink twenty times is as accurate as in a smooth wind.

    This holds by every method.
    """
    method, error = METHODS[name]
    run = crane_sim.simulate(SWUNG, overrides={"integrator": method})
    np.testing.assert_allclose(run.payload[-1, [0, 2]], END, atol=error)
    assert run.events == []  # a kink is no event


def test_automatic_methods_take_kinks_for_switches() -> None:
    """With a tight tolerance `auto` takes order 16 only where the payload meets no kink."""
    tight = {"integrator": {"method": "auto", "rtol": 1e-9}}
    still = {"wind": None, "payload.windage": None}
    kinks: list[Any] = [{}, {"suspension.height": "driven", "wind.profile.lowest": 2.0}]
    kinks += [still | {"payload_drag": {"coefficient": 1.0}}]
    kinks += [still | {"swing_friction": {"model": "quadratic", "tangential": 1.0, "radial": 1.0}}]
    # 5 m of rope below 7.2 m
    smooth = [{"wind.profile": None}, {"wind.profile.lowest": 2.0}, still]
    methods = [load_scene(SWUNG, tight | changes).method for changes in (*kinks, *smooth)]
    assert [type(method) for method in methods] == [DOP853] * 4 + [Gauss16] * 3


BODY = {"mass": 100.0, "inertia": [30.0, 20.0, 40.0], "attachment": [0.3, -0.2, 0.5]}
TILTED = [0.9, 0.3, -0.3, 0.1]
LINKS = {
    "crane": "pendulum",
    "duration": 1.0,
    "rope": {"length": 2.0},
    "links": [{"mass": 5.0, "length": 0.7}],
}
ENDS = [[x, y, 0.0] for x in (0.4, -0.4) for y in (0.3, -0.3)]
BODIES: dict[str, dict[str, Any]] = {
    "body on links": LINKS
    | {
        "payload": BODY,
        "initial": {"direction": [0.6, 0.0, -0.8], "rigging": {"orientation": TILTED}},
    },
    "body on falls": {
        "crane": "pendulum",
        "duration": 1.0,
        "falls": {"top": ENDS, "bottom": ENDS, "axial_stiffness": 1e5},
        "payload": BODY,
        "initial": {"length": 2.0, "position": [0.2, 0.1, -2.8], "orientation": TILTED},
    },
}
CENTRE = np.array([0.4, 0.3, -0.6])


def pressed_height(name: str, scene: crane_sim.Scene) -> float:
    """Return the height in the world of the payload's pressure centre at TIME.

    The payload is in its initial state.
    """
    q, v = np.array(scene.initial_q), np.array(scene.initial_v)
    place = nodes_of(scene, q, v)(0.0)
    if name not in BODIES:
        return float(place[2])
    w, *xyz = np.array(TILTED) / np.linalg.norm(TILTED)
    lever = CENTRE - (np.array(BODY["attachment"]) if name == "body on links" else 0.0)
    return float(place[2] + Rotation.from_quat([*xyz, w]).apply(lever)[2])


@pytest.mark.parametrize("name", [*CRANES, *BODIES])
def test_heights_are_those_at_which_the_wind_presses(name: str) -> None:
    """The guard of a kink is the distance from it at which the wind acts on the payload.

    This holds for every crane.
    """
    document = windy(CRANES.get(name) or BODIES[name])
    if name in BODIES:
        document["payload"]["windage"] = document["payload"]["windage"] | {
            "centre": CENTRE.tolist()
        }
        key, value = (
            ("initial.rigging.orientation", "initial.orientation")[name == "body on falls"],
            np.array(TILTED),
        )
        document = load_scene(document, {key: (value / np.linalg.norm(value)).tolist()}).to_dict()
    scene = load_scene(document)
    height = 9.0 + pressed_height(name, scene)
    for side in (1.0, -1.0):
        model = load_scene(document, {"wind.profile.lowest": height - side * 0.01}).model
        x = system.state(model, TIME, np.array(scene.initial_q), np.array(scene.initial_v))
        # rounding
        assert height_above_kink(model, TIME, x) == pytest.approx(side * 0.01, abs=1e-12)
        assert system.kink_guard(model, 1.0, TIME, x, TIME, x) == pytest.approx(
            0.01 + BAND, abs=1e-12
        )
        assert system.kink_guard(model, 0.001, TIME, x, TIME, x) == 0.001


def test_a_guard_fails_on_the_other_side_of_a_kink() -> None:
    """The guard of a step is positive on the side where it begins, negative just beyond."""
    scene = load_scene(SWUNG)
    q, v = np.array(scene.initial_q), np.zeros(6)
    above, below = (
        system.state(scene.model, 0.0, np.array([*q[:3], np.sqrt(1.0 - z * z), 0.0, -z]), v)
        for z in (0.8, 0.9)
    )
    for begin, end in ((above, below), (below, above)):
        heights = [height_above_kink(scene.model, 0.0, x) for x in (begin, end)]
        assert heights[0] * heights[1] < 0.0
        assert system.kink_guard(scene.model, 9.0, 0.0, begin, 0.0, begin) == abs(heights[0]) + BAND
        assert system.kink_guard(scene.model, 9.0, 0.0, begin, 0.0, end) == BAND - abs(heights[1])
