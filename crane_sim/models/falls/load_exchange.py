"""Pick-up and release of loads on falls: a spreader's motion jumps as it picks a container up; what touches then.

What is let go leaves with the motion that it has. What is taken up joins by a perfectly inelastic impact, see
`suspended.exchange`: elastic falls pull as before in no time, and transmit no impulse, so that linear and angular
momentum of the two bodies together are those of the one.
"""

from crane_sim.models.contact.surface import RigidContact, contact_point, displacement_at
from crane_sim.models.falls.contact_events import fill_contact
from crane_sim.models.falls.crane import FallsCrane, body_state
from crane_sim.models.guards import Guard, encode
from crane_sim.models.suspended.exchange import DONE, carried_energy, describe_exchange, join, load_of, vector_at
from crane_sim.models.suspended.layout import exchange_index, layout_of
from crane_sim.models.suspended.load_dynamics import coordinate_velocity
from crane_sim.multibody.attitude import quaternion_rate
from crane_sim.multibody.vectors import add, cross, multiply, subtract
from crane_sim.numerics.jit import routine

SEAT = 1e-6  # m: no deeper than this a point may be below the surface when its load is taken up


@routine
def apply_exchange(p, t, x):
    """Return (state after the next exchange, its event, whether the run goes on)."""
    (nq, first, modes), mode = layout_of(p), exchange_index(p)
    k, y = int(x[mode]), x.copy()
    y[mode] += 1.0
    before, after, state = load_of(p, x), load_of(p, y), body_state(p, x)
    energy = carried_energy(before, after, state)
    if p.exchange.carried[k] == 0.0:
        joined = join(before, after, state, vector_at(p.exchange.velocities, k, 0))
        turned = multiply(state.rows, cross(subtract(joined.omega, state.omega), p.load.attachment))
        i, energy = nq + first, joined.energy
        y[i], y[i + 1], y[i + 2] = add(coordinate_velocity(state), subtract(joined.jump, turned))
        y[i + 3], y[i + 4], y[i + 5], y[i + 6] = quaternion_rate(state.quaternion, joined.omega)
    if modes > 2 * nq:
        lifted = after.mass * body_state(p, y).position[2] - before.mass * state.position[2]
        y[2 * nq] += energy + p.gravity * lifted
    fill_contact(p, t, y)
    return y, encode(Guard.PAYLOAD, k, DONE), deepest_point(p, t, y) <= SEAT


def deepest_point(p, t, x):
    """Return how far [m] a point is below a surface that it cannot enter."""
    contact = p.contact
    if not isinstance(contact, RigidContact):
        return 0.0
    deepest, load, moved = 0.0, body_state(p, x), displacement_at(contact.surface.motion, t)
    for i in range(len(contact.points)):
        deepest = max(deepest, -contact_point(contact, i, moved, load).gap)
    return deepest


def describe_body_exchange(p: FallsCrane, k: int, outcome: int) -> tuple[str, str]:
    """Return texts (meaning of exchange k, what a user can change); the outcome is DONE, or it ended the run."""
    assert p.exchange is not None
    text, _ = describe_exchange(p.exchange, k, DONE, False)
    if outcome == DONE:
        return text, ""
    key = f"events[{k}]"
    return f"{text}: its points would be below the surface", f"change {key}.at, {key}.set.contact, or the hoist's input"
