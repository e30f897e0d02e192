"""Masses, inertias and limits of a crane's URDF are those of the simulation."""

from math import radians
from typing import NamedTuple
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

AXIAL = {"boom.axial_inertia": 0.3, "jib.axial_inertia": 0.1}
LINKS = {"lengths": [1.5, 0.7, 0.4], "node_masses": [0.5, 0.2, 10.0]}
TROLLEY = {"crane": "overhead", "duration": 1.0, "trolley": {"mass": 5.0}}
HOIST = {"hoist": {"drive": "force", "inertia": 4.0}}
ACTUATED_SCENES = {
    "knuckle": load_scene("knuckle_setpoint"),
    "knuckle with rods that turn": load_scene("knuckle_setpoint", AXIAL),
    "knuckle with a light tower": load_scene("knuckle_setpoint", {"tower.inertia": 0.5}),
    "hoisted rope": load_scene(TROLLEY | HOIST | {"cable": {"lengths": 2.0, "node_masses": 10.0}}),
    "chain of rods": load_scene(TROLLEY | {"cable": LINKS | {"inertia": [0.1, 0.02, 0.01]}}),
}
SPATIAL = TROLLEY | {"dimensions": 3, "bridge": {"mass": 9.0}, "cable": LINKS}
SPRINGS = {"lateral": {"stiffness": 7e3, "deflection": 0.1}, "vertical": {"stiffness": 7e3}}
HOOK_AND_LOAD = {"duration": 1.0, "payload": {"mass": 5.0}, "links": [{"mass": 2.0, "length": 1.5}]}
BENT_JIB = HOOK_AND_LOAD | {
    "crane": "tower",
    "slew": {"drive": "force", "inertia": 150.0},
    "trolley": {"mass": 8.0},
    "flexibility": SPRINGS | {"jib": {"mass": 4.0, "centre": 3.0, "inertia": 12.0}},
    "initial": {"q": [0.4, 6.0, 2.5, 0.2, -0.3]},
}
BENT_BOOM = HOOK_AND_LOAD | {
    "crane": "mobile",
    "superstructure": {"inertia": 30.0, "foot": [0.5, 1.2]},
    "boom": {"mass": 5.0, "centre": 2.0, "inertia": 4.0},
    "telescope": {"mass": 3.0, "centre": 1.5, "inertia": 2.0},
    "flexibility": SPRINGS,
    "initial": {"q": [0.4, 0.6, 7.0, 2.5, 0.2, -0.3]},
}
HOOK = {"links": HOOK_AND_LOAD["links"]}
FREE_SCENES = {
    "pendulum": load_scene("pendulum_free"),
    "hook and load below a point": load_scene("pendulum_free", HOOK),
    "hook and load below a knuckle boom": load_scene(
        "knuckle_setpoint", HOOK | AXIAL | {"control": None}
    ),
    "spatial chain": load_scene(SPATIAL),
    "jib that bends": load_scene(BENT_JIB),
    "boom that bends": load_scene(BENT_BOOM),
}


class Frame(NamedTuple):
    """Frame of a link in the world, and its motion's Jacobians by joint velocities (n,)."""

    R: np.ndarray  # (3, 3) its axes, as columns
    origin: np.ndarray  # (3,) m
    J_v: np.ndarray  # (3, n) of the velocity of its origin
    J_w: np.ndarray  # (3, n) of its angular velocity


def link_frames(
    robot: ElementTree.Element, names: tuple[str, ...], q: np.ndarray
) -> dict[str, Frame]:
    """Return the Frame of each link at positions q (n,) of the joints called `names`."""
    n = len(names)
    frames: dict[str, Frame] = {
        "world": Frame(np.eye(3), np.zeros(3), np.zeros((3, n)), np.zeros((3, n)))
    }
    joints = {joint.find("child").attrib["link"]: joint for joint in robot.iter("joint")}  # pyright: ignore

    def frame_of(link: str) -> Frame:
        if link not in frames:
            joint = joints[link]
            parent = frame_of(joint.find("parent").attrib["link"])  # pyright: ignore[reportOptionalMemberAccess]
            frames[link] = child_frame(joint, parent, names, q)
        return frames[link]

    for link in joints:
        frame_of(link)
    return frames


def child_frame(
    joint: ElementTree.Element, parent: Frame, names: tuple[str, ...], q: np.ndarray
) -> Frame:
    """Return the frame of a joint's child link, from that of its parent link."""
    R, origin, J_v, J_w = parent
    # of the joint's position: coefficients @ q
    mimic, coefficients = joint.find("mimic"), np.zeros(len(names))
    if joint.attrib["type"] != "fixed":
        leader = joint.attrib["name"] if mimic is None else mimic.attrib["joint"]
        coefficients[names.index(leader)] = (
            1.0 if mimic is None else float(mimic.attrib["multiplier"])
        )
    offset = R @ numbers(joint.find("origin"), "xyz")
    if joint.attrib["type"] == "prismatic":
        axis = R @ numbers(joint.find("axis"), "xyz")
        offset = offset + axis * (coefficients @ q)
        return Frame(
            R, origin + offset, J_v + np.cross(J_w.T, offset).T + np.outer(axis, coefficients), J_w
        )
    J_v = J_v + np.cross(J_w.T, offset).T
    if joint.attrib["type"] == "fixed":
        return Frame(R, origin + offset, J_v, J_w)
    axis = numbers(joint.find("axis"), "xyz")
    return Frame(
        R @ rotation(axis, coefficients @ q),
        origin + offset,
        J_v,
        J_w + np.outer(R @ axis, coefficients),
    )


def mass_matrix(document: str, names: tuple[str, ...], q: np.ndarray) -> np.ndarray:
    """Return the mass matrix (n, n) of a URDF at joint positions q (n,), mimic joints included."""
    robot, matrix = ElementTree.fromstring(document), np.zeros((len(names), len(names)))
    frames = link_frames(robot, names, q)
    for link in robot.iter("link"):
        body = link.find("inertial")
        if body is None:
            continue
        R, _, J_v, J_w = frames[link.attrib["name"]]
        # of the centre of mass
        J_c = J_v + np.cross(J_w.T, R @ numbers(body.find("origin"), "xyz")).T
        moments = [numbers(body.find("inertia"), key)[0] for key in ("ixx", "iyy", "izz")]
        matrix += numbers(body.find("mass"), "value")[0] * J_c.T @ J_c
        matrix += J_w.T @ R @ np.diag(moments) @ R.T @ J_w
    return matrix


@pytest.mark.parametrize("scene", ACTUATED_SCENES.values(), ids=ACTUATED_SCENES)
def test_efforts_accelerate_the_urdf_as_they_do_the_crane(scene: Scene) -> None:
    """The URDF's mass matrix times the simulated acceleration by a unit effort is that effort."""
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


@pytest.mark.parametrize("scene", FREE_SCENES.values(), ids=FREE_SCENES)
def test_kinetic_energy_of_the_urdf_is_the_cranes(scene: Scene) -> None:
    """The URDF has the simulated kinetic energy.

    That holds, too, where efforts are no forces or coordinates are not independent.
    """
    random, q = np.random.default_rng(2), np.array(scene.initial_q)
    links = [i for i, name in enumerate(scene.joint_names) if name.startswith("link_")]
    directions = random.normal(size=(len(links) // 3, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    q[links] = directions.ravel()
    matrix = mass_matrix(urdf(scene), scene.joint_names, q)
    for _ in range(4):
        v = random.normal(size=len(q))
        rates = v[links].reshape(-1, 3)
        v[links] = (rates - np.sum(rates * directions, axis=1, keepdims=True) * directions).ravel()
        if scene.crane == "pendulum":
            v[2] = 0.0  # the height of this one is fixed
        kinetic = crane_sim.energy(scene, q, v) - crane_sim.energy(scene, q, np.zeros(len(q)))
        # of energies of up to 1e3 J
        assert 0.5 * v @ matrix @ v == pytest.approx(kinetic, abs=1e-9)


def test_nothing_weighs_more_than_in_the_scene() -> None:
    """The links' masses add up to the scene's: solids that are only drawn have none."""
    scenes = {"knuckle": 2.0 + 3.0 + 1.0, "hoisted rope": 5.0 + 10.0, "pendulum": 4.0}
    for name, mass in scenes.items():
        robot = ElementTree.fromstring(urdf((ACTUATED_SCENES | FREE_SCENES)[name]))
        assert sum(float(body.attrib["value"]) for body in robot.iter("mass")) == pytest.approx(
            mass
        )


def limits(scene: Scene) -> dict[str, tuple[str, dict[str, float]]]:
    """Return the type and the limits of each joint that moves."""
    robot, by_name = ElementTree.fromstring(urdf(scene)), {}
    for joint in robot.iter("joint"):
        limit = joint.find("limit")
        given = {} if limit is None else {key: float(value) for key, value in limit.attrib.items()}
        by_name[joint.attrib["name"]] = joint.attrib["type"], given
    return by_name


def number(value: float | str) -> float:
    """Return a number of a file, which may be an angle in degrees."""
    return radians(float(value.removesuffix("deg"))) if isinstance(value, str) else value


@pytest.mark.parametrize("name", sorted(scene_files()))
def test_limits_of_the_catalogue_are_those_of_its_files(name: str) -> None:
    """Every joint's travel and effort are as in its scene file, else unbounded."""
    scene, document = load_scene(name), load_scene(name).to_dict()
    drives = document.get("actuators") or {}
    for joint, (kind, actual) in limits(scene).items():
        if joint not in scene.joint_names or joint.startswith("link_") or kind == "fixed":
            # links: of unit vectors
            continue
        group = document.get(joint) or {}
        low, high = group.get("limits") or (
            0.0 if joint in ("rope", "hoist") else -UNBOUNDED,
            UNBOUNDED,
        )
        drive = (drives.get("all") or {}) | (drives.get(joint) or {})
        bound = drive.get("limit") or UNBOUNDED
        effort = max(map(abs, bound)) if isinstance(bound, (list, tuple)) else bound
        takes_effort = joint in scene.actuated and scene.effort_units[
            scene.actuated.index(joint)
        ] in ("N", "N m")
        if kind == "continuous":
            assert "limits" not in group and actual.keys() <= {"effort", "velocity"}
        else:
            assert (actual["lower"], actual["upper"]) == pytest.approx(
                (number(low), number(high))
            ), joint
        assert actual.get("effort", UNBOUNDED) == pytest.approx(
            effort if takes_effort else UNBOUNDED
        ), joint
        assert actual.get("velocity", UNBOUNDED) == (drive.get("servo") or {}).get(
            "max_speed", UNBOUNDED
        )


def test_no_limit_is_invented() -> None:
    """Without a scene's limit, revolute joints are continuous, prismatic ones unbounded."""
    actual = limits(ACTUATED_SCENES["knuckle"])
    assert {kind for name, (kind, _) in actual.items() if name not in ("base", "rope")} == {
        "continuous"
    }
    free = {"upper": UNBOUNDED, "effort": UNBOUNDED, "velocity": UNBOUNDED}
    assert actual["rope"] == ("prismatic", {"lower": 0.0} | free)
    assert limits(ACTUATED_SCENES["chain of rods"])["trolley"] == (
        "prismatic",
        {"lower": -UNBOUNDED} | free,
    )
    effort = load_scene("knuckle_setpoint", {"actuators": {"boom": {"limit": 700.0}}})
    assert limits(effort)["boom"] == ("continuous", {"effort": 700.0, "velocity": UNBOUNDED})


def test_the_urdf_says_what_is_not_simulated() -> None:
    """URDF comments explain drawn visuals, the number for no limit, and what has no mass."""
    for scene in (
        ACTUATED_SCENES["knuckle"],
        ACTUATED_SCENES["hoisted rope"],
        FREE_SCENES["pendulum"],
    ):
        assert "every visual is a drawing" in urdf(scene)
        assert f"{UNBOUNDED:g} stands for no limit" in urdf(scene)
    assert "tower_link has no mass" in urdf(ACTUATED_SCENES["knuckle"])
