"""What a moving base does to a knuckle-boom crane: efforts on its joints, in addition to those of a base that rests.

In the slewing frame (e_r, e_t, e_z) boom and jib are masses at their middles, which feel the imposed acceleration, and
rods whose own inertia resists the turning of the base. With an axial inertia I_a a rod's inertia tensor is
I 1 + (I_a - I) u uᵀ, u along the rod. Without one the model lets the inertia resist the turning about the luffing axis
l = -e_t only, and so it does here: the tensor is I l lᵀ. The tower has an inertia about e_z only, I_t e_z e_zᵀ.
With Ω = w + ω, ω relative to the base, such a tensor a 1 + b d dᵀ, d fixed in the body, gives the body the moment

    -(a s + b [(d·s) d + (d·Ω) Ω × d - (d·ω) ω × d]),   s = w' + w × ω,

in addition to what it feels at w = w' = 0.
"""

from crane_sim.base import Carried, added_energy, added_spin, cross, dot, imposed
from crane_sim.jit import generic, lean_generic, lean_kernel, lean_routine
from crane_sim.supports import drive_power, support_base_energy, with_base
from crane_sim.supports.knuckle import Knuckle


@with_base.register(Knuckle)
def _(support, tau, base, pose):
    return shaken(base, support, tau, pose)


@drive_power.register(Knuckle)
def _(support, tau, pose, pull):
    return tau[0] * pose.yaw_rate + tau[1] * pose.beta_rate + tau[2] * pose.gamma_rate


@generic
def shaken(base, support, tau, pose):
    """Return the joint efforts tau plus what the base imposes on tower, boom and jib."""
    return tau


@shaken.register(Carried)
def _(base, support, tau, pose):
    slew, luff, fold = _efforts(base, support, pose)
    return (tau[0] + slew, tau[1] + luff, tau[2] + fold, *tau[3:])


@lean_routine
def _efforts(base, support, pose):
    boom, jib = support.boom, support.jib
    slew, x, z = pushed(base, boom, pose, (0.0, 0.0), (0.0, 0.0), pose.cb, pose.sb, pose.beta_rate)
    knee, rate = boom.length, boom.length * pose.beta_rate
    knee_at, knee_moves = (knee * pose.cb, knee * pose.sb), (-rate * pose.sb, rate * pose.cb)
    turn, jx, jz = pushed(base, jib, pose, knee_at, knee_moves, pose.cg, pose.sg, pose.gamma_rate)
    luff = boom.length * (pose.cb * (0.5 * z + jz) - pose.sb * (0.5 * x + jx))
    fold = 0.5 * jib.length * (pose.cg * jz - pose.sg * jx)
    boom_turn, boom_luff = spun(base, boom, pose, pose.cb, pose.sb, pose.beta_rate)
    jib_turn, jib_fold = spun(base, jib, pose, pose.cg, pose.sg, pose.gamma_rate)
    slew = slew + turn + boom_turn + jib_turn - support.tower.inertia * base.turn_rate[2]
    return slew, luff + boom_luff, fold + jib_fold


@lean_kernel
def pushed(base, rod, pose, root, root_rate, c, s, rate):
    """Return (moment about the vertical [N m], radial, vertical force [N]) that the base imposes on a rod's mass.

    Args:
        base, rod, pose: the base in the slewing frame, the rod, the posture.
        root, root_rate: where the rod begins (radial, vertical) [m], and how that moves in the slewing frame.
        c, s, rate: cosine and sine of the rod's elevation, its rate [rad/s].
    """
    at, moves = middle(rod, pose, root, root_rate, c, s, rate)
    x, y, z = imposed(base, at, moves)
    return rod.mass * y * at[0], rod.mass * x, rod.mass * z


@lean_kernel
def middle(rod, pose, root, root_rate, c, s, rate):
    """Return (position [m], velocity [m/s]) of a rod's middle relative to the base (3,); arguments as of `pushed`."""
    half = 0.5 * rod.length
    at = (root[0] + half * c, 0.0, root[1] + half * s)
    return at, (root_rate[0] - half * s * rate, pose.yaw_rate * at[0], root_rate[1] + half * c * rate)


@lean_kernel
def spun(base, rod, pose, c, s, rate):
    """Return the moments [N m] (about the vertical, about the luffing axis) by which a rod's inertia resists."""
    a, b, d = tensor(rod.axial_inertia, rod.inertia, c, s)
    own = (0.0, -rate, pose.yaw_rate)
    x, y, z = cross(base.turn, own)
    resisted = (x + base.turn_rate[0], y + base.turn_rate[1], z + base.turn_rate[2])
    whole = (own[0] + base.turn[0], own[1] + base.turn[1], own[2] + base.turn[2])
    along, first, second = dot(d, resisted), dot(d, whole), dot(d, own)
    _, whole_y, whole_z = cross(whole, d)
    _, own_y, own_z = cross(own, d)
    luffing = a * resisted[1] + b * (along * d[1] + first * whole_y - second * own_y)
    slewing = a * resisted[2] + b * (along * d[2] + first * whole_z - second * own_z)
    return -slewing, luffing


@lean_generic
def tensor(axial, inertia, c, s):
    """Return (a, b, d (3,)) of the inertia tensor a 1 + b d dᵀ [kg m²] of a rod; about the luffing axis only."""
    return 0.0, inertia, (0.0, -1.0, 0.0)


@tensor.register(float)
def _(axial, inertia, c, s):
    return inertia, axial - inertia, (c, 0.0, s)


@support_base_energy.register(Knuckle)
def _(support, now, pose, gravity):
    rate, knee = support.boom.length * pose.beta_rate, support.boom.length
    knee_at, knee_moves = (knee * pose.cb, knee * pose.sb), (-rate * pose.sb, rate * pose.cb)
    still = (0.0, 0.0)
    boom = rod_energy(now, gravity, support.boom, pose, still, still, pose.cb, pose.sb, pose.beta_rate)
    jib = rod_energy(now, gravity, support.jib, pose, knee_at, knee_moves, pose.cg, pose.sg, pose.gamma_rate)
    tower = added_spin(now, (0.0, support.tower.inertia, (0.0, 0.0, 1.0)), (0.0, 0.0, pose.yaw_rate))
    return boom[0] + jib[0] + tower, boom[1] + jib[1]


@lean_kernel
def rod_energy(now, gravity, rod, pose, root, root_rate, c, s, rate):
    """Return (kinetic, potential) energy [J] of a rod in the world less those relative to the base.

    Args:
        now: BaseState.
        gravity: m/s².
        rod, pose, root, root_rate, c, s, rate: as of `pushed`.
    """
    at, moves = middle(rod, pose, root, root_rate, c, s, rate)
    kinetic, potential = added_energy(now, gravity, rod.mass, at, moves)
    own = (0.0, -rate, pose.yaw_rate)
    return kinetic + added_spin(now, tensor(rod.axial_inertia, rod.inertia, c, s), own), potential
