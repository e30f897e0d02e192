"""The trials and entrants of the league as data: scenes of the catalogue, and what a trial changes of them.

The nominal scene of a law has no disturbances, nor masses and lengths other than the catalogue's: it is the
catalogue's scene on a base at rest. Every trial has a moving base and a gust, mostly of zero amplitude, so that
all trials of a crane and a law are one compiled type.
"""

from collections.abc import Sequence
from typing import Any

from crane_bench.league.site_cases import SITE_GROUPS
from crane_bench.league.trials import (
    HIGHER_MASS,
    LONGER_ROPE,
    LOWER_MASS,
    OF_LENGTH,
    OF_MASS,
    SEA,
    SHORTER_ROPE,
    Entrant,
    FromScene,
    Group,
    Trial,
    gust,
    set_point_trials,
    wind,
)
from crane_sim.files.errors import SceneError, did_you_mean

COLUMNS = (
    "set-point", "obstacle", "resonant base", "irregular sea", "mass -20 %", "mass +20 %",
    "rope -5 %", "rope +5 %", "gust", "30 Hz vision",
)  # fmt: skip
"""The trials: columns of the figure."""
NOISE = "control.vision.seed"


def node_gust(force: float) -> dict[str, Any]:
    """Return a gust [N] along x, of overhead cranes."""
    return {"forces": [{"node": 1, "axis": "x", "force": gust(force)}]}


def base_oscillation(axis: str, amplitude: float, frequency: float) -> dict[str, Any]:
    """Return a base that swings along an axis, by this amplitude [m] and frequency [rad/s]."""
    return {"base_motion": {axis: {"amplitude": amplitude, "frequency": frequency}}}


FIXED_BASE = base_oscillation("sway", 0.0, 0.0) | wind(0.0)
FIXED_RAIL_BASE = base_oscillation("surge", 0.0, 0.0) | node_gust(0.0)
SEA_BASE = {"base_motion": FromScene("pendulum_sea", {"sea.components": 20})}
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


def tracking_trials(scene: str) -> tuple[Trial, ...]:
    """Return the trials of a payload of 4 kg that follows the path of a scene."""
    return (
        Trial("irregular sea", scene, {}, FIXED_BASE | SEA_BASE, seeded=SEA),
        Trial("mass -20 %", scene, {}, FIXED_BASE, {"payload.mass": LOWER_MASS}),
        Trial("mass +20 %", scene, {}, FIXED_BASE, {"payload.mass": HIGHER_MASS}),
        Trial("gust", scene, {}, FIXED_BASE | wind(2.0)),
    )


UNDAMPED = {"damping": 0.0, "kp": 676.0, "kd": 36.4, "acceleration": True}
"""The angular law without damping: the suspension point follows the path, without feedback of the payload."""
SHAPED = "reference.path.shaping.kind"
OPEN_LOOP = (
    Entrant("open loop", "angular", settings=UNDAMPED),
    Entrant("open loop, ZV", "angular", settings=UNDAMPED, nominal={SHAPED: "zv"}),
    Entrant("open loop, ZVD", "angular", settings=UNDAMPED, nominal={SHAPED: "zvd"}),
)
FEEDBACK = tuple(Entrant(name, name) for name in ("angular", "cartesian", "adaptive", "harmonic"))
ENERGY, LQR = Entrant("energy", "energy"), Entrant("lqr", "lqr")
TUNED_LQR = Entrant("lqr, tuned", "lqr", tuned="overhead_lqr")
OF_TROLLEY = (ENERGY, LQR, Entrant("energy, tuned", "energy", tuned="overhead_energy"), TUNED_LQR)
OF_HOIST = (ENERGY, LQR, Entrant("energy, tuned", "energy", tuned="overhead_hoist_energy"))
TUNED_HARMONIC = Entrant("harmonic, tuned", "harmonic", tuned="harmonic")
OF_KNUCKLE = (
    ENERGY,
    Entrant("energy, weighing", "energy", home="knuckle_unknown_load"),
    Entrant("lqr", "lqr", home="knuckle_lqr"),
    Entrant("energy, tuned", "energy", tuned="knuckle_energy"),
    Entrant("lqr, tuned", "lqr", home="knuckle_lqr", tuned="knuckle_lqr"),
)
STEP = {
    "duration": 30.0,
    "reference.path": {"kind": "minimum_jerk", "points": [[1.35, 0.0], [1.35, -1.0]], "times": [1.0, 5.0]},
}
"""A metre in less than two periods of the swing: a path, since the pendulum's laws follow one."""
PENDULUM = (
    Trial("set-point", "offshore_obstacle", STEP, FIXED_BASE),
    Trial("obstacle", "offshore_obstacle", {}, FIXED_BASE),
    *tracking_trials("offshore_obstacle"),
    Trial("resonant base", "offshore_resonant", {}, wind(0.0)),
    Trial("rope -5 %", "offshore_obstacle", {}, FIXED_BASE, {"rope.length": SHORTER_ROPE}),
    Trial("rope +5 %", "offshore_obstacle", {}, FIXED_BASE, {"rope.length": LONGER_ROPE}),
    Trial("30 Hz vision", "offshore_vision", {}, wind(0.0), seeded=NOISE),
)
BOOM = (
    *tracking_trials("knuckle_tracking"),
    Trial("resonant base", "knuckle_tracking", {}, wind(0.0)),
)
KNUCKLE = set_point_trials(
    "knuckle_setpoint",
    {},
    FIXED_BASE,
    {
        "resonant base": base_oscillation("sway", 0.02, 2.557),  # a swing on 1.5 m
        "irregular sea": {"base_motion": FromScene("knuckle_sea")},
        "gust": wind(0.5),
    },
    ("payload.mass",),
)
OVERHEAD_DISTURBANCES = {
    "resonant base": base_oscillation("surge", 0.02, 2.215),
    "irregular sea": PITCHING,
    "gust": node_gust(5.0),
}  # on 2 m
TROLLEY = (
    *set_point_trials("overhead_energy", {}, FIXED_RAIL_BASE, OVERHEAD_DISTURBANCES, ("cable.node_masses",)),
    Trial("rope -5 %", "overhead_energy", {}, FIXED_RAIL_BASE, {"cable.lengths": SHORTER_ROPE}),
    Trial("rope +5 %", "overhead_energy", {}, FIXED_RAIL_BASE, {"cable.lengths": LONGER_ROPE}),
)
HOIST = set_point_trials(
    "overhead_hoist_energy", {"control.period": 0.01}, FIXED_RAIL_BASE, OVERHEAD_DISTURBANCES, ("cable.node_masses",)
)
WEIGHT, WEIGHTS = {"payload.mass": OF_MASS}, {"cable.node_masses": OF_MASS}
"""What samples vary of a crane's payload."""
GROUPS = (
    Group("pendulum", "path", (*OPEN_LOOP, *FEEDBACK, TUNED_HARMONIC), PENDULUM, WEIGHT | {"rope.length": OF_LENGTH}),
    Group("knuckle boom, tracking", "path", FEEDBACK, BOOM, WEIGHT),
    Group("knuckle boom", "target", OF_KNUCKLE, tuple(KNUCKLE), WEIGHT),
    Group("overhead, trolley", "target", OF_TROLLEY, TROLLEY, WEIGHTS | {"cable.lengths": OF_LENGTH}),
    Group("overhead, trolley and hoist", "target", OF_HOIST, tuple(HOIST), WEIGHTS),
    *SITE_GROUPS,
)


def groups_named(cranes: Sequence[str]) -> list[Group]:
    """Return the groups of these cranes in order, all groups where none is named.

    Raises:
        SceneError: there is no such crane.
    """
    known = [group.name for group in GROUPS]
    for crane in cranes:
        if crane not in known:
            near = did_you_mean(crane, known)
            raise SceneError(f"unknown crane {crane!r}{near} (known: {'; '.join(known)})")  # names have commas
    return [group for group in GROUPS if not cranes or group.name in cranes]


def names(groups: Sequence[Group] = GROUPS) -> list[tuple[str, str, str]]:
    """Return crane, law and trial of every cell, in order, without running any."""
    return [(g.name, c.name, trial.column) for g in groups for c in g.entrants for trial in g.trials]
