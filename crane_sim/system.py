"""Interface of a model: the generic functions that integrators, laws and outputs call.

A model registers all of `MANDATORY`, one of `DERIVATIVES`, and all of `SWITCHES` where its
`switching` is not None. Everything else has a default, which its docstring says. Sources of efforts
register `effort`, laws `command`.

Argument order is (p, t, x, u): parameters p (a NamedTuple whose type chooses the body), time t [s],
state x (nested tuples of floats) and u, what drives the actuated joints: a tuple of efforts that
are held, or a NamedTuple with a registered `effort`. An effort is a force or torque, or what else a
drive takes: an acceleration, a rate, a position. Joint coordinates q, v are tuples in the order of
the scene's joint names; SI units and radians; world frame right-handed, z up.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.derivatives import state_and_time_jacobian
from crane_sim.numerics.jit import entry_point, generic
from crane_sim.numerics.linear_systems import factor_dense, solve_dense

EVENT_LOG_CAPACITY = 1000
"""Number of events that the log of a run keeps."""


class EventStepControl(NamedTuple):
    """Marks equations where the step that ends at an event is error-controlled, too.

    It is repeated until it passes.

    Needed where they change fast just before an event, which a longer step can miss: as friction by
    Stribeck.
    """


class KinkStepControl(NamedTuple):
    """Marks equations with kinks (`kink_guard`): a step that passes one is repeated up to it."""

    of_events: Any  # step control of all other events


class Switching(NamedTuple):
    """The model's equations switch at events."""

    capacity: int = EVENT_LOG_CAPACITY  # number of events that the log keeps
    positions: int = 0  # guards depend on t and this number of positions, which precede their rates
    # in x; 0: on all of x
    step_control: Any = None  # `EventStepControl`, `KinkStepControl`, or None: a step that ends at
    # an event stays


@generic
def rhs(p, t, x, u):
    """Return the time derivative of the state, like x.

    A model whose state is an array answers `rhs_into` instead.
    """
    out = np.empty_like(x)
    rhs_into(p, t, x, u, out, workspace(p))
    return out


@generic
def workspace(p):
    """Return the work arrays of `rhs_into`, for many evaluations; None by default."""
    return None


@generic
def position_count(p):
    """Return the number n of positions in an array state: the rates of x[:n] are x[n : 2 n]."""
    raise NotImplementedError


@generic
def rhs_into(p, t, x, u, out, work):
    """Write the time derivative of an array state into `out`; `work` is by `workspace`."""
    raise NotImplementedError


@generic
def compute_jacobian(p, t, x, u):
    """Return (the Jacobian J of the state's derivative by the state, its derivative in time).

    Both are at (t, x).

    J is what `factor_shifted` takes, by default the matrix (n, n). The derivative in time (n,) is
    that of a kink's later side.
    """
    return state_and_time_jacobian(rhs, p, t, x, u)


@generic
def factor_shifted(p, jacobian, shift):
    """Return factors of the matrix shift I - J, shift in 1/s, for `solve_shifted`."""
    a = -jacobian
    for i in range(len(a)):
        a[i, i] += shift
    return a, factor_dense(a)


@generic
def solve_shifted(p, factors, b):
    """Overwrite b (n,) with the solution y of (shift I - J) y = b."""
    solve_dense(factors[0], factors[1], b)


@generic
def project(p, x):
    """Return the state projected onto the model's constraints, an array in place.

    Integrators do so after steps.
    """
    return x


@generic
def project_in_place(p, x):
    """Project an array state onto the model's constraints as `project` does; return nothing."""


@generic
def rate_entries(p):
    """Return ((first, count), ...) of entries of the state whose rates follow them.

    Each `count` entries from `first` on have the next `count` as rates.

    Entries are counted through nested tuples. Default: no entries.
    """
    return ((0, 0),)


@generic
def effort(u, p, t, x):
    """Return the efforts (nu,) of the source u for model p at (t, x). A tuple is held as it is."""
    return u


@generic
def demand(u, p, t, x):
    """Return the efforts (nu,) of the source u before `saturate`; by default its `effort`."""
    return effort(u, p, t, x)


@generic
def command(law, t, q, v):
    """Return the effort commands (nu,) of a law; q and v begin with the actuated joints."""
    raise NotImplementedError


@entry_point
def compute_command(law, t, q, v):
    """Compiled `command`, for calls from Python."""
    return command(law, t, q, v)


@generic
def state(p, t, q, v):
    """Return the state x of model p at t [s], joint positions q (nq,), velocities v (nq,).

    q and v are tuples or arrays.
    """
    raise NotImplementedError


@generic
def efforts_from_row(p, row):
    """Return the efforts (nu,) in the array `row` as a tuple, a source that is held."""
    raise NotImplementedError


@generic
def joints(p, x):
    """Return (q, v), both (nq,), tuples or arrays, finite for every finite state."""
    raise NotImplementedError


@generic
def actuated_joints(p, x):
    """Return (q, v) of the actuated joints only, both (nu,), without trigonometry.

    Laws in the equations need these.
    """
    raise NotImplementedError


@generic
def saturate(p, u):
    """Return the efforts (nu,) that actuators apply for a command u: u, unless limited."""
    return u


@generic
def acceleration(p, t, x, u):
    """Return the joint accelerations (nq,)."""
    raise NotImplementedError


@generic
def kinetic(p, x):
    """Return the kinetic energy [J] relative to the base."""
    raise NotImplementedError


@generic
def potential(p, x):
    """Return the potential energy [J] of springs and gravity, with a level base at height 0."""
    raise NotImplementedError


@generic
def base_energy(p, t, x):
    """Return (kinetic, potential) energy [J] in the world less those in the base at t [s]."""
    return 0.0, 0.0


@generic
def link_count(p):
    """Return the number L of links of the cable: 1 for a rope."""
    return 1


@generic
def tensions(p, t, x, u, rows, i, first):
    """Write the tension [N] of every link, top to payload, into row i of `rows` from `first` on.

    `first` is a column.

    Tension is positive. The row and column are passed as in `store`: a slice of the row would slow
    the whole loop.
    """
    raise NotImplementedError


@generic
def fall_count(p):
    """Return the number n of falls of a rope that is reeved over sheaves, 0 by default."""
    return 0


@generic
def fall_tensions(p, t, x, u, rows, i):
    """Write tensions [N] of lead line and n falls, and the drum's torque [N m], into row i.

    The row has n + 2 floats.

    A fall's tension is that at its upper end. The torque pays out where it is positive, 0 without a
    drum.
    """
    raise NotImplementedError


@generic
def contact_force(p, t, x):
    """Return the normal force [N] of a surface on the load: 0 for a model without contact."""
    return 0.0


@generic
def power(p, t, x, u):
    """Return the power [W] into the model but that of held efforts: all losses are negative."""
    raise NotImplementedError


@generic
def point_count(p):
    """Return the number N of points of the polyline base .. tip .. payload."""
    raise NotImplementedError


@generic
def tip_index(p):
    """Return the index of the tip in the polyline, where the cable begins: 0 by default."""
    return 0


@generic
def points(p, t, x, out):
    """Write the polyline base .. tip .. payload in the world [m] at time t [s] into out (N, 3)."""
    raise NotImplementedError


@generic
def energy_supplied(p, x):
    """Return the energy [J] supplied since the start if the model is metered, else 0."""
    raise NotImplementedError


@generic
def with_meter(p, held):
    """Return the model with a meter where samples of efforts miss work that is done.

    The efforts are `held` between samples or not.
    """
    raise NotImplementedError


@generic
def switching(p):
    """Return `Switching` for a model whose equations switch, None for a smooth one."""
    return None


@generic
def guard(p, t, x, u, work):
    """Return (smallest guard, its number, evaluations); the mode holds while none is negative."""
    raise NotImplementedError


@generic
def kink_guard(p, value, t0, x0, t, x):
    """Return the smaller one of a guard's value and of those of kinks that a step passes.

    The step goes from state x0 at t0 to x at t.

    A kink is where the equations are continuous and their derivatives jump. It has no mode: the
    step's side of it is that on which it begins. By default the value as it is.
    """
    return value


@generic
def apply_reset_map(p, t, x, u, number):
    """Return (state after that guard failed, number of the event, whether the model goes on)."""
    raise NotImplementedError


@generic
def describe_event(p, number):
    """Return texts (meaning of the event or guard of that number, what a user can change)."""
    raise NotImplementedError


MANDATORY = (
    *(state, joints, actuated_joints, efforts_from_row),
    *(acceleration, kinetic, potential, power, tensions),
    *(point_count, points, with_meter, energy_supplied),
)
"""Functions that every model registers."""
DERIVATIVES = rhs, rhs_into
"""The state's derivative: of a model whose state is a tuple, and of one whose state is an array."""
SWITCHES = switching, guard, apply_reset_map, describe_event
"""Functions that a model registers whose equations switch or whose runs can end early."""
