"""Friction in the joints of an `ActuatedSupport`: derivatives of its states, modes, guards and events' step control.

A joint sticks or slides (modes of `friction`), or its friction has bristles (`lugre`), whose deflections are states. A
`GearedSupport` passes all on to the support that it carries.
"""

from crane_sim.models.supports import (
    forward_kinematics,
    joint_constraint_efforts,
    joint_mobilities,
    support_acceleration,
    support_guard,
)
from crane_sim.models.supports.actuated_support import ActuatedSupport, free_ratios, joint_rates
from crane_sim.models.supports.backlash import GearedSupport, initialize_support_modes, with_support_switching
from crane_sim.models.supports.friction import first_not_none, step_control_of
from crane_sim.models.supports.friction_list import (
    FrictionList,
    any_in_list_sticks,
    initialize_friction_states,
    list_length,
    mode_of_stopped_joint,
    place_in_list,
    reset_listed_modes,
    smallest_friction_guard,
    write_list_rates,
)
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_entry
from crane_sim.system import EVENT_LOG_CAPACITY, Switching


@generic
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
def any_joint_sticks(support, xs):
    """Return whether friction holds a joint."""
    return False


@any_joint_sticks.register(ActuatedSupport)
def _(support, xs):
    return any_in_list_sticks(support.frictions, xs.friction_states, 0)


@any_joint_sticks.register(GearedSupport)
def _(support, xs):
    return any_joint_sticks(support.support, xs.inner)


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
def sticking_guard(support, best, pose, gravity, tau, force):
    """Return the smallest one of `best` and of the guards of joints that friction holds, see `support_acceleration`."""
    return best


@sticking_guard.register(ActuatedSupport)
def _(support, best, pose, gravity, tau, force):
    efforts = constraint_efforts(support, pose, gravity, tau, force)
    return smallest_friction_guard(support.frictions, best, pose.rates, efforts, pose.friction_states, True, 0)


@sticking_guard.register(GearedSupport)
def _(support, best, pose, gravity, tau, force):
    return sticking_guard(support.support, best, pose.inner, gravity, tau, force)


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
def mode_after_guard(support, joint, mode_before, sticking, gravity, force):
    """Return the mode of a joint at rest after its guard has failed.

    Args:
        support: the support.
        joint: index of its coordinate.
        mode_before: mode in which the guard has failed.
        sticking: (posture, efforts) of the same state with the joint sticking.
        gravity, force: arguments of `support_acceleration`.
    """
    return mode_before


@mode_after_guard.register(ActuatedSupport)
def _(support, joint, mode_before, sticking, gravity, force):
    pose, tau = sticking
    effort = constraint_efforts(support, pose, gravity, tau, force)[joint]
    return mode_of_stopped_joint(support.frictions, joint, mode_before, effort)


@mode_after_guard.register(GearedSupport)
def _(support, joint, mode_before, sticking, gravity, force):
    return mode_after_guard(support.support, joint, mode_before, (sticking[0].inner, sticking[1]), gravity, force)
