"""Collect the references of the catalogue's hard cases.

Run as python test/reference/collect.py. Writes config/references/hardcases.json, which `crane
reproduce hardcases` and the tests compare with: for each scene the instants, the nodes 1 .. N in
the world with z up, how far they are to be trusted; event times where there are any, and the links'
tensions [N] (K, N) where they are elastic. Sources: test/data/chain.json (its y is up),
test/data/overhead.json (`make.py`) and test/data/knuckle_springs.json (`knuckle.py`), whose nodes
are the boom's end, the tip and the payload.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[2]
TARGET = ROOT / "config" / "references" / "hardcases.json"
SCENES = {
    "knuckle_springs": "23_knuckle_springs_S2k",
    "overhead_swing": "20_N1_S1",
    "overhead_loop": "01_N1_full_loop",
    "overhead_chaos": "02_N2_large_angle",
    "overhead_chain": "03_N10_S3a",
    "overhead_chain_50": "21_N50_S3b",
    "overhead_kinked": "04b_N10_ratio_1e4_kinked",
    "overhead_heavy": "05_N10_ratio_1e6_S4",
    "overhead_heavy_straight": "05_N10_ratio_1e6_S4",
    "overhead_horizontal": "06a_N50_horizontal",
    "overhead_long_cable": "06b_N200",
    "overhead_hoist": "07_fast_hoist_N1",
    "overhead_hoist_chain": "07b_fast_hoist_N4",
    "overhead_winch": "08_massless_winch_N1",
    "overhead_winch_hook": "08_massless_winch_N2",
    "overhead_drum": "08b_force_winch_N2",
    "overhead_pole": "09_3D_spherical_pole",
    "overhead_spatial": "10_3D_driven_N3",
    "overhead_pole_chain": "11_3D_pole_N2",
    "overhead_coulomb": "12_coulomb_stick_slip_N1",
    "overhead_drop": "13_payload_drop_N2",
    "overhead_elastic_free": "14_elastic_k1e7",
    "overhead_bounce": "15_toss_N1_bilateral",
    "overhead_toss": "15_toss_N1_tension_only",
    "overhead_bounce_chain": "15_toss_N3_bilateral",
    "overhead_toss_chain": "15_toss_N3_tension_only",
    "overhead_spring": "22_elastic_k1e6_S5",
    "overhead_steel": "16_elastic_k1e9",
    "overhead_joints": "17_joint_stiffness_N3",
    "overhead_rods": "18_rod_inertia_N3",
    "overhead_friction": "19_stick_slip_N1",
    "overhead_friction_chain": "19b_stick_slip_N3",
}


def stored(name: str) -> dict[str, Any]:
    """Return the cases of a file; none while it is not there."""
    source = ROOT / "test" / "data" / f"{name}.json"
    return json.loads(source.read_text()) if source.exists() else {}


def main() -> None:
    """Write the collection; cases that are not solved yet are left out, and named."""
    old, own = stored("chain"), stored("overhead") | stored("knuckle_springs")
    found = {}
    for scene, key in SCENES.items():
        case = own.get(key) or old.get(key)
        if case is None:
            print(f"{scene}: {key} is not solved yet")
            continue
        nodes = np.array(case["node_positions_xyz"]).reshape(len(case["t"]), -1, 3)
        nodes = nodes if key in own else nodes[..., [0, 2, 1]]
        found[scene] = {
            "t": case["t"],
            "nodes": nodes.tolist(),
            "trusted": case["trusted_abs_error_m"],
        }
        if "event_times" in case:
            found[scene]["events"] = case["event_times"]
        if case["spec"].get("model") == "elastic 2D" and "tension" in case:
            found[scene]["tension"] = case["tension"]
    TARGET.parent.mkdir(exist_ok=True)
    lines = [
        f"{json.dumps(scene)}: {json.dumps(case, separators=(',', ':'))}"
        for scene, case in found.items()
    ]
    TARGET.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
