"""Efforts and energies that a moving base and wind add to the closed form of a knuckle boom.

A moving base (`models.moving_base`) imposes an acceleration on boom and jib, as masses at their
middles, and the inertias of the rods resist its rotation. With an axial inertia I_a a rod's inertia
tensor is I 1 + (I_a - I) u uᵀ, u along the rod. Without one the model has inertia about the luffing
axis l = -e_t only: the tensor is I l lᵀ. The tower has an inertia about e_z only, It e_z e_zᵀ. With
w the angular velocity of the base, ω that of a body relative to it, and Ω = w + ω, a tensor a 1 + b
d dᵀ, d fixed in the body, gives the body the moment

    -(a ε + b [(d·ε) d + (d·Ω) Ω × d - (d·ω) ω × d]),   ε = w' + w × ω,

in addition to that at w = w' = 0.

Functions of a rod, boom or jib, take the posture of the crane, the rod's lower joint `root`
(radial, vertical) [m] and its velocity `root_rate` in the slewing frame [m/s], cosine c, sine s and
rate [rad/s] of the rod's elevation.
"""

from crane_sim.models.moving_base import added_energy, added_spin, airspeed, imposed_acceleration
from crane_sim.models.wind_load import rod_drag
from crane_sim.multibody.vectors import add, cross, dot, scale, subtract
from crane_sim.numerics.jit import routine

FOOT = (0.0, 0.0), (0.0, 0.0)
"""Lower joint of the boom, and its velocity."""


def head_motion(support, pose):
    """Return (position [m], velocity [m/s]) of the boom's end, each (radial, vertical)."""
    length, rate = support.boom.length, support.boom.length * pose.beta_rate
    return (length * pose.cb, length * pose.sb), (-rate * pose.sb, rate * pose.cb)


def point_motion(reach, pose, root, root_rate, c, s, rate):
    """Return (position [m], velocity [m/s]) (3,) of a rod's point relative to the base.

    The point is `reach` [m] from the rod's root.
    """
    position = (root[0] + reach * c, 0.0, root[1] + reach * s)
    return position, (
        root_rate[0] - reach * s * rate,
        pose.yaw_rate * position[0],
        root_rate[1] + reach * c * rate,
    )


def centre_motion(rod, pose, root, root_rate, c, s, rate):
    """Return the result of `point_motion` for a rod's centre."""
    return point_motion(0.5 * rod.length, pose, root, root_rate, c, s, rate)


@routine
def imposed_efforts(base, support, pose):
    """Return the efforts (3,) [N m] of a moving base's inertial forces on slew, boom and jib."""
    boom, jib, (root, root_rate) = support.boom, support.jib, head_motion(support, pose)
    slew, x, z = imposed_load(base, boom, pose, *FOOT, pose.cb, pose.sb, pose.beta_rate)
    jib_slew, jx, jz = imposed_load(
        base, jib, pose, root, root_rate, pose.cg, pose.sg, pose.gamma_rate
    )
    boom_effort = boom.length * (pose.cb * (0.5 * z + jz) - pose.sb * (0.5 * x + jx))
    jib_effort = 0.5 * jib.length * (pose.cg * jz - pose.sg * jx)
    boom_gyro_slew, boom_gyro = gyroscopic_moments(
        base, boom, pose, pose.cb, pose.sb, pose.beta_rate
    )
    jib_gyro_slew, jib_gyro = gyroscopic_moments(base, jib, pose, pose.cg, pose.sg, pose.gamma_rate)
    slew = (
        slew
        + jib_slew
        + boom_gyro_slew
        + jib_gyro_slew
        - support.tower.inertia * base.angular_acceleration[2]
    )
    return slew, boom_effort + boom_gyro, jib_effort + jib_gyro


def imposed_load(base, rod, pose, root, root_rate, c, s, rate):
    """Return (moment about the vertical [N m], radial, vertical force [N]) of the base on a rod."""
    position, velocity = centre_motion(rod, pose, root, root_rate, c, s, rate)
    x, y, z = imposed_acceleration(base, position, velocity)
    return rod.mass * y * position[0], rod.mass * x, rod.mass * z


def gyroscopic_moments(base, rod, pose, c, s, rate):
    """Return the moments [N m] (about the vertical, about the luffing axis).

    The axes are e_z and l = -e_t; see the module's docstring.
    """
    a, b, d = rod.inertia_tensor(c, s)
    w, omega = base.angular_velocity, (0.0, -rate, pose.yaw_rate)
    epsilon, total = add(cross(w, omega), base.angular_acceleration), add(omega, w)  # total: Ω
    turned = add(scale(dot(d, epsilon), d), scale(dot(d, total), cross(total, d)))
    moment = add(
        scale(a, epsilon), scale(b, subtract(turned, scale(dot(d, omega), cross(omega, d))))
    )
    return -moment[2], moment[1]


@routine
def wind_moments(flow, support, base, pose):
    """Return the efforts (3,) [N m] of the wind on slew, boom and jib.

    Arguments of `Knuckle.add_wind_efforts`.
    """
    boom, jib, (root, root_rate) = support.boom, support.jib, head_motion(support, pose)
    of_boom = rod_wind(boom, flow, base, pose, *FOOT, pose.cb, pose.sb, pose.beta_rate)
    of_jib = rod_wind(jib, flow, base, pose, root, root_rate, pose.cg, pose.sg, pose.gamma_rate)
    carried = boom.length * (pose.cb * of_jib[3] - pose.sb * of_jib[2])
    return of_boom[0] + of_jib[0], of_boom[1] + carried, of_jib[1]


def rod_wind(rod, flow, base, pose, root, root_rate, c, s, rate):
    """Return (moment about the vertical, about the root, radial, vertical force) of the wind.

    They are those on a rod, moments in N m and forces in N.
    """
    if rod.windage is None:
        return 0.0, 0.0, 0.0, 0.0
    reach = rod.windage.centre * rod.length
    at, moves = point_motion(reach, pose, root, root_rate, c, s, rate)
    x, y, z = rod_drag(rod.windage, flow, (c, 0.0, s), at, airspeed(base, at, moves))
    return y * at[0], reach * (c * z - s * x), x, z


def world_energies(base, support, pose, gravity):
    """Return the result of `Knuckle.base_energy`."""
    root, root_rate = head_motion(support, pose)
    boom = rod_energy(base, gravity, support.boom, pose, *FOOT, pose.cb, pose.sb, pose.beta_rate)
    jib = rod_energy(
        base, gravity, support.jib, pose, root, root_rate, pose.cg, pose.sg, pose.gamma_rate
    )
    tower = added_spin(
        base, (0.0, support.tower.inertia, (0.0, 0.0, 1.0)), (0.0, 0.0, pose.yaw_rate)
    )
    return boom[0] + jib[0] + tower, boom[1] + jib[1]


def rod_energy(base, gravity, rod, pose, root, root_rate, c, s, rate):
    """Return (kinetic, potential) energy [J] of a rod in the world less those in the base.

    `base` is a BaseState.
    """
    position, velocity = centre_motion(rod, pose, root, root_rate, c, s, rate)
    kinetic, potential = added_energy(base, gravity, rod.mass, position, velocity)
    return kinetic + added_spin(
        base, rod.inertia_tensor(c, s), (0.0, -rate, pose.yaw_rate)
    ), potential
