"""Scenes that measure the cost of optional groups: a baseline scene per crane, and one change for each group."""

from collections.abc import Mapping
from typing import Any, NamedTuple

Changes = Mapping[str, Any]


class Baseline(NamedTuple):
    """A crane without optional groups."""

    label: str
    scene: str  # of the catalogue
    changes: Changes = {}


class Case(NamedTuple):
    """One group: its change of the baseline, and what both scenes need to be comparable."""

    baseline: Baseline
    group: str
    changes: Changes
    common: Changes = {}


KNUCKLE = Baseline("knuckle", "knuckle_setpoint", {"control": None})
ROD = Baseline("one link", "overhead_swing")
CHAIN = Baseline("ten links", "overhead_chain")
ELASTIC = Baseline("elastic link", "overhead_spring")
SPATIAL = Baseline("one link, 3D", "overhead_pole", {"trolley": {"mass": 5.0}, "bridge": {"mass": 5.0}})

_LAW = {"law": "energy", "period": 0.01, "kp": [30, 10, 10, 1], "kd": [50, 30, 50, 10]}
_SMOOTH_MOTION = {"kind": "smooth", "start": 0.0, "duration": 2.0}
_FRICTION_SETTINGS = {"coulomb": 14.0, "static": 20.0, "viscous": 1.0}
_SPRINGS = {
    "boom": {"stiffness": 2000.0, "rest": 0.8},
    "jib": {"stiffness": 1000.0, "rest": -1.0, "relative": True},
}
_FRICTION = {"model": "quadratic", "tangential": 0.1, "radial": 0.1}
_INITIAL_SPEED = {"initial.v": 0.5}  # m/s: a trolley that sticks would have less to compute
_DIRECTION = [[0.5, 0.0, -0.8660254037844386]]
_PAYLOAD_CHANGE = [{"at": 1.0, "set": {"payload": {"mass": 5.0}}}]

CASES = (
    Case(KNUCKLE, "axial inertia of the rods", {"boom.axial_inertia": 0.02, "jib.axial_inertia": 0.02}),
    Case(KNUCKLE, "springs of boom and jib", {"springs": _SPRINGS}),
    Case(KNUCKLE, "spring of the rope", {"springs.rope": {"stiffness": 200.0, "rest": 2.0}}),
    Case(KNUCKLE, "swing friction, linear", {"swing_friction": _FRICTION | {"model": "linear"}}),
    Case(KNUCKLE, "swing friction, quadratic", {"swing_friction": _FRICTION}),
    Case(KNUCKLE, "air drag", {"payload_drag": {"coefficient": 0.05}}),
    Case(KNUCKLE, "winch, rate-driven", {"rope": {"drive": "rate", "time_constant": 0.1}}),
    Case(KNUCKLE, "winch, locked", {"rope": {"drive": "locked"}, "reference": None}),
    Case(KNUCKLE, "meter of the energy", {}, {"control": _LAW}),
    Case(KNUCKLE, "inputs, sine", {"inputs": {"slew": {"kind": "sine", "amplitude": 1.0, "frequency": 1.0}}}),
    Case(KNUCKLE, "law in the equations", {"control": _LAW | {"period": "continuous"}}),
    Case(ROD, "friction of the trolley", {"friction": {"trolley": _FRICTION_SETTINGS}}, _INITIAL_SPEED),
    Case(ROD, "limits of the trolley", {"trolley.limits": [-100.0, 100.0]}),
    Case(
        ROD,
        "trolley, prescribed",
        {"trolley": {"drive": "prescribed", "motion": _SMOOTH_MOTION | {"from": 0.0, "to": 2.0}}},
    ),
    Case(
        ROD,
        "hoist, prescribed",
        {"hoist": {"drive": "prescribed", "profile": _SMOOTH_MOTION | {"from": 2.0, "to": 1.0}}},
    ),
    Case(ROD, "hoist, force-driven", {"hoist": {"drive": "force", "inertia": 5.0}}),
    Case(ROD, "hoist, massless", {"hoist": {"drive": "force"}}),
    Case(ROD, "elastic link", {"cable.model": "elastic", "cable.stiffness": 1e6}),
    Case(ROD, "3 dimensions", {"dimensions": 3, "bridge": {"mass": 5.0}, "initial": {"directions": _DIRECTION}}),
    Case(CHAIN, "bending joints", {"joints": {"stiffness": 20.0, "damping": 0.5}}),
    Case(CHAIN, "links that turn as rods", {"cable.inertia": 0.01}),
    Case(CHAIN, "force on a node", {"forces": [{"node": 5, "axis": "x", "force": {"kind": "constant", "value": 1.0}}]}),
    Case(CHAIN, "hoist, force-driven", {"hoist": {"drive": "force", "inertia": 5.0}}),
    Case(CHAIN, "friction of the trolley", {"friction": {"trolley": _FRICTION_SETTINGS}}, _INITIAL_SPEED),
    Case(CHAIN, "slack ends the run", {"cable.slack": "stop"}),
    Case(CHAIN, "payload that changes", {"events": _PAYLOAD_CHANGE}),
    Case(CHAIN, "elastic links", {"cable.model": "elastic", "cable.stiffness": 1e6}),
    Case(CHAIN, "3 dimensions", {"dimensions": 3, "bridge": {"mass": 5.0}, "initial": {"directions": 10 * _DIRECTION}}),
    Case(CHAIN, "straight cable instead", {"cable.model": "straight"}),
    Case(ELASTIC, "damping", {"cable.damping": 100.0}),
    Case(ELASTIC, "pulls only", {"cable.tension_only": True}),
    Case(SPATIAL, "friction of the bridge", {"friction": {"bridge": _FRICTION_SETTINGS}}, {"initial.vy": 0.5}),
)
