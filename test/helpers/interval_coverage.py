"""How often identified intervals hold the true parameters: cases, and runs with other noise."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import crane_sim
from crane_sim.identification import Measurements, from_rollout, read_measurements

NOISE = 1e-3  # m and rad, of the encoders
FRICTION = {"coulomb": 4.0, "static": 6.0, "viscous": 2.0}
ENCODERS = {"noise": [5e-4, 5e-3], "quantisation": [2e-4, 0.0], "delay": 0.01, "dropout": 0.02}


class Case(NamedTuple):
    """A crane, what its scene believes, and what is true."""

    scene: str
    guess: Mapping[str, Any]  # changes of the scene
    truth: Mapping[str, float]  # of the parameters to identify
    duration: float = 15.0  # s
    segment: float = 5.0  # s
    through_sensors: bool = False  # the scene's own sensors measure; else encoders with normal
    # noise


MASSES = {"cable.lengths.0": 2.1, "cable.node_masses.0": 9.0, "trolley.mass": 22.0}
RAILS = {"trolley.mass": 22.0, "friction.trolley.coulomb": 5.0, "friction.trolley.viscous": 3.0}
DRIVE = {"trolley.mass": 22.0, "actuators.trolley.delay": 0.04, "actuators.trolley.lag": 0.08}
SLEW = {"payload.mass": 1.1, "friction.slew.viscous": 3.0}
CASES = {
    "masses and length": Case("overhead_energy", {}, MASSES),
    "friction": Case("overhead_energy", {"friction": {"trolley": FRICTION}}, RAILS),
    "delay and lag": Case(
        "overhead_energy", {"actuators": {"trolley": {"delay": 0.02, "lag": 0.05}}}, DRIVE
    ),
    "knuckle boom": Case("knuckle_setpoint", {"friction": {"slew": FRICTION}}, SLEW, 8.0, 1.25),
    "sensors": Case(
        "overhead_energy", {"sensors": {"all": ENCODERS}}, MASSES, through_sensors=True
    ),
}


def measured(case: Case, seed: int) -> Measurements:
    """Return measurements of the true crane."""
    changes = {**case.guess, **case.truth, "duration": case.duration}
    if not case.through_sensors:
        return from_rollout(crane_sim.simulate(case.scene, overrides=changes), NOISE, seed)
    run = crane_sim.simulate(case.scene, overrides=changes | {"seed": seed})
    with tempfile.TemporaryDirectory() as folder:
        return read_measurements(run.record(Path(folder, "run.rrd")), run.scene)


def errors_of(case: Case, seed: int) -> dict[str, float]:
    """Return each parameter's error over half its interval; at most 1 if the truth is inside."""
    scene = crane_sim.load_scene(case.scene, dict(case.guess))
    found = crane_sim.identify(scene, measured(case, seed), [*case.truth], segment=case.segment)
    return {
        each.key: (each.value - case.truth[each.key]) / (each.high - each.value)
        for each in found.estimates
    }
