"""What services of simulation_interfaces 2.1 do to the plant, and result codes; no messages."""

from enum import IntEnum
from typing import Any, NamedTuple

from crane_sim.ros.common.messages import SimulationState
from crane_sim.ros.plant.run_control import RunControl


class Code(IntEnum):
    """Result codes: of Result.msg, and above 100 of SetSimulationState.srv."""

    FEATURE_UNSUPPORTED = 0
    OK = 1
    NOT_FOUND = 2
    INCORRECT_STATE = 3
    OPERATION_FAILED = 4
    ALREADY_IN_TARGET_STATE = 101
    STATE_TRANSITION_ERROR = 102


class Feature(IntEnum):
    """What the plant can do, numbered as in SimulatorFeatures.msg.

    Time and state are reset together only.
    """

    ENTITY_CATEGORIES = 8
    ENTITY_STATE_GETTING = 10
    ENTITY_INFO_GETTING = 12
    SIMULATION_RESET = 20
    SIMULATION_STATE_GETTING = 24
    SIMULATION_STATE_SETTING = 25
    SIMULATION_STATE_PAUSE = 26
    STEP_SIMULATION_SINGLE = 31
    STEP_SIMULATION_MULTIPLE = 32
    STEP_SIMULATION_ACTION = 33


class Outcome(NamedTuple):
    """The end of a call."""

    code: Code
    message: str = ""


_NEVER = -1  # a number of steps
_RESET = 3  # the bits SCOPE_TIME and SCOPE_STATE of ResetSimulation.srv


class StandardOperations:
    """The operations behind the standard services.

    Stopped is paused at the start, before any step: the run then begins with the next one, or when
    it is played.
    """

    def __init__(self, control: RunControl) -> None:
        """Control a run."""
        self._control = control
        # steps taken in all when it was stopped; a run that begins paused is stopped
        self._stopped_at = 0

    def state(self) -> SimulationState:
        """Return the state of the simulation; a run that waits for a command is playing."""
        control = self._control
        if not control.begun:
            return SimulationState.STOPPED
        if control.why_not_running() and not control.paused:
            return SimulationState.QUITTING
        if not control.paused:
            return SimulationState.PLAYING
        return (
            SimulationState.STOPPED
            if control.steps_in_all == self._stopped_at
            else SimulationState.PAUSED
        )

    def set_state(self, target: int) -> Outcome:
        """Stop, play, pause or end the simulation."""
        if target == SimulationState.QUITTING:
            self._control.quit()
            return Outcome(Code.OK)
        if target not in (SimulationState.STOPPED, SimulationState.PLAYING, SimulationState.PAUSED):
            return Outcome(
                Code.FEATURE_UNSUPPORTED,
                f"state {target}: possible: 0 stopped, 1 playing, 2 paused, 3 quitting",
            )
        if why_not := self._control.why_not_running():
            return Outcome(Code.INCORRECT_STATE, why_not)
        if target == self.state():
            return Outcome(
                Code.ALREADY_IN_TARGET_STATE,
                f"the simulation is {SimulationState(target).name.lower()}",
            )
        failure = self._control.set_paused(target != SimulationState.PLAYING)
        if target == SimulationState.STOPPED:
            failure = failure or self._control.reset()
        stopped = target == SimulationState.STOPPED and not failure
        self._stopped_at = self._control.steps_in_all if stopped else _NEVER
        return (
            Outcome(Code.STATE_TRANSITION_ERROR, failure)
            if failure
            else Outcome(Code.OK, self._control.why_waiting())
        )

    def step(self, number: int) -> Outcome:
        """Take steps of a paused simulation."""
        return _outcome(self._control.take_steps(number))

    def reset(self, scope: int) -> Outcome:
        """Return to the start; 0 is every scope, and nothing is ever spawned."""
        if scope and scope & _RESET != _RESET:
            return Outcome(
                Code.FEATURE_UNSUPPORTED,
                f"scope {scope}: time and state are reset together: 0, 3 or 255",
            )
        return _outcome(self._control.reset())


def _outcome(failure: str) -> Outcome:
    return Outcome(Code.OPERATION_FAILED, failure) if failure else Outcome(Code.OK)


def write_outcome(response: Any, outcome: Outcome) -> Any:
    """Return the response of a service, or an action's result, with the outcome of the call."""
    response.result.result, response.result.error_message = int(outcome.code), outcome.message
    return response
