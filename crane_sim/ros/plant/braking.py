"""The end of a run that nobody commands any more: the brakes act until the crane rests."""

import time
from functools import partial
from math import ceil

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.scheduler import BLOCK, StepScheduler
from crane_sim.ros.plant.simulation_run import SimulationRun

_LIMIT = 30.0  # simulated s after which a crane that still moves is left to itself
_ALONE = 30.0  # s of wall time in a row after which a crane on the same clock that is behind is waited for no more
_LOOK = 0.02  # s of wall time between two looks at services and pipes


def brake_to_rest(host: NodeHost, stepper: SimulationRun, pace: StepScheduler, period: float) -> None:
    """Brake, at one step per `period` [s] of wall time or as fast as it goes (0); leaves the run with a fault.

    Cranes on the same clock are waited for, as `pace` does, but not for ever: the run is to end.
    """
    plant = stepper.plant
    last = plant.k + ceil(_LIMIT / stepper.scene.period)
    plant.braking, stepper.ending, stepper.waiting = True, host.brake, ""
    stepper.go_on()
    stepper.warn(f"{host.brake}: the brakes act until the crane rests", "commands")
    nobody = (0.0,) * len(stepper.scene.actuated) if stepper.scene.sampled else None
    due = look = level = time.monotonic()
    while stepper.running and plant.k < last and not plant.at_rest and not host.stopping:
        if pace.level():
            level = time.monotonic()
        elif time.monotonic() - level < _ALONE:
            host.spin(_LOOK)
            stepper.heartbeat()
            continue
        stepper.step(nobody)
        if not period:  # at the pace of the wall clock subscribers have time enough, and nobody may delay the brakes
            stepper.throttle_for_recorder(BLOCK, partial(_is_interrupted, host))
        due = max(due + period, time.monotonic())
        if due >= look:
            look = due + _LOOK
            host.spin(0.0)
            stepper.heartbeat()
        time.sleep(max(due - time.monotonic(), 0.0))
    restless = "" if plant.at_rest or plant.k < last else f"; braked for {_LIMIT:g} s the crane still moves"
    stepper.fault = f"{host.brake}; while braking: {stepper.fault}" if stepper.fault else host.brake + restless


def _is_interrupted(host: NodeHost) -> bool:
    """Take the orchestrator's orders; return whether they or a signal end the braking, too."""
    host.poll()
    return bool(host.stopping)
