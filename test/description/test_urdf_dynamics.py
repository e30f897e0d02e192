"""Masses, inertias and limits of a URDF are the simulated ones."""

from math import radians
from xml.etree import ElementTree

import numpy as np
import pytest
from urdf_kinematics import numbers, rotation

import crane_sim
from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.description.robot import UNBOUNDED
from crane_sim.files.catalogue import scene_files
from crane_sim.scenes.scene import Scene

pytestmark = pytest.mark.interpreted

AXIAL = {"boom.axial_inertia": 0.3, "jib.axial_inertia": 0.1}
LINKS = {"lengths": [1.5, 0.7, 0.4], "node_masses": [0.5, 0.2, 10.0]}
TROLLEY = {"crane": "overhead", "duration": 1.0, "trolley": {"mass": 5.0}}
HOIST = {"hoist": {"drive": "force", "inertia": 4.0}}
DRIVEN = {
    "knuckle": load_scene("knuckle_setpoint"),
    "knuckle with rods that turn": load_scene("knuckle_setpoint", AXIAL),
    "knuckle with a light tower": load_scene("knuckle_setpoint", {"tower.inertia": 0.5}),
    "hoisted rope": load_scene(TROLLEY | HOIST | {"cable": {"lengths": 2.0, "node_masses": 10.0}}),
    "chain of rods": load_scene(TROLLEY | {"cable": LINKS | {"inertia": [0.1, 0.02, 0.01]}}),
}
SPATIAL = TROLLEY | {"dimensions": 3, "bridge": {"mass": 9.0}, "cable": LINKS}
SPRINGS = {"lateral": {"stiffness": 7e3, "deflection": 0.1}, "vertical": {"stiffness": 7e3}}
BELOW = {"duration": 1.0, "payload": {"mass": 5.0}, "links": [{"mass": 2.0, "length": 1.5}]}
BENT_JIB = BELOW | {
    "crane": "tower",
    "slew": {"drive": "force", "inertia": 150.0},
    "trolley": {"mass": 8.0},
    "flexibility": SPRINGS | {"jib": {"mass": 4.0, "centre": 3.0, "inertia": 12.0}},
    "initial": {"q": [0.4, 6.0, 2.5, 0.2, -0.3]},
}
BENT_BOOM = BELOW | {
    "crane": "mobile",
    "superstructure": {"inertia": 30.0, "foot": [0.5, 1.2]},
    "boom": {"mass": 5.0, "centre": 2.0, "inertia": 4.0},
    "telescope": {"mass": 3.0, "centre": 1.5, "inertia": 2.0},
    "flexibility": SPRINGS,
    "initial": {"q": [0.4, 0.6, 7.0, 2.5, 0.2, -0.3]},
}
HOOK = {"links": BELOW["links"]}
MOVING = {
    "pendulum": load_scene("pendulum_free"),
    "hook and load below a point": load_scene("pendulum_free", HOOK),
    "hook and load below a knuckle boom": load_scene("knuckle_setpoint", HOOK | AXIAL | {"control": None}),
    "spatial chain": load_scene(SPATIAL),
    "jib that bends": load_scene(BENT_JIB),
    "boom that bends": load_scene(BENT_BOOM),
}

Frame = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def frames(robot: ElementTree.Element, names: tuple[str, ...], q: np.ndarray) -> dict[str, Frame]:
    """Return of each link (its axes (3, 3), its origin (3,), the Jacobians of its velocity and turning rate (3, n))."""
    n = len(names)
    frames: dict[str, Frame] = {"world": (np.eye(3), np.zeros(3), np.zeros((3, n)), np.zeros((3, n)))}
    joints = {joint.find("child").attrib["link"]: joint for joint in robot.iter("joint")}  # pyright: ignore

    def frame(link: str) -> Frame:
        if link not in frames:
            joint = joints[link]
            above = frame(joint.find("parent").attrib["link"])  # pyright: ignore[reportOptionalMemberAccess]
            frames[link] = beyond(joint, above, names, q)
        return frames[link]

    for link in joints:
        frame(link)
    return frames


def beyond(joint: ElementTree.Element, above: Frame, names: tuple[str, ...], q: np.ndarray) -> Frame:
    """Return the frame of a joint's child, from that of its parent."""
    turned, origin, moving, turning = above
    mimic, rate = joint.find("mimic"), np.zeros(len(names))
    if joint.attrib["type"] != "fixed":
        leader = joint.attrib["name"] if mimic is None else mimic.attrib["joint"]
        rate[names.index(leader)] = 1.0 if mimic is None else float(mimic.attrib["multiplier"])
    way = turned @ numbers(joint.find("origin"), "xyz")
    if joint.attrib["type"] == "prismatic":
        axis = turned @ numbers(joint.find("axis"), "xyz")
        way = way + axis * (rate @ q)
        return turned, origin + way, moving + np.cross(turning.T, way).T + np.outer(axis, rate), turning
    moving = moving + np.cross(turning.T, way).T
    if joint.attrib["type"] == "fixed":
        return turned, origin + way, moving, turning
    axis = numbers(joint.find("axis"), "xyz")
    return turned @ rotation(axis, rate @ q), origin + way, moving, turning + np.outer(turned @ axis, rate)


def mass_matrix(document: str, names: tuple[str, ...], q: np.ndarray) -> np.ndarray:
    """Return the mass matrix (n, n) of a URDF at joint positions q (n,), mimic joints included."""
    robot, matrix = ElementTree.fromstring(document), np.zeros((len(names), len(names)))
    placed = frames(robot, names, q)
    for link in robot.iter("link"):
        body = link.find("inertial")
        if body is None:
            continue
        turned, _, moving, turning = placed[link.attrib["name"]]
        centre = moving + np.cross(turning.T, turned @ numbers(body.find("origin"), "xyz")).T
        moments = [numbers(body.find("inertia"), key)[0] for key in ("ixx", "iyy", "izz")]
        matrix += numbers(body.find("mass"), "value")[0] * centre.T @ centre
        matrix += turning.T @ turned @ np.diag(moments) @ turned.T @ turning
    return matrix


@pytest.mark.parametrize("scene", DRIVEN.values(), ids=DRIVEN)
def test_efforts_accelerate_the_urdf_as_they_do_the_crane(scene: Scene) -> None:
    """The mass matrix of the URDF times what a unit effort adds to the simulated accelerations is that effort."""
    random = np.random.default_rng(1)
    q = np.array(scene.initial_q) + random.uniform(0.1, 0.4, len(scene.initial_q))
    v, nu = random.normal(size=len(q)), len(scene.actuated)
    matrix = mass_matrix(urdf(scene), scene.joint_names, q)
    if "hoist" in scene.joint_names:  # the drum, which the document names beside the joint
        matrix[1, 1] += scene.document["hoist"]["inertia"]
        assert "hoist.inertia = 4 kg" in urdf(scene)
    free = crane_sim.acceleration(scene, q, v, np.zeros(nu))
    for j, unit in enumerate(np.eye(nu)):
        added = crane_sim.acceleration(scene, q, v, unit) - free
        # differences of accelerations of up to 1e2 lose 1e-14, times masses of up to 2e2 kg m²
        assert matrix @ added == pytest.approx(np.eye(len(q))[j], abs=1e-9)


@pytest.mark.parametrize("scene", MOVING.values(), ids=MOVING)
def test_kinetic_energy_of_the_urdf_is_the_cranes(scene: Scene) -> None:
    """Where efforts are no forces, or coordinates not independent, the URDF has the simulated kinetic energy."""
    random, q = np.random.default_rng(2), np.array(scene.initial_q)
    links = [i for i, name in enumerate(scene.joint_names) if name.startswith("link_")]
    turns = random.normal(size=(len(links) // 3, 3))
    q[links] = (turns / np.linalg.norm(turns, axis=1, keepdims=True)).ravel()
    matrix = mass_matrix(urdf(scene), scene.joint_names, q)
    for _ in range(4):
        v = random.normal(size=len(q))
        rates, way = v[links].reshape(-1, 3), q[links].reshape(-1, 3)
        v[links] = (rates - np.sum(rates * way, axis=1, keepdims=True) * way).ravel()
        if scene.crane == "pendulum":
            v[2] = 0.0  # the height of this one is fixed
        moving = crane_sim.energy(scene, q, v) - crane_sim.energy(scene, q, np.zeros(len(q)))
        assert 0.5 * v @ matrix @ v == pytest.approx(moving, abs=1e-9)  # of energies of up to 1e3 J


def test_nothing_weighs_more_than_in_the_scene() -> None:
    """The masses of the links add up to those of the scene: none is invented for the eye."""
    scenes = {"knuckle": 2.0 + 3.0 + 1.0, "hoisted rope": 5.0 + 10.0, "pendulum": 4.0}
    for name, mass in scenes.items():
        robot = ElementTree.fromstring(urdf((DRIVEN | MOVING)[name]))
        assert sum(float(body.attrib["value"]) for body in robot.iter("mass")) == pytest.approx(mass)


def limits(scene: Scene) -> dict[str, tuple[str, dict[str, float]]]:
    """Return the type and the limits of each joint that moves."""
    robot, by_name = ElementTree.fromstring(urdf(scene)), {}
    for joint in robot.iter("joint"):
        limit = joint.find("limit")
        given = {} if limit is None else {key: float(value) for key, value in limit.attrib.items()}
        by_name[joint.attrib["name"]] = joint.attrib["type"], given
    return by_name


def test_limits_are_the_scenes() -> None:
    """What a scene bounds has these bounds in the URDF, even beyond what is drawn: travel, length, effort."""
    bounded = {"trolley": {"mass": 5.0, "limits": [-1.5, 300.0]}, "actuators": {"trolley": {"limit": [-20.0, 30.0]}}}
    hoist = {"hoist": {"drive": "force", "inertia": 4.0, "limits": [0.5, 80.0]}}
    actual = limits(load_scene(TROLLEY | hoist | bounded | {"cable": {"lengths": 2.0, "node_masses": 10.0}}))
    trolley = {"lower": -1.5, "upper": 300.0, "effort": 30.0, "velocity": UNBOUNDED}
    assert actual["trolley"] == ("prismatic", trolley)
    assert actual["hoist"] == ("prismatic", {"lower": 0.5, "upper": 80.0, "effort": UNBOUNDED, "velocity": UNBOUNDED})


def number(value: float | str) -> float:
    """Return a number of a file, which may be an angle in degrees."""
    return radians(float(value.removesuffix("deg"))) if isinstance(value, str) else value


@pytest.mark.parametrize("name", sorted(scene_files()))
def test_limits_of_the_catalogue_are_those_of_its_files(name: str) -> None:
    """Travel and effort of every joint of every scene are what its file says, and where it says nothing unbounded."""
    scene, document = load_scene(name), load_scene(name).to_dict()
    drives = document.get("actuators") or {}
    for joint, (kind, actual) in limits(scene).items():
        if joint not in scene.joint_names or joint.startswith("link_") or kind == "fixed":  # links: of unit vectors
            continue
        group = document.get(joint) or {}
        low, high = group.get("limits") or (0.0 if joint in ("rope", "hoist") else -UNBOUNDED, UNBOUNDED)
        drive = (drives.get("all") or {}) | (drives.get(joint) or {})
        bound = drive.get("limit") or UNBOUNDED
        effort = max(map(abs, bound)) if isinstance(bound, (list, tuple)) else bound
        takes_effort = joint in scene.actuated and scene.effort_units[scene.actuated.index(joint)] in ("N", "N m")
        if kind == "continuous":
            assert "limits" not in group and actual.keys() <= {"effort", "velocity"}
        else:
            assert (actual["lower"], actual["upper"]) == pytest.approx((number(low), number(high))), joint
        assert actual.get("effort", UNBOUNDED) == pytest.approx(effort if takes_effort else UNBOUNDED), joint
        assert actual.get("velocity", UNBOUNDED) == (drive.get("servo") or {}).get("max_speed", UNBOUNDED)


def test_no_limit_is_invented() -> None:
    """Where the scene has no limit, turning joints are continuous and the numbers of the others bound nothing."""
    actual = limits(DRIVEN["knuckle"])
    assert {kind for name, (kind, _) in actual.items() if name not in ("base", "rope")} == {"continuous"}
    free = {"upper": UNBOUNDED, "effort": UNBOUNDED, "velocity": UNBOUNDED}
    assert actual["rope"] == ("prismatic", {"lower": 0.0} | free)
    assert limits(DRIVEN["chain of rods"])["trolley"] == ("prismatic", {"lower": -UNBOUNDED} | free)
    effort = load_scene("knuckle_setpoint", {"actuators": {"boom": {"limit": 700.0}}})
    assert limits(effort)["boom"] == ("continuous", {"effort": 700.0, "velocity": UNBOUNDED})


def test_what_is_drawn_says_so() -> None:
    """The document itself tells drawings, which are not simulated, from masses and limits, which are."""
    for scene in (DRIVEN["knuckle"], DRIVEN["hoisted rope"], MOVING["pendulum"]):
        assert "every visual is a drawing" in urdf(scene)
        assert f"{UNBOUNDED:g} stands for no limit" in urdf(scene)
    assert "tower_link has no mass" in urdf(DRIVEN["knuckle"])
