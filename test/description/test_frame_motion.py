"""Velocities of frames: those of their poses a moment before and after."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_transforms import NAMES, random_state

from crane_sim import load_scene
from crane_sim.description import urdf
from crane_sim.description.frame_motion import FrameMotion, frame_accelerations, frame_motions
from crane_sim.description.transforms import TransformTree
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.simulation.derived import world_points

STEP = 1e-5  # s, of central differences


@pytest.mark.parametrize("name", NAMES[::2])
def test_velocities_are_the_rates_of_poses(name: str) -> None:
    """Frame velocities are central differences of poses; the payload is where the model has it."""
    scene = load_scene(name)
    tree = TransformTree(urdf(scene), scene.joint_names)
    for seed in range(3):
        t, q = random_state(scene, seed)
        v = np.random.default_rng(seed).uniform(-1.0, 1.0, len(q))
        _keep_size(scene.joint_names, q, v)
        motions = frame_motions(scene, tree, t, q.tolist(), v.tolist())
        before, after = (
            frame_motions(scene, tree, t + s, (q + s * v).tolist(), v.tolist())
            for s in (-STEP, STEP)
        )
        size = 1.0 + max(float(np.abs(motion.position).max()) for motion in motions.values())
        for frame, motion in motions.items():
            rate = (after[frame].position - before[frame].position) / (2.0 * STEP)
            turn = Rotation.from_matrix(
                after[frame].rotation @ before[frame].rotation.T
            ).as_rotvec() / (2.0 * STEP)
            # rounding 1e-16 / STEP and third derivatives STEP²: 1e-10 each, times lengths and rates
            # of some 10
            assert motion.velocity == pytest.approx(rate, abs=2e-8 * size)
            assert motion.angular_velocity == pytest.approx(turn, abs=2e-8)
        points, _ = world_points(scene.model, t, q, v)
        assert motions["payload_link"].position == pytest.approx(points[-1], abs=1e-12 * size)


@pytest.mark.parametrize("name", NAMES[1::2])
def test_accelerations_are_the_second_derivatives_of_positions(name: str) -> None:
    """A frame's accelerations are the second differences of its place and its turning."""
    scene = load_scene(name)
    tree, step = TransformTree(urdf(scene), scene.joint_names), 1e-3
    t, q = random_state(scene, 1)
    random = np.random.default_rng(1)
    v, a = random.uniform(-1.0, 1.0, len(q)), random.uniform(-1.0, 1.0, len(q))
    _keep_size(scene.joint_names, q, v)
    accelerations = frame_accelerations(scene, tree, t, q.tolist(), v.tolist(), a.tolist())

    def at(s: float) -> dict[str, FrameMotion]:
        return frame_motions(
            scene, tree, t + s, (q + s * (v + 0.5 * s * a)).tolist(), (v + s * a).tolist()
        )

    before, now, after = at(-step), at(0.0), at(step)
    size = 1.0 + max(float(np.abs(motion.position).max()) for motion in now.values())
    for frame, acceleration in accelerations.items():
        second = (
            after[frame].position - 2.0 * now[frame].position + before[frame].position
        ) / step**2
        turning = (after[frame].angular_velocity - before[frame].angular_velocity) / (2.0 * step)
        # fourth derivatives of lengths at some rad/s, times step² = 1e-6; rounding 1e-16 / step²
        assert acceleration.linear == pytest.approx(second, abs=2e-5 * size)
        assert acceleration.angular == pytest.approx(turning, abs=1e-4)


def _keep_size(joints: tuple[str, ...], q: np.ndarray, v: np.ndarray) -> None:
    """Take the size-changing part from a quaternion's rate, in place: the frame has none."""
    indices = [joints.index(name) for name in ATTITUDE if name in joints]
    if indices:
        v[indices] -= q[indices] * (q[indices] @ v[indices])


def test_a_long_cable_has_all_its_frames() -> None:
    """A cable with the most links needs no recursion: its last frame is where the links end."""
    links, length = 500, 0.1  # m
    cable = {"links": links, "lengths": length, "node_masses": 1.0}
    scene = load_scene(
        {"crane": "overhead", "duration": 1.0, "trolley": {"drive": "fixed"}, "cable": cable}
    )
    tree = TransformTree(urdf(scene), scene.joint_names)
    motions = frame_motions(scene, tree, 0.0, scene.initial_q, scene.initial_v)
    # rounding of 500 sums
    assert -motions["payload_link"].position[2] == pytest.approx(links * length, rel=1e-12)
