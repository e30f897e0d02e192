"""Wind on cranes: forces and moments, work, and absence, against closed forms and points.

The points are followed through the world.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from moving_base import pose
from overhead_base_scenes import DIRECTIONS, LENGTHS, MASSES, PLANE, RATES, SHIP

import crane_sim
from crane_sim import system
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.states import add_scaled
from crane_sim.trajectories.wind import gust_at, speed_ratio

Array = np.ndarray[Any, Any]
# s; differences of order 4: 1e-12 of the fifth derivative, and 1e-13 from rounding
TIME, STEP = 1.7, 1e-3
DENSITY, AREA, DRAG = 1.3, 2.5, 1.1
WIND = {
    "speed": 13.0,
    "direction": "40 deg",
    "height": 15.0,
    "origin_height": 9.0,
    "density": DENSITY,
    "profile": {"law": "power", "exponent": 0.2},
    "gusts": {"spectrum": "dryden", "intensity": 0.3, "seed": 3},
}
WINDAGE = {"area": AREA, "drag_coefficient": DRAG}
Place = Callable[[float], Array]


def rate(place: Place) -> Array:
    """Return the derivative of a place at 0."""
    return (place(-2 * STEP) - 8.0 * place(-STEP) + 8.0 * place(STEP) - place(2 * STEP)) / (
        12.0 * STEP
    )


def wind_at(scene: crane_sim.Scene, height: float) -> Array:
    """Return the wind at a height of the world at TIME, from its definition."""
    wind, (u, v, w) = scene.model.wind, (gust_at(gust, TIME) for gust in scene.model.wind.gusts)
    angle = np.deg2rad(40.0)
    along, left = (
        np.array([np.cos(angle), np.sin(angle), 0.0]),
        np.array([-np.sin(angle), np.cos(angle), 0.0]),
    )
    mean = 13.0 * speed_ratio(wind.profile, 9.0 + height, 15.0)
    return (mean + u) * along + v * left + np.array([0.0, 0.0, w])


def force_on(scene: crane_sim.Scene, place: Place, along: Array | None = None) -> Array:
    """Return the force [N] on a point with a given place in the world from TIME on.

    For a rod `along` is its direction in the world.
    """
    v = wind_at(scene, place(0.0)[2]) - rate(place)
    v = v if along is None else v - along * (along @ v)
    return 0.5 * DENSITY * AREA * DRAG * np.linalg.norm(v) * v


def nodes_of(scene: crane_sim.Scene, q: Any, v: Any) -> Place:
    """Return the payload's place in the world, for joints that move at v from q on."""

    def place(s: float) -> Array:
        out = np.empty((system.point_count(scene.model), 3))
        state = system.state(scene.model, TIME + s, np.array(q) + s * np.array(v), np.array(v))
        system.points(scene.model, TIME + s, state, out)
        return out[-1]

    return place


KNUCKLE = {
    "crane": "knuckle",
    "duration": 0.4,
    "boom": {"length": 5.0, "mass": 80.0, "inertia": 160.0, "axial_inertia": 3.0},
    "jib": {"length": 3.0, "mass": 40.0, "inertia": 30.0},
    "tower": {"inertia": 50.0},
    "payload": {"mass": 15.0},
    "initial": {"q": [0.2, 0.7, -0.3, 2.0, 0.1, -0.2]},
}
PENDULUM = {
    "crane": "pendulum",
    "duration": 0.4,
    "rope": {"length": 1.3},
    "payload": {"mass": 10.0},
    "initial": {"direction": [0.6, 0.0, -0.8], "direction_rate": [0.4, 0.5, 0.3]},
}
CABLE = {"lengths": LENGTHS, "node_masses": MASSES}
PLANAR = {
    "crane": "overhead",
    "duration": 0.4,
    "trolley": {"drive": "force", "mass": 5.0},
    "hoist": {"drive": "force", "inertia": 4.0},
    "cable": CABLE,
    "payload": {"mass": MASSES[-1]},
    "initial": {
        "angles": [0.4, -0.2, 0.1],
        "rates": [0.3, 0.6, -0.5],
        "v": 0.8,
        "length_rate": 0.3,
    },
}
BRIDGE = {"dimensions": 3, "bridge": {"drive": "force", "mass": 3.0}}
SPATIAL = PLANAR | BRIDGE
SPATIAL["initial"] = {
    "directions": DIRECTIONS.tolist(),
    "rates": RATES.tolist(),
    "vy": 0.5,
    "length_rate": 0.3,
}
STIFF = CABLE | {"model": "elastic", "stiffness": 2e3, "damping": 5.0}
ELASTIC = SPATIAL | {"cable": STIFF}
CRANES = {
    "pendulum": PENDULUM | {"base_motion": SHIP},
    "knuckle": KNUCKLE | {"base_motion": SHIP},
    "plane": PLANAR | {"base_motion": PLANE},
    "space": SPATIAL | {"base_motion": SHIP},
    "elastic": ELASTIC | {"base_motion": SHIP},
}


def windy(document: dict[str, Any], **wind: Any) -> dict[str, Any]:
    """Return the document in wind, with a windage of its payload."""
    return document | {"payload": document["payload"] | {"windage": WINDAGE}, "wind": WIND | wind}


def pushed(document: dict[str, Any], force: Array) -> dict[str, Any]:
    """Return the document with a constant force [N] in the world on its payload, at TIME."""
    if document["crane"] != "overhead":
        return document | {
            "payload_force": {a: constant(x) for a, x in zip("xyz", force, strict=True)}
        }
    axes = "xyz" if "bridge" in document else "xz"
    own = pose(document.get("base_motion", {}), TIME)[0][0].T @ force
    node = len(MASSES)
    forces = [{"node": node, "axis": a, "force": constant(own["xyz".index(a)])} for a in axes]
    return document | {"forces": forces}


def constant(value: float) -> dict[str, Any]:
    """Return a constant input."""
    return {"kind": "constant", "value": float(value)}


@pytest.mark.parametrize("name", CRANES)
def test_the_force_on_a_payload(name: str) -> None:
    """Accelerations and power are those of the given force ½ ρ C A |v| v.

    v is from the payload's path in the world.
    """
    scene = crane_sim.load_scene(windy(CRANES[name]))
    q, v = np.array(scene.initial_q), np.array(scene.initial_v)
    v[:2] += [0.4, 0.1 if name in ("pendulum", "knuckle", "space", "elastic") else 0.0]
    u = [3.0, -2.0, 5.0, -40.0][: len(scene.actuated)]
    other = crane_sim.load_scene(pushed(CRANES[name], force_on(scene, nodes_of(scene, q, v))))
    expected = crane_sim.acceleration(other, q, v, u, TIME)
    # differences leave 1e-11 of velocities of 1e1, and accelerations are up to 1e2
    assert crane_sim.acceleration(scene, q, v, u, TIME) == pytest.approx(
        expected, rel=1e-9, abs=1e-9
    )
    powers = [power(s.model, q, v, tuple(u)) for s in (scene, other)]
    assert powers[0] == pytest.approx(powers[1], rel=1e-9)


@entry_point
def power(p, q, v, u):
    """Return the power that enters the model at TIME."""
    return system.power(p, TIME, system.state(p, TIME, q, v), u)


def test_the_moments_on_boom_and_jib() -> None:
    """Wind on the rods is the efforts Jᵀ F of forces across them at pressure centres.

    The centres are followed through the world.
    """
    centres = {"boom": 0.4, "jib": 0.8}
    document = KNUCKLE | {"base_motion": SHIP, "wind": WIND}
    for rod, centre in centres.items():
        document[rod] = KNUCKLE[rod] | {"windage": WINDAGE | {"centre": centre}}
    scene, still = (
        crane_sim.load_scene(document),
        crane_sim.load_scene(KNUCKLE | {"base_motion": SHIP}),
    )
    q, v = np.array(scene.initial_q), np.array([0.5, -0.3, 0.4, 0.2, -0.6, 0.7])

    def direction(angles: Array, i: int) -> Array:
        (s, c), (sa, ca) = ((np.sin(a), np.cos(a)) for a in (angles[i], angles[0]))
        return np.array([c * ca, c * sa, s])

    def local(angles: Array, rod: str) -> Array:
        boom = 5.0 * direction(angles, 1)
        return 0.4 * boom if rod == "boom" else boom + 0.8 * 3.0 * direction(angles, 2)

    efforts = np.zeros(3)
    for i, rod in enumerate(centres, 1):

        def world(s: float, rod: str = rod) -> Array:
            rotate, origin = pose(SHIP, TIME + s)
            return origin[0] + rotate[0] @ local(q + s * v, rod)

        turn = pose(SHIP, TIME)[0][0]
        force = force_on(scene, world, turn @ direction(q, i))
        jacobian = np.stack(
            [turn @ rate(lambda s, e=e, rod=rod: local(q + s * e, rod)) for e in np.eye(6)[:3]]
        )
        efforts += jacobian @ force
    u = np.array([30.0, -20.0, 50.0, -100.0])
    expected = crane_sim.acceleration(still, q, v, u + np.append(efforts, 0.0), TIME)
    assert crane_sim.acceleration(scene, q, v, u, TIME) == pytest.approx(
        expected, rel=1e-9, abs=1e-9
    )


TOWER = {
    "crane": "tower",
    "duration": 0.4,
    "slew": {"drive": "force", "inertia": 4e3},
    "trolley": {"mass": 50.0},
    "payload": {"mass": 15.0},
    "initial": {"q": [0.2, 12.0, 2.0, 0.1, -0.2]},
}
MOBILE = {
    "crane": "mobile",
    "duration": 0.4,
    "superstructure": {"inertia": 900.0, "foot": [-1.5, 2.0]},
    "boom": {"mass": 80.0, "centre": 2.0, "inertia": 160.0},
    "telescope": {"mass": 40.0, "centre": 2.5, "inertia": 90.0},
    "payload": {"mass": 15.0},
    "initial": {"q": [0.2, 0.7, 9.0, 2.0, 0.1, -0.2]},
}
SLEWING = {"tower": TOWER, "mobile": MOBILE}
AREA_OF_BOOM = {"width": AREA / 9.0, "drag_coefficient": DRAG}  # that of WINDAGE on the boom's 9 m


def wind_on_support(name: str) -> dict[str, Any]:
    """Return the scene of a slewing crane on a ship, with windages of its jibs or boom.

    The jibs are jib and counter-jib.
    """
    document = SLEWING[name] | {"base_motion": SHIP, "wind": WIND}
    if name == "mobile":
        return document | {"boom": MOBILE["boom"] | {"windage": AREA_OF_BOOM}}
    jibs = {
        "jib_windage": WINDAGE | {"centre": 21.0},
        "counter_jib_windage": WINDAGE | {"centre": -7.0},
    }
    return document | {"slew": TOWER["slew"] | jibs}


def pressure_centres(name: str, q: Array) -> list[tuple[Array, Array]]:
    """Return (place, unit vector along the rod) in base axes of every rod in the wind."""
    across = np.array([np.cos(q[0]), np.sin(q[0]), 0.0])
    if name == "tower":
        return [(centre * across, across) for centre in (21.0, -7.0)]
    along = np.cos(q[1]) * across + np.sin(q[1]) * np.array([0.0, 0.0, 1.0])
    # fixed on the boom while it telescopes
    return [(-1.5 * across + np.array([0.0, 0.0, 2.0]) + 4.5 * along, along)]


@pytest.mark.parametrize("name", SLEWING)
def test_the_moments_on_slewing_supports(name: str) -> None:
    """Wind on jibs and on a telescopic boom is the efforts Jᵀ F of forces across them.

    The forces act at the centres of pressure.
    """
    scene, still = (
        crane_sim.load_scene(wind_on_support(name)),
        crane_sim.load_scene(SLEWING[name] | {"base_motion": SHIP}),
    )
    q, nu = np.array(scene.initial_q), len(scene.actuated)
    v = np.array([0.05, -0.3, 0.4, 0.2, -0.6, 0.7])[: len(q)]
    turn, efforts, axes = pose(SHIP, TIME)[0][0], np.zeros(nu), np.eye(len(q))[:nu]
    for i, (_, along) in enumerate(pressure_centres(name, q)):

        def world(s: float, i: int = i) -> Array:
            rotate, origin = pose(SHIP, TIME + s)
            return origin[0] + rotate[0] @ pressure_centres(name, q + s * v)[i][0]

        force = force_on(scene, world, turn @ along)
        places = [lambda s, e=e, i=i: pressure_centres(name, q + s * e)[i][0] for e in axes]
        efforts += np.stack([turn @ rate(place) for place in places]) @ force
    u = np.array([30.0, -20.0, 50.0, -100.0])[:nu]
    expected = crane_sim.acceleration(still, q, v, u + efforts, TIME)
    assert crane_sim.acceleration(scene, q, v, u, TIME) == pytest.approx(
        expected, rel=1e-9, abs=1e-9
    )


def test_a_free_slew_weathervanes() -> None:
    """A jib with more area moment than its counter-jib is stable at rest only downwind.

    It is at rest downwind and upwind.
    """
    steady = {"speed": 13.0, "direction": 0.0, "density": DENSITY}
    scene = crane_sim.load_scene(wind_on_support("tower") | {"wind": steady, "base_motion": None})

    def slew_acceleration(angle: float) -> float:
        q = np.array([angle, 12.0, 2.0, 0.0, 0.0])
        return float(crane_sim.acceleration(scene, q, 0.0 * q, [0.0] * len(scene.actuated))[0])

    assert slew_acceleration(0.0) == 0.0 and abs(slew_acceleration(np.pi)) < 1e-18
    assert slew_acceleration(0.1) < 0.0 < slew_acceleration(-0.1)
    assert slew_acceleration(np.pi + 0.1) > 0.0 > slew_acceleration(np.pi - 0.1)


@pytest.mark.parametrize("name", CRANES)
def test_energy_changes_by_the_work(name: str) -> None:
    """The energy of a crane in wind changes by drives, losses, base and wind alone."""
    document = windy(CRANES[name])
    if name == "knuckle":
        document["boom"] = document["boom"] | {"windage": WINDAGE}
        document["jib"] = document["jib"] | {"windage": WINDAGE | {"centre": 0.9}}
    scene = crane_sim.load_scene(document)
    u = tuple([3.0, -2.0, 5.0, -40.0][: len(scene.actuated)])
    change, supplied = balance(scene.model, scene.initial_q, scene.initial_v, u, 1e-5)
    # central differences: truncation h² times a third derivative of 1e4 W/s², rounding 1e-16 E / h
    assert change == pytest.approx(supplied, rel=1e-6, abs=1e-5)


@entry_point
def balance(p, q, v, u, h):
    """Return (dE/dt by central differences along the motion, power) at TIME."""
    x = system.state(p, TIME, q, v)
    dx = system.rhs(p, TIME, x, u)
    ahead, behind = add_scaled(x, h, dx), add_scaled(x, -h, dx)
    gained = system.kinetic(p, ahead) + system.potential(p, ahead) - system.kinetic(p, behind)
    return (gained - system.potential(p, behind)) / (2.0 * h), system.power(p, TIME, x, u)


@pytest.mark.long
@pytest.mark.parametrize("name", ["knuckle", "plane", "elastic"])
def test_runs_keep_their_energy(name: str) -> None:
    """The audit of a run in gusts is 1e-9 at most: what the wind gives or takes is its work."""
    gusts = {"spectrum": "kaimal", "intensity": 0.3, "cut_off": 3.0}
    run = crane_sim.simulate(windy(CRANES[name], gusts=gusts))
    assert run.summary["energy_audit_max"] < 1e-9
    still = crane_sim.simulate(CRANES[name])
    assert np.max(np.abs(run.payload[-1] - still.payload[-1])) > 1e-3  # m: it blows


def test_a_load_hangs_where_wind_and_weight_balance() -> None:
    """In a steady wind along x the rope rests at the angle of tangent ½ ρ C A U² / (m g)."""
    force = 0.5 * DENSITY * DRAG * AREA * 13.0**2
    tangent = force / (10.0 * 9.81)
    angle = np.arctan(tangent)
    steady = {"gusts": None, "profile": None, "direction": 0.0}
    scene = crane_sim.load_scene(windy(PENDULUM, **steady))
    q = [0.0, 0.0, 0.0, np.sin(angle), 0.0, -np.cos(angle)]
    assert crane_sim.acceleration(scene, q, np.zeros(6), [0.0, 0.0]) == pytest.approx(
        np.zeros(6), abs=1e-12
    )


def test_wind_without_speed_is_drag_of_still_air() -> None:
    """In the limit of no speed the wind is the drag of still air, -k |v| v, k = ½ ρ C A.

    This holds on a moving base, too.
    """
    faint = crane_sim.load_scene(windy(CRANES["pendulum"], speed=1e-13, gusts=None))
    drag = {"payload_drag": {"coefficient": 0.5 * DENSITY * DRAG * AREA}}
    still = crane_sim.load_scene(CRANES["pendulum"] | drag)
    q, v = faint.initial_q, np.array(faint.initial_v) + [0.3, -0.2, 0.0, 0.0, 0.0, 0.0]
    actual, expected = (
        crane_sim.acceleration(scene, q, v, [0.0, 0.0], TIME) for scene in (faint, still)
    )
    assert actual == pytest.approx(expected, rel=1e-12, abs=1e-11)


ABSENT = {"speed": {"speed": 0.0}, "area": {"area": 0.0}}


@pytest.mark.parametrize(("name", "what"), [("knuckle", "speed"), ("plane", "area")])
def test_zero_strength_is_absence(name: str, what: str) -> None:
    """A wind without speed, or a windage of nothing, is no wind: states are equal bit for bit.

    The model is the same.
    """
    document = {key: value for key, value in CRANES[name].items() if key != "base_motion"} | {
        "duration": 0.05
    }
    zero = windy(document, **(ABSENT[what] if what == "speed" else {}))
    if what != "speed":
        zero["payload"] = zero["payload"] | {"windage": WINDAGE | ABSENT[what]}
    runs = [crane_sim.simulate(each) for each in (document, zero)]
    assert (
        type(runs[0].scene.model) is type(runs[1].scene.model) and runs[1].scene.model.wind is None
    )
    assert runs[0].summary["state_sha256"] == runs[1].summary["state_sha256"]
