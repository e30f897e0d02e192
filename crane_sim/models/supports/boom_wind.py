"""Wind on booms and jibs: additional efforts on the joints of knuckle-boom, tower and mobile cranes."""

from crane_sim.models.moving_base import airspeed
from crane_sim.models.supports import with_wind
from crane_sim.models.supports.knuckle_boom import Knuckle, point_motion
from crane_sim.models.supports.telescopic_boom import TelescopicBoom, centre_motion
from crane_sim.models.supports.tower_crane import Slew, TowerCrane
from crane_sim.models.wind_load import Airflow, BoomWindage, JibWindage, RodWindage, rod_drag
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


@with_wind.register(TowerCrane)
def _(support, tau, flow, base, pose):
    return jibs_wind(flow, support.slew, tau, base, pose)


@generic
def jibs_wind(flow, slew, tau, base, pose):
    """Return the joint efforts tau plus those of the wind on jib and counter-jib; arguments of `with_wind`."""
    return tau


@jibs_wind.register(Airflow)
def _(flow, slew, tau, base, pose):
    return (tau[0] + slew_moment(slew, flow, base, pose), *tau[1:])


@generic
def slew_moment(slew, flow, base, pose):
    """Return the wind's moment [N m] about the tower's axis; none on a locked slew."""
    return 0.0


@slew_moment.register(Slew)
def _(slew, flow, base, pose):
    return jib_moment(slew.jib_windage, flow, base, pose) + jib_moment(slew.counter_jib_windage, flow, base, pose)


@generic
def jib_moment(windage, flow, base, pose):
    """Return the moment [N m] about the tower's axis of the wind on a jib; none without a windage."""
    return 0.0


@jib_moment.register(JibWindage)
def _(windage, flow, base, pose):
    at, moves = (windage.centre, 0.0, 0.0), (0.0, pose.yaw_rate * windage.centre, 0.0)
    return windage.centre * rod_drag(windage, flow, (1.0, 0.0, 0.0), at, airspeed(base, at, moves))[1]


@with_wind.register(TelescopicBoom)
def _(support, tau, flow, base, pose):
    return boom_wind(flow, support, tau, base, pose)


@generic
def boom_wind(flow, support, tau, base, pose):
    """Return the joint efforts tau plus those of the wind on a telescopic boom; arguments of `with_wind`."""
    return tau


@boom_wind.register(Airflow)
def _(flow, support, tau, base, pose):
    slew, luff = telescoped_wind(support.base_section.windage, support, flow, base, pose)
    return (tau[0] + slew, tau[1] + luff, *tau[2:])


@generic
def telescoped_wind(windage, support, flow, base, pose):
    """Return the wind's moments (2,) [N m] about the vertical and the foot pin, of pressure halfway up the boom.

    The pressure is across the boom, so that none is along it, on the telescope. That of a jib is at its own centre.
    """
    return 0.0, 0.0


@telescoped_wind.register(BoomWindage)
def _(windage, support, flow, base, pose):
    reach, whole = 0.5 * pose.length, RodWindage(windage.width * pose.length, windage.drag_coefficient, 0.5)
    at, moves = centre_motion(support, pose, reach, 0.0)
    x, y, z = rod_drag(whole, flow, (pose.cb, 0.0, pose.sb), at, airspeed(base, at, moves))
    return y * at[0], reach * (pose.cb * z - pose.sb * x)


@telescoped_wind.register(JibWindage)
def _(windage, support, flow, base, pose):
    at, moves = centre_motion(support, pose, windage.centre, 0.0)
    x, y, z = rod_drag(windage, flow, (pose.cb, 0.0, pose.sb), at, airspeed(base, at, moves))
    return y * at[0], windage.centre * (pose.cb * z - pose.sb * x)
