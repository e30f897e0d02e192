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
    bounds = []
    for joint, unit in zip(scene.actuated, scene.effort_units, strict=True):
        inertia, load = _asked(scene, scene.joint_names.index(joint))
        bounds.append(_HARD * inertia + _LOADS * load if unit in ("N m", "N") else _HARD)
    return tuple(bounds)


def _asked(scene: Scene, i: int) -> tuple[float, float]:
    """Return the inertia of joint i with all that it carries, and what gravity asks of it, at the initial posture."""
    q, v = np.tile(scene.initial_q, (4, 1)), np.zeros((4, len(scene.joint_names)))
    q[:2, i] += _APART, -_APART
    v[2, i] = 1.0
    known = derived(scene, np.zeros(4), q, v, np.zeros((4, len(scene.actuated))))
    (up, down, _, _), (_, _, moving, still) = known.potential, known.kinetic
    return 2.0 * abs(moving - still), abs(up - down) / (2.0 * _APART)
