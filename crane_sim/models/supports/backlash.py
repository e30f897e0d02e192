"""Drives with play: each turns an inertia of its own, which meets the joint behind a gap.

A drive with the reflected inertia m and the position z moves a joint at q. Between them are the play Δ, of which half
lies on either side, and a shaft with the stiffness k and the damping c, which pushes and never pulls. On the side σ =
1, where the drive pushes the joint forwards, or σ = -1 the shaft is compressed by

    p = σ (z - q) - Δ/2,    and pushes with P = k p + c p' while p and P are positive, else with nothing:

    m z'' = u - σ P,    and the joint has the effort σ P,

u the drive's share of the joint's effort. A joint has any number of drives. A shaft that its drive leaves faster than
it can relax does not push, and its damper takes what the spring gives (Nordin and Gutman, Automatica 38 (2002) 1633,
have it relax with the time c/k). A mode is σ while the shaft pushes, 2σ while it only relaxes, 0 in the gap; the
state says which, and each ends as an event.

`GearedSupport` is any support with such drives, whose reflected inertias a base's motion does not accelerate. Its state
has the drives' coordinates behind its own, and their modes at the end of the crane's, before those of joints with
friction (`actuated_support`), which is that of the joints.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.models.guards import BACKWARDS, FORWARDS, Guard, decode, encode, smaller_guard
from crane_sim.models.supports import (
    add_imposed_efforts,
    add_yaw_moment,
    coordinate_count,
    drive_power,
    forward_kinematics,
    friction_state_count,
    joint_motion,
    support_acceleration,
    support_base_energy,
    support_guard,
    support_kinetic,
    support_polyline,
    support_polyline_size,
    support_potential,
    tip_acceleration,
    tip_mobility,
    trailing_count,
    with_wind,
    yaw,
)
from crane_sim.numerics.jit import generic, routine
from crane_sim.numerics.states import replace_entry
from crane_sim.system import EVENT_LOG_CAPACITY, EventStepControl, Switching

IN_PLAY, RELAXES = 0, 3  # outcomes of an event, beside FORWARDS and BACKWARDS


class Drives(NamedTuple):
    """Drives with play, tuples of n, in units of their joints."""

    joint: tuple[int, ...]  # index of the support's coordinate that each one moves
    inertia: tuple[float, ...]  # kg or kg m², reflected to the joint
    share: tuple[float, ...]  # of the joint's effort
    play: tuple[float, ...]  # m or rad, Δ
    stiffness: tuple[float, ...]  # N/m or N m/rad
    damping: tuple[float, ...]  # N s/m or N m s/rad


class GearedSupport(NamedTuple):
    """A support with drives that have play."""

    support: Any  # of `crane_sim.models.supports`
    drives: Drives

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return self.support.coordinate(i)


class GearedState(NamedTuple):
    """State of support and drives, tuples of n."""

    inner: Any  # of the support
    position: tuple[float, ...]  # m or rad, reflected to the joint
    rate: tuple[float, ...]  # m/s or rad/s
    mode: tuple[float, ...]  # 1 pushes forwards, -1 backwards, 2 and -2 relax on these sides, 0 in the play


class GearedPosture(NamedTuple):
    """Kinematics of a state."""

    tip: tuple[float, float, float]  # m
    tip_velocity: tuple[float, float, float]  # m/s
    yaw_rate: float  # rad/s
    inner: Any  # posture of the support
    xs: GearedState


class Shaft(NamedTuple):
    """What lies between a drive and its joint on the side of contact, in the gap on the nearer one, at one instant."""

    side: float  # 1: the drive pushes forwards, -1: backwards
    compression: float  # m or rad, p: negative in the gap
    rate: float  # m/s or rad/s, p'
    push: float  # N or N m, k p + c p', which acts where it and p are positive
    rates: tuple[float, float]  # m/s or rad/s, of drive and joint


@generic
def drive_count(support):
    """Return the number of drives that have coordinates of their own."""
    return 0


@drive_count.register(GearedSupport)
def _(support):
    return len(support.drives.inertia)


@generic
def to_joint_order(support, row):
    """Return a row of the crane's coordinates or their rates, permuted to the order of joints: bending, drives last."""
    return row.copy()


@to_joint_order.register(GearedSupport)
def _(support, row):
    return permute_to_joint_order(support, row)


@routine
def permute_to_joint_order(support, row):
    """Return the result of `to_joint_order` for a support with trailing coordinates, which come last."""
    n, count = trailing_count(support), len(row)
    own, out = coordinate_count(support) - n, row.copy()
    for i in range(own, count - n):
        out[i] = row[i + n]
    for i in range(n):
        out[count - n + i] = row[own + i]
    return out


@generic
def to_coordinate_order(support, row):
    """Return a row of joints or their rates, permuted to the order of coordinates: the inverse of `to_joint_order`."""
    return row


@to_coordinate_order.register(GearedSupport)
def _(support, row):
    return permute_to_coordinate_order(support, row)


@routine
def permute_to_coordinate_order(support, row):
    """Return a row of joints in the order of coordinates: the inverse of `permute_to_joint_order`."""
    n, count = trailing_count(support), len(row)
    own, out = coordinate_count(support) - n, np.empty(count)
    for i in range(own):
        out[i] = row[i]
    for i in range(own, count - n):
        out[i + n] = row[i]
    for i in range(n):
        out[own + i] = row[count - n + i]
    return out


def shaft_state(support, xs, i):
    """Return the Shaft of drive i in state xs."""
    drives, joint = support.drives, support.drives.joint[i]
    place, joint_rate = joint_motion(support.support, xs.inner, joint)
    ahead, rate, mode = xs.position[i] - place, xs.rate[i], xs.mode[i]
    side = 1.0 if mode > 0.0 or (mode == 0.0 and ahead >= 0.0) else -1.0
    p, moves = side * ahead - 0.5 * drives.play[i], side * (rate - joint_rate)
    return Shaft(side, p, moves, drives.stiffness[i] * p + drives.damping[i] * moves, (rate, joint_rate))


def first_drive_mode(support, x):
    """Return the index of the first drive's mode in a crane's state x; friction of joints stands behind them."""
    return len(x) - len(support.drives.inertia) - friction_state_count(support.support)


def with_drive_states(support, inner, x, nq):
    """Return the GearedState of a crane's state x with nq coordinates; inner: the support's own."""
    drives, own = support.drives, coordinate_count(support.support)
    position, rate, mode = drives.inertia, drives.inertia, drives.inertia  # tuples of the right size, to fill
    for i in range(len(drives.inertia)):
        position = replace_entry(position, i, x[own + i])
        rate = replace_entry(rate, i, x[nq + own + i])
        mode = replace_entry(mode, i, x[first_drive_mode(support, x) + i])
    return GearedState(inner, position, rate, mode)


def joint_push(support, xs, i):
    """Return the effort of drive i on its joint, with the sign of the joint, in the mode of state xs."""
    mode = xs.mode[i]
    return mode * shaft_state(support, xs, i).push if abs(mode) == 1.0 else 0.0


@generic
def joint_efforts(support, tau, pose):
    """Return the efforts on the support's coordinates at commands tau: of drives with play, springs, friction."""
    return tau


@trailing_count.register(GearedSupport)
def _(support):
    return trailing_count(support.support) + len(support.drives.inertia)


@joint_efforts.register(GearedSupport)
def _(support, tau, pose):
    for i in range(len(support.drives.inertia)):
        tau = replace_entry(tau, support.drives.joint[i], 0.0)
    for i in range(len(support.drives.inertia)):
        j = support.drives.joint[i]
        tau = replace_entry(tau, j, tau[j] + joint_push(support, pose.xs, i))
    return joint_efforts(support.support, tau, pose.inner)


@generic
def write_drive_accelerations(support, pose, command, out, at):
    """Write the accelerations of drives under commanded efforts into out[at ...]."""


@write_drive_accelerations.register(GearedSupport)
def _(support, pose, command, out, at):
    drives = support.drives
    for i in range(len(drives.inertia)):
        effort = drives.share[i] * command[drives.joint[i]]
        out[at + i] = (effort - joint_push(support, pose.xs, i)) / drives.inertia[i]


@generic
def play_power(support, pose, command):
    """Return the power [W] of commanded efforts on drives and of losses, less what the drives push into joints."""
    return 0.0


@play_power.register(GearedSupport)
def _(support, pose, command):
    drives, power = support.drives, 0.0
    for i in range(len(drives.inertia)):
        shaft, push = shaft_state(support, pose.xs, i), joint_push(support, pose.xs, i)
        power += drives.share[i] * command[drives.joint[i]] * shaft.rates[0] - push * shaft.rates[1]
        power += (drives.stiffness[i] * max(shaft.compression, 0.0) - push * shaft.side) * shaft.rate
    return power


def mode_of(shaft):
    """Return the mode that a shaft's state asks for."""
    if shaft.compression <= 0.0:
        return 0.0
    return shaft.side if shaft.push > 0.0 else 2.0 * shaft.side


@generic
def initialize_support_modes(support, x, xs):
    """Write the initial modes of drives and friction into the end of state x; xs: the support's state without modes."""


@initialize_support_modes.register(GearedSupport)
def _(support, x, xs):
    for i in range(len(support.drives.inertia)):
        x[first_drive_mode(support, x) + i] = mode_of(shaft_state(support, xs, i))
    initialize_support_modes(support.support, x, xs.inner)


def drive_guard(support, xs, i):
    """Return the guard of drive i: negative where its mode ends."""
    mode, shaft = xs.mode[i], shaft_state(support, xs, i)
    if mode == 0.0:
        return -shaft.compression
    return shaft.push if abs(mode) == 1.0 else min(shaft.compression, -shaft.push)


@support_guard.register(GearedSupport)
def _(support, best, xs):
    best = support_guard(support.support, best, xs.inner)
    for i in range(len(support.drives.inertia)):
        best = smaller_guard(best, drive_guard(support, xs, i), encode(Guard.BACKLASH, i))
    return best


@generic
def with_support_switching(support, switching):
    """Return the result of `system.switching`: `switching` for a support that does not switch."""
    return switching


@with_support_switching.register(GearedSupport)
def _(support, switching):
    return Switching(EVENT_LOG_CAPACITY, 0, EventStepControl())


@generic
def switch_drive(support, x, xs, number):
    """Return the result of `system.apply_reset_map` in the support's state xs: a guard of no drive ends the run."""
    return x, number, False


@switch_drive.register(GearedSupport)
def _(support, x, xs, number):
    kind, i, _ = decode(number)
    if kind != Guard.BACKLASH:
        return x, number, False
    y, at = x.copy(), first_drive_mode(support, x) + i
    y[at] = mode_of(shaft_state(support, xs, i))
    outcome = RELAXES if abs(y[at]) == 2.0 else IN_PLAY if y[at] == 0.0 else FORWARDS if y[at] > 0.0 else BACKWARDS
    return y, encode(Guard.BACKLASH, i, outcome), True


def describe_drive(support: Any, i: int, outcome: int) -> str:
    """Return the text of an event of drive i."""
    joint = support.drives.joint
    number = 1 + sum(1 for k in range(i) if joint[k] == joint[i])
    what = ("is in its play", "pushes forwards", "pushes backwards", "does not push any more")[outcome]
    return f"drive {number} of the {support.coordinate(int(joint[i]))[0]} {what}"


@friction_state_count.register(GearedSupport)
def _(support):
    return friction_state_count(support.support)


@coordinate_count.register(GearedSupport)
def _(support):
    return coordinate_count(support.support) + len(support.drives.inertia)


@forward_kinematics.register(GearedSupport)
def _(support, xs):
    pose = forward_kinematics(support.support, xs.inner)
    return GearedPosture(pose.tip, pose.tip_velocity, pose.yaw_rate, pose, xs)


@support_acceleration.register(GearedSupport)
def _(support, pose, gravity, tau, force):
    return support_acceleration(support.support, pose.inner, gravity, tau, force)


@tip_acceleration.register(GearedSupport)
def _(support, pose, qdd):
    return tip_acceleration(support.support, pose.inner, qdd)


@tip_mobility.register(GearedSupport)
def _(support, pose, n):
    return tip_mobility(support.support, pose.inner, n)


@add_yaw_moment.register(GearedSupport)
def _(support, tau, couple):
    return add_yaw_moment(support.support, tau, couple)


@add_imposed_efforts.register(GearedSupport)
def _(support, base, tau, pose):
    return add_imposed_efforts(support.support, base, tau, pose.inner)


@with_wind.register(GearedSupport)
def _(support, tau, flow, base, pose):
    return with_wind(support.support, tau, flow, base, pose.inner)


@drive_power.register(GearedSupport)
def _(support, tau, pose, force):
    return drive_power(support.support, tau, pose.inner, force)


@yaw.register(GearedSupport)
def _(support, xs):
    return yaw(support.support, xs.inner)


@support_polyline.register(GearedSupport)
def _(support, xs):
    return support_polyline(support.support, xs.inner)


@support_polyline_size.register(GearedSupport)
def _(support):
    return support_polyline_size(support.support)


@support_kinetic.register(GearedSupport)
def _(support, pose):
    energy = support_kinetic(support.support, pose.inner)
    for i in range(len(support.drives.inertia)):
        rate = shaft_state(support, pose.xs, i).rates[0]
        energy += 0.5 * support.drives.inertia[i] * rate * rate
    return energy


@support_potential.register(GearedSupport)
def _(support, pose, gravity):
    energy = support_potential(support.support, pose.inner, gravity)
    for i in range(len(support.drives.inertia)):
        p = max(shaft_state(support, pose.xs, i).compression, 0.0)
        energy += 0.5 * support.drives.stiffness[i] * p * p
    return energy


@support_base_energy.register(GearedSupport)
def _(support, base, pose, gravity):
    return support_base_energy(support.support, base, pose.inner, gravity)


def mean_of_drives(support, row, i, entries):
    """Return the support's entries of a row of coordinates or rates from row[i] on, as its drives have them.

    Those of joints that have play are the mean of their drives, by their shares: where motors and brakes act.
    """
    drives, own = support.drives, coordinate_count(support.support)
    for k in range(len(drives.inertia)):
        entries = replace_entry(entries, drives.joint[k], 0.0)
    for k in range(len(drives.inertia)):
        j = drives.joint[k]
        entries = replace_entry(entries, j, entries[j] + drives.share[k] * row[i + own + k])
    return entries
