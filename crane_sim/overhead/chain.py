"""Rigid links with lumped masses in the vertical plane: their tensions and angular accelerations.

The tensions solve a tridiagonal, positive definite system of N equations, whose condition a heavy payload does not
spoil as it does that of the N x N mass matrix. Angles are absolute, from the downward vertical;
n_k = (sin α_k, -cos α_k) points down link k, t_k = (cos α_k, sin α_k) where it moves when α_k grows. Node 0 is the
trolley.
"""

from typing import Any, NamedTuple

from crane_sim.jit import generic, kernel, routine


class Chain(NamedTuple):
    """Node masses and link lengths from the top, (N,) arrays; the last node is the payload."""

    masses: Any  # kg
    lengths: Any  # m; where there is a hoist, the first one is a coordinate and not used


class Joints(NamedTuple):
    """Stiffness and damping between links, (N,) arrays; the first one is between the trolley and link 1."""

    stiffness: Any  # N m/rad
    damping: Any  # N m s/rad


class Rods(NamedTuple):
    """Moments of inertia of the links about their ends' line, (N,): they turn with the links (Brogliato, 8.1)."""

    inertia: Any  # kg m²


ROWS = 13
"""Rows of the work array (ROWS, N + 1) in which one evaluation keeps what it computes; links in columns 0 to N - 1."""
SIN, COS, RATE, LENGTH = 0, 1, 2, 3  # of the links
BELOW = 4  # 1/kg, one over the mass of the node below each link
TENSION, TURNING, PIVOT = 5, 6, 7  # N, rad/s², one over the pivots of the elimination
ALONG, ACROSS = 8, 9  # 1/kg, cosine and sine of the bend from link k to k + 1, over the mass of the node between
ACC = 10  # and 11, 12: accelerations of nodes 0 to N along x, y, z without tensions [m/s²]
AX, AZ = ACC, ACC + 2


@generic
def add_joints(joints, w, angles):
    """Add what the joints' moments do to the nodes' accelerations in the work array w; node 0 gets forces [N]."""


@add_joints.register(Joints)
def _(joints, w, angles):
    n = len(angles)
    moment = joints.stiffness[0] * angles[0] + joints.damping[0] * w[RATE, 0]
    for k in range(n):
        after = 0.0
        if k + 1 < n:
            after = joints.stiffness[k + 1] * (angles[k + 1] - angles[k])
            after += joints.damping[k + 1] * (w[RATE, k + 1] - w[RATE, k])
        force = (after - moment) / w[LENGTH, k]  # the couple of link k: on its lower node, and back on its upper one
        above = 1.0 if k == 0 else w[BELOW, k - 1]
        w[AX, k] -= force * above * w[COS, k]
        w[AZ, k] -= force * above * w[SIN, k]
        w[AX, k + 1] += force * w[BELOW, k] * w[COS, k]
        w[AZ, k + 1] += force * w[BELOW, k] * w[SIN, k]
        moment = after


@generic
def joint_energy(joints, angles):
    """Return the energy [J] stored in the joints."""
    return 0.0


@joint_energy.register(Joints)
def _(joints, angles):
    energy = 0.5 * joints.stiffness[0] * angles[0] ** 2
    for k in range(1, len(angles)):
        energy += 0.5 * joints.stiffness[k] * (angles[k] - angles[k - 1]) ** 2
    return energy


@generic
def joint_power(joints, rates):
    """Return the power [W] that the joints' damping takes, negative."""
    return 0.0


@joint_power.register(Joints)
def _(joints, rates):
    power = -joints.damping[0] * rates[0] ** 2
    for k in range(1, len(rates)):
        power -= joints.damping[k] * (rates[k] - rates[k - 1]) ** 2
    return power


@generic
def rod_energy(rods, rates):
    """Return the kinetic energy [J] of turning links."""
    return 0.0


@rod_energy.register(Rods)
def _(rods, rates):
    energy = 0.0
    for k in range(len(rates)):
        energy += 0.5 * rods.inertia[k] * rates[k] ** 2
    return energy


@generic
def rod_pull(rods, w):
    """Return the horizontal force [N] on the trolley that the first link carries across."""
    return 0.0


@generic
def solve_links(rods, w, top):
    """Fill the links' tensions [N] and angular accelerations [rad/s²] in the work array w.

    Args:
        rods: the links' inertia, None where they have none.
        w: work array with everything else.
        top: (compliance of the axis [1/kg], compliance and free acceleration of the first length, its rate [m/s]);
            a compliance of -1 says that the acceleration is the tension itself (`drum`).
    """
    solve_tensions(w, top)
    turn(w, top)


@kernel
def demanded(w, k):
    """Return what link k's tension has to supply: the relative acceleration of its ends along it [m/s²]."""
    fall = w[SIN, k] * (w[AX, k + 1] - w[AX, k]) - w[COS, k] * (w[AZ, k + 1] - w[AZ, k])
    return w[LENGTH, k] * w[RATE, k] * w[RATE, k] + fall


@kernel
def bends(w):
    """Fill the rows ALONG and ACROSS."""
    for k in range(w.shape[1] - 2):
        w[ALONG, k] = (w[SIN, k] * w[SIN, k + 1] + w[COS, k] * w[COS, k + 1]) * w[BELOW, k]
        w[ACROSS, k] = (w[COS, k] * w[SIN, k + 1] - w[SIN, k] * w[COS, k + 1]) * w[BELOW, k]


@routine
def solve_tensions(w, top):
    """Eliminate downwards, substitute upwards; arguments as of `solve_links`."""
    n, (give, pay, run, _) = w.shape[1] - 1, top
    bends(w)
    for k in range(n):
        w[TENSION, k] = demanded(w, k)
    pivot = 1.0 / (w[BELOW, 0] + w[SIN, 0] * w[SIN, 0] * give + pay)
    known = w[ALONG, 0]  # by which the first row knows the second tension
    w[TENSION, 0] -= run
    if pay < 0.0:  # a massless winch: the first tension is given
        pivot, known, w[TENSION, 0] = 1.0, 0.0, run
    w[PIVOT, 0] = pivot
    for k in range(1, n):
        ratio = w[ALONG, k - 1] * pivot
        pivot = 1.0 / (w[BELOW, k - 1] + w[BELOW, k] - ratio * known)
        w[TENSION, k] += ratio * w[TENSION, k - 1]
        w[PIVOT, k], known = pivot, w[ALONG, k]
    w[TENSION, n - 1] *= w[PIVOT, n - 1]
    for k in range(n - 2, 0, -1):
        w[TENSION, k] = (w[TENSION, k] + w[ALONG, k] * w[TENSION, k + 1]) * w[PIVOT, k]
    if n > 1 and pay >= 0.0:
        w[TENSION, 0] = (w[TENSION, 0] + w[ALONG, 0] * w[TENSION, 1]) * w[PIVOT, 0]


@kernel
def turn(w, top):
    """Fill the angular accelerations; no difference of large numbers, so that a heavy payload does no harm."""
    n, (give, _, _, rate) = w.shape[1] - 1, top
    for k in range(n):
        pushed = w[COS, k] * (w[AX, k + 1] - w[AX, k]) + w[SIN, k] * (w[AZ, k + 1] - w[AZ, k])
        below = w[ACROSS, k] * w[TENSION, k + 1] if k + 1 < n else 0.0
        above = w[ACROSS, k - 1] * w[TENSION, k - 1] if k > 0 else 0.0
        w[TURNING, k] = (pushed + (below - above)) / w[LENGTH, k]
    first = w[COS, 0] * give * w[TENSION, 0] * w[SIN, 0] + 2.0 * rate * w[RATE, 0]
    w[TURNING, 0] -= first / w[LENGTH, 0]


@kernel
def slid(w, give):
    """Return the acceleration of the first length behind a massless winch, whose tension is given."""
    free = demanded(w, 0) - (w[BELOW, 0] + w[SIN, 0] * w[SIN, 0] * give) * w[TENSION, 0]
    return free + w[ALONG, 0] * w[TENSION, 1] if w.shape[1] > 2 else free
