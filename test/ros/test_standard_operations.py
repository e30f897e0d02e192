"""The operations behind the services of simulation_interfaces, without that package and DDS."""

from types import SimpleNamespace
from typing import Any

import pytest
from lockstep_doubles import CountingPlant, FakeHost, FakeTopics, make_simulation

from crane_sim.ros.common.messages import SimulationState
from crane_sim.ros.common.node_host import QUIT
from crane_sim.ros.plant.run_control import RunControl
from crane_sim.ros.plant.scheduler import Scheduler
from crane_sim.ros.plant.standard_operations import Code, StandardOperations

STOPPED, PLAYING, PAUSED, QUITTING = SimulationState


class ResettablePlant(CountingPlant):
    """A plant in which nothing moves, with a reset that may be refused."""

    error = ""

    def reset(self, *_: Any) -> None:
        """Return to step 0."""
        if self.error:
            raise ValueError(self.error)
        self.k = 0


class OperatedRun:
    """A run without commands, and the standard operations on it."""

    def __init__(self, started: bool = True) -> None:
        """Make the run; `started`: it has begun."""
        self.host: Any = FakeHost()
        self.host.active = True
        self.host.stop = lambda reason: setattr(self.host, "stop_reason", reason)
        self.simulation = make_simulation(FakeTopics())
        self.plant: Any = ResettablePlant()
        self.simulation.plant = self.plant
        if started:
            self.simulation.start()
        settings = SimpleNamespace(reset_positions=(), reset_velocities=())
        scheduler = Scheduler(self.host, self.simulation)
        self.operations = StandardOperations(
            RunControl(self.host, self.simulation, scheduler, settings)
        )

    def set_state(self, state: int) -> Code:
        """Set the state of the simulation; return the result code."""
        return self.operations.set_state(state).code


def test_every_state_is_reached_and_reported() -> None:
    """Playing, paused and stopped follow each other in any order.

    Requesting the current state returns its own code.
    """
    run = OperatedRun()
    assert run.operations.state() == PLAYING
    for target in (PAUSED, STOPPED, PLAYING, STOPPED, PAUSED, PLAYING):
        assert run.set_state(target) == Code.OK and run.operations.state() == target
        assert run.set_state(target) == Code.ALREADY_IN_TARGET_STATE


def test_a_step_ends_the_state_stopped() -> None:
    """Stopping returns to step 0; after a step the state is paused until it is stopped again.

    A reset does not change that.
    """
    run = OperatedRun()
    assert (
        run.set_state(PAUSED) == Code.OK
        and run.operations.step(3).code == Code.OK
        and run.plant.k == 3
    )
    assert (
        run.set_state(STOPPED) == Code.OK
        and run.operations.reset(0).code == Code.OK
        and run.plant.k == 0
    )
    assert run.operations.state() == STOPPED
    assert (
        run.operations.step(1).code == Code.OK
        and run.operations.reset(0).code == Code.OK
        and run.plant.k == 0
    )
    assert run.operations.state() == PAUSED
    assert run.set_state(STOPPED) == Code.OK and run.operations.state() == STOPPED


def test_a_run_that_begins_paused_is_stopped() -> None:
    """A run that is paused before it begins is stopped; after steps and resets it is paused."""
    run = OperatedRun(started=False)
    run.simulation.pause(True, RunControl.USER)
    run.simulation.start()
    assert run.operations.state() == STOPPED
    assert run.operations.step(2).code == Code.OK and run.operations.reset(255).code == Code.OK
    assert run.operations.state() == PAUSED


def test_a_run_that_has_not_begun_is_stopped_and_cannot_be_played() -> None:
    """Before the run begins the state is stopped; changing it returns the code incorrect state."""
    run = OperatedRun(started=False)
    assert run.operations.state() == STOPPED
    assert run.set_state(PLAYING) == Code.INCORRECT_STATE
    assert run.operations.step(1).code == Code.OPERATION_FAILED


def test_unsupported_states_return_their_code() -> None:
    """A state that the plant does not have is an unsupported feature.

    The message lists the possible states.
    """
    run = OperatedRun()
    outcome = run.operations.set_state(4)
    assert outcome.code == Code.FEATURE_UNSUPPORTED and "2 paused" in outcome.message
    assert run.operations.state() == PLAYING


def test_steps_that_fail_say_why() -> None:
    """While the simulation plays a step moves nothing; an early end returns the steps taken."""
    run = OperatedRun()
    assert (
        run.operations.step(1) == (Code.OPERATION_FAILED, "the simulation is not paused")
        and run.plant.k == 0
    )
    steps = run.simulation.scene.steps
    run.set_state(PAUSED)
    run.plant.k = steps - 2
    assert run.operations.step(5) == (Code.OPERATION_FAILED, "2 of 5 steps: the run is over")
    assert run.plant.k == steps


@pytest.mark.parametrize(
    ("scope", "code"),
    [
        (0, Code.OK),
        (7, Code.OK),
        (255, Code.OK),
        (1, Code.FEATURE_UNSUPPORTED),
        (6, Code.FEATURE_UNSUPPORTED),
    ],
)
def test_scopes_of_a_reset(scope: int, code: Code) -> None:
    """Scopes with both time and state reset the run; others are unsupported.

    These are either alone, or only spawned entities.
    """
    run = OperatedRun()
    run.set_state(PAUSED)
    run.operations.step(3)
    assert run.operations.reset(scope).code == code
    assert run.plant.k == (0 if code == Code.OK else 3) and run.operations.state() == PAUSED


def test_a_reset_that_is_refused_fails() -> None:
    """With an invalid initial state a reset fails, and stopping returns a failed transition."""
    run = OperatedRun()
    run.plant.error = "reset_positions: has 2 values"
    assert run.operations.reset(0) == (Code.OPERATION_FAILED, run.plant.error)
    assert run.operations.set_state(STOPPED) == (Code.STATE_TRANSITION_ERROR, run.plant.error)


def test_quitting_ends_the_node_without_a_fault() -> None:
    """The state quitting ends the run without an error, as an operator's key does."""
    run = OperatedRun()
    assert run.set_state(QUITTING) == Code.OK and run.host.stop_reason == QUIT
