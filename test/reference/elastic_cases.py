"""Hard cases of the elastic cable: tosses slack and taut, stiffness of steel, a fast axial mode."""

from collections.abc import Callable
from typing import Any

import numpy as np
from elastic import Elastic
from extrapolation import Setting
from rigid import Real, Vector
from solution import LOOSE, TIGHT, Case, listed
from starts import hang, instants

# links may be slack for less than 1 ms
WATCHFUL = TIGHT._replace(longest=5e-4), LOOSE._replace(longest=3e-4)
# the rounding of forces k e, e a difference of metres, bounds velocities
STEEL = Setting(9, 1e-12), Setting(7, 1e-11)


def stretched(spec: dict[str, Any], angle: float, pulls: list[float]) -> Vector:
    """Return the nodes (N + 1, 2) of a straight chain under tensions [N], rounded to doubles."""
    links = [length + pull / spec["k"] for length, pull in zip(spec["l0"], pulls, strict=True)]
    return hang(links, [angle] * len(links), [0.0] * len(links))[0].astype(float).astype(Real)


def elastic(
    spec: dict[str, Any], nodes: Vector, rates: Vector, times: list[float], settings: Any
) -> Case:
    """Return a case from its description, first nodes and velocities."""
    start = {
        "r0_x": nodes[1:, 0],
        "r0_z": nodes[1:, 1],
        "rdot0_x": rates[1:, 0],
        "rdot0_z": rates[1:, 1],
    }
    spec = (
        spec
        | {name: listed(values) for name, values in start.items()}
        | {"g": 9.81, "N": len(spec["m_i"])}
    )
    only = spec["tension_only"]
    system = Elastic(
        [spec["trolley_mass"]],
        spec["m_i"],
        spec["l0"],
        spring=spec["k"],
        dashpot=spec["c"],
        tension_only=only,
    )
    return Case(
        spec | {"model": "elastic 2D"}, times, nodes, rates, [(times[-1], system)], settings
    )


def toss(masses: list[float], lengths: list[float], k: float, c: float, only: bool) -> Case:
    """Swing too fast for the horizontal, too slow for the top: the payload falls off its circle."""
    spec = {
        "trolley_mass": 50.0,
        "m_i": masses,
        "l0": lengths,
        "k": k,
        "c": c,
        "tension_only": only,
    }
    spec["note"] = (
        "T = k e + c edot; tension_only: max(0, that) where e > 0, else 0; events +k taut, -k slack"
    )
    radii, speed = np.cumsum(lengths), 7.5 / 2.0
    loads = [m * (9.81 + r * speed**2) for m, r in zip(masses, radii, strict=True)]
    nodes = stretched(spec, 0.0, [sum(loads[i:]) for i in range(len(loads))])
    rates = (
        np.stack([-Real(speed) * nodes[:, 1], 0 * nodes[:, 1]], axis=1).astype(float).astype(Real)
    )
    return elastic(spec, nodes, rates, instants(3.0, 12), WATCHFUL)


def steel() -> Case:
    """Five links of 1e9 N/m under one tonne."""
    spec = {"trolley_mass": 200.0, "m_i": [1.0] * 4 + [1000.0], "l0": [2.0] * 5, "k": 1e9, "c": 0.0}
    spec |= {"tension_only": False, "note": "from rest at 0.3 rad, links under their static load"}
    pulls = [float(9.81 * np.cos(0.3) * sum(spec["m_i"][i:])) for i in range(5)]
    nodes = stretched(spec, 0.3, pulls)
    return elastic(spec, nodes, 0 * nodes, instants(1.0), STEEL)


def spring() -> Case:
    """One link of 1e6 N/m let go unstretched at 60 degrees: hundreds of axial vibrations."""
    spec = {
        "trolley_mass": 5.0,
        "m_i": [10.0],
        "l0": [2.0],
        "k": 1e6,
        "c": 0.0,
        "tension_only": False,
    }
    spec["note"] = "scene S5 of the benchmark"
    nodes = stretched(spec, float(np.deg2rad(60.0)), [0.0])
    return elastic(spec, nodes, 0 * nodes, instants(10.0), (TIGHT, LOOSE))


ELASTIC: dict[str, Callable[[], Case]] = {
    "15_toss_N1_bilateral": lambda: toss([10.0], [2.0], 1e4, 20.0, False),
    "15_toss_N1_tension_only": lambda: toss([10.0], [2.0], 1e4, 20.0, True),
    "15_toss_N3_bilateral": lambda: toss([1.0, 1.0, 10.0], [0.7, 0.7, 0.6], 1e5, 50.0, False),
    "15_toss_N3_tension_only": lambda: toss([1.0, 1.0, 10.0], [0.7, 0.7, 0.6], 1e5, 50.0, True),
    "16_elastic_k1e9": steel,
    "22_elastic_k1e6_S5": spring,
}
