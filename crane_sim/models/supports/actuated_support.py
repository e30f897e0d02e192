"""Friction of a support's joints, and motors whose inertia moves with them.

The mass matrix of most supports is diagonal. With the inertia M_i of a joint (`joint_mobilities`: 1 / M_i), the
reflected inertia m_i = ratio² × that of the rotor of its motor, and the acceleration a_i that all efforts, friction
among them, would give it without the motor,

    q_i'' = M_i / (M_i + m_i) a_i,   and 0 where friction holds the joint, as if m_i were infinite,

which holds the load M_i a_i. The tip's mobility has the same ratios. A motor turns relative to the support: a base's
motion does not accelerate what it reflects, of which the ratio's square, not the ratio, counts.

A structure that bends has its drives' motors and friction on the body that turns with them: what bends accelerates as
before.

Boom and jib of a knuckle boom are coupled: `Knuckle` has its motors in its own mass matrix, and leaves joints that are
held out of it. So does a `SwayingTower`, which has no motors.
"""

from typing import Any, NamedTuple

from crane_sim.models.supports import (
    add_imposed_efforts,
    add_yaw_moment,
    coordinate_count,
    drive_power,
    forward_kinematics,
    friction_state_count,
    joint_constraint_efforts,
    joint_mobilities,
    joint_motion,
    support_acceleration,
    support_base_energy,
    support_guard,
    support_kinetic,
    support_polyline,
    support_polyline_size,
    support_potential,
    tip_acceleration,
    tip_levers,
    tip_mobility,
    trailing_count,
    with_wind,
    yaw,
)
from crane_sim.models.supports.backlash import (
    GearedSupport,
    initialize_support_modes,
    joint_efforts,
    permute_to_coordinate_order,
    permute_to_joint_order,
    to_coordinate_order,
    to_joint_order,
    with_support_switching,
)
from crane_sim.models.supports.compliance import as_entries
from crane_sim.models.supports.flexible import FlexibleSupport, as_coordinates, elastic_entries, slew_elevation_length
from crane_sim.models.supports.friction import first_not_none, step_control_of
from crane_sim.models.supports.friction_list import (
    FrictionList,
    add_friction_efforts,
    any_in_list_held,
    initialize_friction_states,
    list_length,
    mode_of_stopped_joint,
    place_in_list,
    read_friction_states,
    reset_listed_modes,
    smallest_friction_guard,
    without_held,
    write_list_rates,
)
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.supports.swaying_tower import SwayingTower, with_held_joints
from crane_sim.numerics.jit import generic, kernel, lean_generic, lean_kernel
from crane_sim.numerics.states import replace_entry, replace_field
from crane_sim.system import EVENT_LOG_CAPACITY, Switching


class ActuatedSupport(NamedTuple):
    """A support whose joints have friction, motors or both; what is None is not modelled."""

    support: Any  # of `crane_sim.models.supports`, not a `GearedSupport`, which can carry this one
    motors: tuple[float, ...] | None  # (n,) kg or kg m², reflected to the joints; a `Knuckle` has its own
    frictions: FrictionList | None

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return self.support.coordinate(i)


class ActuatedState(NamedTuple):
    """State of support and friction."""

    inner: Any  # of the support
    friction_states: Any  # tuple, of `FrictionList`: modes, or deflections of bristles


class ActuatedPosture(NamedTuple):
    """Kinematics of a state."""

    tip: tuple[float, float, float]  # m
    tip_velocity: tuple[float, float, float]  # m/s
    yaw_rate: float  # rad/s
    inner: Any  # posture of the support
    ratio: Any  # (n,) of accelerations with motors and friction to those without
    rates: Any  # (n,) of the joints
    friction_states: Any  # of `ActuatedState`


def bare_support(support: Any) -> Any:
    """Return the support without drives, motors and friction of its joints."""
    return bare_support(support.support) if isinstance(support, GearedSupport | ActuatedSupport) else support


def takes_energy(support: Any) -> bool:
    """Return whether drives with play, a structure that bends or friction take energy."""
    if isinstance(support, ActuatedSupport):
        return support.frictions is not None or takes_energy(support.support)
    return isinstance(support, GearedSupport | FlexibleSupport | SwayingTower)


@lean_kernel
def with_friction_states(support, inner, x):
    """Return the ActuatedState of a crane's state x; inner: the support's own."""
    return ActuatedState(inner, read_friction_states(support.frictions, x, len(x) - list_length(support.frictions)))


@friction_state_count.register(ActuatedSupport)
def _(support):
    return list_length(support.frictions)


@coordinate_count.register(ActuatedSupport)
def _(support):
    return coordinate_count(support.support)


@trailing_count.register(ActuatedSupport)
def _(support):
    return trailing_count(support.support)


@to_joint_order.register(ActuatedSupport)
def _(support, row):
    return permute_to_joint_order(support, row)


@to_coordinate_order.register(ActuatedSupport)
def _(support, row):
    return permute_to_coordinate_order(support, row)


@joint_motion.register(ActuatedSupport)
def _(support, xs, i):
    return joint_motion(support.support, xs.inner, i)


@lean_generic
def motor_ratios(motors, mobilities):
    """Return M_i / (M_i + m_i) of joints with these mobilities 1 / M_i, a tuple."""
    for i in range(len(mobilities)):
        mobilities = replace_entry(mobilities, i, 1.0)
    return mobilities


@motor_ratios.register(tuple)
def _(motors, mobilities):
    for i in range(len(mobilities)):
        mobilities = replace_entry(mobilities, i, 1.0 / (1.0 + motors[i] * mobilities[i]))
    return mobilities


@lean_generic
def free_ratios(support, motors, pose):
    """Return the ratios (n,) of accelerations with motors to those without, a tuple, where no joint is held."""
    return motor_ratios(motors, joint_mobilities(support, pose))


@free_ratios.register(Knuckle)
def _(support, motors, pose):
    return 1.0, 1.0, 1.0


@free_ratios.register(SwayingTower)
def _(support, motors, pose):
    return 1.0, 1.0, 1.0, 1.0


@generic
def held_posture(support, pose, ratio):
    """Return the support's posture, from which joints whose ratio is 0 are left out if its mass matrix couples them."""
    return pose


@held_posture.register(Knuckle)
def _(support, pose, ratio):
    return replace_field(pose, "free", (ratio[0] > 0.0, ratio[1] > 0.0, ratio[2] > 0.0))


@held_posture.register(SwayingTower)
def _(support, pose, ratio):
    return with_held_joints(support, pose, (ratio[0] > 0.0, ratio[1] > 0.0))


@lean_generic
def joint_rates(support, xs, like):
    """Return the rates (n,) of the joints of a support in its state xs; `like`: any tuple of n floats."""
    rates = like
    for i in range(len(rates)):
        rates = replace_entry(rates, i, joint_motion(support, xs, i)[1])
    return rates


@joint_rates.register(FlexibleSupport)
def _(support, xs, like):
    drives = joint_rates(support.support, xs.inner, as_coordinates(support.support, 0.0, 0.0, 0.0))
    lateral, vertical = as_entries(support.lateral, xs.rates[0]), as_entries(support.vertical, xs.rates[1])
    return (*drives, *lateral, *vertical)


@joint_rates.register(SwayingTower)
def _(support, xs, like):
    return joint_motion(support, xs, 0)[1], joint_motion(support, xs, 1)[1], xs.rates[0], xs.rates[1]


@lean_generic
def scaled_accelerations(support, qdd, ratio):
    """Return accelerations of a support's joints, scaled by the ratios that motors and friction leave of them."""
    for i in range(len(qdd)):
        qdd = replace_entry(qdd, i, ratio[i] * qdd[i])
    return qdd


@scaled_accelerations.register(FlexibleSupport)
def _(support, qdd, ratio):
    drives, unscaled = as_coordinates(support.support, 0.0, 0.0, 0.0), slew_elevation_length(support.support, qdd)
    for i in range(len(drives)):
        drives = replace_entry(drives, i, ratio[i] * qdd[i])
    scaled = slew_elevation_length(support.support, drives)
    twist, bend = elastic_entries(support, qdd, 0)  # relative to the drives: the outer body's stay what they were
    lateral = as_entries(support.lateral, twist + unscaled[0] - scaled[0])
    return (*drives, *lateral, *as_entries(support.vertical, bend + unscaled[1] - scaled[1]))


@forward_kinematics.register(ActuatedSupport)
def _(support, xs):
    pose = forward_kinematics(support.support, xs.inner)
    ratio = without_held(support.frictions, free_ratios(support.support, support.motors, pose), xs.friction_states, 0)
    pose, rates = held_posture(support.support, pose, ratio), joint_rates(support.support, xs.inner, ratio)
    return ActuatedPosture(pose.tip, pose.tip_velocity, pose.yaw_rate, pose, ratio, rates, xs.friction_states)


@joint_efforts.register(ActuatedSupport)
def _(support, tau, pose):
    tau = joint_efforts(support.support, tau, pose.inner)
    return add_friction_efforts(support.frictions, tau, pose.rates, pose.friction_states, 0)


@support_acceleration.register(ActuatedSupport)
def _(support, pose, gravity, tau, force):
    qdd = support_acceleration(support.support, pose.inner, gravity, tau, force)
    return scaled_accelerations(support.support, qdd, pose.ratio)


@tip_mobility.register(ActuatedSupport)
def _(support, pose, n):
    return mobility_of(support.support, pose, n)


@generic
def mobility_of(support, pose, n):
    """Return the result of `tip_mobility` for a support in an `ActuatedPosture`."""
    levers, mobilities = tip_levers(support, pose.inner, n), joint_mobilities(support, pose.inner)
    total = 0.0
    for i in range(len(levers)):
        total += pose.ratio[i] * mobilities[i] * levers[i] * levers[i]
    return total


@mobility_of.register(Knuckle)
@mobility_of.register(SwayingTower)
def _(support, pose, n):
    return tip_mobility(support, pose.inner, n)


@lean_generic
def motor_energy(motors, rates):
    """Return the kinetic energy [J] of motors whose joints have these rates."""
    return 0.0


@motor_energy.register(tuple)
def _(motors, rates):
    energy = 0.0
    for i in range(len(motors)):
        energy += 0.5 * motors[i] * rates[i] * rates[i]
    return energy


@support_kinetic.register(ActuatedSupport)
def _(support, pose):
    return support_kinetic(support.support, pose.inner) + motor_energy(support.motors, pose.rates)


@lean_generic
def write_friction_rates(support, pose, out):
    """Write the derivatives of the friction states into the end of `out`."""


@write_friction_rates.register(ActuatedSupport)
def _(support, pose, out):
    write_list_rates(support.frictions, pose.rates, pose.friction_states, 0, out)


@write_friction_rates.register(GearedSupport)
def _(support, pose, out):
    write_friction_rates(support.support, pose.inner, out)


@initialize_support_modes.register(ActuatedSupport)
def _(support, x, xs):
    pose = forward_kinematics(support.support, xs.inner)
    initialize_friction_states(
        support.frictions, joint_rates(support.support, xs.inner, free_ratios(support.support, None, pose)), x
    )


@generic
def reset_friction_modes(support, x, xs):
    """Write the friction modes after a velocity jump into the end of state x; bristles stay as they are."""


@reset_friction_modes.register(ActuatedSupport)
def _(support, x, xs):
    reset_listed_modes(support.frictions, forward_kinematics(support, xs).rates, x)


@reset_friction_modes.register(GearedSupport)
def _(support, x, xs):
    reset_friction_modes(support.support, x, xs.inner)


@generic
def any_joint_held(support, xs):
    """Return whether friction holds a joint."""
    return False


@any_joint_held.register(ActuatedSupport)
def _(support, xs):
    return any_in_list_held(support.frictions, xs.friction_states, 0)


@any_joint_held.register(GearedSupport)
def _(support, xs):
    return any_joint_held(support.support, xs.inner)


@kernel
def constraint_efforts(support, pose, gravity, tau, force):
    """Return the constraint efforts (n,): what friction bears where a joint sticks; see `support_acceleration`."""
    return support_constraint_efforts(support.support, pose.inner, gravity, tau, force)


@generic
def support_constraint_efforts(support, pose, gravity, tau, force):
    """Return the result of `constraint_efforts` for a support in its own posture."""
    qdd, mobilities = support_acceleration(support, pose, gravity, tau, force), joint_mobilities(support, pose)
    efforts = qdd
    for i in range(len(mobilities)):
        if mobilities[i] > 0.0:  # the slew of a tower crane may be locked
            efforts = replace_entry(efforts, i, qdd[i] / mobilities[i])
    return efforts


@support_constraint_efforts.register(Knuckle)
@support_constraint_efforts.register(SwayingTower)
def _(support, pose, gravity, tau, force):
    qdd = support_acceleration(support, pose, gravity, tau, force)
    return joint_constraint_efforts(support, pose, gravity, tau, force, qdd)


@generic
def held_guard(support, best, pose, gravity, tau, force):
    """Return the smallest one of `best` and of the guards of joints that friction holds, see `support_acceleration`."""
    return best


@held_guard.register(ActuatedSupport)
def _(support, best, pose, gravity, tau, force):
    efforts = constraint_efforts(support, pose, gravity, tau, force)
    return smallest_friction_guard(support.frictions, best, pose.rates, efforts, pose.friction_states, True, 0)


@held_guard.register(GearedSupport)
def _(support, best, pose, gravity, tau, force):
    return held_guard(support.support, best, pose.inner, gravity, tau, force)


@support_guard.register(ActuatedSupport)
def _(support, best, xs):
    best = support_guard(support.support, best, xs.inner)
    rates = forward_kinematics(support, xs).rates
    return smallest_friction_guard(support.frictions, best, rates, rates, xs.friction_states, False, 0)


@with_support_switching.register(ActuatedSupport)
def _(support, switching):
    return with_friction_switching(support.frictions, switching)


@generic
def with_friction_switching(frictions, switching):
    """Return the result of `system.switching` with this friction of the joints."""
    return switching


@with_friction_switching.register(FrictionList)
def _(frictions, switching):
    return Switching(EVENT_LOG_CAPACITY, 0, first_not_none(step_control_of(frictions), step_control_in(switching)))


@generic
def step_control_in(switching):
    """Return the `step_control` of a result of `system.switching`, None for None."""
    return None


@step_control_in.register(Switching)
def _(switching):
    return switching.step_control


@generic
def friction_state_offset(support, joint):
    """Return the offset of a joint's friction state from the end of the crane's state: it is x[len(x) - offset]."""
    return 1


@friction_state_offset.register(ActuatedSupport)
def _(support, joint):
    return list_length(support.frictions) - place_in_list(support.frictions, joint)


@friction_state_offset.register(GearedSupport)
def _(support, joint):
    return friction_state_offset(support.support, joint)


@generic
def mode_after_guard(support, joint, mode_before, held, gravity, force):
    """Return the mode of a joint at rest after its guard has failed.

    Args:
        support: the support.
        joint: index of its coordinate.
        mode_before: mode in which the guard has failed.
        held: (posture, efforts) of the same state with the joint sticking.
        gravity, force: arguments of `support_acceleration`.
    """
    return mode_before


@mode_after_guard.register(ActuatedSupport)
def _(support, joint, mode_before, held, gravity, force):
    pose, tau = held
    effort = constraint_efforts(support, pose, gravity, tau, force)[joint]
    return mode_of_stopped_joint(support.frictions, joint, mode_before, effort)


@mode_after_guard.register(GearedSupport)
def _(support, joint, mode_before, held, gravity, force):
    return mode_after_guard(support.support, joint, mode_before, (held[0].inner, held[1]), gravity, force)


@tip_acceleration.register(ActuatedSupport)
def _(support, pose, qdd):
    return tip_acceleration(support.support, pose.inner, qdd)


@add_yaw_moment.register(ActuatedSupport)
def _(support, tau, couple):
    return add_yaw_moment(support.support, tau, couple)


@add_imposed_efforts.register(ActuatedSupport)
def _(support, base, tau, pose):
    return add_imposed_efforts(support.support, base, tau, pose.inner)


@with_wind.register(ActuatedSupport)
def _(support, tau, flow, base, pose):
    return with_wind(support.support, tau, flow, base, pose.inner)


@drive_power.register(ActuatedSupport)
def _(support, tau, pose, force):
    return drive_power(support.support, tau, pose.inner, force)


@yaw.register(ActuatedSupport)
def _(support, xs):
    return yaw(support.support, xs.inner)


@support_polyline.register(ActuatedSupport)
def _(support, xs):
    return support_polyline(support.support, xs.inner)


@support_polyline_size.register(ActuatedSupport)
def _(support):
    return support_polyline_size(support.support)


@support_potential.register(ActuatedSupport)
def _(support, pose, gravity):
    return support_potential(support.support, pose.inner, gravity)


@support_base_energy.register(ActuatedSupport)
def _(support, base, pose, gravity):
    return support_base_energy(support.support, base, pose.inner, gravity)
