"""Transforms, and URDF with the base's transform, put catalogue cranes where their models do."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from urdf_kinematics import link_position

from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.description.rotations import quaternion_of
from crane_sim.description.transforms import (
    Transform,
    TransformTree,
    base_transform,
    payload_orientation,
)
from crane_sim.files.catalogue import scene_files
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.simulation.base_state import base_state
from crane_sim.simulation.derived import world_points

STATES = 25
LONGEST = 60  # joints: the two longest chains have the joints of the shorter ones, and take minutes


NAMES = """
    bridge_hook_and_sling bridge_speed_drive knuckle_bench knuckle_hook_and_sling knuckle_sea
    knuckle_ship_falls mobile_lift offshore_obstacle offshore_resonant overhead_bench overhead_bounce
    overhead_bounce_chain overhead_chain overhead_chain_50 overhead_chaos overhead_drive overhead_drop
    overhead_elastic overhead_friction_chain overhead_hoist overhead_hoist_chain overhead_pole
    overhead_pole_chain overhead_spatial overhead_sway overhead_toss pendulum_lifeboat port_sts_container
    tandem_play tower_beam_turns tower_flexible_jib tower_set_down tower_sway
""".split()  # noqa: E501
"""One scene of the catalogue for each crane, set of joints, and kind of motion of the base."""
ALL = sorted(scene_files())
ENDS = [[x, y, 0.0] for x in (0.2, -0.2) for y in (0.3, -0.3)]
ON_FALLS = {
    "duration": 1.0,
    "payload": {"mass": 100.0, "inertia": [30.0, 20.0, 40.0], "attachment": [0.05, 0.02, 0.5]},
    "falls": {"top": ENDS, "bottom": ENDS, "axial_stiffness": 4e4},
    "base_motion": {
        "roll": {"amplitude": 0.1, "frequency": 0.7},
        "mount": {"position": [1.0, 2.0, 3.0], "yaw": 2.0},
    },
}
BOOM, ROD = {"mass": 100.0, "centre": 2.0, "inertia": 80.0}, {"mass": 80.0, "inertia": 170.0}
FALLS: dict[str, dict[str, Any]] = {
    "mobile": {
        "superstructure": {"inertia": 600.0, "foot": [0.5, 1.2]},
        "boom": BOOM,
        "telescope": BOOM,
        "initial": {"q": [0.4, 0.6, 7.0, 2.0]},
    },
    "knuckle": {
        "tower": {"inertia": 200.0},
        "boom": ROD | {"length": 5.0},
        "jib": ROD | {"length": 4.0},
        "initial": {"q": [0.4, 0.6, -0.2, 2.0]},
    },
    "pendulum": {"initial": {"tip": [1.0, 2.0, 3.0], "length": 2.0}},
}
"""Cranes with falls that no scene of the catalogue has, on a ship."""
# others: swing_link
TIPS = {"overhead": "trolley_link", "pendulum": "tip_link", "gantry": "trolley_link"}


def test_every_kind_of_scene_is_among_the_names() -> None:
    """The representative scenes have each crane, set of joints and kind of base motion once."""
    scenes = {name: load_scene(name) for name in sorted(scene_files(), reverse=True)}
    short = {name: scene for name, scene in scenes.items() if len(scene.joint_names) < LONGEST}
    kinds = {
        (
            scene.crane,
            scene.joint_names,
            type(scene.model),
            type(getattr(scene.model, "base", None)),
        ): name
        for name, scene in short.items()
    }
    assert sorted(kinds.values()) == NAMES


def random_state(scene: Scene, seed: int) -> tuple[float, np.ndarray]:
    """Return (time, positions (nq,)): random unit vectors, quaternions, else near the start."""
    random = np.random.default_rng(seed)
    q = np.array(scene.initial_q) + random.uniform(-0.3, 0.3, len(scene.initial_q))
    groups: dict[str, list[int]] = {}
    for i, name in enumerate(scene.joint_names):
        if name.startswith("link_") or name in ATTITUDE:
            groups.setdefault("attitude" if name in ATTITUDE else name[:-2], []).append(i)
    for indices in groups.values():
        direction = random.normal(size=len(indices))
        q[indices] = direction / np.linalg.norm(direction)
    return random.uniform(0.0, scene.duration), q


def poses(transforms: list[Transform]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return every frame's (rotation (3, 3), position (3,)) in the world by chained transforms."""
    above = {transform.child: transform for transform in transforms}
    assert len(above) == len(transforms)  # one parent each
    found: dict[str, tuple[np.ndarray, np.ndarray]] = {"world": (np.eye(3), np.zeros(3))}

    def pose(frame: str) -> tuple[np.ndarray, np.ndarray]:
        if frame not in found:
            turn, at = pose(above[frame].parent)
            own = Rotation.from_quat(above[frame].rotation).as_matrix()
            found[frame] = turn @ own, at + turn @ np.array(above[frame].translation)
        return found[frame]

    for frame in above:
        pose(frame)
    return found


def transforms_at(scene: Scene, tree: TransformTree, t: float, q: np.ndarray) -> list[Transform]:
    """Return all transforms of a crane at time t [s] and joint positions q (nq,)."""
    moves = getattr(scene.model, "base", None) is not None
    base = [base_transform(base_state(scene, t))] if moves else []
    return [*tree.fixed, *base, *tree.moving(q.tolist())]


@pytest.mark.long(cases=[name for name in ALL if name not in NAMES])
@pytest.mark.parametrize("name", ALL)
def test_chained_transforms_give_payload_tip_and_nodes(name: str) -> None:
    """The transforms, and the URDF, give the model's points for payload, tip and nodes."""
    check_frames(load_scene(name))


@pytest.mark.parametrize("crane", FALLS)
def test_chained_transforms_below_falls(crane: str) -> None:
    """The same of a load on falls below the other supports, on a ship."""
    check_frames(load_scene({"crane": crane} | ON_FALLS | FALLS[crane]))


def check_frames(scene: Scene) -> None:
    """Check the frames of a crane at random states."""
    on_falls = isinstance(scene.model, FallsCrane)
    document, tip_frame = (
        urdf(scene),
        TIPS.get(scene.crane, "head_link" if on_falls else "swing_link"),
    )
    tree = TransformTree(document, scene.joint_names)
    for seed in range(STATES):
        t, q = random_state(scene, seed)
        points, tip = world_points(scene.model, t, q, np.zeros_like(q))
        frames = poses(transforms_at(scene, tree, t, q))
        below = [f"node_{k}" for k in range(1, len(points) - 1 - tip)]
        for frame, point in zip([tip_frame, *below, "payload_link"], points[tip:], strict=True):
            assert frames[frame][1] == pytest.approx(point, abs=1e-12)  # m, rounding: 1e-13 at most
        if seed < 3 or len(scene.joint_names) < LONGEST:
            # what a subscriber computes from URDF, joint states and the base's place
            base = base_state(scene, t)
            aboard = link_position(
                document, dict(zip(scene.joint_names, q.tolist(), strict=True)), "payload_link"
            )
            assert base.position + base.rotation @ aboard == pytest.approx(points[-1], abs=1e-12)


@pytest.mark.parametrize("name", ["tower_gust", "port_sts_container"])
def test_the_pose_of_a_load_on_a_ship_has_its_turn_in_the_world(name: str) -> None:
    """`payload_pose` has the orientation of the payload's frame: base and attitude together."""
    turns = {
        "roll": {"amplitude": 0.1, "frequency": 0.7},
        "yaw": {"amplitude": 0.2, "frequency": 0.4},
    }
    scene = load_scene(name, {"base_motion": turns | {"mount": {"yaw": 2.0}}})
    for seed in range(5):
        t, q = random_state(scene, seed)
        frames = poses(transforms_at(scene, TransformTree(urdf(scene), scene.joint_names), t, q))
        turn = Rotation.from_quat(payload_orientation(scene, t, q.tolist())).as_matrix()
        assert turn == pytest.approx(frames["payload_link"][0], abs=1e-14)  # rounding


def test_a_moving_base_is_the_root_of_the_urdf() -> None:
    """The URDF has a `world` only below a base at rest: a frame has one parent, one publisher."""
    assert '<link name="world"' not in urdf(load_scene("overhead_sway"))
    assert '<link name="world"' in urdf(load_scene("overhead_energy"))


def test_quaternions_are_those_of_their_matrices() -> None:
    """Each of the four branches of the quaternion gives back its matrix, half turns included."""
    turns = list(Rotation.random(200, np.random.default_rng(1)))
    turns += [Rotation.from_rotvec(np.pi * axis) for axis in np.eye(3)]
    for turn in turns:
        again = Rotation.from_quat(quaternion_of(turn.as_matrix())).as_matrix()
        assert again == pytest.approx(turn.as_matrix(), abs=1e-15 * 8)  # rounding of a few products
