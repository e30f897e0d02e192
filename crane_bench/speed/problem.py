"""The benchmark's cranes in plain numbers, for engines that read no scenes."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.models.cables.rope import ForceRope
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import RodCrane
from crane_sim.models.overhead.spring import SpringCrane
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.supports.rails import ForceAxis
from crane_sim.scenes.scene import Scene

Array = npt.NDArray[np.float64]


class Chain(NamedTuple):
    """A trolley free on a rail along x at z = 0, with point masses on massless rigid links.

    They move in the plane x, z (z up).

    Everything starts at rest, the trolley at x = 0; nothing drives or damps it.
    """

    trolley: float  # kg
    masses: Array  # (N,) kg, from the top; the last one is the payload
    lengths: Array  # (N,) m
    angles: Array  # (N,) rad, from the downward vertical, positive towards +x: node k is at node
    # k-1 + l (sin, -cos)
    gravity: float  # m/s²
    duration: float  # s


class Spring(NamedTuple):
    """A free trolley, as in `Chain`, and a payload on an undamped linear spring.

    The spring pulls and pushes.
    """

    trolley: float  # kg
    payload: float  # kg
    length: float  # m, at rest
    stiffness: float  # N/m
    start: Array  # (2,) m, x and z of the payload, which is at rest
    gravity: float  # m/s²
    duration: float  # s


class RodParameters(NamedTuple):
    """One of the two rods of a knuckle crane: uniform, its centre of mass at mid-length."""

    length: float  # m
    mass: float  # kg
    inertia: float  # kg m², about its centre of mass, across the rod
    axial: float  # kg m², about its own axis


class KnuckleCrane(NamedTuple):
    """A tower slewing by α about the vertical, boom and jib at elevations β, γ.

    Both are measured from the horizontal.

    The rods move in the vertical plane at azimuth α; the jib starts at the boom's end, the rope at
    the jib's end, the boom's foot is the origin. Springs hold boom, jib and rope: torques -k_β (β -
    β0) on β, and the couple -k_γ (γ - β - γ0) between boom and jib; the rope is a spring that pulls
    and pushes along the line from the tip to the payload, a point mass. No damping.
    """

    tower: float  # kg m², about the vertical
    boom: RodParameters
    jib: RodParameters
    payload: float  # kg
    stiffness: tuple[float, float, float]  # N m/rad, N m/rad, N/m: of boom, jib (relative to the
    # boom) and rope
    neutral: tuple[float, float, float]  # rad, rad (relative), m
    q: Array  # (3,) rad, α, β, γ at the start; at rest
    start: Array  # (3,) m, of the payload, at rest
    gravity: float  # m/s²
    duration: float  # s


Problem = Chain | Spring | KnuckleCrane


def problem_of(scene: Scene, payload: Array) -> Problem | None:
    """Return the scene in plain numbers, None for a scene of none of the three kinds.

    Args:
        scene: of the catalogue.
        payload: (3,) m, initial position of the payload.
    """
    model = scene.model
    if isinstance(model, PlanarCrane | RodCrane) and _is_plain(model) and _starts_at_rest(scene):
        return _chain_of(scene)
    if (
        isinstance(model, SpringCrane)
        and _is_plain(model)
        and _starts_at_rest(scene)
        and not model.cable.damping
    ):
        cable = model.cable
        values = cable.mass, cable.length, cable.stiffness
        return Spring(_mass(model), *values, payload[[0, 2]], model.gravity, scene.duration)
    if isinstance(model, Crane) and _has_all_springs(model) and _starts_at_rest(scene):
        return _knuckle_of(scene, payload)
    return None


def _mass(model: Any) -> float:
    return model.trolley.mass


def _is_plain(model: Any) -> bool:
    """Return whether nothing but a free trolley and the cable is modelled."""
    optional_groups = (
        "hoist",
        "joints",
        "rods",
        "forces",
        "event_limits",
        "bridge",
        "wind",
        "base",
    )
    free = isinstance(model.trolley, ForceAxis) and model.trolley.friction is None
    return free and all(getattr(model, name, None) is None for name in optional_groups)


def _has_all_springs(model: Crane) -> bool:
    """Return whether springs hold boom, jib and rope, and nothing else acts."""
    arm, cable = model.support, model.cable
    springs = isinstance(cable, ForceRope) and None not in (
        arm.boom_spring,
        arm.jib_spring,
        cable.spring,
    )
    return springs and model.drag is None and model.swing_friction is None and model.wind is None


def _starts_at_rest(scene: Scene) -> bool:
    return not any(scene.initial_v) and "inputs" not in scene.document


def _chain_of(scene: Scene) -> Chain:
    cable, payload = scene.document["cable"], scene.document.get("payload", {})
    n = cable.get("links") or len(cable["lengths"])
    masses = np.array(np.broadcast_to(cable["node_masses"], n), float)
    masses[-1] = payload.get("mass", masses[-1])
    lengths, first = np.array(np.broadcast_to(cable["lengths"], n), float), len(scene.initial_q) - 1
    # a straight cable has one angle
    angles = scene.initial_q[1:] if first == n else [scene.initial_q[1]] * n
    return Chain(
        _mass(scene.model), masses, lengths, np.array(angles), scene.model.gravity, scene.duration
    )


def _knuckle_of(scene: Scene, payload: Array) -> KnuckleCrane:
    model = scene.model
    arm, rope = model.support, model.cable.spring
    springs = (arm.boom_spring, arm.jib_spring, rope)
    stiffness, neutral = (
        tuple(spring.stiffness for spring in springs),
        tuple(spring.rest for spring in springs),
    )
    rods = (
        RodParameters(rod.length, rod.mass, rod.inertia, rod.axial_inertia)
        for rod in (arm.boom, arm.jib)
    )
    q, (boom, jib) = np.array(scene.initial_q[:3]), rods
    values = arm.tower.inertia, boom, jib, model.load.mass, stiffness, neutral
    return KnuckleCrane(*values, q, payload, model.gravity, scene.duration)
