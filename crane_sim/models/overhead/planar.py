"""An overhead crane in the vertical plane: a trolley, N rigid links, with a hoist or without.

State: one array [x, (l1), α_1 .. α_N, x', (l1'), α_1' .. α_N', (energy supplied), (modes)]. On a
moving base energies are those relative to it. What it adds, mass by mass, leaves out an axis with
prescribed motion, which has no mass, and the drum's reflected mass, which does not rotate with the
base.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import (
    COS,
    INV_MASS,
    LENGTH,
    RATE,
    RHS_ACROSS,
    RHS_ALONG,
    ROWS,
    SIN,
    TENSION,
    TURNING,
    Chain,
    Joints,
    Rods,
    add_joints,
    add_node_acceleration,
    assemble_rhs,
    copy_constants,
    fill_known_sines,
    fill_sines,
    joint_energy,
    joint_power,
    massless_hoist_acceleration,
    rod_energy,
    rod_pull,
    solve_links,
    work_array,
)
from crane_sim.models.cables.chain_3d import row_of
from crane_sim.models.effects import NodeForce, PayloadDrag, PayloadForce, force_power
from crane_sim.models.energy_meter import Meter
from crane_sim.models.guards import Guard, decode, encode, friction_event, smaller_guard
from crane_sim.models.moving_base import (
    added_energy,
    added_spin,
    base_kinematics_at,
    base_state,
    pose_at,
    to_world,
)
from crane_sim.models.overhead import first_link, hoist_mode, layout_of
from crane_sim.models.overhead.events import (
    EventLimits,
    drives_power,
    get_payload_mass,
    initial_modes,
    mode_of_stopped_drive,
    mode_rate,
    needs_forces,
    smallest_drive_guard,
    trolley_mode,
)
from crane_sim.models.overhead.planar_loads import add_links_load, add_payload_force
from crane_sim.models.supports.hoist import HOIST, Hoist, hoist_reflected_mass, hoist_response
from crane_sim.models.supports.rails import Axis, axis_mass
from crane_sim.models.wind_load import Windage
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import local_array, routine, simd_range, use_wide_vectors
from crane_sim.trajectories.base_motion import AnyBase
from crane_sim.trajectories.inputs import value_at
from crane_sim.trajectories.wind import Wind


class Solution(NamedTuple):
    """Accelerations and forces at one instant, in addition to the work array."""

    trolley: float  # m/s²
    paid: float  # m/s², of the first link's length
    pull: float  # N, of the cable and of a moving base on the trolley
    outside_power: float  # W, that moving base and wind supply, less what joints between links take


class PlanarCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    cable: Chain
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    joints: Joints | None = None
    rods: Rods | None = None
    forces: tuple[NodeForce, ...] | None = None
    event_limits: EventLimits | None = None
    energy_meter: Meter | None = None
    base: AnyBase | None = None
    wind: Wind | None = None
    windage: Windage | None = None  # of the payload
    drag: PayloadDrag | None = None
    force: PayloadForce | None = None

    def cable_coordinates(self):
        """Return the number of angles."""
        return len(self.cable.masses)

    @routine
    def solve(self, t, x, tau, w):
        """Return the result of `find_motion`."""
        return self.find_motion(t, x, tau, w)

    def find_motion(self, t, x, tau, w):
        """Return accelerations and forces at t in state x under efforts tau.

        Those of links are written into w.
        """
        use_wide_vectors()
        nq, first, modes = layout_of(self)
        self.fill_links(x, w)
        mode = trolley_mode(self.event_limits, x, modes)
        inv_mass, bias_acc = self.trolley.response(t, tau, 0, x[nq], mode)
        first_length = first_link(self, x)
        winch = hoist_response(self.hoist, t, tau, hoist_mode(x), first_length, self.gravity)
        hoist_inv_mass, hoist_bias_acc = winch
        assemble_rhs(w, bias_acc, self.gravity)
        base = base_kinematics_at(self.base, self.gravity, t)
        field = add_links_load(base, self, x, w)
        twist = add_joints(self.joints, w, x, first) + field.x
        w[RHS_ALONG, 0] -= w[SIN, 0] * inv_mass * twist
        w[RHS_ACROSS, 0] -= w[COS, 0] * inv_mass * twist
        add_node_forces(self.forces, t, w)
        wind_power = add_payload_force(self, base, t, x, w)
        rhs_along = w[RHS_ALONG, 0]
        solve_links(self.rods, w, (inv_mass, hoist_inv_mass, hoist_bias_acc, first_length[1]))
        pull = w[TENSION, 0] * w[SIN, 0] + rod_pull(self.rods, w) + twist
        if hoist_inv_mass >= 0.0:
            paid = hoist_bias_acc + hoist_inv_mass * w[TENSION, 0]
        else:
            paid = massless_hoist_acceleration(w, inv_mass, rhs_along)
        power = joint_power(self.joints, x[nq + first : 2 * nq]) + (field.power + wind_power)
        return Solution(bias_acc + inv_mass * pull, paid, pull, power)

    def fill_links(self, x, w):
        """Fill the work array with the links' kinematics."""
        nq, first, _ = layout_of(self)
        n = len(self.cable.masses)
        if isinstance(self.cable.masses, tuple):
            fill_known_sines(n, x[first:], 2 * nq - first, w)
        else:
            fill_sines(n, (w[SIN], w[COS]), (x[first:],))
        for k in simd_range(n):
            w[RATE, k] = x[nq + first + k]
        w[LENGTH, 0] = first_link(self, x)[0]
        # at each evaluation: a fault replaces the payload between periods, the work array stays
        mass = get_payload_mass(self.event_limits, x, len(x) - 1, self.cable.masses[n - 1])
        w[INV_MASS, n - 1] = 1.0 / mass

    @routine
    def node_velocities(self, x, w):
        """Return the velocities of nodes 0 to N relative to the base (N + 1, 3) [m/s]."""
        (nq, _, _), n, rate = layout_of(self), w.shape[1] - 1, first_link(self, x)[1]
        v = np.zeros((n + 1, 3))
        v[0, 0] = x[nq]
        for k in range(n):
            s, c, swing = w[SIN, k], w[COS, k], w[LENGTH, k] * w[RATE, k]
            paid = rate if k == 0 else 0.0
            v[k + 1, 0] = v[k, 0] + paid * s + swing * c
            v[k + 1, 2] = v[k, 2] - paid * c + swing * s
        return v

    def payload_position(self, x):
        """Return the payload's position (3,) [m] relative to the base."""
        _, first, _ = layout_of(self)
        px, pz = x[0], 0.0
        for k in range(len(self.cable.masses)):
            length = self.cable.lengths[k] if k > 0 or first == 1 else x[1]
            s, c = sincos(x[first + k])
            px, pz = px + length * s, pz - length * c
        return px, 0.0, pz


@system.workspace.register(PlanarCrane)
def allocate_work(p):
    """Return the work array of `chain`."""
    return work_array(p.cable.masses, p.cable.lengths)


def add_node_forces(forces, t, w):
    """Add the accelerations by forces on nodes to the links' right-hand sides."""
    for force in forces or ():
        acc = value_at(force.channel, t) * w[INV_MASS, force.node - 1]
        add_node_acceleration(
            w, force.node, acc if force.axis == 0 else 0.0, acc if force.axis == 2 else 0.0
        )


@system.rhs_into.register(PlanarCrane)
@routine
def write_derivative(p, t, x, u, out, work):
    """Write the time derivative of the state into `out`."""
    nq, first, modes = layout_of(p)
    tau = system.effort(u, p, t, x)
    if isinstance(p.cable.masses, tuple):
        given, work = work, local_array((ROWS, len(p.cable.masses) + 1))  # it stays in registers
        copy_constants(given, work)
        solved = p.find_motion(t, x, tau, work)
    else:
        solved = p.solve(t, x, tau, work)
    for i in simd_range(nq):
        out[i] = x[nq + i]
    for k in simd_range(nq - first):
        out[nq + first + k] = work[TURNING, k]
    out[nq] = solved.trolley
    if p.hoist is not None:
        out[nq + first - 1] = solved.paid
    for i in range(2 * nq, len(out)):
        out[i] = 0.0
    if p.energy_meter is not None:
        out[2 * nq] = chain_power(p, t, x, tau, solved, work)
    if p.event_limits is not None:
        out[modes] = mode_rate(p.trolley, x[nq], x[modes])


def chain_power(p, t, x, tau, solved, work):
    """Return the power [W] that drives, imposed motions, forces and losses supply."""
    power = (
        drives_power(p, x, tau, work[TENSION, 0], solved.pull, first_link(p, x)[1])
        + solved.outside_power
    )
    return power + (
        0.0 if p.forces is None else force_power(p.forces, t, p.node_velocities(x, work))
    )


@system.state.register(PlanarCrane)
def initial_state(p, t, q, v):
    """Return the state, with the modes that follow from velocities."""
    (nq, _, first), modes = layout_of(p), initial_modes(p, t, v)
    x = np.zeros(first + len(modes))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    for i, mode in enumerate(modes):
        x[first + i] = mode
    return x


@system.power.register(PlanarCrane)
def external_power(p, t, x, u):
    """Return the power [W] under a source of efforts."""
    tau, work = system.effort(u, p, t, x), system.workspace(p)
    return chain_power(p, t, x, tau, p.solve(t, x, tau, work), work)


@system.tensions.register(PlanarCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    work = system.workspace(p)
    p.solve(t, x, system.effort(u, p, t, x), work)
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = work[TENSION, k]


@system.kinetic.register(PlanarCrane)
@routine
def kinetic_energy(p, x):
    """Return the kinetic energy [J] of trolley, hoist, links and nodes."""
    (nq, first, _), work, rate = layout_of(p), system.workspace(p), first_link(p, x)[1]
    p.fill_links(x, work)
    v = p.node_velocities(x, work)
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2
    kinetic += 0.5 * hoist_reflected_mass(p.hoist) * rate * rate
    kinetic += rod_energy(p.rods, x[nq + first : 2 * nq])
    for k in range(len(p.cable.masses)):
        mass = 1.0 / work[INV_MASS, k]
        kinetic += 0.5 * mass * (v[k + 1, 0] ** 2 + v[k + 1, 1] ** 2 + v[k + 1, 2] ** 2)
    return kinetic


@system.potential.register(PlanarCrane)
@routine
def potential_energy(p, x):
    """Return the potential energy [J] of nodes and joints."""
    nq, first, _ = layout_of(p)
    w = system.workspace(p)
    p.fill_links(x, w)
    z, potential = 0.0, joint_energy(p.joints, x[first:nq])
    for k in range(len(p.cable.masses)):
        z = z - w[LENGTH, k] * w[COS, k]
        potential += 1.0 / w[INV_MASS, k] * p.gravity * z
    return potential


@system.points.register(PlanarCrane)
def write_points(p, t, x, out):
    """Write trolley and nodes."""
    (_, first, _), length = layout_of(p), first_link(p, x)[0]
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for k in range(len(p.cable.masses)):
        link = length if k == 0 else p.cable.lengths[k]
        out[k + 1, 0] = out[k, 0] + link * sin(x[first + k])
        out[k + 1, 1] = 0.0
        out[k + 1, 2] = out[k, 2] - link * cos(x[first + k])
    if p.base is not None:
        pose = pose_at(p.base, t)
        for k in range(len(out)):
            out[k, 0], out[k, 1], out[k, 2] = to_world(pose, row_of(out, k))


@system.base_energy.register(PlanarCrane)
@routine
def base_energy(p, t, x):
    """Return what a moving base adds to the energies of trolley, nodes, and rotating rods."""
    base, w = base_state(p.base, t, 0.0), system.workspace(p)
    if base is None:
        return 0.0, 0.0
    p.fill_links(x, w)
    velocity, position = p.node_velocities(x, w), (x[0], 0.0, 0.0)
    kinetic, potential = added_energy(
        base, p.gravity, axis_mass(p.trolley), position, row_of(velocity, 0)
    )
    for k in range(len(p.cable.masses)):
        position = (
            position[0] + w[LENGTH, k] * w[SIN, k],
            0.0,
            position[2] - w[LENGTH, k] * w[COS, k],
        )
        more = added_energy(
            base, p.gravity, 1.0 / w[INV_MASS, k], position, row_of(velocity, k + 1)
        )
        kinetic, potential = kinetic + more[0], potential + more[1]
        if p.rods is not None:  # angles of links grow against turns about y
            tensor = 0.0, p.rods.inertia[k], (0.0, 1.0, 0.0)
            kinetic += added_spin(base, tensor, (0.0, -w[RATE, k], 0.0))
    return kinetic, potential


@system.guard.register(PlanarCrane)
@routine
def smallest_guard(p, t, x, u, work):
    """Return the smallest guard, of drives, payload and links that must stay taut."""
    tau, forces = system.effort(u, p, t, x), needs_forces(p, x)
    pull = p.solve(t, x, tau, work).pull if forces else 0.0
    best = smallest_drive_guard(p, t, x, tau, work[TENSION, 0], pull, first_link(p, x)[0])
    if p.event_limits.stops.taut > 0.0:
        for k in range(len(p.cable.masses)):
            best = smaller_guard(best, work[TENSION, k], encode(Guard.LINK, k))
    return best[0], best[1], int(forces)


@system.apply_reset_map.register(PlanarCrane)
@routine
def switch(p, t, x, u, number):
    """Return the state after a change of payload or of a drive's friction; others end a run."""
    (nq, first, modes), (kind, joint, _) = layout_of(p), decode(number)
    tau, x = system.effort(u, p, t, x), x.copy()
    if kind == Guard.PAYLOAD:
        before = system.kinetic(p, x) + system.potential(p, x)
        x[len(x) - 1] += 1.0
        # the payload takes its energy along
        gained = system.kinetic(p, x) + system.potential(p, x) - before
        x[2 * nq] += gained
        return x, number, True
    if kind == Guard.FRICTION:
        rate, mode = (nq + first - 1, len(x) - 2) if joint == HOIST else (nq, modes)
        mode_before, work = x[mode], system.workspace(p)
        x[rate], x[mode] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
        pull = p.solve(t, x, tau, work).pull
        x[mode] = mode_of_stopped_drive(p, joint, mode_before, tau, work[TENSION, 0], pull)
        return x, friction_event(joint, x[mode]), True
    return x, number, False
