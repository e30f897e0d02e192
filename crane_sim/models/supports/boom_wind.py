"""Wind on booms and jibs: additional efforts on the joints of knuckle-boom cranes below one rope."""

from crane_sim.models.moving_base import airspeed
from crane_sim.models.supports import with_wind
from crane_sim.models.supports.knuckle_boom import Knuckle, point_motion
from crane_sim.models.wind_load import Airflow, RodWindage, rod_drag
from crane_sim.numerics.jit import generic, routine


@with_wind.register(Knuckle)
def _(support, tau, flow, base, pose):
    return wind_efforts(flow, support, tau, base, pose)


@generic
def wind_efforts(flow, support, tau, base, pose):
    """Return the joint efforts tau plus those of the wind on boom and jib; arguments of `with_wind`."""
    return tau


@wind_efforts.register(Airflow)
def _(flow, support, tau, base, pose):
    slew, boom, jib = rods_wind(flow, support, base, pose)
    return (tau[0] + slew, tau[1] + boom, tau[2] + jib, *tau[3:])


@routine
def rods_wind(flow, support, base, pose):
    """Return the efforts (3,) [N m] of the wind on slew, boom and jib; arguments of `with_wind`."""
    length, rate, zero = support.boom.length, support.boom.length * pose.beta_rate, (0.0, 0.0)
    root, root_rate = (length * pose.cb, length * pose.sb), (-rate * pose.sb, rate * pose.cb)
    boom, jib = support.boom, support.jib
    of_boom = rod_wind(boom.windage, boom, flow, base, pose, zero, zero, pose.cb, pose.sb, pose.beta_rate)
    of_jib = rod_wind(jib.windage, jib, flow, base, pose, root, root_rate, pose.cg, pose.sg, pose.gamma_rate)
    carried = length * (pose.cb * of_jib[3] - pose.sb * of_jib[2])
    return of_boom[0] + of_jib[0], of_boom[1] + carried, of_jib[1]


@generic
def rod_wind(windage, rod, flow, base, pose, root, root_rate, c, s, rate):
    """Return the wind's (moment about the vertical, about the rod's root [N m], radial, vertical force [N]) on a rod.

    Args:
        windage, rod, flow, base, pose: the rod's windage, the rod, and arguments of `with_wind`.
        root, root_rate, c, s, rate: see `knuckle_boom.imposed_load`.
    """
    return 0.0, 0.0, 0.0, 0.0


@rod_wind.register(RodWindage)
def _(windage, rod, flow, base, pose, root, root_rate, c, s, rate):
    reach = windage.centre * rod.length
    at, moves = point_motion(reach, pose, root, root_rate, c, s, rate)
    x, y, z = rod_drag(windage, flow, (c, 0.0, s), at, airspeed(base, at, moves))
    return y * at[0], reach * (c * z - s * x), x, z
