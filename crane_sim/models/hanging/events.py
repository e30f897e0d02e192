"""Events of cranes whose load hangs below a support: switching, changes of state, and texts."""

from typing import Any

from crane_sim import system
from crane_sim.models.carrier.exchange import (
    DONE,
    carried_energy,
    describe_exchange,
    join,
    load_of,
    vector_at,
    with_exchange_switching,
)
from crane_sim.models.carrier.layout import exchange_index, layout_of, rope_length, winch_index
from crane_sim.models.contact.surface import RigidContact, contact_point, displacement_at
from crane_sim.models.elastic.crane import payload_state
from crane_sim.models.falls.contact_events import describe_contact, fill_contact, switch_contact
from crane_sim.models.falls.crane import FallsCrane, body_state
from crane_sim.models.guards import LOWER, TAUT, Guard, decode, encode, friction_event
from crane_sim.models.hanging.interface import HANGING, energies, solve
from crane_sim.models.loads import coordinate_velocity
from crane_sim.models.stops import (
    WINCH,
    Stops,
    describe_cable_event,
    describe_length_event,
    describe_stop,
    make_switching,
)
from crane_sim.models.supports.backlash import describe_drive
from crane_sim.models.supports.friction import friction_of, step_control_of
from crane_sim.models.supports.hoist import hoist_modes
from crane_sim.models.supports.joint_modes import (
    friction_state_index,
    mode_after_guard,
    switch_drive,
    with_support_switching,
)
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.support import read_state
from crane_sim.models.suspended import impulses
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.wind_kink import with_kink_switching
from crane_sim.multibody.attitude import quaternion_rate
from crane_sim.multibody.vectors import add, cross, multiply, subtract
from crane_sim.numerics.jit import routine
from crane_sim.system import EVENT_LOG_CAPACITY, Switching

SEAT = 1e-6  # m: no deeper than this a point may be below the surface when its load is taken up


@system.switching.register(*HANGING)
def switching(p):
    """Return how the equations switch: by cable, support, exchanges and the kink of a wind."""
    of_support = with_support_switching(p.support, rope_switching(p))
    return with_kink_switching(p.wind, with_exchange_switching(p.exchange, of_support))


def rope_switching(p):
    """Return how the equations switch by falls, by friction of a winch, or by the stops."""
    slackens = isinstance(p, FallsCrane) or p.cable_modes() > 0
    if slackens or isinstance(p.hoist, ReevedHoist) or hoist_modes(p.hoist) > 0:
        return Switching(EVENT_LOG_CAPACITY, 0, step_control_of(friction_of(p.hoist)))
    return make_switching(p.stops, 0)


@system.apply_reset_map.register(*HANGING)
def switch(p, t, x, u, number):
    """Return (state after an event, the event, whether the run goes on)."""
    kind, joint, _ = decode(number)
    if kind == Guard.FRICTION:
        return after_friction_guard(p, t, x, system.effort(u, p, t, x), joint)
    if kind == Guard.BACKLASH:
        return switch_drive(p.support, x, read_state(p.support, x, layout_of(p)[0]), number)
    if p.exchange is not None and kind == Guard.PAYLOAD:
        return (
            impulses.apply_exchange(p, t, x)
            if isinstance(p, SuspendedCrane)
            else exchange_on_springs(p, t, x)
        )
    if isinstance(p, FallsCrane) and p.contact is not None and kind == Guard.CONTACT:
        return switch_contact(p, t, x, number)
    if p.cable_modes() > 0 and kind == Guard.LINK:
        return switch_cable(p, x, number)
    return x, number, False


def after_friction_guard(p, t, x, tau, joint):
    """Return the result of `switch` after the guard of a joint's or the winch's friction failed."""
    if hoist_modes(p.hoist) > 0 and joint == WINCH:
        return after_winch_guard(p, t, x, tau)
    return after_joint_guard(p, t, x, tau, joint)


@routine
def after_joint_guard(p, t, x, tau, joint):
    """Return the result of `switch` after the guard of the friction of a support's joint failed."""
    nq, _, _ = layout_of(p)
    x, k = x.copy(), friction_state_index(p.support, x, joint)
    mode_before = stop(x, nq + joint, k)
    x[k] = mode_after_guard(
        p.support, joint, mode_before, solve(p, t, x, tau, system.workspace(p)).support
    )
    return x, friction_event(joint, x[k]), True


@routine
def after_winch_guard(p, t, x, tau):
    """Return the result of `switch` after the guard of the winch's friction has failed."""
    nq, first, _ = layout_of(p)
    x, k = x.copy(), winch_index(p)
    mode_before = stop(x, nq + first - 1, k)
    pull = solve(p, t, x, tau, system.workspace(p)).paid
    x[k] = p.hoist.stopped_mode(tau, mode_before, rope_length(p, x), pull, p.gravity)
    return x, friction_event(WINCH, x[k]), True


def stop(x, rate, mode):
    """Return the mode x[mode] of a friction, and set its rate and mode to those of rest."""
    mode_before = x[mode]
    x[rate], x[mode] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
    return mode_before


@routine
def switch_cable(p, x, number):
    """Return (state with a fall's or link's other mode, the event, whether the run goes on)."""
    (nq, _, modes), (_, i, _) = layout_of(p), decode(number)
    y = x.copy()
    y[modes + i] = 1.0 - x[modes + i]
    if modes > 2 * nq:  # a slack one loses what its spring held against the damper
        y[2 * nq] += energies(p, None, y)[1] - energies(p, None, x)[1]
    return y, encode(Guard.LINK, i, int(y[modes + i])), True


@routine
def exchange_on_springs(p, t, x):
    """Return (state after the next exchange on springs or falls, event, whether the run goes on).

    They pull as before in no time and transmit no impulse, so that the momentum of what hangs is
    that of its parts.
    """
    (nq, _, modes), mode = layout_of(p), exchange_index(p)
    k, y = int(x[mode]), x.copy()
    y[mode] += 1.0
    before, after, state = load_of(p, x), load_of(p, y), kinematics_of_load(p, x)
    energy = carried_energy(before, after, state)
    if p.exchange.carried[k] == 0.0:
        joined = join(before, after, state, vector_at(p.exchange.velocities, k, 0))
        energy = joined.energy
        write_joined_velocity(p, y, state, joined)
    if modes > 2 * nq:
        lifted = after.mass * kinematics_of_load(p, y).position[2] - before.mass * state.position[2]
        y[2 * nq] += energy + p.gravity * lifted
    goes_on = True
    if isinstance(p, FallsCrane):
        fill_contact(p, t, y)
        goes_on = deepest_point(p, t, y) <= SEAT
    return y, encode(Guard.PAYLOAD, k, DONE), goes_on


def kinematics_of_load(p, x):
    """Return the load's kinematics in state x, on springs or falls."""
    return body_state(p, x) if isinstance(p, FallsCrane) else payload_state(p, x)


def write_joined_velocity(p, y, state, joined):
    """Write the velocity of a load joined with what it takes up into y; state: before it."""
    nq, first, _ = layout_of(p)
    if isinstance(p, FallsCrane):
        turned = multiply(state.rows, cross(subtract(joined.omega, state.omega), p.load.attachment))
        i = nq + first
        y[i], y[i + 1], y[i + 2] = add(coordinate_velocity(state), subtract(joined.jump, turned))
        y[i + 3], y[i + 4], y[i + 5], y[i + 6] = quaternion_rate(state.quaternion, joined.omega)
        return
    d = p.dimensions()
    i = 2 * nq - d
    y[i] += joined.jump[0]
    if d == 3:
        y[i + 1] += joined.jump[1]
    y[i + d - 1] += joined.jump[2]


def deepest_point(p, t, x):
    """Return how far [m] a point is below a surface that it cannot enter."""
    contact = p.contact
    if not isinstance(contact, RigidContact):
        return 0.0
    deepest, load, moved = 0.0, body_state(p, x), displacement_at(contact.surface.motion, t)
    for i in range(len(contact.points)):
        deepest = max(deepest, -contact_point(contact, i, moved, load).gap)
    return deepest


@system.describe_event.register(*HANGING)
def describe_event(p, number):
    """Return texts (what an event was, what a user can change)."""
    (kind, i, outcome), stops = decode(number), p.stops or Stops()
    if kind == Guard.BACKLASH:
        return describe_drive(p.support, i, outcome), ""
    if kind == Guard.PAYLOAD and p.exchange is not None:
        return describe_exchange(p.exchange, i, outcome, what_forbids_exchange(p, i))
    if kind == Guard.CONTACT:
        return describe_contact(p.contact, i, outcome), ""
    if kind == Guard.TWIST:
        return (
            "the rope is twisted by almost a turn",
            "change what turns the payload, or rope.torsion.stiffness",
        )
    if kind == Guard.LINK and not isinstance(p, SuspendedCrane):
        what = "fall" if isinstance(p, FallsCrane) else "link"
        return f"{what} {i + 1} {'pulls' if outcome == TAUT else 'went slack'}", ""
    if kind == Guard.LINK and p.overhead is None:
        return describe_slack_link(p, i)
    if kind == Guard.LENGTH and isinstance(p, FallsCrane):
        rope = "shortest fall" if i == LOWER else "falls' rope"
        return describe_length_event(rope, "hoist", i, stops.shortest)
    if getattr(p, "overhead", None) is not None and (
        kind in (Guard.LINK, Guard.LENGTH) or is_of_winch(kind, i)
    ):
        return describe_cable_event(number, stops.shortest)
    return describe_stop(p.support, stops, number)


def is_of_winch(kind: int, i: int) -> bool:
    """Return whether an event is of the winch's friction."""
    return kind == Guard.FRICTION and i == WINCH


def describe_slack_link(p: SuspendedCrane, i: int) -> tuple[str, str]:
    """Return texts (what went slack, what a user can change) of a link or a reeving's fall."""
    if system.fall_count(p) > 0:
        what = f"link {i + 1}" if i else "the rope over the sheaves"
        what = "a fall of the reeving" if i >= len(p.cable.masses) else what
        return (
            f"{what} went slack",
            "change what moves rope or base, or take elastic `falls`, which can go slack",
        )
    if i > 0:
        what = f"link {i + 1} went slack, and a rigid link must be taut"
        return what, "take rope.slack: allow if the links are rods"
    return (
        "the rope went slack, and a rigid one cannot be",
        "take rope.slack: allow if the rope is a rod",
    )


def what_forbids_exchange(p: Any, k: int) -> tuple[str, str]:
    """Return texts (why exchange k would end a run, what a user can change)."""
    if isinstance(p, FallsCrane):
        key = f"events[{k}]"
        return (
            "its points would be below the surface",
            f"change {key}.at, {key}.set.contact, or the hoist's input",
        )
    rods = "" if system.fall_count(p) > 0 else ", or take rope.slack: allow if links are rods"
    return "a link would push at that", f"change events[{k}].velocity{rods}"
