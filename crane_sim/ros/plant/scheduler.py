"""Schedulers of the plant's steps: what all have in common, which is also that of an open loop."""

from typing import Any

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.simulation_run import SimulationRun

BLOCK = 500
"""Unanswered steps between two waits for a recorder: what the smallest usual socket buffer
holds."""
_POLL_STEPS = 100  # open-loop steps between two polls of services and pipes


def should_stop(host: NodeHost) -> bool:
    """Apply the supervisor's orders; return whether they or a signal end the steps.

    It is for a loop that waits.
    """
    host.poll()
    return bool(host.stop_reason or host.brake_reason)


class Scheduler:
    """Decides when the steps of a run are taken, and with which command.

    Here they are taken as fast as subscribers follow, without commands.

    Attributes:
        commands_have_come: whether there were commands, also ones before the run.
    """

    commands_have_come = False

    def __init__(self, host: NodeHost, simulation: SimulationRun) -> None:
        """Schedule the steps of a run."""
        self._host, self._simulation = host, simulation

    @property
    def _goes_on(self) -> bool:
        """Whether there are steps to take, and nothing ends them."""
        host = self._host
        return self._simulation.running and not host.stop_reason and not host.brake_reason

    def _should_stop(self) -> bool:
        return should_stop(self._host)

    def run(self) -> None:
        """Step until the simulation is at its end or the host is to stop."""
        simulation = self._simulation
        simulation.start()
        while self._goes_on:
            if simulation.paused:
                self._host.spin()
            else:
                self.step_once()
                simulation.throttle_for_recorder(BLOCK, self._should_stop)
            if simulation.plant.k % _POLL_STEPS == 0:
                self._host.spin(0.0)
            simulation.heartbeat()

    def commanding_nodes(self) -> set[str]:
        """Return the full names of the nodes that publish commands."""
        return set()

    def missing(self) -> str:
        """Return one line on the controllers still missing, empty when there are enough."""
        return ""

    def in_sync(self) -> bool:
        """Return whether no crane on the same clock is behind."""
        return True

    def step_once(self) -> str:
        """Take one step of a paused run; return why it cannot be taken yet, or an empty string."""
        self._simulation.step(None)
        return ""

    def resume(self) -> None:
        """Resume after a pause."""

    def reset(self) -> None:
        """Drop the pending commands: the run restarts."""

    def metrics(self) -> dict[str, Any]:
        """Return the scheduler's entries of the run's summary."""
        return {}
