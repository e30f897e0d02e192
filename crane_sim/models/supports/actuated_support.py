"""A support whose joints have friction and motors, whose inertia moves with them; its modes are in `friction_modes`.

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
    joint_mobilities,
    joint_motion,
    support_acceleration,
    support_base_energy,
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
    joint_efforts,
    permute_to_coordinate_order,
    permute_to_joint_order,
    to_coordinate_order,
    to_joint_order,
)
from crane_sim.models.supports.compliance import as_entries
from crane_sim.models.supports.flexible import FlexibleSupport, as_coordinates, elastic_entries, slew_elevation_length
from crane_sim.models.supports.friction_list import (
    FrictionList,
    add_friction_efforts,
    list_length,
    read_friction_states,
    without_sticking,
)
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.supports.swaying_tower import SwayingTower, with_sticking_joints
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_entry, replace_field


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


@generic
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


@generic
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
def sticking_posture(support, pose, ratio):
    """Return the support's posture, from which joints whose ratio is 0 are left out if its mass matrix couples them."""
    return pose


@sticking_posture.register(Knuckle)
def _(support, pose, ratio):
    return replace_field(pose, "free", (ratio[0] > 0.0, ratio[1] > 0.0, ratio[2] > 0.0))


@sticking_posture.register(SwayingTower)
def _(support, pose, ratio):
    return with_sticking_joints(support, pose, (ratio[0] > 0.0, ratio[1] > 0.0))


@generic
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


@generic
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
    ratio = without_sticking(
        support.frictions, free_ratios(support.support, support.motors, pose), xs.friction_states, 0
    )
    pose, rates = sticking_posture(support.support, pose, ratio), joint_rates(support.support, xs.inner, ratio)
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


@generic
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
