"""Schedulers of the plant's steps: the protocol of `Lockstep` and `Realtime`, and the scheduler of an open loop."""

from functools import partial
from typing import Any, Protocol

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.simulation_run import SimulationRun

BLOCK = 500
"""Unanswered steps between two waits for a recorder: what the smallest usual socket buffer holds."""
_POLL_STEPS = 100  # open-loop steps between two polls of services and pipes


def should_stop(host: NodeHost) -> bool:
    """Apply the supervisor's orders; return whether they or a signal end the steps, for a loop that waits."""
    host.poll()
    return bool(host.stop_reason or host.brake_reason)


class StepScheduler(Protocol):
    """Decides when the steps of a run are taken, and with which command.

    Attributes:
        commands_have_come: whether there were commands, also ones before the run.
    """

    commands_have_come: bool

    def commanding_nodes(self) -> set[str]:
        """Return the full names of the nodes that publish commands."""
        ...

    def missing(self) -> str:
        """Return one line on the controllers still missing, empty when there are enough."""
        ...

    def run(self) -> None:
        """Step until the simulation is at its end or the host is to stop."""
        ...

    def in_sync(self) -> bool:
        """Return whether no crane on the same clock is behind."""
        ...

    def step_once(self) -> str:
        """Take one step of a paused run; return why it cannot be taken yet, an empty string where it was taken."""
        ...

    def resume(self) -> None:
        """Resume after a pause."""
        ...

    def reset(self) -> None:
        """Drop the pending commands: the run restarts."""
        ...

    def metrics(self) -> dict[str, Any]:
        """Return the scheduler's entries of the run's summary."""
        ...


class OpenLoop:
    """Scheduler that steps as fast as the subscribers can follow, without commands."""

    commands_have_come = False

    def __init__(self, host: NodeHost, simulation: SimulationRun) -> None:
        """Schedule the steps of a run."""
        self._host, self._simulation = host, simulation

    def commanding_nodes(self) -> set[str]:
        """See `StepScheduler`."""
        return set()

    def missing(self) -> str:
        """See `StepScheduler`; there are no controllers."""
        return ""

    def run(self) -> None:
        """See `StepScheduler`."""
        simulation = self._simulation
        simulation.start()
        while simulation.running and not self._host.stop_reason and not self._host.brake_reason:
            if simulation.paused:
                self._host.spin()
            else:
                self.step_once()
                simulation.throttle_for_recorder(BLOCK, partial(should_stop, self._host))
            if simulation.plant.k % _POLL_STEPS == 0:
                self._host.spin(0.0)
            simulation.heartbeat()

    def in_sync(self) -> bool:
        """See `StepScheduler`; its clock is its own."""
        return True

    def step_once(self) -> str:
        """See `StepScheduler`."""
        self._simulation.step(None)
        return ""

    def resume(self) -> None:
        """See `StepScheduler`; there is nothing to resume."""

    def reset(self) -> None:
        """See `StepScheduler`; there are no commands."""

    def metrics(self) -> dict[str, Any]:
        """See `StepScheduler`; there are no deadlines."""
        return {}
