"""Status of an integration."""

from enum import IntEnum


class Status(IntEnum):
    """Status of an integration: in order, or the reason of its end."""

    OK = 0  # running or completed
    STEP_TOO_SMALL = 1  # no step, however small, has an error within the tolerance
    NOT_FINITE = 2
    TOO_MANY_SWITCHES = 3  # at one instant
    TOO_MANY_STEPS = 4  # to one instant
    TERMINATED = 5  # by a guard of the model, which has the words for it

    @property
    def cause(self) -> str:
        """Text for the user of a failed integration.

        It is empty where the integration continues or the model describes the event.
        """
        return _CAUSES.get(self, "")


OK, STEP_TOO_SMALL, NOT_FINITE, TOO_MANY_SWITCHES, TOO_MANY_STEPS, TERMINATED = map(int, Status)
"""The same as plain integers, for compiled code."""
_CAUSES = {
    Status.STEP_TOO_SMALL: "the step size shrank to nothing",
    Status.NOT_FINITE: "the state is not finite",
    Status.TOO_MANY_SWITCHES: "chattering: too many mode switches at one instant",
    Status.TOO_MANY_STEPS: "more steps than allowed to reach one instant: too fast or too stiff "
    "for the tolerance",
}
