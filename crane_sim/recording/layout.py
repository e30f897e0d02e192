"""What a recording holds: the fixed facts of a run, and the arrays of one block of its steps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import yaml

from crane_sim import system
from crane_sim.description import urdf
from crane_sim.overhead import OverheadCrane
from crane_sim.recording.framing import Framing, framing
from crane_sim.supports.trolley import FixedTrolley

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from crane_sim.scene import Scene

    Numbers = NDArray[np.float64]

CURVES = 5  # so many swings fit into a plot


class Layout(NamedTuple):
    """Everything about a run that stays fixed while it is recorded."""

    run_id: str
    name: str  # shown as the recording's name
    joints: tuple[str, ...]  # nq coordinates, in the order of q
    units: tuple[str, ...]  # of the coordinates: "rad" or "m"
    actuated: tuple[str, ...]  # nu of the joints
    effort_units: tuple[str, ...]
    ways: tuple[str, ...]  # joints in metres that move, each with a plot of its own
    swings: tuple[str, ...]  # joints with the angles of the cable that are plotted: of a long chain not all
    tip: int  # which of the nodes is the upper end of the cable
    planar: bool  # the cable stays in the x-z plane: its angles have a sign
    tension: str  # what the recorded tension is
    period_ns: int
    robot: str  # URDF
    framing: Framing
    lyapunov: bool  # the law comes with a Lyapunov function
    properties: Mapping[str, Any]  # run properties that are known at the start

    @property
    def driven(self) -> list[int]:
        """Return the indices of the actuated joints among the coordinates."""
        return [self.joints.index(name) for name in self.actuated]

    @property
    def moving(self) -> list[int]:
        """Return the indices of the coordinates that are plotted: of the swings only those in `swings`."""
        return [i for i, joint in enumerate(self.joints) if joint in self.swings or not joint.startswith("swing")]

    @property
    def crowded(self) -> bool:
        """Return whether there are too many coordinates to plot them all."""
        return len(self.moving) < len(self.joints)


class Block(NamedTuple):
    """K consecutive control steps: the state at the start of each and the effort held over it (SI, radians)."""

    step: NDArray[np.int64]  # (K,) 1 for the first step
    q: Numbers  # (K, nq)
    v: Numbers  # (K, nq)
    effort: Numbers  # (K, nu) applied, after limits
    demanded: Numbers  # (K, nu) commanded; NaN where no command was heard
    reference: Numbers | None  # (K, nu) target of the actuated joints
    nodes: Numbers  # (K, N, 3) base .. tip .. payload; the cable is what follows the tip
    target: Numbers | None  # (K, N, 3) the nodes at rest in the reference pose
    energy: Numbers  # (K,) J
    tension: Numbers  # (K,) N
    swing: Numbers  # (K,) angle from the vertical of the line from the tip to the payload
    lyapunov: Numbers | None  # (K, 2) V [J] and its rate [W]


def of_scene(scene: Scene, run_id: str) -> Layout:
    """Return the layout of a scene's recording."""
    return Layout(
        run_id=run_id,
        name=scene.name,
        joints=scene.joint_names,
        units=scene.joint_units,
        actuated=scene.actuated,
        effort_units=scene.effort_units,
        ways=_ways(scene),
        swings=_swings(scene),
        tip=system.tip_index(scene.model),
        planar=isinstance(scene.model, OverheadCrane),
        tension="smallest link tension" if "swing_2" in scene.joint_names else "rope tension",
        period_ns=scene.period_ns,
        robot=urdf(scene),
        framing=framing(scene),
        lyapunov=hasattr(scene.law, "lyapunov"),
        properties=_properties(scene),
    )


def label(name: str) -> str:
    """Turn a joint name into words for a legend."""
    return name.replace("_", " ")


def _ways(scene: Scene) -> tuple[str, ...]:
    still = set() if isinstance(scene.model, OverheadCrane) else set(scene.joint_names) - set(scene.actuated)
    if isinstance(scene.model, OverheadCrane) and isinstance(scene.model.trolley, FixedTrolley):
        still = {"trolley"}
    pairs = zip(scene.joint_names, scene.joint_units, strict=True)
    return tuple(name for name, unit in pairs if unit == "m" and name not in still)


def _swings(scene: Scene) -> tuple[str, ...]:
    names = tuple(name for name in scene.joint_names if name.startswith("swing"))
    return names if len(names) <= CURVES else (*names[: CURVES - 1], names[-1])


def _properties(scene: Scene) -> dict[str, Any]:
    return {
        "scene": scene.name,
        "law": scene.law_name or "none",
        "seed": scene.seed,
        "period": scene.period,
        "duration": scene.duration,
        "scene_file": yaml.safe_dump(scene.to_dict(), sort_keys=False, allow_unicode=True),
    }
