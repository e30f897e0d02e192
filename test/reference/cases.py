"""The hard cases of the rigid overhead crane: parameters, initial conditions and drives."""

from collections.abc import Callable
from typing import Any

import numpy as np
from extrapolation import Setting
from friction import StickSlip
from rigid import Rigid
from solution import LOOSE, TIGHT, Case
from starts import aim, drive, hang, instants, sine, smooth

DEGREES_30, DEGREES_60 = float(np.deg2rad(30.0)), float(np.deg2rad(60.0))
# rounding of stiff forces is in the velocities of light nodes; in positions it is smaller by their
# frequency
STIFF = Setting(9, 1e-13), Setting(7, 2e-12)


def plane(
    spec: dict[str, Any], times: list[float], settings: Any = (TIGHT, LOOSE), **groups: Any
) -> Case:
    """Return a planar case with a free trolley from its description."""
    spec = {"model": "rigid 2D", "g": 9.81, "F": 0.0, "x0": 0.0, "xdot0": 0.0} | spec
    count = len(spec["m_i"])
    spec = {"N": count} | spec | {"alphadot0": spec.get("alphadot0", [0.0] * count)}
    system = Rigid([spec["trolley_mass"]], spec["m_i"], spec["l_i"], **groups)
    start = hang(spec["l_i"], spec["alpha0"], spec["alphadot0"])
    return Case(spec, times, *start, [(times[-1], system)], settings)


def straight(
    n: int, node: float, payload: float, link: float, trolley: float, angle: float, note: str
) -> Any:
    """Return description of a straight chain that is let go from rest."""
    masses = [node] * (n - 1) + [payload]
    return {
        "trolley_mass": trolley,
        "m_i": masses,
        "l_i": [link] * n,
        "alpha0": [angle] * n,
        "note": note,
    }


def swing() -> Case:
    """One link let go at 60 degrees."""
    spec = straight(1, 0.0, 10.0, 2.0, 5.0, DEGREES_60, "scene S1 of the benchmark")
    return plane(spec, instants(10.0))


def heavy() -> Case:
    """Ten links, payload 1000 times a node."""
    return plane(
        straight(10, 0.1, 100.0, 0.2, 5.0, DEGREES_30, "scene S3a of the benchmark"), instants(5.0)
    )


def fifty() -> Case:
    """Fifty links, payload 1000 times a node, on a rope of ten metres."""
    return plane(
        straight(50, 0.1, 100.0, 0.2, 5.0, DEGREES_30, "scene S3b of the benchmark"), instants(5.0)
    )


def heavier() -> Case:
    """Ten links, payload a million times a node."""
    spec = straight(10, 1e-4, 100.0, 0.2, 5.0, DEGREES_30, "scene S4 of the benchmark: ratio 1e6")
    return plane(spec, instants(5.0), STIFF)


def horizontal() -> Case:
    """Fifty links from the horizontal."""
    spec = straight(
        50, 0.1, 10.0, 0.2, 50.0, float(np.pi / 2), "cable straight out; a kink runs down the cable"
    )
    return plane(spec, instants(2.0))


def long_chain() -> Case:
    """Two hundred links."""
    return plane(
        straight(200, 0.01, 5.0, 0.05, 5.0, DEGREES_30, "many links"), instants(2.0), STIFF
    )


def fast_hoist() -> Case:
    """First link hoisted fast above three fixed ones, then held."""
    spec = {
        "trolley_mass": 50.0,
        "m_i": [0.5, 0.5, 0.5, 20.0],
        "l_i": [10.0, 0.5, 0.5, 0.5],
        "alpha0": [0.1] * 4,
    }
    spec |= {
        "l1": "10-9.5*(10q^3-15q^4+6q^5), q=clip(t/2,0,1)",
        "note": "prescribed winch on link 1",
    }
    case = plane(spec, instants(3.0, 12), profile=smooth(10.0, 0.5, 2.0))
    case.phases.insert(0, (2.0, case.phases[0][1]))
    return case


def winch(masses: list[float], links: list[float], inertia: float, offset: float) -> Case:
    """First link driven by a winch force, with inertia or without.

    Without inertia the tension is minus the force.
    """
    push = {"offset": offset, "amplitude": 20.0, "frequency": 3.0}
    count = len(masses)
    spec = {
        "trolley_mass": 5.0,
        "m_i": masses,
        "l_i": links,
        "alpha0": [0.4, 0.3][:count],
        "l1dot0": 0.0,
    }
    spec |= {"alphadot0": [0.2, -0.1][:count], "winch_inertia": inertia, "F_1": push}
    spec["note"] = (
        "l_i[0] is the first length of link 1; F_1: generalised force on l_1, lengthening positive"
    )
    case = plane(spec, instants(3.0), winch_inertia=inertia, winch_force=sine(push))
    case.winch = [links[0], 0.0] if inertia else []
    return case


def space(spec: dict[str, Any], times: list[float]) -> Case:
    """Return a case in space from its description."""
    spec = {"model": "rigid 3D", "g": 9.81, "N": len(spec["m_i"])} | spec
    moved = [spec["trolley_mass"], spec["trolley_mass"] + spec["bridge_mass"]]
    system = Rigid(moved, spec["m_i"], spec["l_i"], drive=drive(spec["F_x"], spec["F_y"]))
    return Case(spec, times, *aim(spec["l_i"], spec["n0"], spec["ndot0"]), [(times[-1], system)])


def driven_space() -> Case:
    """Bridge and trolley driven by sines, cable out of every plane."""
    spec: dict[str, Any] = {
        "trolley_mass": 20.0,
        "bridge_mass": 30.0,
        "m_i": [1.0, 1.0, 10.0],
        "l_i": [1.0, 0.8, 1.2],
    }
    spec |= {"n0": [[0.6, 0.0, -0.8], [0.0, 0.6, -0.8], [0.48, -0.36, -0.8]]}
    spec |= {"ndot0": [[0.0, 0.5, 0.0], [0.3, 0.0, 0.0], [0.3, 0.4, 0.0]]}
    spec |= {
        "F_x": {"amplitude": 40.0, "frequency": 2.0},
        "F_y": {"amplitude": 60.0, "frequency": 1.3, "phase": 0.5},
    }
    return space(
        spec | {"note": "directions and rates are taken unit and perpendicular"}, instants(5.0)
    )


def pole() -> Case:
    """Both links pass close to the y axis, where out-of-plane angles are singular."""
    spec: dict[str, Any] = {
        "trolley_mass": 20.0,
        "bridge_mass": 30.0,
        "m_i": [1.0, 1.0],
        "l_i": [1.0, 1.0],
    }
    spec |= {
        "n0": [[0.0, 0.0, -1.0], [0.0, 0.0, -1.0]],
        "ndot0": [[0.02, 6.0, 0.0], [-0.03, 6.5, 0.0]],
    }
    return space(
        spec | {"F_x": {}, "F_y": {}, "note": "passes the poles n = (0, +-1, 0)"}, instants(2.5)
    )


def drop() -> Case:
    """Most of the payload falls off at once."""
    spec = {"trolley_mass": 20.0, "m_i": [1.0, 100.0], "l_i": [2.0, 2.0], "alpha0": [0.5, 0.4]}
    spec |= {"events": [{"at": 1.0, "m_N": 1.0}], "note": "velocities are continuous at the drop"}
    case = plane(spec, instants(3.0, 12))
    case.phases = [(1.0, case.phases[0][1]), (3.0, Rigid([20.0], [1.0, 1.0], [2.0, 2.0]))]
    return case


def bending() -> Case:
    """Springs and dampers in the joints."""
    spec = {
        "trolley_mass": 5.0,
        "m_i": [1.0, 1.0, 5.0],
        "l_i": [1.0, 0.8, 0.6],
        "alpha0": [0.5, 0.4, 0.45],
    }
    groups = {"stiffness": [20.0, 10.0, 5.0], "damping": [0.5, 0.3, 0.2]}
    note = (
        "torque on link k at its upper joint: -K_k (alpha_k - alpha_(k-1)) - C_k (rates alike), "
        "alpha_0 = 0"
    )
    return plane(
        spec
        | {
            "joint_stiffness": groups["stiffness"],
            "joint_damping": groups["damping"],
            "note": note,
        },
        instants(3.0),
        **groups,
    )


def rods() -> Case:
    """Links with rotational inertia."""
    spec = {
        "trolley_mass": 5.0,
        "m_i": [1.0, 1.0, 5.0],
        "l_i": [1.0, 0.8, 0.6],
        "alpha0": [0.6, -0.3, 0.9],
    }
    note = "kinetic energy has J_k alphadot_k^2 / 2 besides that of the nodes"
    return plane(
        spec | {"J_k": [0.2, 0.1, 0.3], "note": note},
        instants(3.0),
        rotational_inertias=[0.2, 0.1, 0.3],
    )


def stick_slip(masses: list[float], links: list[float]) -> Case:
    """Trolley that sticks harder than it slips."""
    force: dict[str, float] = {"amplitude": 30.0, "frequency": 2.0}
    dry: dict[str, Any] = {"coulomb": 14.0, "static": 20.0, "viscous": 1.0}
    spec = {
        "trolley_mass": 10.0,
        "m_i": masses,
        "l_i": links,
        "alpha0": [0.4] * len(masses),
        "F": force,
    }
    spec |= {
        "friction": dry,
        "note": "starts in stick (|T_1x| < static); modes: +1, -1 slip, 0 stick",
    }
    case = plane(spec, instants(6.0, 12))
    case.phases = [(6.0, StickSlip([10.0], masses, links, drive=drive(force), **dry))]
    return case


CASES: dict[str, Callable[[], Case]] = {
    "20_N1_S1": swing,
    "03_N10_S3a": heavy,
    "05_N10_ratio_1e6_S4": heavier,
    "07b_fast_hoist_N4": fast_hoist,
    "08_massless_winch_N1": lambda: winch([10.0], [3.0], 0.0, -95.0),
    "08_massless_winch_N2": lambda: winch([0.5, 10.0], [3.0, 1.0], 0.0, -100.0),
    "08b_force_winch_N1": lambda: winch([10.0], [3.0], 15.0, -95.0),
    "08b_force_winch_N2": lambda: winch([0.5, 10.0], [3.0, 1.0], 15.0, -100.0),
    "10_3D_driven_N3": driven_space,
    "13_payload_drop_N2": drop,
    "19_stick_slip_N1": lambda: stick_slip([5.0], [2.0]),
    "11_3D_pole_N2": pole,
    "17_joint_stiffness_N3": bending,
    "18_rod_inertia_N3": rods,
    "19b_stick_slip_N3": lambda: stick_slip([0.5, 0.5, 4.0], [0.7, 0.7, 0.6]),
    "21_N50_S3b": fifty,
    "06a_N50_horizontal": horizontal,
    "06b_N200": long_chain,
}
