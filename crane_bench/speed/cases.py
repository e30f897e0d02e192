"""The scenes of the benchmark, and reference end positions of their payloads."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.reproduce.hardcases import hardcase_references
from crane_sim.scenes.scene import Scene, load_scene

ERROR_LEVELS = (1e-2, 1e-4, 1e-6, 1e-9, 1e-12)
"""Errors [m] at which engines are compared: the distance of the payload from its reference at the
end."""
# smallest error that a case is asked for, as a multiple of its reference's error bound
MIN_TRUST = 20.0


class Case(NamedTuple):
    """One scene of the benchmark."""

    id: str
    scene: str  # of the catalogue
    title: str
    compare_engines: bool = True  # False: other engines cannot model it
    engine_results_from: str = ""  # id of the case whose engines it is compared with: the same
    # crane, another model


CASES = (
    Case("S1", "overhead_swing", "one link, 2 m, 10 kg, let go at 60°"),
    Case("S2k", "knuckle_springs", "knuckle boom on springs, swinging in space"),
    Case("S3a", "overhead_chain", "ten links, payload 1000 times a node"),
    Case("S3b", "overhead_chain_50", "fifty links, payload 1000 times a node"),
    Case("S4", "overhead_heavy", "ten links, payload a million times a node"),
    Case(
        "S4r",
        "overhead_heavy_straight",
        "S4 taken for a straight rod by the scene",
        compare_engines=False,
        engine_results_from="S4",
    ),
    Case("S5", "overhead_spring", "one elastic link of 1e6 N/m"),
    Case("3D", "overhead_spatial", "three links in space, both axes shaken", compare_engines=False),
    Case(
        "hoist", "overhead_hoist", "hoist from 10 m to 0.5 m in two seconds", compare_engines=False
    ),
    Case("slip", "overhead_coulomb", "trolley that sticks and slips", compare_engines=False),
    Case(
        "kink",
        "overhead_kinked",
        "ten kinked links, payload 10 000 times a node",
        compare_engines=False,
    ),
    Case("steel", "overhead_steel", "five elastic links of 1e9 N/m", compare_engines=False),
)


class ReferenceSolution(NamedTuple):
    """The reference of a case."""

    payload: npt.NDArray[np.float64]  # (3,) m, at the end
    error_bound: float  # m
    tension: float | None  # N, of an elastic cable at the end
    attitude: npt.NDArray[np.float64] | None = None  # (3, 3) rotation of a rigid load at the end


def is_asked(level: float, error_bound: float) -> bool:
    """Return whether a reference with this error bound [m] can tell an error `level` [m]."""
    return level >= MIN_TRUST * error_bound


def case_scene(case: Case) -> Scene:
    """Return the scene of a case."""
    return load_scene(case.scene)


def reference_of(case: Case) -> ReferenceSolution:
    """Return the reference of a case, from extended precision (`test/reference`)."""
    data = hardcase_references()[case.scene]
    tension = data["tension"][-1][-1] if "tension" in data else None
    return ReferenceSolution(np.array(data["nodes"][-1][-1]), data["trusted"], tension)
