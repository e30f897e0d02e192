"""An overhead crane with an elastic cable on a moving base: what the base imposes, and its exact derivatives.

Each function takes the base as of `base.carried`, and does nothing for a base that rests (None).
"""

from crane_sim.base import Carried, carried, imposed
from crane_sim.jit import generic, lean_generic, lean_kernel
from crane_sim.overhead.axes import axis_mass
from crane_sim.overhead.carried import NOTHING, push_axes, tilted
from crane_sim.overhead.elastic import layout, mass_of, vector

STILL = (0.0, 0.0, 0.0)


@lean_kernel
def rails(p, x):
    """Return (place [m], velocity [m/s]) of the trolley along x and y."""
    nq, _, d, _ = layout(p)
    if d == 3:
        return (x[0], x[1]), (x[nq], x[nq + 1])
    return (x[0], 0.0), (x[nq], 0.0)


@lean_kernel
def deck(p, t, x):
    """Return the Load of trolley and bridge, as `push_axes` does."""
    place, speed = rails(p, x)
    return push_axes(carried(p.base, p.gravity, t), p.trolley, p.bridge, p.share, place, speed)


@lean_generic
def push_points(now, p, x, out):
    """Add the nodes' accelerations to the state's derivative `out`; return the power [W] that they take."""
    return NOTHING


@push_points.register(Carried)
def _(now, p, x, out):
    nq, first, d, _ = layout(p)
    power, i = 0.0, nq + first
    for k in range(1, 1 + len(p.cable.masses)):
        v = vector(p, x, k, 1)
        ax, ay, az = imposed(now, vector(p, x, k, 0), v)
        power += mass_of(p, x, k) * (ax * v[0] + ay * v[1] + az * v[2])
        out[i] += ax
        if d == 3:
            out[i + 1] += ay
        out[i + d - 1] += az
        i += d
    return power


@lean_kernel
def unit(d, b):
    """Return the unit vector (3,) of coordinate b of d; in the plane the second one is z."""
    return 1.0 if b == 0 else 0.0, 1.0 if b == 1 and d == 3 else 0.0, 1.0 if b == d - 1 else 0.0


@lean_kernel
def entry_of(d, a, vector3):
    """Return entry a of d of a vector (3,)."""
    return vector3[0] if a == 0 else vector3[1] if a == 1 and d == 3 else vector3[2]


@lean_generic
def lean_on(now, p, give, found):
    """Add the derivatives of the imposed accelerations by positions and velocities to the bands `found`.

    Args:
        now: the base.
        p: the crane.
        give: compliances of the axes [1/kg], (d,) or longer.
        found: `elastic_linear.Bands`.
    """


@lean_on.register(Carried)
def _(now, p, give, found):
    _, first, d, _ = layout(p)
    middle = 2 * d - 1
    for b in range(d):
        by_place, by_speed = tilted(now, unit(d, b), STILL), tilted(now, STILL, unit(d, b))
        for a in range(d):
            position, velocity = entry_of(d, a, by_place), entry_of(d, a, by_speed)
            for k in range(len(p.cable.masses)):
                found.positions[first + d * k + a, middle + b - a] += position
                found.velocities[first + d * k + a, middle + b - a] += velocity
            if a < d - 1 and b < d - 1:
                mass = axis_mass(p.trolley) if a == 0 else axis_mass(p.bridge)
                weight = give[a] * mass * (p.share if b < a else 1.0)
                found.positions[a, middle + b - a] += weight * position
                found.velocities[a, middle + b - a] += weight * velocity


@generic
def lean_power(now, p, x, power):
    """Add the derivatives of the imposed power by positions and velocities to `power` (2 nq,)."""


@lean_power.register(Carried)
def _(now, p, x, power):
    nq, first, d, _ = layout(p)
    for k in range(1, 1 + len(p.cable.masses)):
        mass, v, i = mass_of(p, x, k), vector(p, x, k, 1), first + d * (k - 1)
        still = imposed(now, vector(p, x, k, 0), STILL)
        for b in range(d):
            ax, ay, az = tilted(now, unit(d, b), STILL)
            power[i + b] += mass * (ax * v[0] + ay * v[1] + az * v[2])
            power[nq + i + b] += mass * entry_of(d, b, still)
    lean_axes(now, p, x, power)


@lean_kernel
def lean_axes(now, p, x, power):
    """Add what trolley and bridge have of `lean_power`."""
    nq, _, d, _ = layout(p)
    (_, (vx, vy)), load = rails(p, x), push_axes(now, p.trolley, p.bridge, p.share, *rails(p, x))
    trolley, bridge = axis_mass(p.trolley) * vx, axis_mass(p.bridge) * vy
    for b in range(d - 1):
        reach = p.share if b == 0 else 1.0
        place, speed = tilted(now, unit(d, b), STILL), tilted(now, STILL, unit(d, b))
        power[b] += trolley * place[0] + bridge * reach * place[1]
        power[nq + b] += trolley * speed[0] + bridge * reach * speed[1] + (load.x if b == 0 else load.y)
