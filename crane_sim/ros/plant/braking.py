"""The end of a run whose controller has failed for good: the brakes act until the crane rests."""

import time
from functools import partial
from math import ceil

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.scheduler import BLOCK, Scheduler
from crane_sim.ros.plant.simulation_run import SimulationRun

_BRAKING_LIMIT = 30.0  # simulated s after which a crane that still moves is no longer braked
# s of wall time in a row for which the run waits for a crane on the same clock
_PEER_TIMEOUT = 30.0
_POLL = 0.02  # s of wall time between two polls of services and pipes


def brake_to_rest(
    host: NodeHost, simulation: SimulationRun, scheduler: Scheduler, period: float
) -> None:
    """Brake, at a step per `period` [s] of wall time, or at full speed (0); sets the `failure`.

    Cranes on the same clock stay in sync, as with `scheduler`, but only up to a time-out: the run
    is to end.
    """
    plant = simulation.plant
    last = plant.k + ceil(_BRAKING_LIMIT / simulation.scene.period)
    _apply_brakes(simulation, host.brake_reason)
    effort = (0.0,) * len(simulation.scene.actuated) if simulation.scene.sampled else None
    due = next_poll = last_in_sync = time.monotonic()
    while simulation.running and plant.k < last and not plant.at_rest and not host.stop_reason:
        if scheduler.in_sync():
            last_in_sync = time.monotonic()
        elif time.monotonic() - last_in_sync < _PEER_TIMEOUT:
            host.spin(_POLL)
            simulation.heartbeat()
            continue
        simulation.step(effort)
        # at the pace of the wall clock a recorder keeps up, and must not delay the brakes
        if not period:
            simulation.throttle_for_recorder(BLOCK, partial(_is_interrupted, host))
        due = max(due + period, time.monotonic())
        if due >= next_poll:
            next_poll = due + _POLL
            host.spin(0.0)
            simulation.heartbeat()
        time.sleep(max(due - time.monotonic(), 0.0))
    in_time = plant.at_rest or plant.k < last
    simulation.failure = _describe_end(host.brake_reason, simulation.failure, in_time)


def _apply_brakes(simulation: SimulationRun, reason: str) -> None:
    """Apply the brakes of a run that ends for this reason, and let it go on if it is paused."""
    simulation.brake(True, "ending")
    simulation.ending, simulation.waiting = reason, ""
    simulation.resume()
    simulation.warn(f"{reason}: the brakes act until the crane rests", "commands")


def _describe_end(reason: str, failure: str, in_time: bool) -> str:
    """Return one line on why the run ended, and what went wrong while braking."""
    if failure:
        return f"{reason}; while braking: {failure}"
    return reason if in_time else f"{reason}; braked for {_BRAKING_LIMIT:g} s the crane still moves"


def _is_interrupted(host: NodeHost) -> bool:
    """Apply the supervisor's orders; return whether they or a signal end the braking, too."""
    host.poll()
    return bool(host.stop_reason)
