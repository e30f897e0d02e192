"""The largest efforts that a plant takes: far beyond what any law needs, and no burden to any method."""

import numpy as np

from crane_sim.metrics import derived
from crane_sim.scene import Scene

_HARD = 1e5  # rad/s² or m/s², for a joint with all that it carries; in other units than N m and N, as it stands
_LOADS = 1e3  # times what holds a joint against gravity
_APART = 1e-3  # rad or m, between postures whose potential energies are compared


def largest_efforts(scene: Scene, given: float = 0.0) -> tuple[float, ...]:
    """Return bounds (nu,) on the efforts of commands, in the units of the scene's efforts.

    Args:
        scene: its initial posture tells what inertia and gravity ask of a joint.
        given: the same bound for all joints instead; 0 for none.
    """
    if given:
        return (given,) * len(scene.actuated)
    if not scene.actuated:
        return ()
    inertia, load = _asked(scene)
    bounds = np.where(np.isin(scene.effort_units, ("N m", "N")), _HARD * inertia + _LOADS * load, _HARD)
    return tuple(bounds.tolist())


def _asked(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return the inertia of each joint with all that it carries (nu,), and what gravity asks of it (nu,), at first."""
    joints = [scene.joint_names.index(joint) for joint in scene.actuated]
    n = len(joints)
    q, v = np.tile(scene.initial_q, (4, n, 1)), np.zeros((4, n, len(scene.joint_names)))
    each = range(n)
    q[0, each, joints] += _APART
    q[1, each, joints] -= _APART
    v[2, each, joints] = 1.0
    known = derived(scene, np.zeros(4 * n), q.reshape(4 * n, -1), v.reshape(4 * n, -1), np.zeros((4 * n, n)))
    up, down, _, _ = known.potential_relative.reshape(4, n)
    _, _, moving, still = known.kinetic_relative.reshape(4, n)
    return 2.0 * np.abs(moving - still), np.abs(up - down) / (2.0 * _APART)
