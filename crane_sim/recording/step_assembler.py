"""Assembler of control steps from messages: state, effort and command with the same stamp.

Stamps are integer nanoseconds; step k carries k times the period. Each topic arrives in order, the
topics among themselves do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

Vector = Sequence[float]
# steps that a row is held for its command, which may be sent again seconds later
MAX_ROWS_PENDING = 5000
_MAX_COMMANDS = 8  # different commands of one stamp that are kept


class Row(NamedTuple):
    """One control step; the state is the true one where that is known."""

    step: int
    q: Vector
    v: Vector
    effort: Vector
    demanded: Vector | None  # None without a command of this stamp, or where it is not known which
    # one counted
    reference: Vector | None
    measured: tuple[Vector, Vector] | None = None  # (q, v) as sensors measure them
    braked: bool = False  # the plant reports that its brakes act


class StepAssembler:
    """Collects messages and returns complete rows in order, each step once.

    Attributes:
        lost_steps: number of steps before the newest returned row that never became complete.
        lost_commands: number of returned rows of a commanded crane without a command, while no
            brakes acted.
    """

    def __init__(
        self,
        period_ns: int,
        reference: Vector | None,
        commanded: bool = True,
        after: int = 0,
        sensed: bool = False,
    ) -> None:
        """Begin after the step `after`.

        Args:
            period_ns: control period.
            reference: holds until another one is published.
            commanded: commands are expected.
            after: steps up to this one have been recorded by an earlier recorder.
            sensed: joint states are measured by sensors; true states are expected as well.
        """
        self._period_ns, self._commanded = period_ns, commanded
        self._states: dict[int, tuple[Vector, Vector]] = {}
        self._true_states: dict[int, tuple[Vector, Vector]] = {}
        self._sensed = sensed
        self._efforts: dict[int, Vector] = {}
        self._commands: dict[int, list[Vector]] = {}
        self._braked: set[int] = set()
        # the plant publishes which commands count, as it does in real time
        self._acceptance_known = False
        self._references: list[tuple[int, Vector | None]] = [(0, reference)]
        self._done = after * period_ns  # newest stamp returned
        self._newest_state = self._newest_effort = self._newest_command = (
            self._newest_true_state
        ) = self._done
        self.lost_steps = self.lost_commands = 0

    def follows_reset(self, stamp: int) -> bool:
        """Whether a state of this stamp implies that the plant was reset: states are in order."""
        return stamp < self._newest_state

    def add_state(self, stamp: int, q: Vector, v: Vector) -> None:
        """Take a joint state; one whose row was returned before is a repetition."""
        self._newest_state = stamp
        if stamp > self._done:
            self._states[stamp] = (q, v)

    def add_true_state(self, stamp: int, q: Vector, v: Vector) -> None:
        """Take a true state."""
        self._newest_true_state = stamp
        if stamp > self._done:
            self._true_states[stamp] = (q, v)

    def add_effort(self, stamp: int, effort: Vector) -> None:
        """Take the effort that was applied from `stamp` on."""
        self._newest_effort = stamp
        if stamp > self._done:
            self._efforts[stamp] = effort

    def add_command(self, stamp: int, effort: Vector) -> None:
        """Take a command that answers this stamp's state.

        Where several do, the plant has refused all but one.
        """
        if self._acceptance_known or not self._expects(stamp):
            return
        commands = self._commands.setdefault(stamp, [])
        if len(commands) < _MAX_COMMANDS and effort not in commands:
            commands.append(effort)
        self._newest_command = max(self._newest_command, stamp)

    def add_accepted(self, stamp: int, effort: Vector | None) -> None:
        """Take a command that the plant has accepted. None: the brakes act.

        From the first one on no other counts.
        """
        if not self._acceptance_known:
            self._acceptance_known = True
            # lockstep, where every command before has counted
            braked_since = stamp if effort is None else 0
            self._commands = {
                at: commands for at, commands in self._commands.items() if at < braked_since
            }
            self._newest_command = (
                max(self._done, *self._commands) if self._commands else self._done
            )
        if self._expects(stamp):
            self._commands[stamp] = [] if effort is None else [effort]
            (self._braked.add if effort is None else self._braked.discard)(stamp)
            self._newest_command = max(self._newest_command, stamp)

    def _expects(self, stamp: int) -> bool:
        """Whether a command of this stamp may answer a state whose row is still to come."""
        return (
            self._done
            < stamp
            <= max(self._done, self._newest_state) + MAX_ROWS_PENDING * self._period_ns
        )

    def add_reference(self, stamp: int, reference: Vector) -> None:
        """Take the reference that holds from `stamp` on."""
        if reference != self._references[-1][1]:
            self._references.append((stamp, reference))

    @property
    def waiting(self) -> int:
        """Number of steps that are not returned yet; most of them are complete."""
        return len(self._efforts)

    def has(self, step: int) -> bool:
        """Whether all up to this step has been received: what is missing before it is lost."""
        newest = min(self._newest_state, self._newest_effort)
        newest = min(newest, self._newest_command) if self._acceptance_known else newest
        return (
            min(newest, self._newest_true_state if self._sensed else newest)
            >= step * self._period_ns
        )

    def pop_rows(self, final: bool = False) -> list[Row]:
        """Remove and return complete rows; the final call includes those without a command."""
        oldest = max(self._newest_command, self._newest_effort - MAX_ROWS_PENDING * self._period_ns)
        if self._commanded and not final and oldest <= self._done:
            return []  # at once: this is called with every message
        complete = self._efforts.keys() & self._states.keys()
        stamps = sorted(complete & self._true_states.keys() if self._sensed else complete)
        if stamps and self._commanded and not final:
            limit = max(self._newest_command, stamps[-1] - MAX_ROWS_PENDING * self._period_ns)
            stamps = [stamp for stamp in stamps if stamp <= limit]
        rows = [self._row(stamp) for stamp in stamps]
        if rows:
            self.lost_steps += rows[-1].step - self._done // self._period_ns - len(rows)
            self.lost_commands += sum(
                self._commanded and row.demanded is None and not row.braked for row in rows
            )
            self._forget(stamps[-1])
        return rows

    def _row(self, stamp: int) -> Row:
        received = self._states[stamp]
        q, v = self._true_states[stamp] if self._sensed else received
        reference = next(value for since, value in reversed(self._references) if since <= stamp)
        measured, braked = received if self._sensed else None, stamp in self._braked
        efforts, demanded = self._efforts[stamp], self._demanded_efforts(stamp)
        return Row(stamp // self._period_ns, q, v, efforts, demanded, reference, measured, braked)

    def _demanded_efforts(self, stamp: int) -> Vector | None:
        """Return a stamp's only command, of several the applied one; None if none was applied."""
        commands = self._commands.get(stamp, [])
        fitting = (
            commands
            if len(commands) == 1
            else [effort for effort in commands if effort == self._efforts[stamp]]
        )
        return fitting[0] if fitting else None

    def _forget(self, stamp: int) -> None:
        self._done = stamp
        self._braked = {at for at in self._braked if at > stamp}
        for messages in (self._states, self._true_states, self._efforts, self._commands):
            for old in [key for key in messages if key <= stamp]:
                del messages[old]
