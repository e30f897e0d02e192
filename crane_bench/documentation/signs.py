"""Signs and origins: where the axes of each crane are, and which way each of its joints is positive.

The page of the scene format prints these words; `test_scene_format.py` holds each of them against the model.
"""

from typing import NamedTuple


class Sign(NamedTuple):
    """A joint's coordinate in words."""

    crane: str
    joint: str  # its name, k for a number
    unit: str
    zero: str  # where it is zero
    positive: str  # where it grows to


WORLD = """`world` is right-handed: x forward, y left, z up. Everything is in SI units and radians; an angle is a
number of radians up to a turn (of swings, roll, pitch and yaw up to half a turn, of roll and pitch in `base_motion`
up to an eighth), or text of any size such as `45 deg` or `0.5 rad`. On a moving base `base` are the axes that move
with it, and which lie on `world` where the base is at rest in zero; joints and paths are relative to the base, what a
run shows of payload, tip and nodes is in `world`. Joints keep the order of the tables below, those that take efforts
first."""

ORIGINS = {
    "knuckle": "The origin is the pivot of the boom, on the axis about which the tower slews.",
    "tower": "The origin is on the tower's axis, at the height of the jib's underside, where the rope begins.",
    "mobile": "The origin is on the slewing axis; `superstructure.foot` says where the boom's foot pin is from there.",
    "bridge": "The origin is on the trolley's rail, where `trolley` and `bridge` are zero.",
    "gantry": "The origin is on the trolley's rail, where `trolley` and `bridge` are zero. `payload_x` .. `payload_z` "
    "are the load's centre of mass in the axes of the base.",
    "overhead": "The origin is on the trolley's rail, at the height of the cable's upper end, where `trolley` (and "
    "`bridge`) are zero. In 2 dimensions everything moves in the plane of x and z. Efforts of trolley and bridge are "
    "forces along their joints; that of the hoist is a force on its length, positive pays out.",
    "pendulum": "The origin is where the suspension point is when its joints are zero. The effort is the point's "
    "acceleration, or with a servo its target position.",
}
"""Origin and efforts of each crane."""

SIGNS = (
    Sign("knuckle", "slew", "rad", "boom and jib in the plane of x and z, towards x", "counter-clockwise from above"),
    Sign("knuckle", "boom", "rad", "horizontal", "upwards: its elevation"),
    Sign("knuckle", "jib", "rad", "horizontal, independent of the boom's elevation", "upwards: its elevation"),
    Sign("knuckle", "rope", "m", "the payload at the jib's end", "longer"),
    Sign("knuckle", "swing_tangential", "rad", "the rope in the boom's plane", "to where a positive slew goes"),
    Sign("knuckle", "swing_radial", "rad", "the rope leans neither way", "away from the tower"),
    Sign("tower", "slew", "rad", "the jib along x", "counter-clockwise from above"),
    Sign("tower", "trolley", "m", "the tower's axis", "outwards: its radius"),
    Sign("tower", "rope", "m", "the hook at the trolley", "longer"),
    Sign("tower", "swing_tangential", "rad", "the rope in the jib's plane", "to where a positive slew goes"),
    Sign("tower", "swing_radial", "rad", "the rope leans neither way", "away from the tower"),
    Sign("tower", "lateral_deflection", "rad", "the jib straight; `flexibility`", "to where a positive slew goes"),
    Sign("tower", "vertical_deflection", "rad", "the jib level; `flexibility`", "upwards"),
    Sign("tower", "mast_x_deflection", "rad", "the mast upright; `flexibility.mast`", "about x: its head towards -y"),
    Sign("tower", "mast_y_deflection", "rad", "the mast upright; `flexibility.mast`", "about y: its head towards x"),
    Sign("mobile", "slew", "rad", "the boom in the plane of x and z, towards x", "counter-clockwise from above"),
    Sign("mobile", "boom", "rad", "horizontal", "upwards: its elevation"),
    Sign("mobile", "telescope", "m", "no boom", "longer: from the foot pin to the tip"),
    Sign("mobile", "rope", "m", "the hook at the boom's tip", "longer"),
    Sign("mobile", "swing_tangential", "rad", "the rope in the boom's plane", "to where a positive slew goes"),
    Sign("mobile", "swing_radial", "rad", "the rope leans neither way", "away from the slewing axis"),
    Sign("mobile", "lateral_deflection", "rad", "the boom straight; `flexibility`", "to where a positive slew goes"),
    Sign("mobile", "vertical_deflection", "rad", "the boom straight; `flexibility`", "upwards"),
    Sign("bridge", "trolley", "m", "the origin", "along x"),
    Sign("bridge", "bridge", "m", "the origin", "along y"),
    Sign("bridge", "rope", "m", "the hook at the trolley", "longer"),
    Sign("bridge", "swing_tangential", "rad", "the rope across y", "along y"),
    Sign("bridge", "swing_radial", "rad", "the rope across x", "along x"),
    Sign("bridge", "link_k_x", "1", "further link k across x; of all cranes with `links`", "along x"),
    Sign("bridge", "link_k_y", "1", "further link k across y", "along y"),
    Sign("bridge", "link_k_z", "1", "a horizontal link k", "upwards: hanging it is -1"),
    Sign(
        "bridge", "bridge_drive_k", "m", "as the bridge, in the middle of its play", "as the bridge: it moves no load"
    ),
    Sign("gantry", "trolley", "m", "the origin", "along x: it moves the falls' upper ends, not the load"),
    Sign("gantry", "bridge", "m", "the origin", "along y: as the trolley"),
    Sign("gantry", "hoist", "m", "no length of the falls", "longer: the load follows by their elasticity"),
    Sign("gantry", "payload_x", "m", "the origin", "along x"),
    Sign("gantry", "payload_y", "m", "the origin", "along y"),
    Sign("gantry", "payload_z", "m", "the origin", "upwards: below the rail it is negative"),
    Sign("pendulum", "tip_x", "m", "the origin", "along x"),
    Sign("pendulum", "tip_y", "m", "the origin", "along y"),
    Sign("pendulum", "tip_z", "m", "the origin", "along z"),
    Sign("pendulum", "link_1_x", "1", "the rope across x", "payload along x from the point"),
    Sign("pendulum", "link_1_y", "1", "the rope across y", "payload along y from the point"),
    Sign("pendulum", "link_1_z", "1", "a horizontal rope", "upwards: a hanging rope has -1"),
    Sign("overhead", "trolley", "m", "the origin", "along x"),
    Sign("overhead", "bridge", "m", "the origin; in 3 dimensions", "along y"),
    Sign("overhead", "hoist", "m", "no length of the first link; with a hoist", "longer"),
    Sign("overhead", "swing_k", "rad", "link k hangs down; rigid, 2 dimensions", "its lower end towards x"),
    Sign("overhead", "link_k_x", "1", "link k across x; rigid, 3 dimensions", "its lower end towards x"),
    Sign("overhead", "link_k_y", "1", "link k across y; rigid, 3 dimensions", "its lower end towards y"),
    Sign("overhead", "link_k_z", "1", "a horizontal link k; rigid, 3 dimensions", "upwards: hanging it is -1"),
    Sign("overhead", "node_k_x", "m", "the origin; elastic", "along x: a position, not an angle"),
    Sign("overhead", "node_k_y", "m", "the origin; elastic, 3 dimensions", "along y"),
    Sign("overhead", "node_k_z", "m", "the origin; elastic", "upwards: below the rail it is negative"),
    Sign("base", "surge", "m", "the base's origin in that of `world`", "along x of `world`"),
    Sign("base", "sway", "m", "the base's origin in that of `world`", "along y of `world`"),
    Sign("base", "heave", "m", "the base's origin in that of `world`", "along z of `world`"),
    Sign("base", "roll", "rad", "upright", "the left side rises"),
    Sign("base", "pitch", "rad", "upright", "the bow, which is at x, dips"),
    Sign("base", "yaw", "rad", "the bow along x", "counter-clockwise from above"),
)
"""Every joint, and the motions of a base."""

NOTES = {
    "knuckle": """With the boom's plane at the slew angle, e_r its horizontal direction away from the tower, e_t to the
left of it and e_z up, the payload is at rope × (sin θ₂ e_r + cos θ₂ sin θ₁ e_t - cos θ₂ cos θ₁ e_z) from the jib's end,
θ₁ = swing_tangential, θ₂ = swing_radial. Efforts are torques that turn their joints the positive way; the rope's is a
force on its length, positive pays out, so that a hanging load is held by a negative one.""",
    "overhead": """Swing angles are absolute: each from the downward vertical, not from the link above. In 3 dimensions
links are unit vectors, for which no angle is singular.""",
    "tower": """Of a jib that bends (`flexibility`), `slew` is where its drive is, and swing angles are in the plane of
the bent jib: deflections add to the slew and to the jib's elevation. So on mobile cranes. On a mast that bends they are
in the plane of slew and vertical.""",
    "bridge": """Swing angles are those of the knuckle crane, at slew 0. Further links, of tower, mobile and knuckle
cranes and of the pendulum as well, are unit vectors in the axes of the base. A payload with an inertia adds its
attitude `payload_qw` .. `payload_qz`, the unit quaternion from its axes to those of the base. A drive with play
(`backlash`) adds its position, `JOINT_drive_k`, reflected to its joint; so on tower, mobile and knuckle cranes.""",
    "gantry": """`payload_qw` .. `payload_qz` are the unit quaternion from the load's axes to those of the base. Skew,
trim and list are its rotations about z, y and x. Tower, mobile and knuckle cranes and the pendulum with `falls` in
place of a rope have the joints of their support, then `hoist` (but the pendulum's falls keep their length), and the
load's as here; the falls' upper ends slew with jib or boom, and stay level. What bends, and drives,
stand last.""",
    "base": """The base turns by yaw first, then by pitch about its new y, then by roll about its new x: its axes in
`world` are Rz(yaw) Ry(pitch) Rx(roll).""",
}
"""Further definitions of each crane's joints."""


def section() -> list[str]:
    """Return the lines of the page's section."""
    lines = ["## Signs and origins", "", WORLD, ""]
    titles = {
        "knuckle": "Knuckle crane",
        "tower": "Tower crane",
        "mobile": "Mobile crane",
        "bridge": "Bridge crane with hook and sling",
        "gantry": "Gantry crane",
        "pendulum": "Pendulum",
        "overhead": "Overhead crane",
        "base": "Moving base",
    }
    for crane, title in titles.items():
        lines += [f"### Joints: {title}" if crane != "base" else f"### {title}", ""]
        lines += [ORIGINS[crane], ""] if crane in ORIGINS else []
        lines += ["| joint | unit | zero | positive |", "|---|---|---|---|"]
        lines += [f"| `{s.joint}` | {s.unit} | {s.zero} | {s.positive} |" for s in SIGNS if s.crane == crane]
        lines += ["", NOTES[crane], ""] if crane in NOTES else [""]
    return lines
