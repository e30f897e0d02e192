"""Geometry and inertia of a crane's URDF are those of the model."""

from math import cos, sin
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from urdf_kinematics import link_position, numbers

from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import world_points

SCENE = load_scene("knuckle_setpoint")


TWO_D = {"crane": "overhead", "duration": 1.0, "trolley": {"mass": 5.0}}


THREE_D = TWO_D | {"dimensions": 3, "bridge": {"mass": 9.0}}


LINKS = {"lengths": [1.5, 0.7, 0.4], "node_masses": [0.5, 0.2, 10.0]}


HOIST = {"hoist": {"drive": "force", "inertia": 5.0}}


OVERHEAD = {
    "hoisted rope": load_scene(TWO_D | HOIST | {"cable": {"lengths": 2.0, "node_masses": 10.0}}),
    "rod": load_scene(TWO_D | HOIST | {"cable": LINKS | {"model": "straight"}}),
    "hoisted chain": load_scene(TWO_D | HOIST | {"cable": LINKS}),
    "long chain": load_scene(
        TWO_D | {"cable": {"links": 200, "lengths": 0.05, "node_masses": 1.0}}
    ),
    "spatial chain": load_scene(THREE_D | {"cable": LINKS}),
    "hoisted spatial chain": load_scene(THREE_D | HOIST | {"cable": LINKS}),
    "elastic": load_scene(TWO_D | {"cable": LINKS | {"model": "elastic", "stiffness": 1e5}}),
    "elastic in space": load_scene(
        THREE_D | {"cable": LINKS | {"model": "elastic", "stiffness": 1e5}}
    ),
}


ANGLE = st.floats(-3.0, 3.0)
SWING = st.floats(-1.5, 1.5)


def payload(scene: Scene, q: tuple[float, ...]) -> np.ndarray:
    """Return the payload's position (3,) by the formula of the model's convention."""
    a, b, c, d, t1, t2 = q
    boom, jib = scene.model.support.boom.length, scene.model.support.jib.length
    out, across = np.array([cos(a), sin(a), 0.0]), np.array([-sin(a), cos(a), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    tip = (boom * cos(b) + jib * cos(c)) * out + (boom * sin(b) + jib * sin(c)) * up
    return tip + d * (sin(t2) * out + cos(t2) * sin(t1) * across - cos(t1) * cos(t2) * up)


@settings(max_examples=50)
@given(st.tuples(ANGLE, ANGLE, ANGLE, st.floats(0.1, 8.0), SWING, SWING))
def test_forward_kinematics_is_the_models(q: tuple[float, ...]) -> None:
    """The payload link is at the model's payload in any posture, by level frames and rope chain."""
    actual = link_position(
        urdf(SCENE), dict(zip(SCENE.joint_names, q, strict=True)), "payload_link"
    )
    # lengths up to 17 m in double precision
    assert actual == pytest.approx(payload(SCENE, q), abs=1e-12)


def test_joints_are_the_scenes() -> None:
    """Every joint state has its joint, and nothing else moves but the two level frames."""
    robot = ElementTree.fromstring(urdf(SCENE))
    free = {
        j.attrib["name"]
        for j in robot.iter("joint")
        if j.attrib["type"] != "fixed" and j.find("mimic") is None
    }
    assert free == set(SCENE.joint_names)
    assert {
        joint.attrib["name"] for joint in robot.iter("joint") if joint.find("mimic") is not None
    } == {
        "boom_level",
        "jib_level",
    }


@pytest.mark.parametrize(
    "scene",
    [SCENE, load_scene("pendulum_free"), *OVERHEAD.values()],
    ids=["knuckle", "pendulum", *OVERHEAD],
)
def test_links_make_one_tree(scene: Scene) -> None:
    """Each link but the root has one parent, so robot_state_publisher accepts the description."""
    robot = ElementTree.fromstring(urdf(scene))
    links = [link.attrib["name"] for link in robot.iter("link")]
    children = [child.attrib["link"] for child in robot.iter("child")]
    assert len(set(links)) == len(links)
    assert sorted(children) == sorted(set(links) - {"world"})
    assert {parent.attrib["link"] for parent in robot.iter("parent")} <= set(links)


def test_masses_and_inertias_are_the_models() -> None:
    """Rod and payload masses are the scene's; every inertia is possible for a rigid body."""
    robot = ElementTree.fromstring(urdf(SCENE))
    inertials = {link.attrib["name"]: link.find("inertial") for link in robot.iter("link")}
    support = SCENE.model.support
    for name, rod in (("boom_link", support.boom), ("jib_link", support.jib)):
        body = inertials[name]
        assert body is not None
        assert numbers(body.find("mass"), "value") == pytest.approx([rod.mass])
        assert numbers(body.find("origin"), "xyz") == pytest.approx([0.5 * rod.length, 0.0, 0.0])
        assert numbers(body.find("inertia"), "iyy") == pytest.approx([rod.inertia])
    crate = inertials["payload_link"]
    assert crate is not None
    assert numbers(crate.find("mass"), "value") == pytest.approx([SCENE.model.load.mass])
    for body in filter(None, inertials.values()):
        moments = sorted(
            float(numbers(body.find("inertia"), key)[0]) for key in ("ixx", "iyy", "izz")
        )
        assert 0.0 <= moments[0] and moments[2] <= moments[0] + moments[1]


@pytest.mark.parametrize("scene", OVERHEAD.values(), ids=OVERHEAD)
def test_free_joints_of_an_overhead_crane_are_the_scenes(scene: Scene) -> None:
    """Joint states move everything, whatever the number of links; no other joint is free."""
    robot = ElementTree.fromstring(urdf(scene))
    free = [
        j.attrib["name"]
        for j in robot.iter("joint")
        if j.attrib["type"] != "fixed" and j.find("mimic") is None
    ]
    assert sorted(free) == sorted(scene.joint_names)


def posture(scene: Scene, seed: int) -> np.ndarray:
    """Return joint positions (nq,) of a random posture; a spatial hoist keeps its length.

    See `cables`.
    """
    random = np.random.default_rng(seed)
    turns = random.normal(size=(len(scene.joint_names), 3))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    q = np.array(scene.initial_q)
    for i, name in enumerate(scene.joint_names):
        if name.startswith("link_"):
            q[i] = turns[int(name.split("_")[1]), "xyz".index(name[-1])]
        elif name != "hoist" or "bridge" not in scene.joint_names:
            q[i] = random.uniform(0.5, 3.0)
    return q


@pytest.mark.parametrize("scene", OVERHEAD.values(), ids=OVERHEAD)
def test_the_nodes_are_the_models(scene: Scene) -> None:
    """Every cable node is at the model's place, by joint positions and URDF alone."""
    q = posture(scene, 1)
    nodes, _ = world_points(scene.model, 0.0, q, np.zeros_like(q))
    document, joints = urdf(scene), dict(zip(scene.joint_names, q, strict=True))
    n = len(nodes) - 1
    for k in {1, n // 2, n - 1, n} - {0}:
        actual = link_position(document, joints, "payload_link" if k == n else f"node_{k}")
        # rounding of up to 200 lengths, 10 m together
        assert actual == pytest.approx(nodes[k], abs=1e-12)


def test_a_hoist_in_space_is_exact_below_the_trolley() -> None:
    """Where the first link is vertical, a hoist in space lowers all nodes by what it pays out."""
    scene = OVERHEAD["hoisted spatial chain"]
    q = posture(scene, 0)
    q[2:6] = 2.5, 0.0, 0.0, -1.0  # hoist, first link
    nodes, _ = world_points(scene.model, 0.0, q, np.zeros_like(q))
    actual = link_position(
        urdf(scene), dict(zip(scene.joint_names, q, strict=True)), "payload_link"
    )
    assert actual == pytest.approx(nodes[-1], abs=1e-12)  # rounding of a few metres


def test_locked_rope_is_described_too() -> None:
    """A scene with a locked rope still describes the rope, since joint states contain it."""
    scene = load_scene(SCENE.to_dict() | {"rope": {"drive": "locked"}})
    assert 'name="rope" type="prismatic"' in urdf(scene)
