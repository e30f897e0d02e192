"""The trials of the league and who takes part: catalogue scenes, and what of them is changed, as data.

Laws are told nothing of disturbances, nor of masses and lengths that are not what the catalogue says: they believe the
catalogue's scene on a base at rest. Every trial has a base that can move and a gust that can blow, mostly by nothing,
so that all trials of a crane and a law are one compiled type.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

SEEDS = tuple(range(100, 110))
"""Seeds of seas and of a camera's noise that nothing in the catalogue uses: no law is tuned to them."""
COLUMNS = (
    "set-point", "obstacle", "resonant base", "irregular sea", "mass -20 %", "mass +20 %",
    "rope -5 %", "rope +5 %", "gust", "30 Hz vision",
)  # fmt: skip
"""What is asked of the laws."""
SEA, NOISE = "base_motion.sea.seed", "control.vision.seed"
LIGHT, HEAVY, SHORT, LONG = 0.8, 1.2, 0.95, 1.05


class FromScene(NamedTuple):
    """A group that a scene takes from another one of the catalogue."""

    scene: str
    changes: dict[str, Any] = {}  # by dotted key, within the group


class Task(NamedTuple):
    """What is asked of all laws of a crane in one column."""

    column: str
    scene: str  # of the catalogue
    told: dict[str, Any] = {}  # changes of the scene by dotted key that the laws know of
    untold: dict[str, Any] = {}  # changes that they do not know of
    scaled: dict[str, float] = {}  # numbers of the scene, by what part of what the laws believe
    seeded: str = ""  # the dotted key that takes SEEDS


class Entrant(NamedTuple):
    """A law, or a way to do without one."""

    name: str
    law: str
    home: str = ""  # scene whose settings it takes; "": the trial's own, where that has the law
    settings: dict[str, Any] = {}  # on top
    believes: dict[str, Any] = {}  # besides the catalogue's scene, by dotted key


class Group(NamedTuple):
    """The contenders on a crane, their trials, and where the payload should be: on the path, or at the target."""

    name: str
    goal: Literal["path", "target"]
    contenders: tuple[Entrant, ...]
    trials: tuple[Task, ...]


def gust(force: float) -> dict[str, Any]:
    """Return a wind that rises to this force [N] within a second, holds for three, and falls again."""
    return {"kind": "table", "times": [12.0, 13.0, 16.0, 17.0], "values": [0.0, force, force, 0.0]}


def wind(force: float) -> dict[str, Any]:
    """Return a gust [N] along x, of cranes whose payload takes a force."""
    return {"payload_force": {"x": gust(force)}}


def make_gust(force: float) -> dict[str, Any]:
    """Return a gust [N] along x, of overhead cranes."""
    return {"forces": [{"node": 1, "axis": "x", "force": gust(force)}]}


def base_oscillation(axis: str, amplitude: float, frequency: float) -> dict[str, Any]:
    """Return a base that swings along an axis, by this amplitude [m] and frequency [rad/s]."""
    return {"base_motion": {axis: {"amplitude": amplitude, "frequency": frequency}}}


STILL = base_oscillation("sway", 0.0, 0.0) | wind(0.0)
FIRM = base_oscillation("surge", 0.0, 0.0) | make_gust(0.0)
AFLOAT = {"base_motion": FromScene("pendulum_sea", {"sea.components": 20})}
PITCHING = {
    "base_motion": {
        "sea": {
            "significant_height": 0.4,
            "peak_period": 4.0,
            "components": 20,
            "response": {
                "heave": {"frequencies": [0.8, 1.5, 2.2, 3.0], "amplitudes": [1.0, 0.6, 0.2, 0.02]},
                "surge": {"frequencies": [0.8, 1.5, 2.5], "amplitudes": [0.6, 0.3, 0.05]},
                "pitch": {"frequencies": [0.8, 1.2, 1.8, 3.0], "amplitudes": [0.02, 0.06, 0.02, 0.002]},
            },
        }
    }
}
"""The sea of the scene `pendulum_sea` from ahead, for cranes in the plane."""


def make_tracking_task(scene: str) -> tuple[Task, ...]:
    """Return what is asked of a payload of 4 kg that follows the path of a scene."""
    return (
        Task("irregular sea", scene, {}, STILL | AFLOAT, seeded=SEA),
        Task("mass -20 %", scene, {}, STILL, {"payload.mass": LIGHT}),
        Task("mass +20 %", scene, {}, STILL, {"payload.mass": HEAVY}),
        Task("gust", scene, {}, STILL | wind(2.0)),
    )


def setpoint_tasks(
    scene: str, told: dict[str, Any], still: dict[str, Any], others: dict[str, Any], mass: str
) -> list[Task]:
    """Return what is asked of a crane that is brought to a target; others: what happens in further columns."""
    return [
        Task("set-point", scene, told, still),
        Task("mass -20 %", scene, told, still, {mass: LIGHT}),
        Task("mass +20 %", scene, told, still, {mass: HEAVY}),
        *(Task(name, scene, told, still | do, seeded=SEA if "sea" in name else "") for name, do in others.items()),
    ]


FOLLOWING = {"damping": 0.0, "kp": 676.0, "kd": 36.4, "acceleration": True}
"""The angular law without damping: the suspension point follows the path, and nobody looks at the payload."""
SHAPED = "reference.path.shaping.kind"
BLIND = (
    Entrant("open loop", "angular", settings=FOLLOWING),
    Entrant("open loop, ZV", "angular", settings=FOLLOWING, believes={SHAPED: "zv"}),
    Entrant("open loop, ZVD", "angular", settings=FOLLOWING, believes={SHAPED: "zvd"}),
)
LOOKING = tuple(Entrant(name, name) for name in ("angular", "cartesian", "adaptive", "harmonic"))
ENERGY, LQR = Entrant("energy", "energy"), Entrant("lqr", "lqr")
OF_KNUCKLE = (
    ENERGY,
    Entrant("energy, weighing", "energy", home="knuckle_unknown_load"),
    Entrant("lqr", "lqr", home="knuckle_lqr"),
)
STEP = {
    "duration": 30.0,
    "reference.path": {"kind": "minimum_jerk", "points": [[1.35, 0.0], [1.35, -1.0]], "times": [1.0, 5.0]},
}
"""A metre in less than two periods of the swing: a path, since the pendulum's laws follow one."""
PENDULUM = (
    Task("set-point", "offshore_obstacle", STEP, STILL),
    Task("obstacle", "offshore_obstacle", {}, STILL),
    *make_tracking_task("offshore_obstacle"),
    Task("resonant base", "offshore_resonant", {}, wind(0.0)),
    Task("rope -5 %", "offshore_obstacle", {}, STILL, {"rope.length": SHORT}),
    Task("rope +5 %", "offshore_obstacle", {}, STILL, {"rope.length": LONG}),
    Task("30 Hz vision", "offshore_vision", {}, wind(0.0), seeded=NOISE),
)
BOOM = (
    *make_tracking_task("knuckle_tracking"),
    Task("resonant base", "knuckle_tracking", {}, wind(0.0)),
)
KNUCKLE = setpoint_tasks(
    "knuckle_setpoint",
    {},
    STILL,
    {
        "resonant base": base_oscillation("sway", 0.02, 2.557),  # a swing on 1.5 m
        "irregular sea": {"base_motion": FromScene("knuckle_sea")},
        "gust": wind(0.5),
    },
    "payload.mass",
)
ROLLED = {
    "resonant base": base_oscillation("surge", 0.02, 2.215),
    "irregular sea": PITCHING,
    "gust": make_gust(5.0),
}  # on 2 m
TROLLEY = (
    *setpoint_tasks("overhead_energy", {}, FIRM, ROLLED, "cable.node_masses"),
    Task("rope -5 %", "overhead_energy", {}, FIRM, {"cable.lengths": SHORT}),
    Task("rope +5 %", "overhead_energy", {}, FIRM, {"cable.lengths": LONG}),
)
HOIST = setpoint_tasks("overhead_hoist_energy", {"control.period": 0.01}, FIRM, ROLLED, "cable.node_masses")
GROUPS = (
    Group("pendulum", "path", (*BLIND, *LOOKING), PENDULUM),
    Group("knuckle boom, tracking", "path", LOOKING, BOOM),
    Group("knuckle boom", "target", OF_KNUCKLE, tuple(KNUCKLE)),
    Group("overhead, trolley", "target", (ENERGY, LQR), TROLLEY),
    Group("overhead, trolley and hoist", "target", (ENERGY, LQR), tuple(HOIST)),
)


def names(groups: Sequence[Group] = GROUPS) -> list[tuple[str, str, str]]:
    """Return crane, law and trial of every cell, in order, without running any."""
    return [(g.name, c.name, trial.column) for g in groups for c in g.contenders for trial in g.trials]
