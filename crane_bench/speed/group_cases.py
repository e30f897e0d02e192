"""Scenes that measure the cost of optional groups: a baseline scene per crane, and one change for each group.

Limit switches, sensors, faults, and limits and lags of drives have no row here: they are no part of the equations, the
plant computes them once a period.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

Changes = Mapping[str, Any]


class Baseline(NamedTuple):
    """A crane without optional groups."""

    label: str
    scene: str  # of the catalogue
    changes: Changes = {}


class GroupCase(NamedTuple):
    """One group: its change of the baseline, and changes that both scenes need to be comparable."""

    baseline: Baseline
    group: str
    changes: Changes
    common: Changes = {}
    parts: tuple[str, ...] = ()  # groups of the same baseline that a joint case has at once; empty: a single group


KNUCKLE = Baseline("knuckle", "knuckle_setpoint", {"control": None})
ROD = Baseline("one link", "overhead_swing")
CHAIN = Baseline("ten links", "overhead_chain")
ELASTIC = Baseline("elastic link", "overhead_spring")
SPATIAL = Baseline("one link, 3D", "overhead_pole", {"trolley": {"mass": 5.0}, "bridge": {"mass": 5.0}})
_BARE: Changes = {
    "links": [],
    "rope": {"drive": "rate", "time_constant": 0.3},
    "control": None,
    "reference": None,
    "actuators": {},
}
"""Changes common to cranes with one rope: no further links, no law or target, ideal actuators; a rate-driven rope."""
TOWER = Baseline("tower", "tower_gust", {**_BARE, "wind": None, "trolley.limits": None, "payload": {"mass": 4000.0}})
MOBILE = Baseline(
    "mobile",
    "mobile_lift",
    {**_BARE, "payload": {"mass": 8000.0}, "boom.limits": None, "telescope.limits": None},
)
BRIDGE = Baseline(
    "bridge",
    "bridge_hook_and_sling",
    {"links": [], "payload": {"mass": 8000.0}, "trolley.limits": None, "rope.limits": None, "initial.rigging": None},
)
_ENDS = [[0.0, 0.0, 0.0]]
GANTRY = Baseline("one fall", "spreader_skew", {"falls": {"top": _ENDS, "bottom": _ENDS, "axial_stiffness": 3.9e8}})

TOWER_FALLS = Baseline(
    "tower falls", "tower_set_down", {"contact": None, "friction": {}, "inputs": {}, "trolley.limits": None}
)

MOBILE_FALLS = Baseline(
    "mobile falls",
    "mobile_lift",
    {
        "rope": None,
        "links": None,
        "control": None,
        "reference": None,
        "actuators": {},
        "boom.limits": None,
        "telescope.limits": None,
        "initial": {"q": [0.0, "65 deg", 36.0, 22.0]},
        "falls": {"top": _ENDS, "bottom": _ENDS, "axial_stiffness": 9.6e7},
        "hoist": {"drive": "rate"},
    },
)
SHIP = Baseline(
    "knuckle hook",
    "knuckle_hook_and_sling",
    {**_BARE, "links": [{"mass": 60.0, "length": 2.5}], "payload": {"mass": 2000.0}},
)
SHIP_FALLS = Baseline(
    "knuckle falls",
    "knuckle_ship_falls",
    {
        "contact": None,
        "base_motion": None,
        "inputs": {},
        "actuators": {},
        "boom.limits": None,
        "jib.limits": None,
        "hoist": {"drive": "rate"},
        "falls": {"top": _ENDS, "bottom": _ENDS, "axial_stiffness": 3.06e7},
    },
)
POINT = Baseline("pendulum", "pendulum_sea", {"base_motion": None, "control": None, "reference": None})
POINT_FALLS = Baseline("boat on falls", "pendulum_lifeboat", {"base_motion": None, "inputs": {}})

_LAW = {"law": "energy", "period": 0.01, "kp": [30, 10, 10, 1], "kd": [50, 30, 50, 10]}
_SMOOTH_MOTION = {"kind": "smooth", "start": 0.0, "duration": 2.0}
_TROLLEY_FRICTION = {"coulomb": 14.0, "static": 20.0, "viscous": 1.0}
_SPRINGS = {
    "boom": {"stiffness": 2000.0, "rest": 0.8},
    "jib": {"stiffness": 1000.0, "rest": -1.0, "relative": True},
}
_SWING_FRICTION = {"model": "quadratic", "tangential": 0.1, "radial": 0.1}
_INITIAL_SPEED = {"initial.v": 0.5}  # m/s: a trolley that sticks would have less to compute
_DIRECTION = [[0.5, 0.0, -0.8660254037844386]]
_GUSTS = {"spectrum": "von_karman", "intensity": 0.15}
_WIND = {"speed": 9.0, "height": 40.0, "origin_height": 50.0, "profile": {"law": "power", "exponent": 0.16}}
_WINDAGE = {"area": 8.0, "drag_coefficient": 1.3}
_SMALL_WINDAGE, _BOOM_WINDAGE = {"area": 0.1, "drag_coefficient": 1.2}, {"area": 0.8, "drag_coefficient": 1.7}
_BOOM_AND_JIB_WINDAGE = {"boom.windage": _BOOM_WINDAGE, "jib.windage": _BOOM_WINDAGE}
_JOINTS = ("slew", "boom", "jib", "rope")
_DRY = {"coulomb": 1.0, "static": 1.4, "viscous": 0.5, "stribeck": 0.05}
_BRISTLES = _DRY | {"stiffness": 1e3, "damping": 10.0}
_SPEEDS = {"initial.v": [0.2, 0.1, 0.1, 0.1, 0.0, 0.0]}  # no joint sticks
_RAILS, _TRAVELS = ("trolley", "bridge"), {"initial.v": [0.5, 0.5, 0.0, 0.0, 0.0]}
_TRAVELS_BELOW = {"initial.v": [0.5, 0.5, 0.0]}
_RUBS = {"coulomb": 600.0, "static": 800.0, "viscous": 50.0, "stribeck": 0.01}
_BENDS = _RUBS | {"stiffness": 1e6, "damping": 1e4}
_WIDE = ["-80 deg", "80 deg"]
_MOTOR = {"motor": {"ratio": 50.0, "inertia": 1e-3}}
_LINK = {"links": [{"mass": 450.0, "length": 3.0}]}
_BODY = {"payload": {"mass": 4000.0, "inertia": [2.8e3, 8.9e3, 9.3e3], "attachment": [0.1, 0.0, 0.7]}}
_PUSH = {"payload_force": {"x": {"kind": "constant", "value": 100.0}}}
_FOUR = [[x, y, 0.0] for x in (1.2, -1.2) for y in (2.8, -2.8)]
_FALLS = {"top": _FOUR, "bottom": [[0.6 * x, 0.8 * y, z] for x, y, z in _FOUR], "axial_stiffness": 9.6e7}
_DRIVE = {"inertia": 2e3, "play": 2e-3, "stiffness": 1e7, "damping": 1.4e4}
_DECK = {"points": [[x, y, -2.0] for x, y, _ in _FOUR], "height": -60.0, "friction": 0.1, "restitution": 0.1}
_CONTAINER = {"mass": 58.48e3, "inertia": [655e3, 52e3, 655e3], "attachment": [0.0, 0.0, 2.2]}
_MODE = {"stiffness": 3e8, "damping_ratio": 0.01}
_MAST = {"height": 41.0, "stiffness": 3.8e8, "damping_ratio": 0.01, "mass": 6e3}
_BENDING, _JIB = {"lateral": _MODE, "vertical": _MODE}, {"mass": 1.05e4, "centre": 30.0, "inertia": 3.15e6}
_SHEAVES = {"radius": 0.2, "inertia": 0.5, "loss": {"kind": "efficiency", "efficiency": 0.98}}
_WOUND = {"falls": 1, "sheaves": _SHEAVES, "drum": {"radius": 0.2, "inertia": 60.0}}
_REEVING = {"falls": 12, "lead_sheaves": 1, "sheaves": _SHEAVES, "drum": {"radius": 0.2, "inertia": 60.0}}
_JIB_RUBS = {"friction": dict.fromkeys(("slew", "trolley"), _RUBS)}
_JIB_MOVES = {"initial.v": [0.01, 0.5, 0.0, 0.0, 0.0]}
_CORNERS = [[x, y, -2.0] for x in (2.0, -2.0) for y in (1.2, -1.2)]
_ROOF = {"points": _CORNERS, "height": -60.0, "friction": 0.5, "restitution": 0.1}
_SPRINGS_BELOW = {key: _DECK[key] for key in ("points", "height", "friction")} | {"kind": "compliant", "stiffness": 1e8}
_SLAB = {"mass": 8.9e3, "inertia": [9e3, 15e3, 15e3], "attachment": [0.05, 0.1, 2.25]}
_PAYLOAD_CHANGE = [{"at": 1.0, "set": {"payload": {"mass": 5.0}}}]
_EXCHANGE_ON_DECK = [
    {"at": 1.0, "set": {"payload": _CONTAINER, "contact": {"points": _DECK["points"], "height": -60.0}}}
]
_HEAVING = {"heave": {"amplitude": 0.5, "frequency": 0.7}}
_WINDS, _HEAVY = {"initial.v": [0.0, 0.0, 0.5]}, {"hoist": {"drive": "force", "mass": 2e4}}  # a winch that turns
_BOOM_JOINTS, _BOOM_MOVES = ("slew", "boom", "telescope"), {"initial.v": [0.01, 0.01, 0.1, 0.0, 0.0, 0.0]}
_MOBILE_WINDAGE = {"width": 0.9, "drag_coefficient": 1.6}
_SHIP_MOVES = {"initial.v": [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]}
_SHIP_FALLS_MOVE = {"initial.v": [0.01, 0.01, 0.01, 0.0]}
_TWO = [[x, 0.0, 0.0] for x in (0.15, -0.15)]
_TWO_FALLS = {"top": _TWO, "bottom": _TWO, "axial_stiffness": 1.53e7}

SINGLE = (
    GroupCase(KNUCKLE, "axial inertia of the rods", {"boom.axial_inertia": 0.02, "jib.axial_inertia": 0.02}),
    GroupCase(KNUCKLE, "springs of boom and jib", {"springs": _SPRINGS}),
    GroupCase(KNUCKLE, "spring of the rope", {"springs.rope": {"stiffness": 200.0, "rest": 2.0}}),
    GroupCase(KNUCKLE, "swing friction, linear", {"swing_friction": _SWING_FRICTION | {"model": "linear"}}),
    GroupCase(KNUCKLE, "swing friction, quadratic", {"swing_friction": _SWING_FRICTION}),
    GroupCase(KNUCKLE, "air drag", {"payload_drag": {"coefficient": 0.05}}),
    GroupCase(KNUCKLE, "winch, rate-driven", {"rope": {"drive": "rate", "time_constant": 0.1}}),
    GroupCase(KNUCKLE, "winch, locked", {"rope": {"drive": "locked"}, "reference": None}),
    GroupCase(KNUCKLE, "energy meter", {}, {"control": _LAW}),
    GroupCase(KNUCKLE, "inputs, sine", {"inputs": {"slew": {"kind": "sine", "amplitude": 1.0, "frequency": 1.0}}}),
    GroupCase(KNUCKLE, "law in the equations", {"control": _LAW | {"period": "continuous"}}),
    GroupCase(ROD, "friction of the trolley", {"friction": {"trolley": _TROLLEY_FRICTION}}, _INITIAL_SPEED),
    GroupCase(ROD, "limits of the trolley", {"trolley.limits": [-100.0, 100.0]}),
    GroupCase(
        ROD,
        "trolley, prescribed",
        {"trolley": {"drive": "prescribed", "motion": _SMOOTH_MOTION | {"from": 0.0, "to": 2.0}}},
    ),
    GroupCase(
        ROD,
        "hoist, prescribed",
        {"hoist": {"drive": "prescribed", "profile": _SMOOTH_MOTION | {"from": 2.0, "to": 1.0}}},
    ),
    GroupCase(ROD, "hoist, force-driven", {"hoist": {"drive": "force", "inertia": 5.0}}),
    GroupCase(ROD, "hoist, massless", {"hoist": {"drive": "force"}}),
    GroupCase(ROD, "elastic link", {"cable.model": "elastic", "cable.stiffness": 1e6}),
    GroupCase(ROD, "3 dimensions", {"dimensions": 3, "bridge": {"mass": 5.0}, "initial": {"directions": _DIRECTION}}),
    GroupCase(CHAIN, "bending joints", {"joints": {"stiffness": 20.0, "damping": 0.5}}),
    GroupCase(CHAIN, "links that turn as rods", {"cable.inertia": 0.01}),
    GroupCase(
        CHAIN, "force on a node", {"forces": [{"node": 5, "axis": "x", "force": {"kind": "constant", "value": 1.0}}]}
    ),
    GroupCase(CHAIN, "hoist, force-driven", {"hoist": {"drive": "force", "inertia": 5.0}}),
    GroupCase(CHAIN, "friction of the trolley", {"friction": {"trolley": _TROLLEY_FRICTION}}, _INITIAL_SPEED),
    GroupCase(CHAIN, "slack ends the run", {"cable.slack": "stop"}),
    GroupCase(CHAIN, "payload that changes", {"events": _PAYLOAD_CHANGE}),
    GroupCase(CHAIN, "elastic links", {"cable.model": "elastic", "cable.stiffness": 1e6}),
    GroupCase(
        CHAIN, "3 dimensions", {"dimensions": 3, "bridge": {"mass": 5.0}, "initial": {"directions": 10 * _DIRECTION}}
    ),
    GroupCase(CHAIN, "straight cable instead", {"cable.model": "straight"}),
    GroupCase(ELASTIC, "damping", {"cable.damping": 100.0}),
    GroupCase(ELASTIC, "tension-only", {"cable.tension_only": True}),
    GroupCase(SPATIAL, "friction of the bridge", {"friction": {"bridge": _TROLLEY_FRICTION}}, {"initial.vy": 0.5}),
    GroupCase(KNUCKLE, "wind on the payload", {"wind": _WIND, "payload.windage": _SMALL_WINDAGE}),
    GroupCase(KNUCKLE, "wind with gusts on it", {"wind": _WIND | {"gusts": _GUSTS}, "payload.windage": _SMALL_WINDAGE}),
    GroupCase(KNUCKLE, "wind on boom and jib", {"wind": _WIND, **_BOOM_AND_JIB_WINDAGE}),
    GroupCase(KNUCKLE, "friction of the joints", {"friction": dict.fromkeys(_JOINTS, _DRY)}, _SPEEDS),
    GroupCase(KNUCKLE, "LuGre friction", {"lugre": dict.fromkeys(_JOINTS, _BRISTLES)}, _SPEEDS),
    GroupCase(KNUCKLE, "motors", {"actuators": dict.fromkeys(_JOINTS[:3], _MOTOR)}),
    GroupCase(KNUCKLE, "limits of boom and jib", {"boom.limits": _WIDE, "jib.limits": _WIDE}),
    GroupCase(TOWER, "hook block and sling", _LINK),
    GroupCase(TOWER, "payload with a body", _BODY),
    GroupCase(TOWER, "wind with gusts", {"wind": _WIND | {"gusts": _GUSTS}, "payload.windage": _WINDAGE}),
    GroupCase(TOWER, "moving base", {"base_motion": {"heave": {"amplitude": 0.5, "frequency": 0.7}}}),
    GroupCase(TOWER, "force on the payload", _PUSH),
    GroupCase(TOWER, "slack ends the run", {"rope.slack": "stop"}),
    GroupCase(TOWER, "limits of the trolley", {"trolley.limits": [3.0, 60.0]}),
    GroupCase(TOWER, "jib that bends", {"flexibility": _BENDING | {"jib": _JIB}}),
    GroupCase(TOWER, "friction of the joints", _JIB_RUBS, _JIB_MOVES),
    GroupCase(TOWER, "rope on twelve falls", {"rope.reeving": _REEVING}, {"rope.slack": "stop"}),
    GroupCase(MOBILE, "hook block and sling", _LINK),
    GroupCase(MOBILE, "payload with a body", _BODY),
    GroupCase(MOBILE, "boom that bends", {"flexibility": _BENDING}),
    GroupCase(BRIDGE, "hook block and sling", _LINK),
    GroupCase(BRIDGE, "payload with a body", _BODY),
    GroupCase(BRIDGE, "torsion of the rope", {"rope.torsion": {"stiffness": 60.0, "damping": 5.0}}, _BODY),
    GroupCase(BRIDGE, "drive with play", {"backlash": {"bridge": [_DRIVE]}}),
    GroupCase(BRIDGE, "friction of the joints", {"friction": dict.fromkeys(_RAILS, _RUBS)}, _TRAVELS),
    GroupCase(BRIDGE, "LuGre friction", {"lugre": dict.fromkeys(_RAILS, _BENDS)}, _TRAVELS),
    GroupCase(BRIDGE, "motors", {"actuators": dict.fromkeys(_RAILS, _MOTOR)}),
    GroupCase(BRIDGE, "loads exchanged", {"events": [{"at": 1.0, "set": {"payload": {"mass": 9000.0}}}]}),
    GroupCase(GANTRY, "four falls", {"falls": _FALLS}),
    GroupCase(GANTRY, "damping of the fall", {"falls.relaxation": 0.02}),
    GroupCase(GANTRY, "wind with gusts", {"wind": _WIND | {"gusts": _GUSTS}, "payload.windage": _WINDAGE}),
    GroupCase(GANTRY, "contact with a deck below", {"contact": _DECK}),
    GroupCase(GANTRY, "contact, compliant", {"contact": _SPRINGS_BELOW}),
    GroupCase(GANTRY, "friction of the joints", {"friction": dict.fromkeys(_RAILS, _RUBS)}, _TRAVELS_BELOW),
    GroupCase(GANTRY, "drive with play", {"backlash": {"bridge": [_DRIVE]}}),
    GroupCase(GANTRY, "loads exchanged", {"events": [{"at": 1.0, "set": {"payload": _CONTAINER}}]}),
    GroupCase(TOWER_FALLS, "contact with a roof below", {"contact": _ROOF}),
    GroupCase(TOWER_FALLS, "friction of the joints", _JIB_RUBS, {"initial.v": [0.01, 0.5, 0.0]}),
    GroupCase(TOWER_FALLS, "jib that bends", {"flexibility": _BENDING | {"jib": _JIB}}),
    GroupCase(TOWER_FALLS, "wind with gusts", {"wind": _WIND | {"gusts": _GUSTS}, "payload.windage": _WINDAGE}),
    GroupCase(TOWER_FALLS, "loads exchanged", {"events": [{"at": 1.0, "set": {"payload": _SLAB}}]}),
    GroupCase(GANTRY, "hoist, force-driven", {"hoist": {"drive": "force", "mass": 2e4}}),
    GroupCase(GANTRY, "sheaves, drum and their loss", {"hoist": {"drive": "force", "reeving": _WOUND}}, _WINDS),
    GroupCase(GANTRY, "friction of the winch", {"hoist.friction": _RUBS}, _HEAVY | _WINDS),
    GroupCase(GANTRY, "moving base", {"base_motion": _HEAVING}),
    GroupCase(GANTRY, "loads exchanged on a deck", {"events": _EXCHANGE_ON_DECK}, {"contact": _DECK}),
    GroupCase(TOWER, "mast that sways", {"flexibility": {"jib": _JIB, "mast": _MAST}}),
    GroupCase(TOWER_FALLS, "sheaves, drum and their loss", {"hoist": {"drive": "force", "reeving": _WOUND}}, _WINDS),
    GroupCase(MOBILE, "friction of the joints", {"friction": dict.fromkeys(_BOOM_JOINTS, _RUBS)}, _BOOM_MOVES),
    GroupCase(MOBILE, "wind on the boom", {"wind": _WIND, "boom.windage": _MOBILE_WINDAGE}),
    GroupCase(MOBILE_FALLS, "four falls", {"falls": _FALLS}),
    GroupCase(MOBILE_FALLS, "boom that bends", {"flexibility": _BENDING}),
    GroupCase(MOBILE_FALLS, "contact with the ground", {"contact": _ROOF}),
    GroupCase(SHIP, "payload with a body", _BODY),
    GroupCase(SHIP, "moving base", {"base_motion": _HEAVING}),
    GroupCase(SHIP, "friction of the joints", {"friction": dict.fromkeys(_JOINTS[:3], _RUBS)}, _SHIP_MOVES),
    GroupCase(SHIP_FALLS, "two falls", {"falls": _TWO_FALLS}),
    GroupCase(SHIP_FALLS, "moving base", {"base_motion": _HEAVING}),
    GroupCase(SHIP_FALLS, "contact with its deck", {"contact": _ROOF}),
    GroupCase(SHIP_FALLS, "friction of the joints", {"friction": dict.fromkeys(_JOINTS[:3], _RUBS)}, _SHIP_FALLS_MOVE),
    GroupCase(POINT, "moving base", {"base_motion": _HEAVING}),
    GroupCase(POINT, "servo of the point", {"suspension": {"drive": "servo", "kp": 676.0, "kd": 36.4}}),
    GroupCase(POINT, "payload with a body", _BODY),
    GroupCase(POINT_FALLS, "moving base", {"base_motion": _HEAVING}),
    GroupCase(POINT_FALLS, "contact with the sea bed", {"contact": _ROOF}),
)


def merge_changes(parts: Iterable[Changes]) -> Changes:
    """Return the changes of all parts; groups that several parts set are merged, and must agree on common keys."""
    merged: dict[str, Any] = {}
    for key, value in (item for part in parts for item in part.items()):
        earlier = merged.get(key, value)
        if isinstance(value, Mapping):
            assert all(earlier[name] == value[name] for name in earlier.keys() & value.keys()), key
            merged[key] = {**earlier, **value}
        else:
            assert earlier == value, key
            merged[key] = value
    return merged


def join_groups(baseline: Baseline, *groups: str) -> GroupCase:
    """Return the case of several groups of SINGLE at once, whose changes are merged."""
    rows = {case.group: case for case in SINGLE if case.baseline is baseline}
    changes, common = ([getattr(rows[group], name) for group in groups] for name in ("changes", "common"))
    return GroupCase(baseline, "all of these at once", merge_changes(changes), merge_changes(common), groups)


CASES = (
    *SINGLE,
    join_groups(
        KNUCKLE,
        "axial inertia of the rods",
        "springs of boom and jib",
        "spring of the rope",
        "swing friction, quadratic",
        "wind with gusts on it",
        "wind on boom and jib",
        "friction of the joints",
        "motors",
        "limits of boom and jib",
    ),
    join_groups(
        TOWER,
        "hook block and sling",
        "payload with a body",
        "wind with gusts",
        "force on the payload",
        "slack ends the run",
        "limits of the trolley",
        "jib that bends",
        "friction of the joints",
        "rope on twelve falls",
    ),
    join_groups(MOBILE, "hook block and sling", "payload with a body", "boom that bends"),
    join_groups(
        BRIDGE,
        "hook block and sling",
        "payload with a body",
        "torsion of the rope",
        "drive with play",
        "friction of the joints",
    ),
    join_groups(
        GANTRY,
        "four falls",
        "damping of the fall",
        "wind with gusts",
        "contact with a deck below",
        "friction of the joints",
        "drive with play",
        "hoist, force-driven",
    ),
    join_groups(MOBILE_FALLS, "four falls", "boom that bends", "contact with the ground"),
    join_groups(SHIP, "payload with a body", "moving base", "friction of the joints"),
    join_groups(SHIP_FALLS, "two falls", "moving base", "contact with its deck", "friction of the joints"),
    join_groups(
        TOWER_FALLS,
        "contact with a roof below",
        "friction of the joints",
        "jib that bends",
        "wind with gusts",
    ),
)
