"""Drives with play: each turns an inertia of its own, which meets its joint behind a gap.

A drive with the reflected inertia m and the position z moves a joint at q. Between them are the
play Δ, of which half lies on either side, and a shaft with the stiffness k and the damping c, which
pushes and never pulls. On the side σ = 1, where the drive pushes the joint forwards, or σ = -1 the
shaft is compressed by

    p = σ (z - q) - Δ/2,    and pushes with P = k p + c p' while p and P are positive, else with nothing:

    m z'' = u - σ P,    and the joint has the effort σ P,

u the drive's share of the joint's effort. A joint has any number of drives. A shaft that its drive
leaves faster than it can relax does not push, and its damper takes what the spring gives (Nordin
and Gutman, Automatica 38 (2002) 1633, have it relax with the time c/k). A mode is σ while the shaft
pushes, 2σ while it only relaxes, 0 in the gap; the state says which, and each ends as an event. A
base's motion does not accelerate a drive's reflected inertia.
"""  # noqa: E501

from typing import Any, NamedTuple

from crane_sim.models.guards import BACKWARDS, FORWARDS
from crane_sim.numerics.states import replace_entry

IN_PLAY, RELAXES = 0, 3  # outcomes of an event, beside FORWARDS and BACKWARDS


class Drive(NamedTuple):
    """A drive with play, in units of its joint."""

    inertia: float  # kg or kg m², reflected to the joint
    share: float  # of the joint's effort
    play: float  # m or rad, Δ
    stiffness: float  # N/m or N m/rad
    damping: float  # N s/m or N m s/rad


class DriveState(NamedTuple):
    """State of a drive."""

    position: Any  # m or rad, reflected to the joint
    rate: Any  # m/s or rad/s
    mode: Any  # 1 pushes forwards, -1 backwards, 2 and -2 relax on these sides, 0 in the play


class Shaft(NamedTuple):
    """The contact between a drive and its joint, in the gap on the nearer side, at one instant."""

    side: Any  # 1: the drive pushes forwards, -1: backwards
    compression: Any  # m or rad, p: negative in the gap
    rate: Any  # m/s or rad/s, p'
    push: Any  # N or N m, k p + c p', which acts where it and p are positive


def drives_of(drives: tuple[tuple[Drive, ...], ...] | None) -> tuple[tuple[int, Drive], ...]:
    """Return (coordinate, drive) of all drives, in the order of their states."""
    if drives is None:
        return ()
    return tuple((i, drive) for i, own in enumerate(drives) for drive in own)


def shaft_of(drive: Drive, state: DriveState, q: Any, v: Any) -> Shaft:
    """Return the Shaft of a drive whose joint is at q and moves at v."""
    ahead = state.position - q
    side = 1.0 if state.mode > 0.0 or (state.mode == 0.0 and ahead >= 0.0) else -1.0
    p, rate = side * ahead - 0.5 * drive.play, side * (state.rate - v)
    return Shaft(side, p, rate, drive.stiffness * p + drive.damping * rate)


def push_of(drive: Drive, state: DriveState, q: Any, v: Any) -> Any:
    """Return the effort of a drive on its joint, with the sign of the joint, in its mode."""
    return state.mode * shaft_of(drive, state, q, v).push if abs(state.mode) == 1.0 else 0.0


def pushes(drives: Any, state: Any) -> tuple[Any, ...]:
    """Return the efforts of all drives on their joints; state: SupportState."""
    pairs = zip(drives_of(drives), state.drives, strict=True)
    return tuple(push_of(drive, own, state.q[i], state.v[i]) for (i, drive), own in pairs)


def replace_by_pushes(drives: Any, efforts: tuple[Any, ...], state: Any) -> tuple[Any, ...]:
    """Return the efforts (n,), on joints with play replaced by what their drives push."""
    if drives is None:
        return efforts
    efforts = tuple(0 if own else effort for own, effort in zip(drives, efforts, strict=True))
    for (i, _), push in zip(drives_of(drives), pushes(drives, state), strict=True):
        efforts = replace_entry(efforts, i, efforts[i] + push)
    return efforts


def drive_accelerations(drives: Any, command: tuple[Any, ...], posture: Any) -> tuple[Any, ...]:
    """Return the accelerations of all drives under commanded efforts; posture: of the support."""
    efforts = posture.mechanism.by_coordinate(command)
    pairs = zip(drives_of(drives), pushes(drives, posture.state), strict=True)
    return tuple((drive.share * efforts[i] - push) / drive.inertia for (i, drive), push in pairs)


def play_power(drives: Any, command: tuple[Any, ...], posture: Any) -> Any:
    """Return the power [W] of drives with play: efforts and losses, less the pushes on joints."""
    power, efforts, state = 0.0, posture.mechanism.by_coordinate(command), posture.state
    for (i, drive), own, push in zip(
        drives_of(drives), state.drives, pushes(drives, state), strict=True
    ):
        shaft = shaft_of(drive, own, state.q[i], state.v[i])
        power += drive.share * efforts[i] * own.rate - push * state.v[i]
        power += (drive.stiffness * max(shaft.compression, 0.0) - push * shaft.side) * shaft.rate
    return power


def drive_energies(drives: Any, state: Any) -> tuple[Any, Any]:
    """Return (kinetic, potential) energy [J] of drives and their shafts."""
    kinetic, potential = 0.0, 0.0
    for (i, drive), own in zip(drives_of(drives), state.drives, strict=True):
        p = max(shaft_of(drive, own, state.q[i], state.v[i]).compression, 0.0)
        kinetic += 0.5 * drive.inertia * own.rate * own.rate
        potential += 0.5 * drive.stiffness * p * p
    return kinetic, potential


def mode_of(shaft: Shaft) -> Any:
    """Return the mode that a shaft's state asks for."""
    if shaft.compression <= 0.0:
        return 0.0
    return shaft.side if shaft.push > 0.0 else 2.0 * shaft.side


def drive_guard(drive: Drive, state: DriveState, q: Any, v: Any) -> Any:
    """Return the guard of a drive: negative where its mode ends."""
    shaft = shaft_of(drive, state, q, v)
    if state.mode == 0.0:
        return -shaft.compression
    return shaft.push if abs(state.mode) == 1.0 else min(shaft.compression, -shaft.push)


def outcome_of(mode: Any) -> Any:
    """Return the outcome of an event after which a drive is in a mode."""
    if abs(mode) == 2.0:
        return RELAXES
    if mode == 0.0:
        return IN_PLAY
    return FORWARDS if mode > 0.0 else BACKWARDS


def describe_drive(support: Any, number: int, outcome: int) -> str:
    """Return the text of an event of a support's drive."""
    joints = [i for i, _ in drives_of(support.drives)]
    which = joints[: number + 1].count(joints[number])
    what = ("is in its play", "pushes forwards", "pushes backwards", "does not push any more")[
        outcome
    ]
    return f"drive {which} of the {support.coordinate(joints[number])[0]} {what}"


def mean_of_drives(
    drives: Any, row: Any, i: Any, entries: tuple[Any, ...], n: int
) -> tuple[Any, ...]:
    """Return the n entries of a row of coordinates or rates from row[i] on, as at the drives.

    Those of joints that have play are the mean of their drives, by their shares: where motors and
    brakes act.
    """
    if drives is None:
        return entries
    entries = tuple(0.0 if drives[k] else entry for k, entry in enumerate(entries))
    for number, (k, drive) in enumerate(drives_of(drives)):
        entries = replace_entry(entries, k, entries[k] + drive.share * row[i + n + number])
    return entries
