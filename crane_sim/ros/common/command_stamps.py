"""Policies of the stamps of commands: which ones the plant accepts in lockstep and real time."""

from typing import NamedTuple

from crane_sim.ros.common.choices import CommandStamps

_LAG = 100_000  # ns


def clock_lag(period: int) -> int:
    """Return by how many ns a leading clock is behind the states; `period`: of control, ns.

    Every state that is sent again takes one of them: the clock never stands while the plant waits.
    """
    return min(_LAG, period // 2)


class StampRange(NamedTuple):
    """The stamps [ns] that a command may have."""

    oldest: int
    newest: int
    repeats: bool = False  # whether several commands may have the same stamp
    epoch: str = "simulated"  # the clock; stamps of two clocks are not compared


def lockstep_range(
    policy: str, state: int, period: int, ahead: tuple[int, int] = (0, 0)
) -> StampRange | None:
    """Return the stamps of answers to a state in lockstep, None where any will do.

    With ROS time the clock leads: it reads the time of the next state as soon as this one has been
    acknowledged.

    Args:
        policy: one of CommandStamps.
        state: its stamp, ns.
        period: from a state to the next one, ns.
        ahead: by how much more than that the clock was ahead when the state was new, and is now,
            ns.
    """
    if policy == CommandStamps.ANY:
        return None
    return (
        StampRange(state + 1 + ahead[0], state + period + ahead[1])
        if policy == CommandStamps.ROS
        else StampRange(state, state)
    )


def realtime_range(
    policy: str, stamp: int, state: int, wall: int, timeouts: tuple[int, int]
) -> StampRange | None:
    """Return the stamps of commands in real time, None where any will do.

    With ROS time a stamp is one of the clock that it is nearer to: /clock, or the wall clock, of
    which it may be as much ahead as it may be behind, since clocks of two machines differ.

    Args:
        policy: one of CommandStamps.
        stamp: of the command, ns.
        state: stamp of the newest state, ns.
        wall: time of the wall clock, ns.
        timeouts: of commands, ns of simulated and of wall time; 0: none.
    """
    if policy == CommandStamps.ANY:
        return None
    simulated, real = timeouts
    if policy == CommandStamps.ROS and abs(stamp - wall) < abs(stamp - state):
        return StampRange(wall - real, wall + real, True, "wall") if real else None
    return StampRange(state - simulated if simulated else 0, state, policy == CommandStamps.ROS)
