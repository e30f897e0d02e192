"""When the plant takes its steps: what `Lockstep` and `Realtime` have in common, and the pace of an open loop."""

from functools import partial
from typing import Any, Protocol

from crane_sim.ros.common.node_host import NodeHost
from crane_sim.ros.plant.simulation_run import SimulationRun

BLOCK = 500
"""Steps that nobody answers between two waits for a recorder: what the smallest usual socket buffer holds."""
_LOOK = 100  # open-loop steps between two looks at services and pipes


def should_stop(host: NodeHost) -> bool:
    """Take the orchestrator's orders; return whether they or a signal end the pace: for whoever waits for something."""
    host.poll()
    return bool(host.stopping or host.brake)


class StepScheduler(Protocol):
    """Takes the steps of a run."""

    def missing(self) -> str:
        """Return one line on the controllers still missing, empty when there are enough."""
        ...

    def run(self) -> None:
        """Step until the stepper is at its end or the host is to stop."""
        ...

    def level(self) -> bool:
        """Return whether no crane on the same clock is behind."""
        ...

    def step_once(self) -> str:
        """Take one step of a paused run; returns why it cannot be taken yet, empty where it is done."""
        ...

    def go_on(self) -> None:
        """Pick up the thread after a pause."""
        ...

    def forget(self) -> None:
        """Drop the commands at hand: the run begins anew."""
        ...

    def figures(self) -> dict[str, Any]:
        """Return what the pace adds to the run's summary."""
        ...


class OpenLoop:
    """Steps as fast as the subscribers can follow; nobody commands."""

    def __init__(self, host: NodeHost, stepper: SimulationRun) -> None:
        """Step without commands."""
        self._host, self._stepper = host, stepper

    def missing(self) -> str:
        """See `StepScheduler`; nobody is needed."""
        return ""

    def run(self) -> None:
        """See `StepScheduler`."""
        stepper = self._stepper
        stepper.begin()
        while stepper.running and not self._host.stopping and not self._host.brake:
            if stepper.paused:
                self._host.spin()
            else:
                self.step_once()
                stepper.throttle_for_recorder(BLOCK, partial(should_stop, self._host))
            if stepper.plant.k % _LOOK == 0:
                self._host.spin(0.0)
            stepper.heartbeat()

    def level(self) -> bool:
        """See `StepScheduler`; it shares its clock with nobody."""
        return True

    def step_once(self) -> str:
        """See `StepScheduler`."""
        self._stepper.step(None)
        return ""

    def go_on(self) -> None:
        """See `StepScheduler`; there is no thread to pick up."""

    def forget(self) -> None:
        """See `StepScheduler`; there are no commands."""

    def figures(self) -> dict[str, Any]:
        """See `StepScheduler`; nothing is due at any time."""
        return {}
