"""The scenes of the benchmark, and where their payloads truly end."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.evaluation.reproduce.hardcases import hardcase_references
from crane_sim.scenes.scene import Scene, load_scene

LEVELS = (1e-2, 1e-4, 1e-6, 1e-9)
"""Errors [m] at which engines are compared: the distance of the payload from its reference at the end."""


class Case(NamedTuple):
    """One scene of the benchmark."""

    id: str
    scene: str  # of the catalogue
    title: str
    compared: bool = True  # with other engines; otherwise it has what they do not model
    like: str = ""  # the case whose engines it is compared with: the same crane, modelled otherwise


CASES = (
    Case("S1", "overhead_swing", "one link, 2 m, 10 kg, let go at 60°"),
    Case("S2k", "knuckle_springs", "knuckle boom on springs, swinging in space"),
    Case("S3a", "overhead_chain", "ten links, payload 1000 times a node"),
    Case("S3b", "overhead_chain_50", "fifty links, payload 1000 times a node"),
    Case("S4", "overhead_heavy", "ten links, payload a million times a node"),
    Case("S4r", "overhead_heavy_straight", "S4 taken for a straight rod by the scene", compared=False, like="S4"),
    Case("S5", "overhead_spring", "one elastic link of 1e6 N/m"),
    Case("3D", "overhead_spatial", "three links in space, both axes shaken", compared=False),
    Case("hoist", "overhead_hoist", "hoist from 10 m to 0.5 m in two seconds", compared=False),
    Case("slip", "overhead_coulomb", "trolley that sticks and slips", compared=False),
    Case("kink", "overhead_kinked", "ten kinked links, payload 10 000 times a node", compared=False),
    Case("steel", "overhead_steel", "five elastic links of 1e9 N/m", compared=False),
)


class Truth(NamedTuple):
    """The reference of a case."""

    payload: npt.NDArray[np.float64]  # (3,) m, at the end
    trusted: float  # m
    tension: float | None  # N, of an elastic cable at the end


def case_scene(case: Case) -> Scene:
    """Return the scene of a case."""
    return load_scene(case.scene)


def truth_of(case: Case) -> Truth:
    """Return the reference of a case, from extended precision (`test/reference`)."""
    known = hardcase_references()[case.scene]
    tension = known["tension"][-1][-1] if "tension" in known else None
    return Truth(np.array(known["nodes"][-1][-1]), known["trusted"], tension)
