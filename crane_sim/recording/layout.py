"""What a recording holds: the fixed facts of a run, and the arrays of one block of its steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import yaml

from crane_sim.description import pedestal_height, urdf

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from crane_sim.scene import Scene

    Numbers = NDArray[np.float64]


class Layout(NamedTuple):
    """Everything about a run that stays fixed while it is recorded."""

    run_id: str
    name: str  # shown as the recording's name
    joints: tuple[str, ...]  # nq coordinates, in the order of q
    units: tuple[str, ...]  # of the coordinates: "rad" or "m"
    actuated: tuple[str, ...]  # nu, the first of the joints
    effort_units: tuple[str, ...]
    effort_scales: tuple[float, ...]  # the efforts that are drawn as arrows of a seventh of `size`
    period_ns: int
    robot: str  # URDF
    size: float  # m, a typical length of the crane: sets line widths and the camera's distance
    heading: float  # rad, about z from x: where the crane works, which the camera looks at
    lyapunov: bool  # the law comes with a Lyapunov function
    ground: float  # m, height of the ground that is drawn
    properties: Mapping[str, Any]  # run properties that are known at the start


class Block(NamedTuple):
    """K consecutive control steps: the state at the start of each and the effort held over it (SI, radians)."""

    step: NDArray[np.int64]  # (K,) 1 for the first step
    q: Numbers  # (K, nq)
    v: Numbers  # (K, nq)
    effort: Numbers  # (K, nu) applied, after limits
    demanded: Numbers  # (K, nu) commanded; NaN where no command was heard
    reference: Numbers | None  # (K, nu) target of the actuated joints
    nodes: Numbers  # (K, N, 3) base .. tip .. payload; the last two are the ends of the rope
    target: Numbers | None  # (K, N, 3) the nodes at rest in the reference pose
    energy: Numbers  # (K,) J
    tension: Numbers  # (K,) N
    swing: Numbers  # (K,) rope angle from the vertical
    lyapunov: Numbers | None  # (K, 2) V [J] and its rate [W]


def of_scene(scene: Scene, run_id: str) -> Layout:
    """Return the layout of a scene's recording."""
    support = scene.model.support
    return Layout(
        run_id=run_id,
        name=scene.name,
        joints=scene.joint_names,
        units=scene.joint_units,
        actuated=scene.actuated,
        effort_units=scene.effort_units,
        effort_scales=_effort_scales(scene),
        period_ns=scene.period_ns,
        robot=urdf(scene),
        size=support.boom.length + support.jib.length,
        heading=0.5 * (scene.initial_q[0] + (scene.reference or scene.initial_q)[0]),
        lyapunov=hasattr(scene.law, "lyapunov"),
        ground=-pedestal_height(scene),
        properties=_properties(scene),
    )


def label(name: str) -> str:
    """Turn a joint name into words for a legend."""
    return name.replace("_", " ")


def _properties(scene: Scene) -> dict[str, Any]:
    return {
        "scene": scene.name,
        "law": scene.law_name or "none",
        "seed": scene.seed,
        "period": scene.period,
        "duration": scene.duration,
        "scene_file": yaml.safe_dump(scene.to_dict(), sort_keys=False, allow_unicode=True),
    }


def _effort_scales(scene: Scene) -> tuple[float, ...]:
    """Return what each joint needs to carry the outstretched crane; a slew, which carries nothing, gets a fifth."""
    boom, jib, load = scene.model.support.boom, scene.model.support.jib, scene.model.load.mass
    torque = scene.model.gravity * boom.length * (load + 0.5 * boom.mass + jib.mass)
    scales = {"N m": torque, "N": load * scene.model.gravity}
    slew, *others = (max(scales.get(unit, 1.0), 1e-9) for unit in scene.effort_units)
    return (0.2 * slew, *others)
